//! The G-buffer's packing: the shader's words mean what the twin's mean, and hold what went in as well as their bits allow.

use glam::{UVec4, Vec2, Vec3, Vec4, Vec4Swizzles};
use gnomon_brdf::Frame;
use gnomon_shaders::twin::gbuffer_packing::{
    PackedSurface, pack_coat, pack_geometry, pack_normal, pack_reflectance, pack_rgb9e5, pack_sheen,
    unpack_coat, unpack_normal, unpack_rgb9e5, unpack_sheen, unpack_surface,
};

use super::{compare, unit_vector};

/// A step of 16 bits, which may be rounded either way.
const STEP: f32 = 1e-4;
/// A step of the tangent's angle [rad].
const ANGLE_STEP: f32 = 3e-4;

fn surface(n: Vec3, tangent: Vec4) -> PackedSurface {
    PackedSurface {
        frame: Frame::from_tangent(n, tangent),
        geometric_normal: -n,
        material: 4711,
        finish: 0x1234_5678,
        base_color: Vec3::ONE,
        emission: Vec3::ONE,
        specular_color: Vec3::ONE,
        specular: 1.0,
        roughness: 1.0,
        metallic: 1.0,
    }
}

/// A normal, and a tangent with the sign of its bitangent.
fn frame(u: Vec4, v: Vec4) -> [Vec4; 2] {
    let n = unit_vector(u);
    let tangent = n.any_orthonormal_vector();
    let turned = glam::Quat::from_axis_angle(n, 6.0 * v.x) * tangent;
    [n.extend(0.0), turned.extend(if v.y < 0.5 { -1.0 } else { 1.0 })]
}

const GEOMETRY: &str = "unpack_surface(pack_geometry(PackedSurface(frame_from_tangent(a.xyz, b), -a.xyz, 4711u, 0x12345678u, \
    vec3f(1.0), vec3f(1.0), vec3f(1.0), 1.0, 1.0, 1.0)), vec4u(0u))";

fn geometry(n: Vec4, tangent: Vec4) -> PackedSurface {
    unpack_surface(pack_geometry(&surface(n.truncate(), tangent)), UVec4::ZERO)
}

#[test]
fn normals() {
    let body = "vec4f(unpack_normal(pack_normal(a.xyz)), 0.0)";
    compare("gbuffer_packing", body, STEP, frame, |[n, _]| {
        unpack_normal(pack_normal(n.truncate())).extend(0.0)
    });
    compare("gbuffer_packing", body, STEP, frame, |[n, _]| n);
    let body = format!("vec4f({GEOMETRY}.geometric_normal, 0.0)");
    compare("gbuffer_packing", &body, STEP, frame, |[n, _]| -n);
}

#[test]
fn tangents() {
    let body = format!("vec4f({GEOMETRY}.frame.t, 0.0)");
    compare("gbuffer_packing", &body, ANGLE_STEP, frame, |[n, tangent]| {
        geometry(n, tangent).frame.t.extend(0.0)
    });
    compare("gbuffer_packing", &body, ANGLE_STEP, frame, |[_, tangent]| tangent.with_w(0.0));
    let body = format!("vec4f({GEOMETRY}.frame.b, 0.0)");
    compare("gbuffer_packing", &body, ANGLE_STEP, frame, |[n, tangent]| {
        surface(n.truncate(), tangent).frame.b.extend(0.0)
    });
}

#[test]
fn material_and_finish() {
    let body = format!("vec4f(vec2f(unpack2x16unorm({GEOMETRY}.finish)), f32({GEOMETRY}.material), 0.0)");
    compare("gbuffer_packing", &body, STEP, frame, |[n, tangent]| {
        let found = geometry(n, tangent);
        assert_eq!(found.material, 4711);
        let halves = [found.finish & 0xffff, found.finish >> 16].map(|half| half as f32 / 65535.0);
        Vec2::from(halves).extend(found.material as f32).extend(0.0)
    });
}

#[test]
fn sheens() {
    let body = "unpack_sheen(pack_sheen(a.xyz, a.w))";
    let input = |u: Vec4, _| [u, Vec4::ZERO];
    compare("gbuffer_packing", body, 8e-3, input, |[a, _]| unpack_sheen(pack_sheen(a.truncate(), a.w)));
    compare("gbuffer_packing", body, 4.1e-3, input, |[a, _]| a);
}

