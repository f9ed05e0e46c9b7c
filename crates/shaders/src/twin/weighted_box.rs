//! `weighted_box.wgsl`.

use glam::{Vec2, Vec3, Vec3Swizzles};

/// Box with mean and variance of the points of an outline, each weighted by its cosine at a receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightedBox {
    /// From the outline's own centre, along its two axes.
    pub center: Vec2,
    /// Half width and height.
    pub half_extent: Vec2,
}

/// For the points `c + x a + y b` of a box, `|x|` and `|y|` up to `half_extent`: `cosines` are `n.c`, `n.a` and `n.b`. Exact where
/// the whole box lies above the receiver's horizon; across it, the box counts as even.
pub fn weighted_box(cosines: Vec3, half_extent: Vec2) -> WeightedBox {
    let steepness = cosines.yz().length();
    if steepness < 1e-4 {
        return WeightedBox { center: Vec2::ZERO, half_extent };
    }
    let variances = half_extent * half_extent / 3.0;
    let across = cosines.yz() / steepness;
    let variance = (across * across).dot(variances).max(1e-20);
    let upper = (3.0 * variance).sqrt();
    let lower = (-cosines.x / steepness).clamp(-upper, upper);
    let low_weight = (cosines.x + steepness * lower).max(0.0);
    let high_weight = (cosines.x + steepness * upper).max(0.0);
    let sum = (low_weight + high_weight).max(1e-9);
    let length = upper - lower;
    let mean = lower + length * (low_weight + 2.0 * high_weight) / (3.0 * sum);
    let product = low_weight * high_weight / (sum * sum);
    let left = length * length * (1.0 + 2.0 * product) / 18.0;
    let along = across * variances / variance;
    let rest = (variances - (variance - left) * along * along).max(Vec2::ZERO);
    WeightedBox { center: mean * along, half_extent: Vec2::map(3.0 * rest, f32::sqrt) }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    /// Mean and half extents of a dense grid of points over the box.
    fn summed(cosines: Vec3, half_extent: Vec2) -> (DVec2, DVec2) {
        let side = 400;
        let at = |i: i32| 2.0 * (f64::from(i) + 0.5) / f64::from(side) - 1.0;
        let (mut total, mut first, mut second) = (0.0, DVec2::ZERO, DVec2::ZERO);
        for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
            let p = DVec2::new(at(i), at(j)) * half_extent.as_dvec2();
            let weight = cosines.as_dvec3().dot(DVec3::new(1.0, p.x, p.y)).max(0.0);
            (total, first, second) = (total + weight, first + weight * p, second + weight * p * p);
        }
        let mean = first / total;
        (mean, DVec2::map(3.0 * (second / total - mean * mean), f64::sqrt))
    }

    fn error(cosines: Vec3, half_extent: Vec2) -> f64 {
        let (mean, extent) = summed(cosines, half_extent);
        let found = weighted_box(cosines, half_extent);
        let off = (found.center.as_dvec2() - mean).abs() + (found.half_extent.as_dvec2() - extent).abs();
        (off / half_extent.as_dvec2()).max_element()
    }

    #[test]
    fn mean_and_variance_are_those_of_the_weighted_points() {
        // Above the horizon, with slopes along one axis and both.
        for cosines in [Vec3::new(0.9, 0.0, 0.4), Vec3::new(0.5, -0.6, 0.3), Vec3::new(1.0, 0.0, 0.0)] {
            let error = error(cosines, Vec2::new(0.4, 0.2));
            assert!(error < 1e-3, "{cosines}: {error}");
        }
        // Cut by the horizon along an axis: exact, too.
        for cosines in [Vec3::new(0.1, 0.9, 0.0), Vec3::new(-0.2, 0.0, -0.9)] {
            let error = error(cosines, Vec2::new(0.4, 0.3));
            assert!(error < 5e-3, "{cosines}: {error}");
        }
        // Cut at a corner the even profile stands for a trapezium.
        let error = error(Vec3::new(0.0, 0.6, 0.6), Vec2::new(0.4, 0.3));
        assert!(error < 0.15, "{error}");
    }

    #[test]
    fn what_does_not_shine_on_the_receiver_still_has_a_place() {
        let extent = Vec2::new(0.4, 0.3);
        for cosines in [Vec3::new(-0.9, 0.3, 0.2), Vec3::new(-1.0, 0.0, 0.0), Vec3::ZERO] {
            let found = weighted_box(cosines, extent);
            assert!(found.center.is_finite() && found.center.abs().cmple(extent * 1.5).all(), "{found:?}");
            assert!(found.half_extent.is_finite() && found.half_extent.cmple(extent).all(), "{found:?}");
        }
        assert_eq!(weighted_box(Vec3::X, Vec2::ZERO).half_extent, Vec2::ZERO);
    }
}
