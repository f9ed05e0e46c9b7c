//! Real-time renderer: a scene under an [`gnomon_lights::LightSet`], every light with soft shadows, nothing precomputed on the scene.
//!
//! One frame: `transform` brings vertices to world space; `shadow maps` draws the scene's depth from every light;
//! `shadow filter` makes the shadow technique's images of them; `gbuffer` draws what the camera sees; `shade` lights
//! every sample in compute; `resolve` filters samples to pixels and tone-maps them.

pub mod ambient;
mod batch_plan;
mod bindings;
mod bounds;
mod camera;
pub mod composite;
mod depth_maps;
mod error;
mod gbuffer;
mod geometry;
mod gpu;
mod light_frame;
mod lighting;
mod materials;
mod near_light_frame;
mod readback;
mod recorder;
mod renderer;
mod resolve;
mod shade;
pub mod shadow;
mod shadow_batches;
#[cfg(test)]
mod twins;

pub use batch_plan::ShadowSizing;
pub use error::RenderError;
pub use gpu::{AdapterSummary, Gpu, GpuOptions, list_adapters};
pub use recorder::PassTiming;
pub use renderer::{Frame, RenderSettings, Renderer};
