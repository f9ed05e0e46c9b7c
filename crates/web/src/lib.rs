//! A live session for a page in a browser, by wasm-bindgen: [`gnomon_studio::Studio`] with a canvas to draw on, and its tracer for
//! another worker. What a panel offers is told as JSON, made of the options as they are declared.
//!
//! Everything but [`panel`] and [`files`] exists for wasm32 alone.

pub mod files;
pub mod panel;

#[cfg(target_arch = "wasm32")]
mod canvas;
#[cfg(target_arch = "wasm32")]
mod detail;
#[cfg(target_arch = "wasm32")]
mod error;
#[cfg(target_arch = "wasm32")]
mod frames;
#[cfg(target_arch = "wasm32")]
mod session;
#[cfg(target_arch = "wasm32")]
mod split;
#[cfg(target_arch = "wasm32")]
mod tracer;

#[cfg(target_arch = "wasm32")]
pub use session::{FileSet, Session};
#[cfg(target_arch = "wasm32")]
pub use tracer::Tracer;
