//! Bumps against the ray-traced height field, and what they must leave alone.

use std::sync::Arc;

use crate::common::*;
use glam::{Affine2, Affine3A, Mat3, Vec2, Vec3};
use gnomon_envmap::{Equirect, builtin};
use gnomon_lights::LightSet;
use gnomon_lights::fit::{self, FitOptions};
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_reference::ReferenceOptions;
use gnomon_renderer::{BumpShadows, Bumps, RenderSettings, Renderer};
use gnomon_scene::{
    AreaLight, AreaLightShape, Camera, Height, HeightMap, HeightMapId, Material, Node, NodeId, Scene, Wrap,
};
use gnomon_testing::tolerances;

/// Three by three domes a metre, as high as a third of their width, on a square of 2 m.
fn domes() -> HeightMap {
    let side = 64;
    let height = |i: u32| {
        let p = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
        let squared = ((2.0 * p).fract() - 0.5).length_squared() / (0.42 * 0.42);
        (1.0 - squared).max(0.0)
    };
    HeightMap::new(side, side, (0..side * side).map(height).collect(), [Wrap::Repeat; 2]).unwrap()
}

/// A square of 2 m with texture coordinates, under these heights.
fn square(map: HeightMap, scale: f32, uv_from_mesh: Affine2) -> Scene {
    let mut mesh = horizontal(Vec2::splat(-1.0), Vec2::splat(1.0), 0.0);
    mesh.uvs[0] = mesh.positions.iter().map(|p| Vec2::new(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.z)).collect();
    let mut material = Material::default();
    material.surface.base_color = Vec3::new(0.8, 0.7, 0.5);
    material.height = Some(Height { map: HeightMapId(0), uv_from_mesh, set: 0, scale });
    let mut scene = scene_of(vec![mesh], material);
    scene.height_maps.push(Arc::new(map));
    scene
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.4, 1.8, 1.7), Vec3::new(0.0, 0.0, 0.1), 0.9)
}

fn settings(bumps: Bumps, shadows: BumpShadows) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.bumps = bumps;
        s.techniques.bump_shadows = shadows;
        s.techniques.supersample = 2;
    })
}

/// Relative RMSE of each way to draw bumps against the truth: off, shade, shadow and scatter by ellipses, scatter by horizons.
fn errors(scene: &Scene, map: &Equirect, set: &LightSet, what: &str) -> Option<[f64; 5]> {
    let gpu = gpu_or_skip()?;
    let [width, height] = [64, 48];
    let options = ReferenceOptions { width, height, samples_per_pixel: 160, seed: 3, ..Default::default() };
    let truth = gnomon_reference::render(scene, &camera(), map, &options).unwrap().mean;
    let ways = [
        (Bumps::Off, BumpShadows::Ellipses),
        (Bumps::Shade, BumpShadows::Ellipses),
        (Bumps::Shadow, BumpShadows::Ellipses),
        (Bumps::Scatter, BumpShadows::Ellipses),
        (Bumps::Scatter, BumpShadows::Horizons),
    ];
    let errors = ways.map(|(bumps, shadows)| {
        let frame = render(&gpu, settings(bumps, shadows), scene, map, set, &camera(), [width, height]);
        if std::env::var_os("GNOMON_BUMP_PICTURES").is_some() {
            let name = format!("{}-{}-{}.exr", what.replace(' ', "-"), bumps.name(), shadows.name());
            let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
            gnomon_picture::write(folder.join(name), &frame.radiance).unwrap();
            gnomon_picture::write(folder.join(format!("{}-truth.exr", what.replace(' ', "-"))), &truth)
                .unwrap();
        }
        compare(&frame.radiance, &truth, None).unwrap().relative_rmse
    });
    println!(
        "{what}: off {:.4}, shade {:.4}, shadow {:.4}, scatter {:.4}, by horizons {:.4}",
        errors[0], errors[1], errors[2], errors[3], errors[4]
    );
    Some(errors)
}

fn check(errors: [f64; 5], what: &str) {
    let [off, shade, shadow, scatter, horizons] = errors;
    assert!(
        off > shade && shade > shadow && shadow > scatter,
        "{what}: every step earns its place: {errors:?}"
    );
    assert!(scatter <= tolerances::BUMPS && horizons <= tolerances::BUMPS, "{what}: {errors:?}");
}

#[test]
#[ignore = "a minute of tracing: cargo test --workspace --test gpu bumps -- --ignored --nocapture"]
fn bumps_under_the_sky_are_those_of_the_traced_height_field() {
    let map = builtin::by_name("sky").unwrap();
    let set = fit::by_name("optimized", &FitOptions::default()).unwrap().fit(&map).unwrap();
    let scene = square(domes(), 0.25, Affine2::from_scale(Vec2::splat(2.0)));
    let Some(errors) = errors(&scene, &map, &set, "sky") else { return };
    check(errors, "sky");
}

