//! Reflectance models. One file a model; every function that a shader also has bears the shader's name.
//!
//! Measures: `f` is per steradian without the cosine; every pdf is per steradian of `wi`. `wo` points to the viewer, `wi`
//! to the light, both unit length; in the local frame `z` is the shading normal.
//!
//! References: Walter et al. 2007 (GGX); Heitz 2014, 2018 (masking, visible normals); glTF 2.0 appendix B with
//! `KHR_materials_specular` and `KHR_materials_ior`; Karis 2013 (split sum).

mod dfg;
mod fresnel;
mod ggx;
mod lambert;
mod metallic_roughness;
mod reflectance;
mod sampling;
mod surface;

pub use dfg::{dfg, dfg_table};
pub use fresnel::{f_schlick, f0_from_ior};
pub use ggx::{
    MIN_ALPHA, MIN_N_DOT_V, alpha_from_roughness, d_ggx, g1_smith_ggx, lambda_ggx, pdf_ggx_vndf,
    sample_ggx_vndf, v_smith_ggx_correlated,
};
pub use lambert::{Lambert, fd_lambert};
pub use metallic_roughness::{MetallicRoughness, evaluate_metallic_roughness};
pub use reflectance::{MODELS, Reflectance, ReflectanceModel, Sample, model};
pub use sampling::{local_from_world, sample_cosine_hemisphere, world_from_local};
pub use surface::Surface;
