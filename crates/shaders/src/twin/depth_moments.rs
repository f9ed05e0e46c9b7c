//! Twins of `depth_moments.wgsl`: four filtered moments of depth (Peters and Klein 2015).

use glam::{Vec2, Vec3, Vec4};

/// A distribution of three depths.
#[derive(Clone, Copy, Debug)]
pub struct ThreeAtoms {
    /// Depths in `[-1, 1]`, the first as prescribed; one of the others may lie far outside, with next to no weight.
    pub depths: Vec3,
    /// Weights, of sum 1.
    pub weights: Vec3,
}

/// Moments 1 to 4 of one depth in `[-1, 1]`.
pub fn depth_moments(depth: f32) -> Vec4 {
    let square = depth * depth;
    Vec4::new(depth, square, square * depth, square * square)
}

/// Moments moved by `bias` towards those of a wide distribution (Muenstermann et al. 2018).
pub fn biased_moments(moments: Vec4, bias: f32) -> Vec4 {
    moments.lerp(Vec4::new(0.0, 0.375, 0.0, 0.375), bias)
}

/// The distribution with the biased moments `b` and an atom at `d` (Peters and Klein 2015, algorithm 3).
pub fn three_atoms(b: Vec4, d: f32) -> ThreeAtoms {
    let d22 = (b.y - b.x * b.x).max(1e-10);
    let l32 = (b.z - b.x * b.y) / d22;
    let d33 = (b.w - b.y * b.y - l32 * l32 * d22).max(1e-10);
    let mut c = Vec3::new(1.0, d - b.x, 0.0);
    c.z = (d * d - b.y - l32 * c.y) / d33;
    c.y = c.y / d22 - l32 * c.z;
    c.x -= b.x * c.y + b.y * c.z;
    let weight = 1.0 / c.dot(Vec3::new(1.0, d, d * d));
    c.z = if c.z.abs() < 1e-6 { 1e-6 } else { c.z };
    let root = (c.y * c.y - 4.0 * c.z * c.x).max(0.0).sqrt();
    let q = -0.5 * (c.y + if c.y >= 0.0 { root } else { -root });
    let (z1, z2) = (q / c.z, c.x / q);
    let rest = 1.0 - weight;
    let weight_2 = (b.x - weight * d - rest * z1) / (z2 - z1);
    ThreeAtoms { depths: Vec3::new(d, z1, z2), weights: Vec3::new(weight, rest - weight_2, weight_2) }
}

/// Least weight in front of the first depth that any distribution with the same moments has (x), and the depth of its centre
/// (y; the first depth where there is none).
pub fn blockers_in_front(atoms: ThreeAtoms) -> Vec2 {
    let d = atoms.depths.x;
    let (mut weight, mut sum) = (0.0, 0.0);
    for i in 1..3 {
        if atoms.depths[i] < d {
            let in_front = atoms.weights[i].clamp(0.0, 1.0);
            weight += in_front;
            sum += in_front * atoms.depths[i].clamp(-1.0, 1.0);
        }
    }
    Vec2::new(weight.min(1.0), if weight > 0.0 { sum / weight } else { d })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the renderer uses with moments of 32 bits.
    const BIAS: f32 = 1e-6;

    fn moments(depths: &[(f32, f32)]) -> Vec4 {
        depths.iter().map(|&(z, weight)| weight * depth_moments(z)).sum()
    }

    fn in_front(depths: &[(f32, f32)], d: f32) -> Vec2 {
        blockers_in_front(three_atoms(biased_moments(moments(depths), BIAS), d))
    }

    fn brute_force(depths: &[(f32, f32)], d: f32) -> f32 {
        depths.iter().filter(|&&(z, _)| z < d).map(|&(_, weight)| weight).sum()
    }

    #[test]
    fn one_or_two_depths_are_told_exactly() {
        let cases: [&[(f32, f32)]; 5] = [
            &[(0.3, 1.0)],
            &[(-0.9, 1.0)],
            &[(-0.5, 0.5), (0.5, 0.5)],
            &[(-0.2, 0.1), (0.7, 0.9)],
            &[(-0.8, 0.95), (0.1, 0.05)],
        ];
        for depths in cases {
            for i in 0..=40 {
                let d = -1.0 + 0.05 * i as f32 + 0.0123;
                // The bias blurs the step by the fourth root of its size.
                if depths.iter().any(|&(z, _)| (z - d).abs() < 0.08) {
                    continue;
                }
                let (found, truth) = (in_front(depths, d), brute_force(depths, d));
                assert!((found.x - truth).abs() < 0.02, "{depths:?} at {d}: {found}, not {truth}");
                if truth > 0.0 {
                    let center =
                        depths.iter().filter(|&&(z, _)| z < d).map(|&(z, w)| w * z).sum::<f32>() / truth;
                    assert!((found.y - center).abs() < 0.02, "{depths:?} at {d}: {found}, not {center}");
                }
            }
        }
    }

    #[test]
    fn the_atoms_have_the_moments_and_bound_the_weight_from_below() {
        for i in 0..200 {
            let u = |step: f32| (0.5 + step * i as f32).fract();
            let depths = [
                (-0.9 + 0.3 * u(0.618), 0.1 + u(0.71)),
                (-0.4 + 0.3 * u(0.27), 0.1 + u(0.39)),
                (0.1 + 0.3 * u(0.83), 0.1 + u(0.17)),
                (0.6 + 0.3 * u(0.47), 0.1 + u(0.91)),
            ];
            let total: f32 = depths.iter().map(|d| d.1).sum();
            let depths = depths.map(|(z, w)| (z, w / total));
            let d = -1.0 + 2.0 * u(0.557);
            let b = biased_moments(moments(&depths), BIAS);
            let atoms = three_atoms(b, d);
            assert!(atoms.weights.min_element() > -1e-3, "{atoms:?}");
            let again: Vec4 = (0..3).map(|i| atoms.weights[i] * depth_moments(atoms.depths[i])).sum();
            // An atom far outside has next to no weight, whose rounding its powers magnify.
            let far = atoms.depths.abs().max_element().powi(4).max(1.0);
            assert!((again - b).abs().max_element() < 1e-3 * far, "{again} for {b}");
            let (found, truth) = (blockers_in_front(atoms).x, brute_force(&depths, d));
            let most = found + atoms.weights.x;
            assert!(found <= truth + 1e-3 && most >= truth - 1e-3, "{truth} outside {found} to {most}");
        }
    }

    #[test]
    fn a_planted_fault_breaks_the_reconstruction() {
        let swapped = |b: Vec4| Vec4::new(b.x, b.y, b.w, b.z);
        let b = biased_moments(moments(&[(-0.5, 0.5), (0.5, 0.5)]), BIAS);
        let found = blockers_in_front(three_atoms(swapped(b), 0.2));
        assert!((found.x - 0.5).abs() > 0.02 || !found.is_finite(), "{found}");
    }
}
