//! Twins of `series.wgsl`: the Fourier series of the shadow test (Annen et al. 2008).

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec4};

/// Depths are scaled into `[0, 0.9]` before the series, away from the square wave's next period.
pub const SERIES_DEPTH_SCALE: f32 = 0.9;

/// `cos(c_k x)` and `sin(c_k x)` of the four terms `k = 4 group + 1 ..= 4 group + 4`, `c_k = pi (2k - 1)`.
pub fn series_phases(x: f32, group: u32) -> [Vec4; 2] {
    let first = PI * (8.0 * group as f32 + 1.0) * x;
    let turn = Vec2::new((TAU * x).cos(), (TAU * x).sin());
    let p1 = Vec2::new(first.cos(), first.sin());
    let p2 = turn.rotate(p1);
    let p3 = turn.rotate(p2);
    let p4 = turn.rotate(p3);
    [Vec4::new(p1.x, p2.x, p3.x, p4.x), Vec4::new(p1.y, p2.y, p3.y, p4.y)]
}

/// `2 / c_k` for terms up to `order`, 0 beyond it.
pub fn series_weights(group: u32, order: u32) -> Vec4 {
    let k = Vec4::new(1.0, 2.0, 3.0, 4.0) + 4.0 * group as f32;
    Vec4::select(k.cmple(Vec4::splat(order as f32)), 2.0 / (PI * (2.0 * k - 1.0)), Vec4::ZERO)
}

/// One layer's part of `s_f - 1/2`: the sum of `(2 / c_k) [cos(c_k d) S_k - sin(c_k d) C_k]`.
pub fn series_lit(phases: [Vec4; 2], filtered_sin: Vec4, filtered_cos: Vec4, weights: Vec4) -> f32 {
    weights.dot(phases[0] * filtered_sin - phases[1] * filtered_cos)
}

/// One layer's part of the CSM-Z numerator less half the filtered depth (2008, eq. 11).
pub fn series_blocker_depth(
    phases: [Vec4; 2],
    filtered_z_sin: Vec4,
    filtered_z_cos: Vec4,
    weights: Vec4,
) -> f32 {
    weights.dot(phases[1] * filtered_z_cos - phases[0] * filtered_z_sin)
}

/// Scale, shift and clamp so that ringing only falls outside `[0, 1]` (2008, section 3.3).
pub fn suppress_ringing(s: f32, black_point: f32, white_point: f32) -> f32 {
    ((s - black_point) / (white_point - black_point)).clamp(0.0, 1.0)
}

/// Darkening at contacts (2008, eq. 9).
pub fn sharpen(s: f32, blocker_distance: f32, a: f32, b: f32) -> f32 {
    s.max(0.0).powf(1.0 + a * (-b * blocker_distance.max(0.0)).exp())
}

/// Mip level whose trilinear lookup has the variance of a bilinear lookup in texels of `width`.
pub fn level_from_width(width: f32) -> f32 {
    if width <= 1.0 {
        return 0.0;
    }
    let base = width.log2().floor();
    let ratio = width / base.exp2();
    base + (ratio * ratio - 1.0) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `s(d, z)` of one blocker depth.
    fn shadow_test(d: f32, z: f32, order: u32) -> f32 {
        (0..order.div_ceil(4)).fold(0.5, |s, group| {
            let basis = series_phases(z, group);
            s + series_lit(series_phases(d, group), basis[1], basis[0], series_weights(group, order))
        })
    }

    #[test]
    fn the_series_is_a_shadow_test_within_its_ringing() {
        for order in 1..=16 {
            let edge = 1.0 / order as f32;
            for i in 0..100 {
                let (d, z) = (0.45, 0.9 * i as f32 / 99.0);
                if (z - d).abs() < 0.5 * edge || (z - d).abs() > 1.0 - 0.5 * edge {
                    continue;
                }
                let lit = if d <= z { 1.0 } else { 0.0 };
                // First lobe of the Gibbs ringing is 9 % of the jump, at most 14 % for the lowest order.
                assert!((shadow_test(d, z, order) - lit).abs() < 0.14, "order {order} d {d} z {z}");
            }
        }
    }

    #[test]
    fn average_blocker_depth_matches_brute_force() {
        // Half of a kernel holds blockers between 0.1 and 0.3, the rest lies behind the receiver at 0.6.
        let depths: Vec<f32> =
            (0..200).map(|i| if i < 100 { 0.1 + 0.002 * i as f32 } else { 0.85 }).collect();
        let (d, order) = (0.6, 16);
        let mean = |f: &dyn Fn(f32) -> Vec4| depths.iter().map(|&z| f(z)).sum::<Vec4>() / depths.len() as f32;
        let (mut lit, mut sum) = (0.5, 0.5 * depths.iter().sum::<f32>() / depths.len() as f32);
        for group in 0..order / 4 {
            let phases = series_phases(d, group);
            let weights = series_weights(group, order);
            lit += series_lit(
                phases,
                mean(&|z| series_phases(z, group)[1]),
                mean(&|z| series_phases(z, group)[0]),
                weights,
            );
            sum += series_blocker_depth(
                phases,
                mean(&|z| z * series_phases(z, group)[1]),
                mean(&|z| z * series_phases(z, group)[0]),
                weights,
            );
        }
        let blockers: Vec<f32> = depths.iter().copied().filter(|&z| z < d).collect();
        let truth = blockers.iter().sum::<f32>() / blockers.len() as f32;
        assert!((lit - 0.5).abs() < 0.02, "{lit}");
        assert!((sum / (1.0 - lit) - truth).abs() < 0.02, "{} against {truth}", sum / (1.0 - lit));
    }

    #[test]
    fn trilinear_levels_have_the_variance_asked_for() {
        for i in 1..200 {
            let width = 1.0 + 0.3 * i as f32;
            let level = level_from_width(width);
            let (low, t) = (level.floor(), level.fract());
            let variance = (1.0 - t) * 4_f32.powf(low) / 4.0 + t * 4_f32.powf(low + 1.0) / 4.0;
            assert!((variance / (width * width / 4.0) - 1.0).abs() < 1e-3, "{width}");
        }
    }

    #[test]
    fn sharpening_darkens_contacts_and_leaves_wide_penumbrae() {
        assert!(sharpen(0.8, 0.0, 30.0, 10.0) < 0.01);
        assert!((sharpen(0.8, 0.9, 30.0, 10.0) - 0.8).abs() < 0.01);
        assert_eq!(sharpen(1.0, 0.0, 30.0, 10.0), 1.0);
    }
}
