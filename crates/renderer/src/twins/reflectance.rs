//! The reflectance models, every one of the list.

use std::sync::LazyLock;

use glam::{Vec2, Vec3, Vec4};
use gnomon_brdf::{
    Frame, LightPatch, Lobe, Model, SeenFinish, Surface, Tables, coat_share, d_charlie, finish_light,
    finish_pdf, finish_sample, finish_value, lambda_charlie, sheen_albedo,
};
use gnomon_testing::tolerances::SHADER_TWIN;
use gnomon_testing::{glossy_surface, tabulated_surfaces};

use super::{compare, scalar, unit_vector};

/// Of the tabulated surfaces of the tests, by their numbers.
pub(super) static TABLES: LazyLock<Vec<Tables>> =
    LazyLock::new(|| tabulated_surfaces().iter().filter_map(Surface::tables).collect());

/// Every model with lobes from narrow to wide, and two different tints. Of tabulated ones the shape is the number of the tables.
fn lobes() -> impl Iterator<Item = Lobe<'static>> {
    let tint = Vec4::new(0.8, 0.5, 0.1, 0.9);
    let analytic = Model::ALL.iter().filter(|model| !model.is_tabulated()).flat_map(move |&model| {
        [0.283, 0.5, 0.95].map(|roughness| Lobe { tint, ..glossy_surface(model, roughness).layers().lobe })
    });
    let tabulated =
        tabulated_surfaces().into_iter().zip(&*TABLES).enumerate().map(move |(number, (surface, tables))| {
            Lobe { tint, shape: number as f32, tables: Some(tables), ..surface.layers().lobe }
        });
    analytic.chain(tabulated)
}

fn wgsl(lobe: &Lobe) -> String {
    let [x, y, z, w] = lobe.tint.to_array();
    format!("Lobe({}u, {:?}, vec4f({x:?}, {y:?}, {z:?}, {w:?}))", lobe.model as u32, lobe.shape)
}

// Densities of half vectors are compared times |wo + wi|, of sampled ones times its square: they have a pole where that is 0, and
// the half vector loses its digits.

/// A view on either side of the surface, and a direction that is often near the mirrored one.
fn directions(u: Vec4, v: Vec4) -> [Vec4; 2] {
    let wo = unit_vector(u);
    let wi = Vec3::new(-wo.x, -wo.y, wo.z) + u.w * 2.0 * v.w * (unit_vector(v) - 0.5 * Vec3::Z);
    [wo.extend(u.z), wi.normalize().extend(v.z)]
}

/// Values up to some hundred hang on cosines rounded to 1e-7, times exponents up to 300 or over squared slopes of 0.006; a power of a
/// sampled number is wrong by as much again.
const TOLERANCE: f32 = 2e-3;

#[test]
fn values_and_densities() {
    for lobe in lobes() {
        let call = |name| format!("reflectance_{name}({}, a.xyz, b.xyz)", wgsl(&lobe));
        let body = format!("vec4f({}, {} * length(a.xyz + b.xyz))", call("lobe"), call("pdf"));
        compare("brdf_models", &body, TOLERANCE, directions, |[a, b]| {
            let (wo, wi) = (a.truncate(), b.truncate());
            lobe.value(wo, wi).extend(lobe.pdf(wo, wi) * (wo + wi).length())
        });
    }
}

#[test]
fn samples() {
    for lobe in lobes() {
        let sample = format!("reflectance_sample({}, a.xyz, vec2f(a.w, b.w))", wgsl(&lobe));
        let pdf = format!("reflectance_pdf({}, a.xyz, {sample})", wgsl(&lobe));
        let body = format!("vec4f({sample}, {pdf} * dot(a.xyz + {sample}, a.xyz + {sample}))");
        compare("brdf_models", &body, TOLERANCE, directions, |[a, b]| {
            let wo = a.truncate();
            let wi = lobe.sample(wo, Vec2::new(a.w, b.w));
            wi.extend(lobe.pdf(wo, wi) * (wo + wi).length_squared())
        });
    }
}

#[test]
fn lobes_over_area_lights() {
    for lobe in lobes() {
        for is_disk in [false, true] {
            // Half sides of 1 mrad to 0.3 rad, one of them slanted.
            let body = format!(
                "vec4f(reflectance_light_lobe({}, a.xyz, LightPatch(b.xyz, \
                 world_from_local(frame_from_normal(b.xyz), vec3f(0.001 + 0.3 * a.w, 0.0, 0.0)), \
                 world_from_local(frame_from_normal(b.xyz), vec3f(0.1 * a.w, 0.001 + 0.3 * b.w, 0.0)), \
                 {is_disk})), 0.0)",
                wgsl(&lobe)
            );
            compare("brdf_models", &body, TOLERANCE, directions, |[a, b]| {
                let (wo, direction) = (a.truncate(), b.truncate());
                let frame = Frame::from_normal(direction);
                let light = LightPatch {
                    direction,
                    half_width: frame.world_from_local(Vec3::new(0.001 + 0.3 * a.w, 0.0, 0.0)),
                    half_height: frame.world_from_local(Vec3::new(0.1 * a.w, 0.001 + 0.3 * b.w, 0.0)),
                    is_disk,
                };
                lobe.over_light(wo, &light).extend(0.0)
            });
        }
    }
}

