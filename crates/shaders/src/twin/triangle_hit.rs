//! `triangle_hit.wgsl`.

use glam::{Vec3, Vec4};

/// Distance (x) and barycentric coordinates (yzw) of where a ray meets a triangle whose corners are given from its origin; a distance below 0
/// where it does not.
pub fn triangle_hit(a: Vec3, b: Vec3, c: Vec3, direction: Vec3) -> Vec4 {
    let (e0, e1, e2) = (c - a, a - b, b - c);
    let u = e0.cross(c + a).dot(direction);
    let v = e1.cross(a + b).dot(direction);
    let w = e2.cross(b + c).dot(direction);
    let sum = u + v + w;
    let normal = e1.cross(e0);
    let denominator = normal.dot(direction);
    let outside = u.min(v.min(w)) < 0.0 && u.max(v.max(w)) > 0.0;
    if outside || sum == 0.0 || denominator == 0.0 {
        return Vec4::new(-1.0, 0.0, 0.0, 0.0);
    }
    let weights = Vec3::new(w, u, v) / sum;
    Vec4::new(a.dot(normal) / denominator, weights.x, weights.y, weights.z)
}
