use glam::{DVec3, Vec3};

/// Largest coordinate [m] that is taken for a position: its square, and products of a few, stay far inside `f32`.
pub const LARGEST_COORDINATE: f32 = 1e12;

/// Unit normal of the plane through three corners, counter-clockwise from the front; `None` without area.
/// In double precision: the square of a small triangle's area would vanish in single.
pub fn triangle_normal([a, b, c]: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c]: [DVec3; 3] = [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()];
    (b - a).cross(c - a).try_normalize().map(|normal| normal.as_vec3())
}
