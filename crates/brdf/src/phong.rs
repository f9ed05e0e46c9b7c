//! Phong's lobe about the mirrored view direction (Phong 1975), reciprocal and normalised as by Lafortune and Willems 1994.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use crate::sampling::{reflect, world_from_local};

/// Smallest cosine that is raised to a power: the logarithm stays finite.
const MIN_COSINE: f32 = 1e-20;

/// `cosine^exponent`, 0 for a negative cosine unless the exponent is 0.
pub(crate) fn cosine_power(cosine: f32, exponent: f32) -> f32 {
    cosine.max(MIN_COSINE).powf(exponent)
}

/// Phong's lobe for a specular colour of 1 [1/sr]: `(s + 2) / (2 pi) cos^s`, the cosine being that between `wi` and the
/// mirrored `wo`.
///
/// In this form, without a division by the cosine at the surface, the model is reciprocal; seen along the normal it
/// reflects exactly the specular colour, elsewhere less (Lafortune and Willems 1994, "Using the modified Phong reflectance
/// model for physically based rendering", eqs. 1 and 8).
pub fn phong_lobe(shininess: f32, n: Vec3, wo: Vec3, wi: Vec3) -> f32 {
    (shininess + 2.0) / TAU * cosine_power(reflect(n, wo).dot(wi), shininess)
}

/// A direction about the mirrored `wo`, distributed as [`phong_pdf`] for `u` in `[0, 1)^2`. It may lie under the surface.
pub fn phong_sample(shininess: f32, n: Vec3, wo: Vec3, u: Vec2) -> Vec3 {
    world_from_local(reflect(n, wo), sample_cosine_power(shininess, u))
}

/// Density of [`phong_sample`] [1/sr]: `(s + 1) / (2 pi) cos^s`.
pub fn phong_pdf(shininess: f32, n: Vec3, wo: Vec3, wi: Vec3) -> f32 {
    let cosine = reflect(n, wo).dot(wi);
    if cosine > 0.0 { (shininess + 1.0) / TAU * cosine_power(cosine, shininess) } else { 0.0 }
}

/// A direction about +z with the density `(exponent + 1) / (2 pi) z^exponent`.
pub(crate) fn sample_cosine_power(exponent: f32, u: Vec2) -> Vec3 {
    let z = (1.0 - u.x).powf(1.0 / (exponent + 1.0));
    let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
    Vec3::new(r * cos_phi, r * sin_phi, z)
}
