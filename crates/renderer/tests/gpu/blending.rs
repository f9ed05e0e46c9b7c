//! Surfaces that light passes in part, in the picture and in shadows.

use std::sync::Arc;

use crate::common::*;
use glam::{Vec2, Vec3};
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_renderer::{Gpu, RenderSettings};
use gnomon_scene::{AlphaMode, Camera, Material, MaterialId, Mesh, Projection, Scene};
use gnomon_testing::tolerances;

/// A material that emits and reflects nothing.
fn shining(radiance: Vec3, alpha: f32) -> Material {
    let alpha_mode = if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
    let mut material = Material { emissive: radiance, alpha, alpha_mode, ..Material::default() };
    material.surface.base_color = Vec3::ZERO;
    material
}

fn straight_down(half_width: f32) -> Camera {
    Camera {
        projection: Projection::Orthographic { half_width },
        ..Camera::look_at(Vec3::new(0.0, 9.0, 1e-3), Vec3::ZERO, 1.0)
    }
}

/// Sheets above one another, each with its height, a radiance and an alpha, that cover everything where x is above `from`.
fn sheets(of: &[(f32, Vec3, f32)], from: f32) -> Scene {
    let mesh = |y: f32| horizontal(Vec2::new(if y > 0.0 { from } else { -5.0 }, -5.0), Vec2::splat(5.0), y);
    let mut scene = scene_of(of.iter().map(|sheet| mesh(sheet.0)).collect(), Material::default());
    scene.materials = of.iter().map(|&(_, radiance, alpha)| shining(radiance, alpha)).collect();
    for (number, mesh) in scene.meshes.iter_mut().enumerate() {
        Arc::make_mut(mesh).material = Some(MaterialId(number));
    }
    scene
}

/// What is seen of them from above (Porter and Duff 1984, over).
fn over(of: &[(f32, Vec3, f32)]) -> Vec3 {
    let mut sorted = of.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    sorted.iter().fold(Vec3::ZERO, |behind, &(_, radiance, alpha)| alpha * radiance + (1.0 - alpha) * behind)
}

fn drawn(gpu: &Gpu, scene: &Scene, layers: u32, supersample: u32) -> RgbImage {
    let settings = RenderSettings::default().with(|s| {
        s.techniques.blended_layers = layers;
        s.techniques.supersample = supersample;
        s.techniques.shadow_sampling = supersample;
    });
    let set = one_disk(Vec3::Y, 0.1);
    render(gpu, settings, scene, &no_light(), &set, &straight_down(1.0), [32, 32]).radiance
}

fn mean(picture: &RgbImage) -> Vec3 {
    picture.texels().iter().sum::<Vec3>() / picture.texels().len() as f32
}

const SHEETS: [(f32, Vec3, f32); 5] = [
    (2.0, Vec3::new(0.2, 4.0, 1.0), 0.3),
    (0.0, Vec3::new(3.0, 1.0, 0.5), 1.0),
    (1.0, Vec3::new(1.0, 0.1, 5.0), 0.7),
    (3.0, Vec3::new(2.0, 2.0, 0.0), 0.1),
    // Hidden by what is opaque.
    (-1.0, Vec3::new(90.0, 90.0, 90.0), 0.9),
];

#[test]
fn layers_lie_over_one_another() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (expected, below) = (over(&SHEETS[..4]), SHEETS[1].1);
    // Opacities have eight bits: of each sheet half a step, times how far it differs from what lies behind.
    let near = |found: Vec3, expected: Vec3| {
        assert!((found - expected).abs().max_element() < 0.02, "{found} against {expected}");
    };
    for supersample in [1, 4] {
        let picture = drawn(&gpu, &sheets(&SHEETS, -5.0), 4, supersample);
        picture.texels().iter().for_each(|&texel| near(texel, expected));
        // Samples that no sheet covers show what lies below: the sheets end in the middle of a column of pixels; x grows to the left.
        let picture = drawn(&gpu, &sheets(&SHEETS, 1.0 / 32.0), 4, supersample.max(2));
        near(picture.get(14, 8), expected);
        near(picture.get(15, 8), 0.5 * (below + expected));
        near(picture.get(16, 8), below);
    }
}

#[test]
fn what_lies_behind_the_layers_is_right_on_average() {
    let Some(gpu) = gpu_or_skip() else { return };
    let expected = over(&SHEETS[..4]);
    let scene = sheets(&SHEETS, -5.0);
    for layers in [1, 2] {
        let found = mean(&drawn(&gpu, &scene, layers, 4));
        println!("{layers} layers: {found} against {expected}");
        assert!(((found - expected) / expected).abs().max_element() < 0.03, "{layers} layers: {found}");
    }
}

/// The floor beside a plate of an alpha, under a light whose shadow falls there.
fn shadow(gpu: &Gpu, technique: &str, alpha: f32, angular_radius: f32) -> RgbImage {
    let mut plate = horizontal(Vec2::splat(-0.5), Vec2::splat(0.5), 1.0);
    plate.material = Some(MaterialId(1));
    let mut scene =
        scene_of(vec![horizontal(Vec2::splat(-3.0), Vec2::splat(3.0), 0.0), plate], Material::default());
    let mut material = Material { alpha, ..Material::default() };
    material.alpha_mode = if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
    scene.materials.push(material);
    let mesh: &mut Mesh = Arc::make_mut(&mut scene.meshes[1]);
    mesh.material = Some(MaterialId(1));
    let settings = RenderSettings::default().with(|s| {
        s.techniques.shadows = technique.to_owned();
        s.techniques.compositing = "additive".to_owned();
        s.techniques.supersample = 2;
        s.techniques.shadow_sampling = 1;
    });
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.9 },
        ..Camera::look_at(Vec3::new(1.6, 0.9, 1e-3), Vec3::new(1.6, 0.0, 0.0), 1.0)
    };
    let set = one_disk(Vec3::new(-1.5, 1.0, 0.0).normalize(), angular_radius);
    render(gpu, settings, &scene, &no_light(), &set, &camera, [48, 48]).radiance
}

#[test]
fn shadows_are_as_dark_as_alpha_says() {
    let Some(gpu) = gpu_or_skip() else { return };
    for technique in ["pcss", "pcf", "rays"] {
        for angular_radius in [0.005, 0.1] {
            let [whole, none] = [1.0, 0.0].map(|alpha| shadow(&gpu, technique, alpha, angular_radius));
            for alpha in [0.25, 0.6] {
                let found = shadow(&gpu, technique, alpha, angular_radius);
                let expected = whole.texels().iter().zip(none.texels());
                let expected = expected.map(|(whole, none)| none.lerp(*whole, alpha)).collect();
                let expected = RgbImage::from_texels(48, 48, expected).unwrap();
                let error = compare(&found, &expected, None).unwrap().relative_rmse;
                let level = mean(&found).x / mean(&expected).x - 1.0;
                println!("{technique} {angular_radius} {alpha}: {error:.4}, mean {level:+.4}");
                let most = if technique == "rays" { 1e-3 } else { tolerances::BLENDED_SHADOW };
                assert!(error <= most, "{technique} {angular_radius} {alpha}: {error}");
            }
        }
    }
}