#[test]
#[ignore = "fails: 0.17 by ellipses, 0.15 by horizons; a minute of tracing"]
fn bumps_under_a_lamp_are_those_of_the_traced_height_field() {
    let down = Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y);
    let mut scene = square(domes(), 0.25, Affine2::from_scale(Vec2::splat(2.0)));
    let parent_from_node = Affine3A::from_mat3_translation(down, Vec3::new(-1.0, 1.2, -0.6));
    scene.nodes.push(Node { parent_from_node, ..Node::default() });
    let shape = AreaLightShape::Disk { radius: 0.3 };
    scene.lights.push(AreaLight {
        node: NodeId(scene.nodes.len() - 1),
        shape,
        radiance: Vec3::splat(5.0),
        spread: Default::default(),
    });
    let dark = LightSet::new("test", Vec::new(), no_light());
    let Some(errors) = errors(&scene, &no_light(), &dark, "lamp") else { return };
    check(errors, "lamp");
}

fn draw(renderer: &mut Renderer) -> RgbImage {
    renderer.render(&camera(), 64, 48).unwrap().radiance
}

/// Flat heights, those of one texel, and heights on a mesh without coordinates change no bit; heights that are taken away leave nothing.
#[test]
fn odd_heights_leave_the_picture_as_it_is() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = builtin::by_name("sky").unwrap();
    let set = one_disk(Vec3::new(0.5, 0.8, 0.3).normalize(), 0.2);
    let mut renderer = Renderer::new(&gpu, settings(Bumps::Scatter, BumpShadows::Ellipses)).unwrap();
    renderer.set_lighting(&map, &set).unwrap();
    let mut plain = square(domes(), 0.2, Affine2::IDENTITY);
    plain.materials[0].height = None;
    renderer.set_scene(&plain).unwrap();
    let expected = draw(&mut renderer);
    let one = || HeightMap::new(1, 1, vec![7.0], [Wrap::ClampToEdge; 2]).unwrap();
    let constant = || HeightMap::new(5, 3, vec![-2.0; 15], [Wrap::MirroredRepeat; 2]).unwrap();
    let mut without = square(domes(), 0.2, Affine2::IDENTITY);
    Arc::make_mut(&mut without.meshes[0]).uvs[0].clear();
    let scenes = [square(one(), 1.0, Affine2::IDENTITY), square(constant(), 1.0, Affine2::IDENTITY), without];
    for (i, scene) in scenes.iter().enumerate() {
        renderer.set_scene(scene).unwrap();
        let found = compare(&draw(&mut renderer), &expected, None).unwrap().relative_rmse;
        assert!(found < 2e-3, "scene {i}: {found}");
    }
    let bumpy = square(domes(), 0.2, Affine2::IDENTITY);
    renderer.set_scene(&bumpy).unwrap();
    let bumps = draw(&mut renderer);
    assert!(compare(&bumps, &expected, None).unwrap().relative_rmse > 0.05);
    // Heights upside down on a square that is seen from above, mirrored: the same bumps at other places.
    renderer.set_settings(settings(Bumps::Off, BumpShadows::Ellipses), &set).unwrap();
    assert_eq!(draw(&mut renderer).texels(), expected.texels(), "off");
    renderer.set_settings(settings(Bumps::Scatter, BumpShadows::Ellipses), &set).unwrap();
    assert_eq!(draw(&mut renderer).texels(), bumps.texels(), "on again");
    renderer.set_scene(&plain).unwrap();
    assert_eq!(draw(&mut renderer).texels(), expected.texels(), "heights taken away");
}

/// Mirrored coordinates with mirrored heights are the same bumps.
#[test]
#[ignore = "fails: the pictures differ by 0.084, for a reason that is not known yet"]
fn mirrored_coordinates_show_the_same_bumps() {
    let Some(gpu) = gpu_or_skip() else { return };
    let side = 32u32;
    let value = |x: u32, y: u32| ((x as f32 * 0.4).sin() + (y as f32 * 0.7).cos()) * 0.5;
    let of = |mirrored: bool| {
        let values =
            (0..side * side).map(|i| value(if mirrored { side - 1 - i % side } else { i % side }, i / side));
        HeightMap::new(side, side, values.collect(), [Wrap::Repeat; 2]).unwrap()
    };
    let map = builtin::by_name("sky").unwrap();
    let set = one_disk(Vec3::new(0.5, 0.6, 0.3).normalize(), 0.2);
    let picture = |scene: &Scene| {
        render(&gpu, settings(Bumps::Scatter, BumpShadows::Ellipses), scene, &map, &set, &camera(), [64, 48])
            .radiance
    };
    let straight = picture(&square(of(false), 0.2, Affine2::IDENTITY));
    let mirror = Affine2::from_scale_angle_translation(Vec2::new(-1.0, 1.0), 0.0, Vec2::X);
    let found = compare(&picture(&square(of(true), 0.2, mirror)), &straight, None).unwrap().relative_rmse;
    assert!(found < 0.01, "{found}");
    let wrong = compare(&picture(&square(of(false), 0.2, mirror)), &straight, None).unwrap().relative_rmse;
    assert!(wrong > 5.0 * found.max(0.01), "the test sees nothing: {wrong}");
}
