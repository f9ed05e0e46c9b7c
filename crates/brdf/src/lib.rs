//! Reflectance models. One file a model; every function that a shader also has bears the shader's name.
//!
//! Measures: `f` is per steradian without the cosine; every pdf is per steradian of `wi`. `wo` points to the viewer, `wi`
//! to the light, both unit length; in the local frame `z` is the shading normal.
//!
//! References: Walter et al. 2007 (GGX, Beckmann); Heidrich 2001 (Torrance-Sparrow); Phong 1975, Lafortune and Willems 1994, Blinn 1977; Heitz 2014, 2018 (masking, visible normals); glTF 2.0 appendix B with
//! `KHR_materials_specular` and `KHR_materials_ior`; Karis 2013 (split sum).

mod area;
mod blinn_phong;
mod dfg;
mod fresnel;
mod ggx;
mod glossy;
mod lambert;
mod lobe;
mod metallic_roughness;
mod phong;
mod reflectance;
mod sampling;
mod surface;
mod torrance_sparrow;

pub use area::{LightPatch, erf, gaussian_interval, gaussian_patch, light_lobe};
pub use blinn_phong::{blinn_phong_lobe, blinn_phong_norm, blinn_phong_pdf, blinn_phong_sample};
pub use dfg::{dfg, dfg_table};
pub use fresnel::{f_schlick, f0_from_ior};
pub use ggx::{
    MIN_ALPHA, MIN_N_DOT_V, alpha_from_roughness, d_ggx, g1_smith_ggx, lambda_ggx, pdf_ggx_vndf,
    sample_ggx_vndf, v_smith_ggx_correlated,
};
pub use glossy::Glossy;
pub use lambert::{Lambert, fd_lambert};
pub use lobe::{reflectance_lobe, reflectance_pdf, reflectance_sample};
pub use metallic_roughness::{MetallicRoughness, evaluate_metallic_roughness};
pub use phong::{phong_lobe, phong_pdf, phong_sample};
pub use reflectance::{MODELS, Model, Reflectance, ReflectanceModel, Sample, model};
pub use sampling::{local_from_world, sample_cosine_hemisphere, world_from_local};
pub use surface::{Layers, MAX_SHININESS, Surface};
pub use torrance_sparrow::{
    MAX_SLOPE, MIN_SLOPE, SlopeDistribution, d_beckmann, d_gaussian, g1_smith_beckmann, gaussian_norm,
    torrance_sparrow_lobe, torrance_sparrow_pdf, torrance_sparrow_sample, v_smith_beckmann,
};
