use gnomon_envmap::EnvMapError;
use gnomon_image::ImageError;
use gnomon_lights::fit::FitError;
use gnomon_metrics::MetricsError;
use gnomon_reference::ReferenceError;
use gnomon_renderer::RenderError;
use gnomon_scene::SceneError;

/// Why an experiment gave nothing.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
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
    /// A scene could not be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An environment could not be read.
    #[error(transparent)]
    Environment(#[from] EnvMapError),
    /// A truth picture could not be read.
    #[error(transparent)]
    Image(#[from] ImageError),
}
