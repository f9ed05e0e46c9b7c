//! `partial_cover.wgsl`.

use glam::UVec2;

/// Of a surface, from what tells it from others before or behind it.
pub fn cover_key(slab: u32, material: u32, is_front: bool) -> u32 {
    let mut key = slab.wrapping_mul(0x85eb_ca6b) ^ material.wrapping_mul(0xc2b2_ae35);
    key = (key ^ (key >> 16)).wrapping_mul(0x7feb_352d);
    key = (key ^ (key >> 15)).wrapping_mul(0x846c_a68b);
    ((key ^ (key >> 16)) & !1) | u32::from(is_front)
}

/// Whether a texel shows a surface of this opacity.
pub fn is_covered(opacity: f32, texel: UVec2, key: u32) -> bool {
    let place = if key & 1 == 0 { texel } else { UVec2::new(texel.y, texel.x) };
    let second: u32 = if key & 2 == 0 { 2_447_445_414 } else { 1_847_521_882 };
    let lattice = place.x.wrapping_mul(3_242_174_889).wrapping_add(place.y.wrapping_mul(second));
    let threshold = lattice.wrapping_add(key);
    ((threshold >> 8) as f32) / 16_777_216.0 < opacity
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(side: u32, corner: UVec2, test: impl Fn(UVec2) -> bool) -> f32 {
        let texels = (0..side * side).map(|i| corner + UVec2::new(i % side, i / side));
        texels.filter(|&texel| test(texel)).count() as f32 / (side * side) as f32
    }

    #[test]
    fn a_few_neighbours_are_covered_by_the_share() {
        for (opacity, key) in [(0.1, 0), (0.3, 1), (0.5, 2), (0.8, 3), (0.5, cover_key(3, 5, true))] {
            for i in 0..50 {
                let corner = UVec2::new(37 * i, 11 * i);
                for (side, most) in [(3, 0.2), (4, 0.07), (8, 0.03), (16, 0.02)] {
                    let error =
                        (share(side, corner, |texel| is_covered(opacity, texel, key)) - opacity).abs();
                    assert!(error <= most, "{opacity} {key} {side}: {error}");
                }
            }
        }
        assert_eq!(share(64, UVec2::ZERO, |texel| is_covered(1.0, texel, 7)), 1.0);
        assert_eq!(share(64, UVec2::ZERO, |texel| is_covered(0.0, texel, 7)), 0.0);
    }

    /// What two surfaces together let through is the product of what each does: of both sides of a body always, of others on average.
    #[test]
    fn surfaces_behind_one_another_cover_independently() {
        for (near, far) in [(0.3, 0.3), (0.5, 0.5), (0.2, 0.9)] {
            let expected = 1.0 - (1.0 - near) * (1.0 - far);
            let mut mean = 0.0;
            for pair in 0..400 {
                let covered = |a: u32, b: u32| {
                    let is_covered_by = |texel| is_covered(near, texel, a) || is_covered(far, texel, b);
                    share(32, UVec2::new(5 * pair, 3), is_covered_by)
                };
                let sides = covered(cover_key(pair, 4, true), cover_key(pair + 1, 4, false));
                assert!((sides - expected).abs() < 0.05, "{near} {far} {pair}: {sides} against {expected}");
                mean += covered(cover_key(pair, 4, true), cover_key(pair, 5, true)) / 400.0;
            }
            assert!((mean - expected).abs() < 0.02, "{near} {far}: {mean} against {expected}");
        }
    }
}
