//! Gnomon lights a scene in which everything moves with an HDR environment map, soft shadows included.
//!
//! ```no_run
//! use gnomon::lights::fit::{self, FitOptions};
//! use gnomon::renderer::{Gpu, GpuOptions, RenderSettings, Renderer};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = gnomon::scene::builtin::by_name("three-boxes")?;
//! let environment = gnomon::envmap::load("grace.hdr", None)?.map;
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

pub use gnomon_bench as bench;
pub use gnomon_brdf as brdf;
pub use gnomon_envmap as envmap;
pub use gnomon_image as image;
pub use gnomon_lights as lights;
pub use gnomon_metrics as metrics;
pub use gnomon_reference as reference;
pub use gnomon_renderer as renderer;
pub use gnomon_report as report;
pub use gnomon_scene as scene;
pub use gnomon_studio as studio;
