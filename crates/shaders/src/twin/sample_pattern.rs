//! Twins of `sample_pattern.wgsl`: point sets for filtering with few samples.

use glam::Vec2;

const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// Point `i` of `count` in the unit disk, evenly spread for any count (Vogel 1979), the whole turned by `rotation` [rad].
pub fn vogel_disk(i: u32, count: u32, rotation: f32) -> Vec2 {
    let radius = ((i as f32 + 0.5) / count as f32).sqrt();
    radius * Vec2::from_angle(i as f32 * GOLDEN_ANGLE + rotation)
}

/// Point `i` of `count` in the unit square (Hammersley), at the middle of its strata in both coordinates.
pub fn hammersley(i: u32, count: u32) -> Vec2 {
    let radical_inverse = (i.reverse_bits() >> 8) as f32 / 16_777_216.0;
    let strata = (count as f32).log2().ceil().exp2();
    Vec2::new((i as f32 + 0.5) / count as f32, radical_inverse + 0.5 / strata)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vogel_disk_fills_the_disk_evenly_around_its_centre() {
        for count in [1, 7, 16, 64] {
            let points: Vec<Vec2> = (0..count).map(|i| vogel_disk(i, count, 0.3)).collect();
            assert!(points.iter().all(|p| p.length() < 1.0));
            // A uniform disk has variance 1/4 along each axis; so much is exact for the sum of both.
            let variance = points.iter().map(|p| p.length_squared()).sum::<f32>() / count as f32;
            assert!((variance - 0.5).abs() < 1e-5, "{count}: {variance}");
            let mean = points.iter().sum::<Vec2>() / count as f32;
            assert!(count < 16 || mean.length() < 0.05, "{count}: {mean}");
        }
    }

    #[test]
    fn hammersley_points_lie_one_in_every_stratum_of_the_square() {
        let count = 32;
        let points: Vec<Vec2> = (0..count).map(|i| hammersley(i, count)).collect();
        for axis in 0..2 {
            let mut strata: Vec<u32> = points.iter().map(|p| (p[axis] * count as f32) as u32).collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..count).collect::<Vec<_>>());
        }
        let mean = points.iter().sum::<Vec2>() / count as f32;
        assert!((mean - 0.5).length() < 1e-6, "{mean}");
        // A count that is no power of two stays inside.
        assert!((0..33).all(|i| hammersley(i, 33).max_element() < 1.0));
        assert_eq!(hammersley(0, 1), Vec2::splat(0.5));
    }
}
