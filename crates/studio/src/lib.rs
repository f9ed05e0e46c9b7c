//! What `gnomon render`, sequences and the viewer share, so that all make the same picture.
//!
//! [`Look`] is every choice that a picture depends on beside the scene, as plain data. [`Project`] is a scene with the look that its file asks
//! for, [`Stage`] the scene in its pose under its environment, [`Studio`] a live session on a device:
//!
//! ```no_run
//! use gnomon_renderer::{Gpu, GpuOptions};
//! use gnomon_studio::{Look, Project, Stage, Studio, environment_named};
//!
//! # fn main() -> Result<(), gnomon_studio::StudioError> {
//! let mut project = Project::open("robot.glb", Look::default(), &Default::default())?;
//! project.look.set_environment(environment_named("room"));
//! let gpu = Gpu::new(&GpuOptions::default())?;
//! let mut studio = Studio::new(&gpu, Stage::new(project)?)?;
//! studio.edit(|look| look.environment.rotation = 30.0)?;
//! let picture = studio.frame(1024, 768)?; // picture.radiance, picture.display
//! # Ok(())
//! # }
//! ```

mod check;
mod converging;
#[cfg(not(target_arch = "wasm32"))]
mod dataset;
mod edit;
mod environment;
mod error;
#[cfg(not(target_arch = "wasm32"))]
mod error_bound;
mod executor;
mod files;
mod frame_rate;
mod job;
mod look;
mod pace;
mod paper;
mod pose;
mod project;
mod rig;
mod save;
mod sequence;
mod stage;
mod studio;

pub use check::CHECKED_PIXELS;
pub use converging::{Converging, ReferencePicture};
#[cfg(not(target_arch = "wasm32"))]
pub use dataset::{Dataset, DatasetFiles, DrawnItem, ItemFiles, Manifest, Record, Unit};
pub use edit::changed_surface;
pub use environment::{FitScene, Surroundings, environment_named, fit_lights, load_surroundings};
pub use error::StudioError;
#[cfg(not(target_arch = "wasm32"))]
pub use error_bound::ErrorBound;
#[cfg(not(target_arch = "wasm32"))]
pub use executor::Threads;
pub use executor::{Executor, Slices, Task, default_executor};
pub use files::{FileKind, SceneFiles, kind_of};
pub use frame_rate::{DrawnFrame, FrameRate};
pub use gnomon_metrics::SampledError;
pub use look::{
    AnimationLook, CameraLook, ENVIRONMENT, EnvironmentLook, Look, PictureSettings, SCENE, SceneLook,
};
pub use pace::Pace;
pub use paper::Paper;
pub use pose::Clip;
pub use project::{Project, SceneSource};
pub use rig::EditedRig;
pub use sequence::{Film, FrameFiles, Sequence, SequenceRun, Timeline};
pub use stage::Stage;
pub use studio::{Studio, Update};
