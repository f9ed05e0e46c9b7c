//! The reflectance models.

use glam::{Vec2, Vec3, Vec4};
use gnomon_brdf::{Model, world_from_local};

use super::{compare, scalar, unit_vector};

/// The normal of all inputs, and the same in WGSL.
const N: Vec3 = Vec3::new(0.36, -0.48, 0.8);
const N_WGSL: &str = "vec3f(0.36, -0.48, 0.8)";

/// Every model with two of its parameters.
const CASES: [(Model, f32); 12] = [
    (Model::MetallicRoughness, 0.3),
    (Model::MetallicRoughness, 0.9),
    (Model::Lambert, 0.5),
    (Model::Phong, 0.0),
    (Model::Phong, 40.0),
    (Model::Phong, 500.0),
    (Model::BlinnPhong, 7.5),
    (Model::BlinnPhong, 300.0),
    (Model::TorranceSparrowBeckmann, 0.08),
    (Model::TorranceSparrowBeckmann, 0.6),
    (Model::TorranceSparrowGaussian, 0.08),
    (Model::TorranceSparrowGaussian, 1.0),
];

// Densities of half vectors are compared times |wo + wi|, of sampled ones times its square: they have a pole where that is 0, and
// the half vector loses its digits.

/// A view on either side of the surface, and a direction that is often near the mirrored one.
fn directions(u: Vec4, v: Vec4) -> [Vec4; 2] {
    let wo = unit_vector(u);
    let wi = 2.0 * N.dot(wo) * N - wo + u.w * 2.0 * v.w * (unit_vector(v) - 0.5 * N);
    [wo.extend(u.z), wi.normalize().extend(v.z)]
}

/// Values up to some hundred hang on cosines rounded to 1e-7, times exponents up to 500 or over squared slopes of 0.006; a power of a
/// sampled number is wrong by as much again.
const TOLERANCE: f32 = 2e-3;

#[test]
fn lobes() {
    for (model, parameter) in CASES {
        let call = |name| format!("{name}({}u, {parameter:?}, {N_WGSL}, a.xyz, b.xyz)", model as u32);
        let pdf = call("reflectance_pdf");
        let body = format!("vec4f({}, {pdf} * length(a.xyz + b.xyz), 0.0)", call("reflectance_lobe"));
        compare("brdf_reflectance", &body, TOLERANCE, directions, |[a, b]| {
            let (wo, wi) = (a.truncate(), b.truncate());
            let lobe = gnomon_brdf::reflectance_lobe(model, parameter, N, wo, wi);
            let pdf = gnomon_brdf::reflectance_pdf(model, parameter, N, wo, wi);
            lobe.extend(pdf * (wo + wi).length()).extend(0.0)
        });
    }
}

#[test]
fn samples() {
    for (model, parameter) in CASES {
        let call =
            format!("reflectance_sample({}u, {parameter:?}, {N_WGSL}, a.xyz, vec2f(a.w, b.w))", model as u32);
        let body = format!("vec4f({call}.wi, {call}.pdf * dot(a.xyz + {call}.wi, a.xyz + {call}.wi))");
        compare("brdf_reflectance", &body, TOLERANCE, directions, |[a, b]| {
            let wo = a.truncate();
            let (wi, pdf) = gnomon_brdf::reflectance_sample(model, parameter, N, wo, Vec2::new(a.w, b.w));
            wi.extend(pdf * (wo + wi).length_squared())
        });
    }
}

#[test]
fn normalisations() {
    let body =
        "vec4f(gaussian_norm(a.x), blinn_phong_norm(500.0 * a.y), g1_smith_beckmann(a.z, a.w + 0.01), 0.0)";
    compare(
        "brdf_reflectance",
        body,
        1e-4,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| {
            Vec4::new(
                gnomon_brdf::gaussian_norm(a.x),
                gnomon_brdf::blinn_phong_norm(500.0 * a.y),
                gnomon_brdf::g1_smith_beckmann(a.z, a.w + 0.01),
                0.0,
            )
        },
    );
    compare(
        "brdf_reflectance",
        "vec4f(g1_smith_ggx(a.x + 0.01, a.y), 0.0, 0.0, 0.0)",
        1e-5,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| scalar(gnomon_brdf::g1_smith_ggx(a.x + 0.01, a.y)),
    );
}

#[test]
fn lobes_over_area_lights() {
    for (model, parameter) in CASES {
        for is_disk in [false, true] {
            // Half sides of 1 mrad to 0.3 rad, one of them slanted.
            let body = format!(
                "vec4f(light_lobe({}u, {parameter:?}, {N_WGSL}, a.xyz, LightPatch(b.xyz, \
                 world_from_local(b.xyz, vec3f(0.001 + 0.3 * a.w, 0.0, 0.0)), \
                 world_from_local(b.xyz, vec3f(0.1 * a.w, 0.001 + 0.3 * b.w, 0.0)), {is_disk})), 0.0, 0.0)",
                model as u32
            );
            compare("brdf_area", &body, TOLERANCE, directions, |[a, b]| {
                let direction = b.truncate();
                let light = gnomon_brdf::LightPatch {
                    direction,
                    half_width: world_from_local(direction, Vec3::new(0.001 + 0.3 * a.w, 0.0, 0.0)),
                    half_height: world_from_local(direction, Vec3::new(0.1 * a.w, 0.001 + 0.3 * b.w, 0.0)),
                    is_disk,
                };
                let lobe = gnomon_brdf::light_lobe(model, parameter, N, a.truncate(), &light);
                lobe.extend(0.0).extend(0.0)
            });
        }
    }
}
