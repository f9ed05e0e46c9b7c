//! Real-time renderer: a scene under an [`gnomon_lights::LightSet`], every light with soft shadows, nothing precomputed on the scene.
//!
//! One frame: `transform` brings vertices to world space; `shadow maps` draws the scene's depth from every light;
//! `shadow filter` makes the shadow technique's images of them; `gbuffer` draws what the camera sees; `points` lists
//! the samples that are lit and `light` sums the lights there, in turns; `compose` makes radiance of the sums, of a smooth pixel once, of an edge pixel sample by
//! sample; `resolve` tone-maps it.

pub mod ambient;
mod batch_plan;
mod bindings;
mod bumps;
mod camera;
mod casters;
mod compose;
pub mod composite;
mod cryptomatte;
pub mod debug_view;
mod deformation;
mod error;
mod gbuffer;
mod geometry;
mod gloss;
mod gpu;
mod ground;
mod irradiance;
pub mod layers;
mod light_batches;
mod light_frame;
mod light_pass;
mod light_points;
mod light_uniforms;
mod lighting;
pub mod lod;
mod materials;
mod mip_chain;
mod models;
mod near_light_frame;
mod present;
mod radiance_cache;
mod ray_scene;
mod recorder;
mod renderer;
mod resolve;
mod seen;
mod settings;
mod shading_points;
pub mod shadow;
mod sky_samples;
#[cfg(test)]
mod twins;
pub mod unshadowed;
mod view_slices;

pub use batch_plan::ShadowSizing;
pub use bumps::{BumpShadows, Bumps};
pub use error::RenderError;
pub use gloss::{GlossPath, Reflections};
#[cfg(not(target_arch = "wasm32"))]
pub use gpu::list_adapters;
pub use gpu::{AdapterSummary, Gpu, GpuOptions};
pub use lighting::PreparedLighting;
pub use present::Presenter;
pub use recorder::PassTiming;
pub use renderer::{Change, Frame, LightingChange, Renderer, SceneChange, TimedFrame};
pub use settings::{
    Background, DisplaySettings, LightPaths, LightingSettings, MeasureSettings, RenderSettings,
    TechniqueSettings,
};
/// The graphics interface that [`Gpu::from_wgpu`] and [`Renderer::display_view`] speak of.
pub use wgpu;
