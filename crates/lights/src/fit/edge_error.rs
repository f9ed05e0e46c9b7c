//! How wrong lights are behind an edge: the error that [`super::Optimized`] makes small.
//!
//! Let `m(w)` be the flux of lights less that of their map. An occluder with one straight edge through the sky hides half of all directions
//! from a surface with normal `n`: its irradiance is off by the integral of `m(w) max(0, n . w)` over the other half. The mean square over
//! all normals and all edges is the double integral of `m(w) k(w, w') m(w')` with
//!
//! `k = (1 - g / pi) (sin g + (pi - g) cos g) / pi`, `g` the angle between `w` and `w'`,
//!
//! but for a factor of 1/12: the share of edges that leave both directions open, and the mean product of both cosines.

use glam::DVec3;

/// Sums run in so many lanes.
const LANES: usize = 4;
/// Least half chord in a derivative, which has no value where two directions meet.
const LEAST_HALF_CHORD: f64 = 7e-4;
/// Of the kernel in the half chord, fitted over all angles.
const SERIES: [f64; 7] = [
    1.000_001_545_5,
    -0.450_269_828_0,
    -0.998_661_703_6,
    0.706_576_263_7,
    -0.120_874_991_2,
    0.025_594_198_2,
    -0.003_210_476_6,
];

/// Flux from single directions; flux may be negative.
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    /// Unit directions, then linear Rec. 709 flux: one list a component, padded with nothing to whole lanes.
    components: [Vec<f64>; 6],
    len: usize,
}

impl Points {
    pub(super) fn push(&mut self, towards: DVec3, flux: DVec3) {
        let values = [towards.x, towards.y, towards.z, flux.x, flux.y, flux.z];
        let padded = (self.len + 1).next_multiple_of(LANES);
        for (component, value) in self.components.iter_mut().zip(values) {
            component.resize(padded, 0.0);
            component[self.len] = value;
        }
        self.len += 1;
    }

    /// The same points with what they lack instead of what they have.
    pub(super) fn negated(&self) -> Self {
        let mut negated = self.clone();
        negated.components[3..].iter_mut().flatten().for_each(|flux| *flux = -*flux);
        negated
    }

    /// Direction and flux of each.
    pub(super) fn all(&self) -> Vec<(DVec3, DVec3)> {
        let at = |i: usize| self.components.each_ref().map(|list| list[i]);
        (0..self.len).map(at).map(|[x, y, z, r, g, b]| (DVec3::new(x, y, z), DVec3::new(r, g, b))).collect()
    }

    /// Sum of `flux k(towards, w)` over all points at `w`, for each channel.
    pub(super) fn potential(&self, towards: DVec3) -> DVec3 {
        self.sums(|at, flux| flux * kernel(towards.dot(at).clamp(-1.0, 1.0)))
    }

    /// Derivative of `flux . potential(towards)` by `towards`, up to a part along `towards`.
    pub(super) fn gradient(&self, towards: DVec3, flux: DVec3) -> DVec3 {
        self.sums(|at, other| at * (flux.dot(other) * kernel_slope(towards.dot(at).clamp(-1.0, 1.0))))
    }

    /// Sum of a function of each point's direction and flux, always in the same order.
    fn sums(&self, of: impl Fn(DVec3, DVec3) -> DVec3) -> DVec3 {
        let mut lanes = [[0.0; LANES]; 3];
        let [x, y, z, red, green, blue] = self.components.each_ref().map(|list| list.as_chunks::<LANES>().0);
        for (((((x, y), z), red), green), blue) in x.iter().zip(y).zip(z).zip(red).zip(green).zip(blue) {
            for lane in 0..LANES {
                let at = DVec3::new(x[lane], y[lane], z[lane]);
                let values = of(at, DVec3::new(red[lane], green[lane], blue[lane])).to_array();
                for (sum, value) in lanes.iter_mut().zip(values) {
                    sum[lane] += value;
                }
            }
        }
        DVec3::from_array(lanes.map(|sum| sum.into_iter().sum()))
    }
}

