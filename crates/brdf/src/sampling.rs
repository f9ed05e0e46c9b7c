use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

/// Cosine-weighted direction about +z for `u` in `[0, 1)^2`; its pdf is `z / pi` (Malley's method).
pub fn sample_cosine_hemisphere(u: Vec2) -> Vec3 {
    let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
    let r = u.x.sqrt();
    // From 1 - u.x, not 1 - r^2, so that z is never lost to rounding for u.x < 1.
    Vec3::new(r * cos_phi, r * sin_phi, (1.0 - u.x).max(0.0).sqrt())
}

/// `wo` mirrored about the unit vector `n`: the direction that light comes from.
pub(crate) fn reflect(n: Vec3, wo: Vec3) -> Vec3 {
    2.0 * n.dot(wo) * n - wo
}

/// `wo` mirrored about the surface's normal.
pub(crate) fn mirrored(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}

/// Unit vector that halves the angle between two; 0 where they are opposite.
pub(crate) fn half_vector(wo: Vec3, wi: Vec3) -> Vec3 {
    (wo + wi).normalize_or_zero()
}

/// Smallest cosine that is raised to a power: the logarithm stays finite.
const MIN_COSINE: f32 = 1e-20;

/// `cosine^exponent`, 0 for a negative cosine unless the exponent is 0.
pub(crate) fn cosine_power(cosine: f32, exponent: f32) -> f32 {
    cosine.max(MIN_COSINE).powf(exponent)
}

/// A direction about +z with the density `(exponent + 1) / (2 pi) z^exponent`.
pub(crate) fn sample_cosine_power(exponent: f32, u: Vec2) -> Vec3 {
    let z = (1.0 - u.x).powf(1.0 / (exponent + 1.0));
    let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
    Vec3::new(r * cos_phi, r * sin_phi, z)
}

/// Point `i` of `count` of the Hammersley set, moved to the middle of its stratum.
pub(crate) fn hammersley(i: u32, count: u32) -> Vec2 {
    // 24 bits keep the radical inverse under 1 in 32-bit floats.
    let radical_inverse = (i.reverse_bits() >> 8) as f32 / (1u32 << 24) as f32;
    Vec2::new((i as f32 + 0.5) / count as f32, radical_inverse + 0.5 / count as f32)
}
