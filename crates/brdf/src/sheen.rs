//! Sheen of cloth (`KHR_materials_sheen`): the "Charlie" distribution of Conty Estevez and Kulla 2017, "Production friendly microfacet sheen
//! BRDF", with its own masking.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::sampling::half_vector;
use crate::{LightPatch, MIN_N_DOT_V};

/// Smallest perceptual roughness: the lobe of smoother fibres lies within six degrees of the horizon.
pub const MIN_SHEEN_ROUGHNESS: f32 = 0.1;

fn alpha_from_sheen_roughness(roughness: f32) -> f32 {
    let roughness = roughness.clamp(MIN_SHEEN_ROUGHNESS, 1.0);
    roughness * roughness
}

/// Distribution of normals [1/sr] (section 2 of the paper).
pub fn d_charlie(n_dot_h: f32, alpha: f32) -> f32 {
    let sine2 = ((1.0 - n_dot_h).max(0.0) * (1.0 + n_dot_h)).max(1e-20);
    (2.0 + 1.0 / alpha) / TAU * sine2.powf(0.5 / alpha)
}

/// Smith's auxiliary function of that distribution, as the paper fits it (section 3).
pub fn lambda_charlie(cosine: f32, alpha: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let mix = |rough: f32, smooth: f32| rough + (smooth - rough) * t;
    let (a, b, c) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801));
    let (d, e) = (mix(-1.97760, -1.27393), mix(-4.32054, -4.85967));
    let l = |x: f32| a / (1.0 + b * x.max(1e-9).powf(c)) + d * x + e;
    if cosine < 0.5 { l(cosine).exp() } else { (2.0 * l(0.5) - l(1.0 - cosine)).exp() }
}

/// Value of white sheen [1/sr], without the cosine.
pub fn sheen_value(roughness: f32, wo: Vec3, wi: Vec3) -> f32 {
    if wi.z <= 0.0 {
        return 0.0;
    }
    let alpha = alpha_from_sheen_roughness(roughness);
    let (n_dot_v, n_dot_l) = (wo.z.max(MIN_N_DOT_V), wi.z.max(MIN_N_DOT_V));
    let masking = 1.0 + lambda_charlie(n_dot_v, alpha) + lambda_charlie(n_dot_l, alpha);
    d_charlie(half_vector(wo, wi).z, alpha) / (masking * 4.0 * n_dot_v * n_dot_l)
}

/// Uniform over the hemisphere: the lobe is wide, and highest towards the horizon.
pub fn sheen_sample(u: Vec2) -> Vec3 {
    let r = ((1.0 - u.x) * (1.0 + u.x)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
    Vec3::new(r * cos_phi, r * sin_phi, u.x)
}

/// Points of a light along each of its sides.
const LIGHT_POINTS: u32 = 3;

/// Integral of white sheen times the cosine over an area light: the mean of a few points of it.
pub fn sheen_light(roughness: f32, wo: Vec3, light: &LightPatch) -> f32 {
    // A square for a disk, of its area.
    let scale = if light.is_disk { 0.5 * PI.sqrt() } else { 1.0 };
    let (a, b) = (scale * light.half_width, scale * light.half_height);
    let solid_angle = 4.0 * a.cross(b).length();
    let mut sum = 0.0;
    for i in 0..LIGHT_POINTS * LIGHT_POINTS {
        let at = |place: u32| (2.0 * place as f32 + 1.0) / LIGHT_POINTS as f32 - 1.0;
        let wi = (light.direction + at(i % LIGHT_POINTS) * a + at(i / LIGHT_POINTS) * b).normalize();
        sum += sheen_value(roughness, wo, wi) * wi.z.max(0.0);
    }
    sum * solid_angle / (LIGHT_POINTS * LIGHT_POINTS) as f32
}

/// Share of uniform light that white sheen reflects, above 1 for smooth fibres at grazing views. The exponential of a polynomial of powers of
/// cosine and roughness, fitted to quadrature; its error is at most 0.004.
pub fn sheen_albedo(n_dot_v: f32, roughness: f32) -> f32 {
    let x = 2.0 * n_dot_v.clamp(MIN_N_DOT_V, 1.0).powf(0.35) - 1.0;
    let least = MIN_SHEEN_ROUGHNESS.sqrt();
    let y = 2.0 * (roughness.clamp(MIN_SHEEN_ROUGHNESS, 1.0).sqrt() - least) / (1.0 - least) - 1.0;
    let horner = |sum: f32, coefficient: f32, x: f32| sum * x + coefficient;
    let row = |row: &&[f32]| row.iter().rev().fold(0.0, |sum, &coefficient| horner(sum, coefficient, y));
    SHEEN_ALBEDO.iter().map(row).rev().fold(0.0, |sum, coefficient| horner(sum, coefficient, x)).exp()
}

/// Coefficients of powers of the cosine's coordinate; each row has those of powers of the roughness's.
const SHEEN_ALBEDO: [&[f32]; 7] = [
    &[-0.74026, 0.274512, 0.357819, -0.00734018, -0.397441, 0.102027],
    &[-1.33475, 1.00308, -0.964969, 0.860866, -0.696752, 0.277774],
    &[-0.686047, 0.846554, -1.39064, 1.3289, -0.476526],
    &[-0.245873, 0.994721, -1.30587, 0.511931],
    &[-0.585693, 1.0186, -0.455921],
    &[-0.163936, 0.395611],
    &[-0.348205],
];
