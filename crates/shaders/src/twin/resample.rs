//! `resample.wgsl`.

use glam::Vec2;

const RESAMPLE_SIGMA: f32 = 0.5;
const RESAMPLE_SIGMA_HEIGHT: f32 = 0.5;
const RESAMPLE_NORMAL_POWER: f32 = 4.0;
const RESAMPLE_MAX_NORMAL_POWER: f32 = 110.0;
const RESAMPLE_LOBE_SHARE: f32 = 0.65;

/// Exponent of the cosine between normals for a surface with a GGX lobe of this alpha, 1 for a matte one.
pub fn resample_normal_power(alpha: f32) -> f32 {
    (2.0 * RESAMPLE_LOBE_SHARE / (alpha * alpha)).clamp(RESAMPLE_NORMAL_POWER, RESAMPLE_MAX_NORMAL_POWER)
}

/// Weight of a point of the shadow buffer `across` the screen and at `height` above the receiver's plane [tiles], with the cosine between
/// the normals to the power of `normal_power` (DeCoro and Rusinkiewicz 2008, section 3.2).
pub fn resample_weight(across: Vec2, height: f32, n_dot_n: f32, normal_power: f32) -> f32 {
    let squares = across.length_squared() / (RESAMPLE_SIGMA * RESAMPLE_SIGMA)
        + height * height / (RESAMPLE_SIGMA_HEIGHT * RESAMPLE_SIGMA_HEIGHT);
    (-0.5 * squares).exp() * n_dot_n.max(0.0).powf(normal_power)
}
