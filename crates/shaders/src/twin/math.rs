//! Twins of `math.wgsl`.

use glam::{Vec2, Vec3};

fn sign_not_zero(v: Vec2) -> Vec2 {
    Vec2::new(if v.x >= 0.0 { 1.0 } else { -1.0 }, if v.y >= 0.0 { 1.0 } else { -1.0 })
}

/// Octahedral map of a unit vector to `[-1, 1]^2` (Cigolle et al. 2014).
pub fn octahedral_encode(n: Vec3) -> Vec2 {
    let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    if n.z >= 0.0 { p } else { (1.0 - Vec2::new(p.y, p.x).abs()) * sign_not_zero(p) }
}

/// Inverse of [`octahedral_encode`].
pub fn octahedral_decode(e: Vec2) -> Vec3 {
    let z = 1.0 - e.x.abs() - e.y.abs();
    let t = (-z).max(0.0);
    (e - t * sign_not_zero(e)).extend(z).normalize()
}
