//! Reflectance models. One file a model ([`Model`] lists them); every function that a shader also has bears the shader's name.
//!
//! Measures: a lobe's value is per steradian without the cosine; every pdf is per steradian of `wi`. `wo` points to the viewer, `wi`
//! to the light, both unit length, in the surface's tangent [`Frame`]: `z` is the shading normal, `x` the tangent.
//!
//! References: Walter et al. 2007 (GGX, Beckmann); Heidrich 2001 (Torrance-Sparrow); Phong 1975, Lafortune and Willems 1994, Blinn
//! 1977; Heitz 2014, 2018 (masking, visible normals); glTF 2.0 appendix B with `KHR_materials_specular` and `KHR_materials_ior`; Karis
//! 2013 (split sum).

mod area;
mod dfg;
mod finish;
mod frame;
mod fresnel;
mod ggx;
mod layers;
mod lobe;
mod model;
mod parameter;
mod sampling;
mod sheen;
mod surface;
pub mod tables;
mod torrance_sparrow;

pub use area::{LightPatch, erf, gaussian_interval, gaussian_patch};
pub use dfg::{dfg, dfg_table};
pub use finish::{
    Finish, SeenFinish, coat_share, finish_light, finish_pdf, finish_sample, finish_strength, finish_value,
};
pub use frame::Frame;
pub use fresnel::{METALS, Metal, f_exact, f_schlick, f0_from_ior};
pub use ggx::{
    MIN_ALPHA, MIN_N_DOT_V, alpha_from_roughness, d_ggx, g1_smith_ggx, lambda_ggx, pdf_ggx_vndf,
    sample_ggx_vndf, v_smith_ggx_correlated,
};
pub use layers::{Layers, Sample};
pub use lobe::Lobe;
pub use model::blinn_phong::blinn_phong_norm;
pub use model::torrance_sparrow_beckmann::d_beckmann;
pub use model::torrance_sparrow_gaussian::{d_gaussian, gaussian_masking_slope, gaussian_norm};
pub use model::{Model, ReflectanceModel};
pub use parameter::*;
pub use sampling::sample_cosine_hemisphere;
pub use sheen::{
    MIN_SHEEN_ROUGHNESS, d_charlie, lambda_charlie, sheen_albedo, sheen_light, sheen_sample, sheen_value,
};
pub use surface::Surface;
pub use tables::Tables;
pub use torrance_sparrow::{g1_smith_beckmann, v_smith_beckmann};
