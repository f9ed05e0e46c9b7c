//! Twins of `hemisphere.wgsl`.

use glam::{Vec2, Vec3};

/// Maps a unit vector with `n.z >= 0` to `[-1, 1]^2`: the upper half of the octahedral map, turned by 45 degrees (Cigolle et al. 2014).
pub fn hemisphere_encode(n: Vec3) -> Vec2 {
    let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.max(0.0));
    Vec2::new(p.x + p.y, p.x - p.y)
}

/// Inverse of [`hemisphere_encode`].
pub fn hemisphere_decode(e: Vec2) -> Vec3 {
    let p = 0.5 * Vec2::new(e.x + e.y, e.x - e.y);
    p.extend(1.0 - p.x.abs() - p.y.abs()).normalize()
}
