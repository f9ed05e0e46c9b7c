use glam::{Vec2, Vec3};

use crate::sampling::hammersley;
use crate::{MIN_N_DOT_V, alpha_from_roughness, g1_smith_ggx, lambda_ggx, sample_ggx_vndf};

/// Samples of one entry; the table's error against fine quadrature is under 0.003 (see `tests`).
const SAMPLES: u32 = 128;

/// Split-sum environment BRDF (Karis 2013, "Real shading in Unreal Engine 4"): `(scale, bias)` so that the directional albedo
/// of GGX is `f0 * scale + f90 * bias` under Schlick's Fresnel. `n_dot_v` and `roughness` are in `[0, 1]`.
///
/// Visible normals make every sample's weight `G2 / G1(wo)` (Heitz 2018, eq. 19); the points are fixed, so is the result.
pub fn dfg(n_dot_v: f32, roughness: f32) -> Vec2 {
    let alpha = alpha_from_roughness(roughness);
    let n_dot_v = n_dot_v.clamp(MIN_N_DOT_V, 1.0);
    let wo = Vec3::new((1.0 - n_dot_v * n_dot_v).max(0.0).sqrt(), 0.0, n_dot_v);
    let lambda_v = lambda_ggx(n_dot_v, alpha);
    let mut sum = Vec2::ZERO;
    for i in 0..SAMPLES {
        let s = hammersley(i, SAMPLES);
        // What is lost under the surface lies at the rim of the disk of normals: u = 1 - (1 - s)^2 puts more points there,
        // and du/ds = 2 (1 - s) weighs them.
        let rim = 1.0 - s.x;
        let h = sample_ggx_vndf(wo, alpha, Vec2::new(1.0 - rim * rim, s.y));
        let v_dot_h = wo.dot(h).clamp(0.0, 1.0);
        let n_dot_l = 2.0 * v_dot_h * h.z - n_dot_v;
        if n_dot_l <= 0.0 {
            continue;
        }
        let g2 = 1.0 / (1.0 + lambda_v + lambda_ggx(n_dot_l, alpha));
        let weight = 2.0 * rim * g2 / g1_smith_ggx(n_dot_v, alpha);
        let fresnel = (1.0 - v_dot_h).powi(5);
        sum += weight * Vec2::new(1.0 - fresnel, fresnel);
    }
    sum / SAMPLES as f32
}

/// `size * size` entries of [`dfg`], row-major: `n_dot_v = (x + 0.5) / size`, `roughness = (y + 0.5) / size`.
pub fn dfg_table(size: u32) -> Vec<Vec2> {
    let coordinate = |i: u32| (i as f32 + 0.5) / size as f32;
    (0..size).flat_map(|y| (0..size).map(move |x| dfg(coordinate(x), coordinate(y)))).collect()
}
