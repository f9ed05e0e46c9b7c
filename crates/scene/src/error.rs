/// Why a scene, a camera or a pose could not be had. Every message is one line that names who is at fault.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The caller asked for something that does not exist or makes no sense.
    #[error("{0}")]
    Request(String),
}
