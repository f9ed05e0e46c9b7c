//! What glossy surfaces reflect of the environment, and what the scene hides of it.

use crate::common::*;
use glam::{Vec2, Vec3};
use gnomon_brdf::Surface;
use gnomon_lights::{FitOptions, LightSet};
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_renderer::{GlossPath, RenderSettings};
use gnomon_scene::{Camera, Material};
use gnomon_testing::tolerances;

fn metal(roughness: f32) -> Material {
    let surface =
        Surface { base_color: Vec3::ONE, metallic: 1.0, roughness, specular: 1.0, ..Default::default() };
    Material { surface, ..Default::default() }
}

fn settings(gloss: GlossPath) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.gloss = gloss;
        s.display.background = gnomon_renderer::Background::None;
    })
}

/// Values above four times the mean are highlights of which a path tracer's noise tells little.
#[test]
fn metals_under_st_peters() {
    let Some((gpu, scene, camera, map, truth)) = of_mitsuba("metals", "stpeters", "metals_stpeters") else {
        return;
    };
    let options = FitOptions { ground: scene.stands_on_ground(), ..Default::default() };
    let set = gnomon_lights::fit::by_name("optimized", &options).unwrap().fit(&map).unwrap();
    let sum: Vec3 = truth.texels().iter().copied().sum();
    let most = Vec3::splat(4.0 * sum.element_sum() / (3 * truth.texels().len()) as f32);
    let [width, height] = [truth.width(), truth.height()];
    let error = |gloss| {
        let drawn = render(&gpu, settings(gloss), &scene, &map, &set, &camera, [width, height]).radiance;
        // Both are black where there is background; the edges against it are not what this is about.
        let clamped = |of: &RgbImage| {
            RgbImage::from_fn(width, height, |x, y| match truth.get(x, y) == Vec3::ZERO {
                true => Vec3::ZERO,
                false => of.get(x, y).min(most),
            })
        };
        compare(&clamped(&drawn), &clamped(&truth), None).unwrap().relative_rmse
    };
    let (rays, lights) = (error(GlossPath::Rays), error(GlossPath::Lights));
    println!("rays {rays:.4}, lights {lights:.4}");
    assert!(rays <= tolerances::GLOSS, "{rays}");
    assert!(lights > 1.3 * rays, "{lights} {rays}");
}

#[test]
fn nothing_is_reflected_between_closed_plates() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = constant_map(Vec3::ONE);
    let set = LightSet::new("none", Vec::new(), map.clone());
    // The viewer is between the plates, and so is all that a narrow lobe reflects to him.
    let plate = |y| horizontal(Vec2::splat(-50.0), Vec2::splat(50.0), y);
    let camera = Camera::look_at(Vec3::new(0.0, 0.9, 1.0), Vec3::ZERO, 0.5);
    let brightest = |gloss, meshes| {
        let scene = scene_of(meshes, metal(0.15));
        let frame = render(&gpu, settings(gloss), &scene, &map, &set, &camera, [32, 24]);
        frame.radiance.texels().iter().map(|texel| texel.max_element()).fold(0.0, f32::max)
    };
    let closed = brightest(GlossPath::Rays, vec![plate(0.0), plate(1.0)]);
    let open = brightest(GlossPath::Rays, vec![plate(0.0)]);
    println!("closed {closed}, open {open}");
    assert!(closed < 1e-3, "{closed}");
    assert!((open - 1.0).abs() < 0.03, "{open}");
}

#[test]
fn a_traced_furnace_gives_its_directional_albedo() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = constant_map(Vec3::ONE);
    let set = LightSet::new("none", Vec::new(), map.clone());
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 5_f32.to_radians());
    for roughness in [0.0, 0.1, 0.4, 0.7, 1.0] {
        let scene = scene_of(vec![sphere()], metal(roughness));
        let frame = render(&gpu, settings(GlossPath::Rays), &scene, &map, &set, &camera, [4, 4]);
        let albedo = gnomon_brdf::dfg(1.0, roughness).element_sum();
        let seen = frame.radiance.get(2, 2).x;
        println!("roughness {roughness}: {seen}, {albedo}");
        assert!((seen - albedo).abs() < tolerances::GLOSS_FURNACE, "roughness {roughness}: {seen}, {albedo}");
    }
}
