use std::path::PathBuf;

use crate::script::ScriptError;

/// Why there is no window, or a scripted session did not go as it should.
#[derive(Debug, thiserror::Error)]
pub enum ViewerError {
    /// The system gives no window, or no device for it.
    #[error(
        "cannot open a window: {0} (a display and a graphics driver are needed; gnomon render draws without a window)"
    )]
    Window(String),
    /// The graphics device went away more often than it can be opened anew.
    #[error("the graphics device was lost {0} times in a row")]
    DeviceLost(u32),
    /// The script cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    ReadScript {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The script is wrong, or something was not as it expects.
    #[error(transparent)]
    Script(#[from] ScriptError),
}