/// What lies on a base: a coat along its normal, one away from it, sheen, both.
fn finishes() -> impl Iterator<Item = (SeenFinish, String)> {
    let tilted = Vec3::new(0.3, -0.2, 0.9).normalize();
    let cases = [
        (0.2, 0.4, Vec3::Z, 0.0),
        (0.2, 0.7, tilted, 0.0),
        (0.0, 0.5, Vec3::Z, 0.8),
        (0.2, 0.6, tilted, 0.8),
    ];
    cases.into_iter().map(|(coat, coat_roughness, coat_normal, strength)| {
        let (sheen, sheen_roughness) = (strength * Vec3::new(1.0, 0.5, 0.1), 0.6);
        let finish = SeenFinish { base: 0.8, coat, coat_roughness, coat_normal, sheen, sheen_roughness };
        let vector = |Vec3 { x, y, z }| format!("vec3f({x:?}, {y:?}, {z:?})");
        let (normal, tint) = (vector(coat_normal), vector(sheen));
        (finish, format!("Finish(0.8, {coat:?}, {coat_roughness:?}, {normal}, {tint}, {sheen_roughness:?})"))
    })
}

#[test]
fn shares_of_finishes() {
    let body = "vec4f(sheen_albedo(a.x, a.y), lambda_charlie(a.x, 0.01 + 0.99 * a.y), \
        d_charlie(a.x, 0.01 + 0.99 * a.y), seen_finish(a.z, 0.5, vec3f(0.0, 0.0, 1.0), a.yzw, a.w, a.x).base)";
    compare(
        "brdf_finish",
        body,
        TOLERANCE,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| {
            let alpha = 0.01 + 0.99 * a.y;
            let albedo = sheen_albedo(a.x, a.w).min(1.0);
            let base = (1.0 - a.z) * (1.0 - a.y.max(a.z).max(a.w) * albedo);
            Vec4::new(sheen_albedo(a.x, a.y), lambda_charlie(a.x, alpha), d_charlie(a.x, alpha), base)
        },
    );
}

#[test]
fn values_and_samples_of_finishes() {
    for (finish, text) in finishes() {
        let body = format!(
            "vec4f(finish_value({text}, a.xyz, b.xyz) * b.z, finish_pdf({text}, a.xyz, b.xyz) * length(a.xyz + b.xyz))"
        );
        compare("brdf_finish", &body, TOLERANCE, directions, |[a, b]| {
            let (wo, wi) = (a.truncate(), b.truncate());
            (finish_value(&finish, wo, wi) * wi.z).extend(finish_pdf(&finish, wo, wi) * (wo + wi).length())
        });
        let body = format!("vec4f(finish_sample({text}, a.xyz, vec2f(a.w, b.w)), coat_share(a.w, b.w))");
        compare("brdf_finish", &body, TOLERANCE, directions, |[a, b]| {
            finish_sample(&finish, a.truncate(), Vec2::new(a.w, b.w)).extend(coat_share(a.w, b.w))
        });
        let body = format!(
            "vec4f(finish_light({text}, a.xyz, LightPatch(b.xyz, 0.1 * frame_from_normal(b.xyz).t, \
             0.2 * frame_from_normal(b.xyz).b, false)), 0.0)"
        );
        compare("brdf_finish", &body, TOLERANCE, directions, |[a, b]| {
            let direction = b.truncate();
            let frame = Frame::from_normal(direction);
            let (half_width, half_height) = (0.1 * frame.t, 0.2 * frame.b);
            let light = LightPatch { direction, half_width, half_height, is_disk: false };
            finish_light(&finish, a.truncate(), &light).extend(0.0)
        });
    }
}

#[test]
fn what_maps_are_looked_up_with() {
    for lobe in lobes() {
        let (model, text) = (lobe.model, wgsl(&lobe));
        let body = format!(
            "vec4f(reflectance_albedo({text}, a.x, a.yz), reflectance_matte_weight({text}, b, a.w))\
             + vec4f(reflectance_cached({text}, b.xyz, a.yzw, a.x), reflectance_equivalent_roughness({text}))"
        );
        compare(
            "brdf_models",
            &body,
            1e-5,
            |u, v| [u, v],
            |[a, b]| {
                let albedo = model.albedo(&lobe, a.x, Vec2::new(a.y, a.z));
                let cached = model.cached(&lobe, [b.truncate(), Vec3::new(a.y, a.z, a.w)], a.x);
                albedo.extend(model.matte_weight(b, a.w)) + cached.extend(model.equivalent_roughness(&lobe))
            },
        );
    }
}

#[test]
fn frames() {
    let body =
        "vec4f(local_from_world(frame_from_tangent(a.xyz, vec4f(b.xyz, a.w)), vec3f(0.3, -0.5, 0.8)), 0.0)";
    let input = |u: Vec4, v: Vec4| {
        let sign = if u.w < 0.5 { -1.0 } else { 1.0 };
        [unit_vector(u).extend(sign), (if v.w < 0.1 { Vec3::ZERO } else { unit_vector(v) }).extend(0.0)]
    };
    compare("brdf_frame", body, SHADER_TWIN, input, |[a, b]| {
        let frame = Frame::from_tangent(a.truncate(), b.truncate().extend(a.w));
        frame.local_from_world(Vec3::new(0.3, -0.5, 0.8)).extend(0.0)
    });
}

#[test]
fn normalisations() {
    let body =
        "vec4f(gaussian_norm(a.x), blinn_phong_norm(500.0 * a.y), g1_smith_beckmann(a.z, a.w + 0.01), 0.0)";
    compare(
        "brdf_models",
        body,
        SHADER_TWIN,
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
        "brdf_models",
        "vec4f(g1_smith_ggx(a.x + 0.01, a.y), 0.0, 0.0, 0.0)",
        1e-5,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| scalar(gnomon_brdf::g1_smith_ggx(a.x + 0.01, a.y)),
    );
}
