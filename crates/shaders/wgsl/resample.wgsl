#import math

// Resampling of a shadow buffer that has fewer samples than the picture (DeCoro and Rusinkiewicz 2008, section 3.2): weights
// Gaussian(|dx|) (n . n'). Across the screen |dx| counts in tiles of the buffer, so that the radius adapts to its
// coarseness; out of the receiver's own plane it counts in tiles, too, which keeps weights from crossing depth edges.

// Standard deviation of the Gaussian across the screen [tiles].
const RESAMPLE_SIGMA: f32 = 0.5;
// Standard deviation out of the receiver's plane [tiles].
const RESAMPLE_SIGMA_HEIGHT: f32 = 0.5;
// Exponent of n . n' on a matte surface, and the most of all: narrower highlights take fewer samples, and blur shows the less.
const RESAMPLE_NORMAL_POWER: f32 = 4.0;
const RESAMPLE_MAX_NORMAL_POWER: f32 = 110.0;
// Exponent of a glossy surface over that of its lobe as a power of n . h.
const RESAMPLE_LOBE_SHARE: f32 = 0.65;
// A sample with less weight than this among the tiles around it is lit by itself. Amid tiles of its own plane the weights sum to
// at least 1.4.
const RESAMPLE_MIN_WEIGHT: f32 = 0.3;

// Exponent of n . n' for a surface with a GGX lobe of this alpha, 1 for a matte one: a highlight changes with the normal as its lobe does,
// which is about n . h to the power of 2 / alpha^2.
fn resample_normal_power(alpha: f32) -> f32 {
    return clamp(2.0 * RESAMPLE_LOBE_SHARE / (alpha * alpha), RESAMPLE_NORMAL_POWER, RESAMPLE_MAX_NORMAL_POWER);
}

fn resample_weight(across: vec2f, height: f32, n_dot_n: f32, normal_power: f32) -> f32 {
    let squares = dot(across, across) / (RESAMPLE_SIGMA * RESAMPLE_SIGMA)
        + height * height / (RESAMPLE_SIGMA_HEIGHT * RESAMPLE_SIGMA_HEIGHT);
    return exp(-0.5 * squares) * pow(max(n_dot_n, 0.0), normal_power);
}
