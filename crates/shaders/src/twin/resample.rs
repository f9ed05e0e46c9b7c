//! `resample.wgsl`.

use glam::Vec2;

const RESAMPLE_SIGMA: f32 = 0.5;
const RESAMPLE_SIGMA_HEIGHT: f32 = 0.5;
const RESAMPLE_NORMAL_POWER: f32 = 4.0;

/// Weight of a point of the shadow buffer `across` the screen and at `height` above the receiver's plane [tiles], with the cosine between
/// the normals (DeCoro and Rusinkiewicz 2008, section 3.2).
pub fn resample_weight(across: Vec2, height: f32, n_dot_n: f32) -> f32 {
    let squares = across.length_squared() / (RESAMPLE_SIGMA * RESAMPLE_SIGMA)
        + height * height / (RESAMPLE_SIGMA_HEIGHT * RESAMPLE_SIGMA_HEIGHT);
    (-0.5 * squares).exp() * n_dot_n.max(0.0).powf(RESAMPLE_NORMAL_POWER)
}
