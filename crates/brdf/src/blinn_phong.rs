//! Blinn's form of Phong's lobe (Blinn 1977): a power of the cosine between normal and half vector.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::phong::{cosine_power, sample_cosine_power};
use crate::sampling::{reflect, world_from_local};

/// Factor with which `(n . h)^s` reflects everything that arrives along the normal [1/sr]:
/// `(s + 2) (s + 4) / (8 pi (2^(-s/2) + s))`.
///
/// It is the inverse of the integral of `cos(theta / 2)^s cos(theta)` over the hemisphere. (The often seen `(s + 8) / (8 pi)` is
/// its approximation; Akenine-Moeller et al., "Real-Time Rendering", 3rd edition, section 7.6.)
pub fn blinn_phong_norm(shininess: f32) -> f32 {
    let s = shininess;
    (s + 2.0) * (s + 4.0) / (8.0 * PI * ((-0.5 * s).exp2() + s))
}

/// Blinn's lobe for a specular colour of 1 [1/sr]: reciprocal, and seen along the normal it reflects exactly the specular
/// colour, elsewhere less.
pub fn blinn_phong_lobe(shininess: f32, n: Vec3, wo: Vec3, wi: Vec3) -> f32 {
    blinn_phong_norm(shininess) * cosine_power(n.dot((wo + wi).normalize_or_zero()), shininess)
}

/// `wo` mirrored about a half vector drawn about `n`, distributed as [`blinn_phong_pdf`] for `u` in `[0, 1)^2`. It may lie under
/// the surface.
pub fn blinn_phong_sample(shininess: f32, n: Vec3, wo: Vec3, u: Vec2) -> Vec3 {
    reflect(world_from_local(n, sample_cosine_power(shininess, u)), wo)
}

/// Density of [`blinn_phong_sample`] [1/sr]: `(s + 1) / (2 pi) (n . h)^s / (4 wo . h)`.
pub fn blinn_phong_pdf(shininess: f32, n: Vec3, wo: Vec3, wi: Vec3) -> f32 {
    let h = (wo + wi).normalize_or_zero();
    let (n_dot_h, v_dot_h) = (n.dot(h), wo.dot(h));
    if n_dot_h <= 0.0 || v_dot_h <= 0.0 {
        return 0.0;
    }
    (shininess + 1.0) / TAU * cosine_power(n_dot_h, shininess) / (4.0 * v_dot_h)
}
