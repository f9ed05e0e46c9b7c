use gnomon_envmap::EnvMapError;
use gnomon_lights::fit::FitError;
use gnomon_metrics::MetricsError;
use gnomon_picture::ImageError;
use gnomon_reference::ReferenceError;
use gnomon_renderer::RenderError;
use gnomon_scene::SceneError;
use gnomon_scene_files::SceneFileError;
use gnomon_terminal::TerminalError;

use crate::report::ReportError;

/// Why an experiment gave nothing.
#[derive(Debug, thiserror::Error)]
pub enum LabError {
    /// The request makes no sense; says what would.
    #[error("{0}")]
    Request(String),
    /// The adapter could not draw.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The truth could not be traced.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// Lights could not be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Pictures could not be compared.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// A scene could not be made or moved.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene's file could not be read.
    #[error(transparent)]
    SceneFile(#[from] SceneFileError),
    /// The report could not be written.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// Nobody reads the output, or it cannot be written, or the arguments do not parse.
    #[error("{0}")]
    Terminal(#[from] TerminalError),
    /// An environment could not be read.
    #[error(transparent)]
    Environment(#[from] EnvMapError),
    /// A truth picture could not be read.
    #[error(transparent)]
    Image(#[from] ImageError),
}
