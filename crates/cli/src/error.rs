//! Everything that can stop a command, and how it is said: one line.

use std::io;
use std::path::PathBuf;

use gnomon::envmap::EnvMapError;
use gnomon::lights::FitError;
use gnomon::metrics::MetricsError;
use gnomon::picture::ImageError;
use gnomon::reference::ReferenceError;
use gnomon::renderer::RenderError;
use gnomon::renderer::lod::LodError;
use gnomon::rigs::RigError;
use gnomon::scene::SceneError;
use gnomon::scene_files::SceneFileError;
use gnomon::studio::StudioError;
use gnomon_terminal::TerminalError;

/// Why a command ended early.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The command line does not make sense: the user is at fault.
    #[error("{0}")]
    Usage(String),
    /// A file of text or JSON could not be written.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// Nobody reads the output, or it cannot be written, or the arguments do not parse.
    #[error("{0}")]
    Terminal(#[from] TerminalError),
    /// A picture could not be read or written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The environment cannot be used.
    #[error(transparent)]
    Environment(#[from] EnvMapError),
    /// The scene cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene's or camera's file cannot be used.
    #[error(transparent)]
    SceneFile(#[from] SceneFileError),
    /// The lights cannot be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The rig cannot be written.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The pictures cannot be compared.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// The reference cannot be rendered.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The picture cannot be set up or kept.
    #[error(transparent)]
    Studio(#[from] StudioError),
    /// There is no window, or a scripted session failed.
    #[cfg(feature = "view")]
    #[error(transparent)]
    View(#[from] gnomon_viewer::ViewerError),
    /// The picture cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The frame rate cannot be held.
    #[error(transparent)]
    LevelOfDetail(#[from] LodError),
}

impl CliError {
    /// A fault of the command line.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::Usage(message.into())
    }
}
