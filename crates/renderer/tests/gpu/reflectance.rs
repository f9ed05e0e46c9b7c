//! Reflectance models on the GPU: against the ray tracer, and edited while running.

use std::sync::Arc;

use crate::common::*;
use glam::{DVec2, DVec3, Vec3};
use gnomon_brdf::{Model, Surface};
use gnomon_lights::{DistantLight, LightSet};
use gnomon_picture::RgbImage;
use gnomon_reference::{ReferenceOptions, ResidualShadows};
use gnomon_renderer::{Gpu, RenderSettings, Renderer};
use gnomon_scene::{Camera, Material, MaterialId, Scene};
use gnomon_testing::{glossy_surface, tolerances};

/// Every model with a lobe of middle width, and Phong's with a narrow one.
fn surfaces() -> impl Iterator<Item = Surface> {
    let cases = Model::ALL.iter().map(|&model| (model, 0.45)).chain([(Model::Phong, 0.24)]);
    // GGX lobes are not integrated over lights, only widened.
    cases.filter(|(model, _)| *model != Model::MetallicRoughness).map(|(model, roughness)| Surface {
        base_color: Vec3::new(0.4, 0.3, 0.2),
        specular: 0.6,
        specular_color: Vec3::new(1.0, 0.8, 0.5),
        ior: 2.5,
        ..glossy_surface(model, roughness)
    })
}

fn one_sphere(surface: Surface) -> Scene {
    scene_of(vec![sphere()], Material { surface, ..Material::default() })
}

/// A disk and a rectangle, all light of the scene.
fn lights() -> LightSet {
    let frame = [DVec3::NEG_X, DVec3::Y, DVec3::Z];
    let lights = vec![
        DistantLight::disk(DVec3::new(-1.0, 0.7, 0.8).normalize(), 0.1, DVec3::new(1.0, 1.2, 0.9)),
        DistantLight::rectangle(
            frame,
            DVec2::new(-0.4, 0.1),
            DVec2::new(0.0, 0.2),
            DVec3::new(0.6, 0.8, 1.0),
        ),
    ];
    LightSet::new("test", lights, no_light())
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.0, 0.5, 4.0), Vec3::ZERO, 0.6)
}

/// Unshadowed lights, which on a convex body are all there is.
fn settings() -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.shadows = "none".to_owned();
        s.lighting.ambient = "unshadowed".to_owned();
        s.techniques.compositing = "additive".to_owned();
        s.display.background = gnomon_renderer::Background::None;
        s.techniques.supersample = 4;
    })
}

fn renderer(gpu: &Gpu, scene: &Scene) -> Renderer {
    let mut renderer = Renderer::new(gpu, settings()).unwrap();
    renderer.set_scene(scene).unwrap();
    renderer.set_lighting(&no_light(), &lights()).unwrap();
    renderer
}

/// Root mean square of the difference over that of the truth: highlights are far above the picture's mean.
fn error_of_power(seen: &RgbImage, truth: &RgbImage) -> f64 {
    let power = |sum: f64, texel: Vec3| sum + f64::from(texel.length_squared());
    let difference = seen.texels().iter().zip(truth.texels()).map(|(a, b)| *a - *b);
    (difference.fold(0.0, power) / truth.texels().iter().copied().fold(0.0, power)).sqrt()
}

#[test]
fn models_under_area_lights_are_the_ray_tracers() {
    let Some(gpu) = gpu_or_skip() else { return };
    let options = ReferenceOptions { width: 32, height: 32, samples_per_pixel: 768, ..Default::default() };
    for surface in surfaces() {
        let truth = |surface| {
            let scene = one_sphere(surface);
            let shadows = ResidualShadows::Cast;
            let camera = camera();
            gnomon_reference::render_lights(&scene, &camera, &lights(), shadows, &no_light(), &options)
                .unwrap()
                .mean
        };
        let seen = renderer(&gpu, &one_sphere(surface)).render(&camera(), 32, 32).unwrap().radiance;
        let error = |surface| error_of_power(&seen, &truth(surface));
        let own = error(surface);
        println!("{} {}: {own:.4}", surface.model.name(), surface.shape());
        assert!(own <= tolerances::GPU_REFLECTANCE, "{surface:?}: {own}");
        // The measure tells a lobe half as wide.
        if surface.model == Model::Phong {
            let other = error(Surface { shininess: 4.0 * surface.shininess, ..surface });
            assert!(other > 2.0 * tolerances::GPU_REFLECTANCE, "{other}");
        }
    }
}

/// With the environment itself, whose unshadowed light depends on the materials too.
fn edited_renderer(gpu: &Gpu, scene: &Scene) -> Renderer {
    let settings = settings().with(|s| s.techniques.compositing = "ratio".to_owned());
    let mut renderer = Renderer::new(gpu, settings).unwrap();
    renderer.set_lighting(&constant_map(Vec3::new(0.3, 0.2, 0.1)), &lights()).unwrap();
    renderer.set_scene(scene).unwrap();
    renderer
}

#[test]
fn edited_materials_are_those_of_a_fresh_renderer() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut scene = one_sphere(Surface::default());
    let mut edited = edited_renderer(&gpu, &scene);
    let mut last = edited.render(&camera(), 24, 24).unwrap().radiance;
    let mut check = |scene: &Scene| {
        edited.set_materials(scene).unwrap();
        let now = edited.render(&camera(), 24, 24).unwrap().radiance;
        assert_ne!(now, last, "{:?}", scene.materials);
        assert_eq!(now, edited_renderer(&gpu, scene).render(&camera(), 24, 24).unwrap().radiance);
        last = now;
    };
    let coat = Surface { clearcoat: 1.0, clearcoat_roughness: 0.2, ..Surface::default() };
    let cloth = Surface { sheen_color: Vec3::splat(0.5), sheen_roughness: 0.5, ..Surface::default() };
    for surface in surfaces().chain([coat, cloth, coat.without_finish()]) {
        scene.materials[0].surface = surface;
        check(&scene);
    }
    // A material more, and a mesh that takes it.
    scene.materials.push(Material { emissive: Vec3::ONE, ..Material::default() });
    Arc::make_mut(&mut scene.meshes[0]).material = Some(MaterialId(1));
    check(&scene);
}
