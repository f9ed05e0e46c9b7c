//! Slopes of heights.

use glam::{Vec2, Vec3, Vec4};
use gnomon_scene::{Gradients, bent_by_heights};
use gnomon_testing::tolerances::SHADER_TWIN;

use super::compare;

#[test]
fn gradients_of_coordinates() {
    // A surface about y, seen aslant, with skewed coordinates.
    let body = "vec4f(uv_gradients(normalize(vec3f(a.x - 0.5, 1.0, a.y - 0.5)), vec3f(1.0, b.x - 0.5, b.y - 0.5), \
        vec3f(b.z - 0.5, b.w - 0.5, -1.0), vec2f(0.5, a.z), vec2f(a.w, 1.5), 1.0).u, \
        uv_gradients(normalize(vec3f(a.x - 0.5, 1.0, a.y - 0.5)), vec3f(1.0, b.x - 0.5, b.y - 0.5), \
        vec3f(b.z - 0.5, b.w - 0.5, -1.0), vec2f(0.5, a.z), vec2f(a.w, 1.5), 0.5).v.x)";
    let gradients = |[a, b]: [Vec4; 2]| {
        let n = Vec3::new(a.x - 0.5, 1.0, a.y - 0.5).normalize();
        let across = Vec3::new(1.0, b.x - 0.5, b.y - 0.5);
        let down = Vec3::new(b.z - 0.5, b.w - 0.5, -1.0);
        Gradients::new([Vec3::ZERO, across, down], [Vec2::ZERO, Vec2::new(0.5, a.z), Vec2::new(a.w, 1.5)], n)
    };
    compare(
        "height_slopes",
        body,
        1e-4,
        |u, v| [u, v],
        |input| {
            // Coordinates that change twice as much for the same step.
            gradients(input).map_or(Vec4::ZERO, |gradients| gradients.u.extend(2.0 * gradients.v.x))
        },
    );
}

#[test]
fn normals_and_roughness() {
    let body = "vec4f(bent_by_heights(normalize(vec3f(a.x - 0.5, 0.1 + a.y, a.z - 0.5)), vec3f(0.0, 1.0, 0.0), 2.0 * b.xyz - 1.0), \
        roughness_with_slopes(a.w, b.w))";
    compare(
        "height_slopes",
        body,
        SHADER_TWIN,
        |u, v| [u, v],
        |[a, b]| {
            let normal = Vec3::new(a.x - 0.5, 0.1 + a.y, a.z - 0.5).normalize();
            let bent = bent_by_heights(normal, Vec3::Y, 2.0 * b.truncate() - 1.0);
            bent.extend((a.w.powi(4) + b.w).powf(0.25).min(1.0))
        },
    );
}
