//! A window over the library: look around a scene, change everything its picture depends on, and compare it with the reference.
//!
//! Nothing happens here but widgets, input and a camera: sessions are [`gnomon_studio::Studio`]'s.

mod app;
mod error;
mod keys;
mod notices;
mod overlay;
mod panel;
mod picture;
mod player;
pub mod script;
mod targets;
mod viewer;
mod window;

use std::path::PathBuf;

pub use error::ViewerError;
pub use window::run;

/// What to open, and how.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// A file, or the name of a built-in scene; `None` opens one to look at.
    pub scene: Option<String>,
    /// A file, or the name of a built-in environment; `None` is the scene's own, or a built-in one.
    pub environment: Option<String>,
    /// Part of the adapter's name or backend; `None` takes the fastest that can draw to the window.
    pub adapter: Option<String>,
    /// Frames a second that the level of detail is to hold, above 0; `None` leaves it to the user.
    pub target_fps: Option<f64>,
    /// Actions to be done in place of a user, see [`script`].
    pub script: Option<PathBuf>,
    /// Width and height of the window [points].
    pub size: Option<[f32; 2]>,
}
