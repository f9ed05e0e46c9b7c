//! Form factors of lights, and angles to their outlines.

use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use gnomon_lights::{DistantLight, LightShape};
use gnomon_testing::tolerances::SHADER_TWIN;

use super::{compare, scalar, unit_vector};

#[test]
fn form_factors() {
    let input = |u: Vec4, v: Vec4| [unit_vector(u).extend(0.01 + 1.4 * u.z), unit_vector(v).extend(0.0)];
    compare(
        "form_factor",
        "vec4f(disk_form_factor(b.xyz, a.xyz, a.w), 0.0, 0.0, 0.0)",
        2e-4,
        input,
        |[a, b]| scalar(gnomon_lights::form_factor::disk_form_factor(b.truncate(), a.truncate(), a.w)),
    );
    // A rectangle on the plane z = 1, counter-clockwise seen from the origin.
    let corners = |u: Vec4| {
        let min = Vec2::new(u.x, u.y) * 1.6 - 1.0;
        let max = min + Vec2::new(u.z, u.w) * 0.35 + 0.05;
        [min, Vec2::new(min.x, max.y), max, Vec2::new(max.x, min.y)].map(|p| p.extend(1.0).normalize())
    };
    let corner = |x: &str, y: &str| format!("vec4f(normalize(vec3f({x}, {y}, 1.0)), 0.0)");
    let (x0, y0) = ("a.x * 1.6 - 1.0", "a.y * 1.6 - 1.0");
    let (x1, y1) = ("a.x * 1.6 - 1.0 + a.z * 0.35 + 0.05", "a.y * 1.6 - 1.0 + a.w * 0.35 + 0.05");
    let list = [corner(x0, y0), corner(x0, y1), corner(x1, y1), corner(x1, y0)].join(", ");
    let body = format!("vec4f(rectangle_form_factor(b.xyz, array<vec4f, 4>({list})), 0.0, 0.0, 0.0)");
    compare(
        "form_factor",
        &body,
        2e-4,
        |u, v| [u, unit_vector(v).extend(0.0)],
        |[a, b]| scalar(gnomon_lights::form_factor::rectangle_form_factor(b.truncate(), corners(a))),
    );
}

#[test]
fn shares_of_spots() {
    let cone = |u: Vec4, _| {
        let outer = 0.1 + 1.4 * u.y;
        let cone = gnomon_scene::Spread::Cone { inner: u.z * outer, outer }.cone();
        [Vec4::new(2.0 * u.x - 1.0, cone.x, cone.y, 0.0), Vec4::ZERO]
    };
    compare("cone_share", "vec4f(cone_share(a.x, a.yz), 0.0, 0.0, 0.0)", SHADER_TWIN, cone, |[a, _]| {
        scalar(gnomon_scene::cone_share(a.x, Vec2::new(a.y, a.z)))
    });
}

#[test]
fn flat_disk_form_factors() {
    // Across, above and below the horizon; from close by to five radii away.
    let center = "vec3f(a.x * 2.0 - 1.0, a.y * 2.0 - 1.0, a.z * 2.0 + 0.05)";
    let body = format!(
        "vec4f(flat_disk_form_factor(b.xyz, {center}, vec3f(0.4, 0.0, 0.0), vec3f(0.0, 0.4 * (0.2 + a.w), 0.0)), 0.0, 0.0, 0.0)"
    );
    compare(
        "form_factor",
        &body,
        2e-4,
        |u, v| [u, unit_vector(v).extend(0.0)],
        |[a, b]| {
            let center = Vec3::new(a.x * 2.0 - 1.0, a.y * 2.0 - 1.0, a.z * 2.0 + 0.05);
            let axes = [Vec3::new(0.4, 0.0, 0.0), Vec3::new(0.0, 0.4 * (0.2 + a.w), 0.0)];
            scalar(gnomon_lights::form_factor::flat_disk_form_factor(b.truncate(), center, axes[0], axes[1]))
        },
    );
}

#[test]
fn angles_to_outlines() {
    let direction = |u: Vec4, v| [unit_vector(u).extend(0.01 + u.w), unit_vector(v).extend(0.0)];
    compare(
        "outline_angle",
        "vec4f(disk_signed_angle(b.xyz, a.xyz, a.w))",
        SHADER_TWIN,
        direction,
        |[a, b]| {
            let light = DistantLight::disk(a.truncate().as_dvec3(), f64::from(a.w), DVec3::ONE);
            Vec4::splat(light.signed_angle(b.truncate()))
        },
    );
    let front = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
    let light = DistantLight::rectangle(front, DVec2::new(-0.6, 0.1), DVec2::new(0.4, 0.9), DVec3::ONE);
    let LightShape::Rectangle { corners } = light.shape else { panic!("not a rectangle") };
    let corners = corners.map(|c| format!("vec4f({}, {}, {}, 0.0)", c.x, c.y, c.z)).join(", ");
    // Drivers approximate asin.
    let body = format!("vec4f(rectangle_signed_angle(a.xyz, array({corners})))");
    compare(
        "outline_angle",
        &body,
        5e-4,
        |u, _| [unit_vector(u).extend(0.0), Vec4::ZERO],
        |[a, _]| Vec4::splat(light.signed_angle(a.truncate())),
    );
}
