//! What glossy surfaces reflect of the environment and of the scene.

use std::sync::Arc;

use crate::common::*;
use glam::{Vec2, Vec3};
use gnomon_brdf::Surface;
use gnomon_lights::{FitOptions, LightSet};
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_reference::ReferenceOptions;
use gnomon_renderer::{GlossPath, Reflections, RenderSettings};
use gnomon_scene::{Camera, Material, MaterialId, Scene, Texture, TextureId, TextureRef, Wrap};
use gnomon_testing::tolerances;

fn metal(roughness: f32) -> Material {
    let surface =
        Surface { base_color: Vec3::ONE, metallic: 1.0, roughness, specular: 1.0, ..Default::default() };
    Material { surface, ..Default::default() }
}

fn settings(gloss: GlossPath) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.gloss = gloss;
        s.paths.reflections = Reflections::Off;
        s.display.background = gnomon_renderer::Background::None;
    })
}

fn reflecting() -> RenderSettings {
    settings(GlossPath::Rays).with(|s| s.paths.reflections = Reflections::Scene)
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

/// A metal plate below one that shines, whose light goes only the way that is asked about.
#[test]
fn what_shines_is_seen_in_a_mirror() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (map, light) = (no_light(), Vec3::new(2.0, 1.0, 0.5));
    let set = LightSet::new("none", Vec::new(), map.clone());
    let plate = |y| horizontal(Vec2::splat(-50.0), Vec2::splat(50.0), y);
    let mut scene = scene_of(vec![plate(0.0), plate(1.0)], metal(0.15));
    scene.materials.push(Material { emissive: light, ..Material::default() });
    Arc::make_mut(&mut scene.meshes[1]).material = Some(MaterialId(1));
    let camera = Camera::look_at(Vec3::new(0.0, 0.9, 1.0), Vec3::ZERO, 0.5);
    let seen = |settings| render(&gpu, settings, &scene, &map, &set, &camera, [32, 24]).radiance.get(16, 12);
    let mirrored = seen(reflecting()) / light;
    println!("{mirrored}");
    assert!((mirrored - 1.0).abs().max_element() < 0.02, "{mirrored}");
    assert_eq!(seen(settings(GlossPath::Rays)), Vec3::ZERO);
}

/// A metal ball on a chequered floor.
fn ball_on_checks(roughness: f32) -> Scene {
    let mut floor = horizontal(Vec2::splat(-4.0), Vec2::splat(4.0), -1.0);
    floor.uvs[0] = floor.positions.iter().map(|p| Vec2::new(p.x, p.z) * 0.125).collect();
    let mut scene = scene_of(vec![sphere(), floor], metal(roughness));
    let texel =
        |i: u32| if (i % 8 + i / 8).is_multiple_of(2) { [230, 230, 230, 255] } else { [20, 60, 120, 255] };
    let rgba8 = (0..64).map(texel).collect();
    scene.textures.push(Arc::new(Texture {
        width: 8,
        height: 8,
        rgba8,
        wrap: [Wrap::Repeat; 2],
        nearest: true,
    }));
    let texture = TextureRef { texture: TextureId(0), set: 0, uv_from_mesh: glam::Affine2::IDENTITY };
    scene.materials.push(Material { base_color_texture: Some(texture), ..Material::default() });
    Arc::make_mut(&mut scene.meshes[1]).material = Some(MaterialId(1));
    scene
}

#[test]
fn a_ball_reflects_its_floor_as_the_ray_tracer_has_it() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = gnomon_envmap::builtin::by_name("sky").unwrap().resized(256, 128);
    let set = gnomon_lights::fit::by_name("optimized", &FitOptions::default()).unwrap().fit(&map).unwrap();
    let camera = Camera::look_at(Vec3::new(0.0, 1.5, 6.0), Vec3::new(0.0, -0.2, 0.0), 0.5);
    let options = ReferenceOptions {
        width: 64,
        height: 48,
        samples_per_pixel: 256,
        background: false,
        ..Default::default()
    };
    for roughness in [0.05, 0.4] {
        let scene = ball_on_checks(roughness);
        let truth = gnomon_reference::render(&scene, &camera, &map, &options).unwrap().mean;
        let sum: Vec3 = truth.texels().iter().copied().sum();
        let most = Vec3::splat(4.0 * sum.element_sum() / (3 * truth.texels().len()) as f32);
        let clamped = |of: &RgbImage| RgbImage::from_fn(64, 48, |x, y| of.get(x, y).min(most));
        let error = |settings| {
            let drawn = render(&gpu, settings, &scene, &map, &set, &camera, [64, 48]).radiance;
            compare(&clamped(&drawn), &clamped(&truth), None).unwrap().relative_rmse
        };
        let (scene, light) = (error(reflecting()), error(settings(GlossPath::Rays)));
        println!("roughness {roughness}: {scene:.4}, light alone {light:.4}");
        assert!(scene <= tolerances::GLOSS_OF_SCENE, "roughness {roughness}: {scene}");
        assert!(light > 2.0 * scene, "the measure tells: {light}");
    }
}
