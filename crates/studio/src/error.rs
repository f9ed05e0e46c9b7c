use std::io;
use std::path::PathBuf;

use gnomon_envmap::EnvMapError;
use gnomon_lights::{DocumentError, FitError};
use gnomon_metrics::MetricsError;
use gnomon_picture::ImageError;
use gnomon_reference::ReferenceError;
use gnomon_renderer::RenderError;
use gnomon_rigs::RigError;
use gnomon_scene::SceneError;
use gnomon_scene_files::SceneFileError;

/// Why something did not come about. Each is one line that names who is at fault and, where there is one, the way out.
#[derive(Debug, thiserror::Error)]
pub enum StudioError {
    /// What was asked for does not exist or makes no sense.
    #[error("{0}")]
    Request(String),
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// An option cannot be what it is.
    #[error(transparent)]
    Option(#[from] gnomon_options::OptionError),
    /// The scene cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene's file cannot be used.
    #[error(transparent)]
    SceneFile(#[from] SceneFileError),
    /// The environment cannot be used.
    #[error(transparent)]
    Environment(#[from] EnvMapError),
    /// The lights cannot be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The picture cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The reference cannot be traced.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The pictures cannot be compared.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// A light rig cannot be.
    #[error(transparent)]
    Rig(#[from] DocumentError),
    /// A light rig could not be written.
    #[error(transparent)]
    WriteRig(#[from] RigError),
    /// A picture could not be read or written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// Background work ended before it was done: nothing was there to run it, or a fault of this library.
    #[error("{0} ended unexpectedly")]
    Background(&'static str),
}

impl StudioError {
    /// A name that stands for nothing.
    pub(crate) fn unknown(what: &str, name: &str, known: &[&str]) -> Self {
        Self::Request(format!(
            "unknown {what} `{}`; choose one of: {}",
            gnomon_messages::quoted(name),
            known.join(", ")
        ))
    }
}
