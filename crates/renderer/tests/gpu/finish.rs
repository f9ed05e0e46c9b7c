//! What lies on the base of surfaces, against the ray tracer.

use crate::common::*;
use glam::{Affine3A, Vec2, Vec3};
use gnomon_brdf::{Model, Surface};
use gnomon_envmap::Equirect;
use gnomon_lights::{FitOptions, LightSet};
use gnomon_picture::RgbImage;
use gnomon_reference::ReferenceOptions;
use gnomon_renderer::{Background, RenderSettings};
use gnomon_scene::{AreaLight, AreaLightShape, Camera, Material, Node, NodeId, Scene};
use gnomon_testing::tolerances;

pub const SIZE: [u32; 2] = [48, 48];

fn ball(surface: Surface) -> Scene {
    scene_of(vec![sphere()], Material { surface, ..Material::default() })
}

pub fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.6, 0.7, 3.4), Vec3::ZERO, 0.5)
}

/// A plastic, a metal and a matte surface under smooth and rough coats.
fn coats() -> [Surface; 3] {
    let red = Surface { base_color: Vec3::new(0.6, 0.05, 0.03), ..Surface::default() };
    let coat = |base: Surface, clearcoat_roughness| Surface { clearcoat: 1.0, clearcoat_roughness, ..base };
    [
        coat(Surface { roughness: 0.6, specular: 1.0, ..red }, 0.05),
        coat(Surface { base_color: Vec3::new(0.1, 0.2, 0.6), metallic: 1.0, roughness: 0.7, ..red }, 0.1),
        coat(Surface { model: Model::Lambert, ..red }, 0.4),
    ]
}

/// Velvet over a matte surface, smooth sheen over a plastic, and sheen under a coat.
fn cloths() -> [Surface; 3] {
    let blue = Surface { base_color: Vec3::new(0.05, 0.1, 0.3), ..Surface::default() };
    let sheen_color = Vec3::new(0.9, 0.7, 0.5);
    [
        Surface { model: Model::Lambert, sheen_color, sheen_roughness: 0.6, ..blue },
        Surface { roughness: 0.6, specular: 1.0, sheen_color, sheen_roughness: 0.4, ..blue },
        Surface { sheen_color, sheen_roughness: 0.8, clearcoat: 1.0, clearcoat_roughness: 0.3, ..blue },
    ]
}

pub fn settings() -> RenderSettings {
    RenderSettings::default().with(|s| s.display.background = Background::None)
}

pub fn fitted(map: &Equirect) -> LightSet {
    gnomon_lights::fit::by_name("optimized", &FitOptions::default()).unwrap().fit(map).unwrap()
}

/// Two independent estimates of the truth.
pub fn traced(scene: &Scene, map: &Equirect, samples_per_pixel: u32) -> [RgbImage; 2] {
    let [width, height] = SIZE;
    [1, 2].map(|seed| {
        let options = ReferenceOptions {
            width,
            height,
            samples_per_pixel,
            seed,
            background: false,
            ..Default::default()
        };
        gnomon_reference::render(scene, &camera(), map, &options).unwrap().mean
    })
}

/// Relative RMSE within the ball's outline, values clamped at four times the mean of the truth. Noise of the two estimates of the truth has no
/// part in it: it is not the same in both.
pub fn error(seen: &RgbImage, truth: &[RgbImage; 2]) -> f64 {
    let [width, height] = SIZE;
    let is_inside = |x: u32, y: u32| {
        let range = |at: u32, end: u32| at.saturating_sub(1)..(at + 2).min(end);
        range(y, height).all(|y| range(x, width).all(|x| truth[0].get(x, y) != Vec3::ZERO))
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let places: Vec<_> = places.filter(|&(x, y)| is_inside(x, y)).collect();
    let sum = |of: &dyn Fn(u32, u32) -> Vec3| {
        places.iter().map(|&(x, y)| f64::from(of(x, y).element_sum())).sum::<f64>()
            / (3 * places.len()) as f64
    };
    let mean = sum(&|x, y| truth[0].get(x, y));
    let most = Vec3::splat(4.0 * mean as f32);
    let off = |truth: &RgbImage, x, y| seen.get(x, y).min(most) - truth.get(x, y).min(most);
    sum(&|x, y| off(&truth[0], x, y) * off(&truth[1], x, y)).max(0.0).sqrt() / mean
}

#[test]
fn finished_balls_are_the_ray_tracers() {
    let Some(gpu) = gpu_or_skip() else { return };
    let Some(file) = gnomon_testing::data_file("reference/env_stpeters_latlong_512x256.exr") else { return };
    let st_peters = gnomon_envmap::load(&file, Default::default()).unwrap().map;
    let studio = gnomon_envmap::builtin::by_name("studio").unwrap().resized(512, 256);
    // Lamps of St Peter's end within a pixel in a smooth coat, as in a smooth metal.
    for (name, map, least) in [("studio", &studio, 0.0), ("st peters", &st_peters, 0.3)] {
        let set = fitted(map);
        for finished in coats().into_iter().chain(cloths()) {
            let surface =
                Surface { clearcoat_roughness: finished.clearcoat_roughness.max(least), ..finished };
            let truth = |surface| traced(&ball(surface), map, 256);
            let seen = render(&gpu, settings(), &ball(surface), map, &set, &camera(), SIZE).radiance;
            let (own, bare) = (error(&seen, &truth(surface)), error(&seen, &truth(surface.without_finish())));
            println!("{name} {} {own:.4}, without its finish {bare:.4}", surface.model.name());
            // Wide strong lobes are sampled too coarsely for lamps as strong as St Peter's, with a finish and without.
            let is_wide = surface.metallic > 0.0 || surface.sheen_color != Vec3::ZERO;
            let most = if is_wide && least > 0.0 { tolerances::FINISH_WIDE } else { tolerances::FINISH };
            assert!(own <= most && bare > 1.4 * own, "{name} {surface:?}: {own} {bare}");
        }
    }
}

/// A lamp of the scene, whose highlights are integrals over its outline, in the shadow that the ball itself casts.
#[test]
fn lamps_shine_on_finished_surfaces_as_the_ray_tracer_has_it() {
    let Some(gpu) = gpu_or_skip() else { return };
    let dark = LightSet::new("none", Vec::new(), no_light());
    let [plastic, _, matte] = coats();
    let [velvet, ..] = cloths();
    for surface in [plastic, matte, velvet] {
        let scene = |surface| {
            let mut scene = ball(surface);
            let towards = Camera::look_at(Vec3::new(1.5, 2.0, 2.5), Vec3::ZERO, 1.0).world_from_camera;
            scene.nodes.push(Node { parent_from_node: Affine3A::from_mat4(towards), ..Node::default() });
            let shape = AreaLightShape::Rectangle { size: Vec2::new(0.8, 0.5) };
            let node = NodeId(scene.nodes.len() - 1);
            let radiance = Vec3::new(9.0, 8.0, 7.0);
            scene.lights.push(AreaLight { node, shape, radiance, spread: Default::default() });
            scene
        };
        let truth = |surface| traced(&scene(surface), &no_light(), 200);
        let fine = settings().with(|s| s.techniques.supersample = 4);
        let seen = render(&gpu, fine, &scene(surface), &no_light(), &dark, &camera(), SIZE).radiance;
        let (own, bare) = (error(&seen, &truth(surface)), error(&seen, &truth(surface.without_finish())));
        println!("lamp {} {own:.4}, without its finish {bare:.4}", surface.model.name());
        assert!(own <= tolerances::FINISH_LAMP && bare > 1.4 * own, "{surface:?}: {own} {bare}");
    }
}
