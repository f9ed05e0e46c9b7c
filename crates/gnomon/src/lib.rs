//! Gnomon lights a scene in which everything moves with an HDR environment map, soft shadows included.
pub use gnomon_brdf as brdf;
pub use gnomon_envmap as envmap;
pub use gnomon_image as image;
pub use gnomon_lights as lights;
pub use gnomon_metrics as metrics;
pub use gnomon_reference as reference;
pub use gnomon_renderer as renderer;
pub use gnomon_scene as scene;
