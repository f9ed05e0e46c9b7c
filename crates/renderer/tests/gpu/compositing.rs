//! Compositing rules on glossy surfaces under few lights: no pixel is negative or not finite, whatever a rule takes away.

use std::sync::Arc;

use crate::common::*;
use glam::{Affine3A, Vec2, Vec3};
use gnomon_brdf::Surface;
use gnomon_envmap::Equirect;
use gnomon_lights::fit::{FitOptions, by_name};
use gnomon_picture::RgbImage;
use gnomon_renderer::RenderSettings;
use gnomon_renderer::composite::COMPOSITINGS;
use gnomon_scene::{Camera, Material, MaterialId, Scene};
use gnomon_testing::glossy_models;

const SIZE: [u32; 2] = [64, 48];

/// Every model at both ends of what shapes its lobe, and a mirror.
fn surfaces() -> Vec<Surface> {
    let base = Surface { base_color: Vec3::splat(0.5), specular: 1.0, ..Surface::default() };
    let mut surfaces = vec![Surface { metallic: 1.0, roughness: 0.0, ..base }];
    for model in glossy_models() {
        for end in model.shape().unwrap().range {
            let mut surface = Surface { model, ..base };
            (model.shape().unwrap().set)(&mut surface, Vec3::splat(end));
            surfaces.push(surface);
        }
    }
    surfaces
}

/// Rows of spheres close enough to shadow one another and the ground.
fn scene() -> Scene {
    let surfaces = surfaces();
    let mut meshes: Vec<_> = (0..surfaces.len()).map(|_| sphere()).collect();
    meshes.push(horizontal(Vec2::splat(-8.0), Vec2::splat(8.0), -1.0));
    let mut scene = scene_of(meshes, Material::default());
    for (place, surface) in surfaces.into_iter().enumerate() {
        scene.materials.push(Material { surface, ..Material::default() });
        Arc::make_mut(&mut scene.meshes[place]).material = Some(MaterialId(scene.materials.len() - 1));
        let at = Vec3::new(2.1 * (place % 4) as f32 - 3.15, 0.0, 2.1 * (place / 4) as f32 - 1.05);
        scene.nodes[place].parent_from_node = Affine3A::from_translation(at);
    }
    scene
}

/// Black but for a sun of a few texels 10^6 times as bright as the sky, and half a sky: what few lights get most wrong.
fn harsh_environment() -> Equirect {
    Equirect::new(RgbImage::from_fn(128, 64, |x, y| match (x, y) {
        (40..42, 20..22) => Vec3::new(1e6, 8e5, 6e5),
        (_, ..32) => Vec3::new(0.0, 0.5, 1.0),
        _ => Vec3::ZERO,
    }))
}

/// Pixels that no picture may have.
fn faults(picture: &RgbImage) -> usize {
    let fault = |texel: &&Vec3| !texel.is_finite() || texel.min_element() < 0.0;
    picture.texels().iter().filter(fault).count()
}

#[test]
fn no_rule_leaves_negative_or_infinite_pixels_on_glossy_surfaces() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (scene, map) = (scene(), harsh_environment());
    let camera = Camera::look_at(Vec3::new(0.0, 3.0, 9.0), Vec3::ZERO, 0.9);
    for (fit, count, shadows) in [("samples", 3, "hard"), ("partition", 6, "convolution")] {
        let options = FitOptions { light_count: Some(count), ..FitOptions::default() };
        let set = by_name(fit, &options).unwrap().fit(&map).unwrap();
        for compositing in COMPOSITINGS.iter().map(|entry| entry.name) {
            for (unshadowed, shadow_sampling) in [("auto", 1), ("cache", 4), ("sh", 2)] {
                let settings = RenderSettings::default().with(|s| {
                    s.techniques.shadows = shadows.to_owned();
                    s.techniques.compositing = compositing.to_owned();
                    s.techniques.unshadowed = unshadowed.to_owned();
                    s.techniques.gloss_samples = 8;
                    s.techniques.shadow_resolution = 64;
                    s.techniques.shadow_sampling = shadow_sampling;
                    s.techniques.supersample = 1;
                });
                let picture = render(&gpu, settings, &scene, &map, &set, &camera, SIZE).radiance;
                let what = format!("{count} of {fit}, {compositing}, {unshadowed}");
                assert_eq!(faults(&picture), 0, "{what}");
                assert!(picture.texels().iter().any(|texel| texel.max_element() > 0.1), "{what}: black");
            }
        }
    }
}

#[test]
fn faults_are_found() {
    let with = |texel| RgbImage::from_fn(4, 4, |x, y| if (x, y) == (1, 2) { texel } else { Vec3::ONE });
    assert_eq!(faults(&with(Vec3::ZERO)), 0);
    for wrong in [Vec3::new(1.0, -1e-30, 1.0), Vec3::splat(f32::NAN), Vec3::new(0.0, 0.0, f32::INFINITY)] {
        assert_eq!(faults(&with(wrong)), 1, "{wrong}");
    }
}
