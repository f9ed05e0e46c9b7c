//! Unshadowed light against brute-force integration of the environment, for every reflectance model.

use crate::common::*;
use glam::{Mat3, Vec3};
use gnomon_brdf::{Model, Surface};
use gnomon_envmap::Equirect;
use gnomon_lights::LightSet;
use gnomon_renderer::{Gpu, RenderSettings};
use gnomon_scene::{Camera, Material, Projection};
use gnomon_testing::{glossy_models, tolerances};

const SIDE: u32 = 64;
/// Every so many pixels are integrated.
const STEP: usize = 3;

/// Radiance that a sphere reflects to the viewer in the direction `wo` with the normal `n`: the sum over all texels.
fn integrated(surface: &Surface, map: &Equirect, n: Vec3, wo: Vec3) -> Vec3 {
    let (x, y) = n.any_orthonormal_pair();
    let local = Mat3::from_cols(x, y, n).transpose();
    let (wo, layers) = (local * wo, surface.layers());
    let mut sum = Vec3::ZERO;
    for row in 0..map.height() {
        let solid_angle = map.texel_solid_angle(row) as f32;
        for column in 0..map.width() {
            let wi = local * map.texel_direction(column, row);
            if wi.z > 0.0 {
                let reflected = layers.evaluate(wo, wi) * (wi.z * solid_angle);
                sum += reflected * map.radiance().get(column, row);
            }
        }
    }
    sum
}

/// Relative RMSE of a sphere's unshadowed picture.
fn error(gpu: &Gpu, surface: Surface, unshadowed: &str, projection: Projection) -> f64 {
    let map = gnomon_envmap::builtin::sized("room", 256, 128).unwrap();
    let scene = scene_of(vec![sphere()], Material { surface, ..Default::default() });
    let distance = 4.0;
    let camera = Camera { projection, ..Camera::look_at(Vec3::new(0.0, 0.0, distance), Vec3::ZERO, 1.0) };
    let settings = RenderSettings::default().with(|s| {
        s.techniques.shadows = "none".to_owned();
        s.techniques.unshadowed = unshadowed.to_owned();
        s.techniques.supersample = 1;
        s.techniques.shadow_sampling = 1;
        s.display.background = gnomon_renderer::Background::None;
    });
    let set = LightSet::new("none", Vec::new(), map.clone());
    let frame = render(gpu, settings, &scene, &map, &set, &camera, [SIDE, SIDE]);
    let (mut squares, mut mean, mut count) = (0.0, 0.0, 0.0);
    for y in (0..SIDE).step_by(STEP) {
        for x in (0..SIDE).step_by(STEP) {
            let unit = |i: u32| 2.0 * (i as f32 + 0.5) / SIDE as f32 - 1.0;
            let (origin, direction) = match projection {
                Projection::Orthographic { half_width } => {
                    (Vec3::new(unit(x), -unit(y), 0.0) * half_width + Vec3::Z * distance, -Vec3::Z)
                }
                Projection::Perspective { fov_x } => {
                    let edge = (0.5 * fov_x).tan();
                    (Vec3::Z * distance, Vec3::new(unit(x) * edge, -unit(y) * edge, -1.0).normalize())
                }
            };
            // Where the ray meets the unit sphere; its very edge is left out, where the mesh is a polygon.
            let b = origin.dot(direction);
            let root = b * b - origin.length_squared() + 1.0;
            if root <= 0.1 {
                continue;
            }
            let n = origin + direction * (-b - root.sqrt());
            let truth = integrated(&surface, &map, n.normalize(), -direction);
            squares += f64::from((frame.radiance.get(x, y) - truth).length_squared());
            mean += f64::from(truth.element_sum());
            count += 3.0;
        }
    }
    (squares / count).sqrt() / (mean / count)
}

fn glossy(model: Model) -> Surface {
    Surface {
        model,
        base_color: Vec3::splat(0.3),
        specular: 0.6,
        specular_color: Vec3::new(1.0, 0.9, 0.8),
        roughness: 0.4,
        ..Default::default()
    }
}

const PARALLEL: Projection = Projection::Orthographic { half_width: 1.1 };

#[test]
fn radiance_caches_match_brute_force() {
    let Some(gpu) = gpu_or_skip() else { return };
    for model in glossy_models() {
        // Of glTF's a metal: what its matte part gets is an approximation.
        let metallic = if model == Model::MetallicRoughness { 1.0 } else { 0.0 };
        let (name, surface) = (model.name(), Surface { metallic, ..glossy(model) });
        let parallel = error(&gpu, surface, "cache", PARALLEL);
        let perspective = error(&gpu, surface, "cache", Projection::Perspective { fov_x: 0.56 });
        println!("{name}: {parallel:.4} parallel, {perspective:.4} in perspective");
        assert!(parallel <= tolerances::RADIANCE_CACHE, "{name}: {parallel}");
        assert!(perspective <= tolerances::RADIANCE_CACHE_PERSPECTIVE, "{name}: {perspective}");
    }
}

#[test]
fn maps_and_spherical_harmonics_match_brute_force() {
    let Some(gpu) = gpu_or_skip() else { return };
    let matte = Surface::default();
    let metal = Surface { metallic: 1.0, ..glossy(Model::MetallicRoughness) };
    let (map, sh) = (error(&gpu, matte, "auto", PARALLEL), error(&gpu, matte, "sh", PARALLEL));
    let prefiltered = error(&gpu, metal, "auto", PARALLEL);
    println!("irradiance map {map:.4}, spherical harmonics {sh:.4}, prefiltered GGX {prefiltered:.4}");
    assert!(map <= tolerances::IRRADIANCE_MAP && sh <= tolerances::SH_IRRADIANCE, "{map} {sh}");
    assert!(sh > map, "{sh} {map}");
    assert!(prefiltered <= tolerances::PREFILTERED_ENVIRONMENT, "{prefiltered}");
}
