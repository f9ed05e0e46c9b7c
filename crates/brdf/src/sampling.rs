use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

/// Cosine-weighted direction about +z for `u` in `[0, 1)^2`; its pdf is `z / pi` (Malley's method).
pub fn sample_cosine_hemisphere(u: Vec2) -> Vec3 {
    let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
    let r = u.x.sqrt();
    // From 1 - u.x, not 1 - r^2, so that z is never lost to rounding for u.x < 1.
    Vec3::new(r * cos_phi, r * sin_phi, (1.0 - u.x).max(0.0).sqrt())
}

/// `wo` mirrored about the unit vector `n`: the direction that light comes from.
pub(crate) fn reflect(n: Vec3, wo: Vec3) -> Vec3 {
    2.0 * n.dot(wo) * n - wo
}

/// A world vector in the local frame whose z axis is the unit normal `n` (Duff et al. 2017).
pub fn local_from_world(n: Vec3, world: Vec3) -> Vec3 {
    let (t, b) = n.any_orthonormal_pair();
    Vec3::new(world.dot(t), world.dot(b), world.dot(n))
}

/// Inverse of [`local_from_world`].
pub fn world_from_local(n: Vec3, local: Vec3) -> Vec3 {
    let (t, b) = n.any_orthonormal_pair();
    t * local.x + b * local.y + n * local.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn frames_are_inverse(nx in -1f32..1.0, ny in -1f32..1.0, nz in -1f32..1.0, u in 0f32..1.0, v in 0f32..1.0) {
            let n = Vec3::new(nx, ny, nz);
            prop_assume!(n.length() > 0.01);
            let n = n.normalize();
            let d = sample_cosine_hemisphere(Vec2::new(u, v));
            prop_assert!((d.length() - 1.0).abs() < 1e-5);
            prop_assert!(local_from_world(n, world_from_local(n, d)).distance(d) < 1e-5);
            prop_assert!((world_from_local(n, Vec3::Z)).distance(n) < 1e-6);
        }
    }
}
