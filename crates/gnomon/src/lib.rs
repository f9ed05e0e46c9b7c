//! Gnomon lights a scene in which everything moves with an HDR environment map, soft shadows included.
//!
//! Pictures, environments, lights, materials and scenes are always there. The rest are features, all of them on by default:
//!
//! | feature | brings |
//! |---|---|
//! | `files` | `scene_files`: scene and camera files |
//! | `metrics` | `metrics`: differences of pictures |
//! | `reference` | `reference`: the ray tracer that tells the truth |
//! | `renderer` | `renderer`: frames on a GPU |
//! | `studio` | `studio`: a live session; it needs the four others |
//!
#![cfg_attr(feature = "renderer", doc = "```no_run")]
#![cfg_attr(not(feature = "renderer"), doc = "```ignore")]
//! use gnomon::lights::fit::{self, FitOptions};
//! use gnomon::renderer::{Gpu, GpuOptions, RenderSettings, Renderer};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = gnomon::scene::builtin::by_name("three-boxes")?;
//! let environment = gnomon::envmap::load("grace.hdr", Default::default())?.map;
//! let lights = fit::by_name("optimized", &FitOptions::default())?.fit(&environment)?;
//!
//! let gpu = Gpu::new(&GpuOptions::default())?;
//! let mut renderer = Renderer::new(&gpu, RenderSettings::default())?;
//! renderer.set_scene(&scene)?;
//! renderer.set_lighting(&environment, &lights)?;
//! let frame = renderer.render(&scene.cameras[0], 1024, 768)?; // frame.radiance, frame.display
//! # Ok(())
//! # }
//! ```

pub use gnomon_brdf as brdf;
pub use gnomon_envmap as envmap;
pub use gnomon_lights as lights;
#[cfg(feature = "files")]
pub use gnomon_measured as measured;
#[cfg(feature = "metrics")]
pub use gnomon_metrics as metrics;
pub use gnomon_options as options;
pub use gnomon_picture as picture;
#[cfg(feature = "reference")]
pub use gnomon_reference as reference;
#[cfg(feature = "renderer")]
pub use gnomon_renderer as renderer;
pub use gnomon_rigs as rigs;
pub use gnomon_scene as scene;
#[cfg(feature = "files")]
pub use gnomon_scene_files as scene_files;
#[cfg(feature = "studio")]
pub use gnomon_studio as studio;