/// A number between two steps may be rounded to either: a step of 6 bits of a root, one of 10.
#[test]
fn coats() {
    let input = |u: Vec4, v: Vec4| [u, 2.0 * v - Vec4::ONE];
    let body = "vec4f(unpack_coat(pack_coat(a.x, a.y, b.xy)).xy, 0.0, 0.0)";
    let twin = |[a, b]: [Vec4; 2]| unpack_coat(pack_coat(a.x, a.y, Vec2::new(b.x, b.y)));
    compare("gbuffer_packing", body, 0.032, input, |inputs| twin(inputs).xy().extend(0.0).extend(0.0));
    compare("gbuffer_packing", body, 0.017, input, |[a, _]| Vec4::new(a.x, a.y, 0.0, 0.0));
    let body = "vec4f(unpack_coat(pack_coat(a.x, a.y, b.xy)).zw, 0.0, 0.0)";
    compare("gbuffer_packing", body, 4e-3, input, |inputs| twin(inputs).zw().extend(0.0).extend(0.0));
    compare("gbuffer_packing", body, 2.1e-3, input, |[_, b]| Vec4::new(b.x, b.y, 0.0, 0.0));
}

#[test]
fn shared_exponents() {
    let input = |u: Vec4, v: Vec4| [u * (16.0 * v.x - 8.0).exp2(), Vec4::ZERO];
    compare("gbuffer_packing", "vec4f(unpack_rgb9e5(pack_rgb9e5(a.xyz)), 0.0)", 1e-6, input, |[a, _]| {
        unpack_rgb9e5(pack_rgb9e5(a.truncate())).extend(0.0)
    });
}

#[test]
fn colours() {
    const REFLECTANCE: &str = "unpack_surface(vec4u(0u), pack_reflectance(PackedSurface(frame_from_normal(vec3f(0.0, 0.0, 1.0)), \
        vec3f(0.0, 0.0, 1.0), 0u, 0u, 4.0 * a.xyz, vec3f(1.0), b.xyz, b.w, a.w, \
        1.0 - a.w)))";
    let twin = |[a, b]: [Vec4; 2]| {
        let packed = PackedSurface {
            base_color: 4.0 * a.truncate(),
            specular_color: b.truncate(),
            specular: b.w,
            roughness: a.w,
            metallic: 1.0 - a.w,
            ..surface(Vec3::Z, Vec4::ONE)
        };
        let found = unpack_surface(UVec4::ZERO, pack_reflectance(&packed));
        let near = |a: Vec3, b: Vec3, step: f32| (a - b).abs().max_element() <= step;
        assert!(near(found.base_color, packed.base_color, 1e-3));
        assert!(near(found.specular_color, packed.specular_color, 4e-3));
        assert!((found.specular - packed.specular).abs() <= 2e-3);
        assert!((found.roughness - packed.roughness).abs() <= 1e-3);
        assert!((found.metallic - packed.metallic).abs() <= 4e-3);
        found
    };
    let input = |u, v| [u, v];
    // A number between two steps may be rounded to either.
    let body = format!("vec4f({REFLECTANCE}.base_color, {REFLECTANCE}.roughness)");
    compare("gbuffer_packing", &body, 2e-3, input, |inputs| {
        let found = twin(inputs);
        found.base_color.extend(found.roughness)
    });
    let body = format!("vec4f({REFLECTANCE}.specular_color, {REFLECTANCE}.specular)");
    compare("gbuffer_packing", &body, 8e-3, input, |inputs| {
        let found = twin(inputs);
        found.specular_color.extend(found.specular)
    });
    let body = format!("vec4f({REFLECTANCE}.metallic, 0.0, 0.0, 0.0)");
    compare("gbuffer_packing", &body, 8e-3, input, |inputs| super::scalar(twin(inputs).metallic));
}

#[test]
fn normals_of_corners() {
    use gnomon_shaders::twin::hit_normals::{pack_thirds, unpack_third};
    for which in 0..3 {
        let body =
            format!("vec4f(unpack_third(pack_thirds(a.xyz, b.xyz, vec3f(0.0, 0.0, 1.0)), {which}u), 0.0)");
        let input = |u, v| [unit_vector(u).extend(0.0), unit_vector(v).extend(0.0)];
        // Ten bits a coordinate: half a step of each, and the map stretches them by up to 1.8.
        let step = 4e-3;
        compare("hit_normals", &body, step, input, |[a, b]| {
            unpack_third(pack_thirds(a.truncate(), b.truncate(), Vec3::Z), which).extend(0.0)
        });
        compare("hit_normals", &body, step, input, |[a, b]| [a, b, Vec4::Z][which]);
    }
    assert_eq!(unpack_third(pack_thirds(Vec3::X, Vec3::ZERO, Vec3::Z), 1), Vec3::ZERO);
}
