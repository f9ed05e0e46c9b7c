#import math

// Fourier series of the shadow test [d <= z] (Annen et al. 2007; 2008 appendix, eq. 10).

// Depths are scaled into [0, 0.9] before the series: it is a square wave of period 2, and with d near 0 and z near 1 it would already be
// falling into its next period. Biased depths stay above the least for which four terms still call the far plane lit.
const SERIES_DEPTH_SCALE: f32 = 0.9;
const SERIES_LEAST_DEPTH: f32 = -0.02;

// cos(c_k x) and sin(c_k x) of the four terms of one RGBA layer, k = 4 group + 1 .. 4 group + 4: the first by definition, the
// others by turning it by 2 pi x.
fn series_phases(x: f32, group: u32) -> mat2x4f {
    let first = PI * (8.0 * f32(group) + 1.0) * x;
    let turn = vec2f(cos(TAU * x), sin(TAU * x));
    let p1 = vec2f(cos(first), sin(first));
    let p2 = vec2f(p1.x * turn.x - p1.y * turn.y, p1.x * turn.y + p1.y * turn.x);
    let p3 = vec2f(p2.x * turn.x - p2.y * turn.y, p2.x * turn.y + p2.y * turn.x);
    let p4 = vec2f(p3.x * turn.x - p3.y * turn.y, p3.x * turn.y + p3.y * turn.x);
    return mat2x4f(vec4f(p1.x, p2.x, p3.x, p4.x), vec4f(p1.y, p2.y, p3.y, p4.y));
}

// 2 / c_k for terms up to `order`, 0 beyond it.
fn series_weights(group: u32, order: u32) -> vec4f {
    let k = vec4f(1.0, 2.0, 3.0, 4.0) + 4.0 * f32(group);
    return select(vec4f(0.0), 2.0 / (PI * (2.0 * k - 1.0)), k <= vec4f(f32(order)));
}

// One layer's part of s_f - 1/2: sum of (2 / c_k) [cos(c_k d) S_k - sin(c_k d) C_k]; `phases` are those of d.
fn series_lit(phases: mat2x4f, filtered_sin: vec4f, filtered_cos: vec4f, weights: vec4f) -> f32 {
    return dot(weights, phases[0] * filtered_sin - phases[1] * filtered_cos);
}

// One layer's part of the CSM-Z numerator less half the filtered depth (2008, eq. 11).
fn series_blocker_depth(phases: mat2x4f, filtered_z_sin: vec4f, filtered_z_cos: vec4f, weights: vec4f) -> f32 {
    return dot(weights, phases[1] * filtered_z_cos - phases[0] * filtered_z_sin);
}

// Scale, shift and clamp so that ringing only falls outside [0, 1] (2008, section 3.3, Fig. 3).
fn suppress_ringing(s: f32, black_point: f32, white_point: f32) -> f32 {
    return clamp((s - black_point) / (white_point - black_point), 0.0, 1.0);
}

// Darkening at contacts (2008, eq. 9).
fn sharpen(s: f32, blocker_distance: f32, a: f32, b: f32) -> f32 {
    return pow(max(s, 0.0), 1.0 + a * exp(-b * max(blocker_distance, 0.0)));
}

// Variance of a bilinear lookup in squared texels of its level: `LOOKUP_VARIANCE` of light_frame.rs.
const LOOKUP_VARIANCE: f32 = 5.0 / 12.0;

// Mip level whose trilinear lookup has the variance of a bilinear lookup in texels of `width`. The variance of a level is four
// times that of the level above it, and linear interpolation between levels interpolates variance linearly.
fn level_from_width(width: f32) -> f32 {
    if width <= 1.0 {
        return 0.0;
    }
    let base = floor(log2(width));
    let ratio = width / exp2(base);
    return base + (ratio * ratio - 1.0) / 3.0;
}