/// `k` of the angle whose cosine this is, within 2e-6: a power series in the half chord, in which it is smooth throughout. Without a
/// branch, so that a loop over it runs in lanes.
fn kernel(cosine: f64) -> f64 {
    let s = half_chord(cosine);
    SERIES.into_iter().rev().fold(0.0, |sum, factor| sum * s + factor)
}

/// Derivative of [`kernel`] by the cosine.
fn kernel_slope(cosine: f64) -> f64 {
    let s = half_chord(cosine);
    let by_half_chord =
        (1..SERIES.len()).rev().fold(0.0, |sum, power| sum * s + power as f64 * SERIES[power]);
    -0.5 * by_half_chord / s.max(LEAST_HALF_CHORD)
}

/// Half the distance of two unit directions, times the root of two.
fn half_chord(cosine: f64) -> f64 {
    (1.0 - cosine).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_PI, PI};

    use super::*;

    /// Evenly spread directions (a spherical Fibonacci lattice).
    fn directions(count: usize) -> impl Iterator<Item = DVec3> + Clone {
        (0..count).map(move |i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let (sin, cos) = (i as f64 * PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            DVec3::new(radius * cos, radius * sin, z)
        })
    }

    #[test]
    fn the_kernel_is_the_mean_over_normals_and_edges() {
        let a = DVec3::new(0.3, 0.5, 0.8).normalize();
        let mean = |f: &dyn Fn(DVec3) -> f64| directions(100_000).map(f).sum::<f64>() / 1e5;
        for angle in [0.0_f64, 0.1, 0.6, 1.3, 2.2, 3.0] {
            let b = (a * angle.cos() + a.any_orthonormal_vector() * angle.sin()).normalize();
            let cosines = mean(&|n| n.dot(a).max(0.0) * n.dot(b).max(0.0));
            let open = mean(&|edge| f64::from(edge.dot(a) > 0.0 && edge.dot(b) > 0.0));
            let (expected, found) = (12.0 * open * cosines, kernel(angle.cos()));
            let closed = (1.0 - FRAC_1_PI * angle) * FRAC_1_PI * (angle.sin() + (PI - angle) * angle.cos());
            assert!((found - closed).abs() < 3e-6, "{angle}: {found} {closed}");
            assert!((found - expected).abs() < 1e-3, "{angle}: {found} {expected}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_potential() {
        let mut points = Points::default();
        for (i, towards) in directions(37).enumerate() {
            points.push(towards, DVec3::new(1.0, (i % 3) as f64, -((i % 5) as f64)));
        }
        let (at, flux) = (DVec3::new(0.2, 0.6, -0.5).normalize(), DVec3::new(0.7, 0.2, 1.5));
        for along in [at.any_orthonormal_vector(), at.cross(at.any_orthonormal_vector())] {
            let step = 0.02;
            let moved = |by: f64| flux.dot(points.potential((at + by * along).normalize()));
            let expected = (moved(step) - moved(-step)) / (2.0 * step);
            let found = points.gradient(at, flux).dot(along);
            assert!((found - expected).abs() < 0.02 * expected.abs().max(0.1), "{found} {expected}");
        }
    }

    #[test]
    fn points_that_fill_no_lane_count_like_others() {
        let mut points = Points::default();
        assert_eq!(points.potential(DVec3::Y), DVec3::ZERO);
        for _ in 0..9 {
            points.push(DVec3::Y, DVec3::new(1.0, 2.0, -3.0));
        }
        assert!((points.potential(DVec3::Y) - 9.0 * DVec3::new(1.0, 2.0, -3.0)).length() < 1e-3);
        assert!((points.negated().potential(DVec3::Y).y + 18.0).abs() < 1e-3);
    }
}
