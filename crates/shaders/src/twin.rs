//! Rust twins of shader functions that belong to no other crate: same names, same arithmetic, compared over random inputs.
//!
//! BRDFs have their twins in `gnomon-brdf`, form factors in `gnomon-lights`, tone mapping in `gnomon-picture`, SH in `gnomon-envmap`.

pub mod depth_moments;
pub mod gbuffer_packing;
pub mod half_pairs;
pub mod hemisphere;
pub mod hit_normals;
pub mod math;
pub mod micromap;
pub mod partial_cover;
pub mod pyramid_meets_box;
pub mod resample;
pub mod sample_pattern;
pub mod series;
pub mod triangle_hit;
pub mod unit_outline;
pub mod weighted_box;
