//! Area lights in the scene: closed forms, and ray-traced truth.

use std::f32::consts::PI;

use crate::common::*;
use glam::{Affine3A, Mat3, Vec2, Vec3};
use gnomon_brdf::Surface;
use gnomon_lights::LightSet;
use gnomon_metrics::{compare, penumbra};
use gnomon_picture::RgbImage;
use gnomon_reference::ReferenceOptions;
use gnomon_renderer::{Gpu, RenderError, RenderSettings, Renderer, composite, shadow};
use gnomon_scene::{
    AreaLight, AreaLightShape, Camera, Material, MaterialId, Mesh, Node, NodeId, Profile, Projection, Scene,
    Spread, builtin,
};
use gnomon_testing::tolerances;

const RADIANCE: Vec3 = Vec3::new(3.0, 2.0, 1.0);
const DISK: AreaLightShape = AreaLightShape::Disk { radius: 0.2 };

fn add_light(scene: &mut Scene, shape: AreaLightShape, parent_from_node: Affine3A) {
    scene.nodes.push(Node { parent_from_node, ..Node::default() });
    scene.lights.push(AreaLight {
        node: NodeId(scene.nodes.len() - 1),
        shape,
        radiance: RADIANCE,
        spread: Default::default(),
    });
}

/// Facing down, the width along x.
fn facing_down(position: Vec3) -> Affine3A {
    Affine3A::from_mat3_translation(Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y), position)
}

/// Facing from one place towards another.
fn facing(position: Vec3, target: Vec3) -> Affine3A {
    Affine3A::from_mat4(Camera::look_at(position, target, 1.0).world_from_camera)
}

fn dark_set() -> LightSet {
    LightSet::new("test", Vec::new(), no_light())
}

fn lambert(albedo: f32) -> Material {
    Material {
        surface: Surface { base_color: Vec3::splat(albedo), ..Default::default() },
        ..Default::default()
    }
}

fn downward(height: f32, half_width: f32) -> Camera {
    let camera = Camera::look_at(Vec3::new(0.0, height, 0.0), Vec3::ZERO, 1.0);
    Camera { projection: Projection::Orthographic { half_width }, ..camera }
}

fn settings(shadows: &str) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.shadows = shadows.to_owned();
        s.techniques.shadow_resolution = 512;
        s.techniques.supersample = 1;
    })
}

/// No environment, no scene yet.
fn unlit_renderer(gpu: &Gpu, shadows: &str) -> Renderer {
    let mut renderer = Renderer::new(gpu, settings(shadows)).unwrap();
    renderer.set_lighting(&no_light(), &dark_set()).unwrap();
    renderer
}

fn picture(gpu: &Gpu, shadows: &str, scene: &Scene, camera: &Camera, size: [u32; 2]) -> RgbImage {
    render(gpu, settings(shadows), scene, &no_light(), &dark_set(), camera, size).radiance
}

/// Projected solid angle of a rectangle parallel to the floor at `height`, over the point under one corner.
fn corner_form_factor(a: f32, b: f32, height: f32) -> f32 {
    let half = |x: f32, y: f32| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    0.5 * (half(a / height, b / height) + half(b / height, a / height))
}

#[test]
fn irradiance_on_the_open_plane_has_its_closed_form() {
    let Some(gpu) = gpu_or_skip() else { return };
    let height = 1.5_f32;
    let at = |shape| (shape, facing_down(Vec3::Y * height));
    let aside = Vec3::new(0.8, height, 0.3);
    let cases = [
        (at(AreaLightShape::Disk { radius: 0.7 }), PI * 0.49 / (0.49 + height * height)),
        (
            at(AreaLightShape::Rectangle { size: Vec2::splat(0.8) }),
            4.0 * corner_form_factor(0.4, 0.4, height),
        ),
        (
            at(AreaLightShape::Rectangle { size: Vec2::new(2.0, 0.6) }),
            4.0 * corner_form_factor(1.0, 0.3, height),
        ),
        (
            (AreaLightShape::Sphere { radius: 0.4 }, Affine3A::from_translation(aside)),
            PI * 0.16 / aside.length_squared() * height / aside.length(),
        ),
        (
            (AreaLightShape::Sun { angular_radius: 0.05 }, facing(aside, Vec3::ZERO)),
            PI * 0.05_f32.sin().powi(2) * height / aside.length(),
        ),
    ];
    for (shadows, _) in shadow::names() {
        let mut renderer = unlit_renderer(&gpu, shadows);
        for ((shape, place), form_factor) in cases {
            let mut scene =
                scene_of(vec![horizontal(Vec2::splat(-3.0), Vec2::splat(3.0), 0.0)], lambert(1.0));
            add_light(&mut scene, shape, place);
            renderer.set_scene(&scene).unwrap();
            let seen = renderer.render(&downward(0.1, 1e-3), 3, 3).unwrap().radiance.get(1, 1);
            let expected = RADIANCE * form_factor / PI;
            let error = (seen / expected - 1.0).abs().max_element();
            println!("{shadows} {shape:?}: off by {error}");
            assert!(error <= tolerances::OPEN_PLANE_IRRADIANCE, "{shadows} {shape:?}: {seen} {expected}");
        }
    }
}

/// Half way between the angles of inner and outer cone, by cosine, a spot has a quarter of its intensity; outside it has none.
#[test]
fn spots_fall_off_as_khr_lights_punctual_has_it() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (radius, height) = (0.01_f32, 2.0_f32);
    let floor = horizontal(Vec2::splat(-3.0), Vec2::splat(3.0), 0.0);
    for (shadows, _) in shadow::names() {
        let mut renderer = unlit_renderer(&gpu, shadows);
        for (angle, share) in [(0.0_f32, 1.0), (0.2, 1.0), (0.55_f32.acos(), 0.25), (1.2, 0.0)] {
            let mut scene = scene_of(vec![floor.clone()], lambert(1.0));
            // As far from the place that is looked at, which lies in that direction from the front.
            let turned = Affine3A::from_translation(Vec3::Y * height) * Affine3A::from_rotation_z(angle);
            add_light(&mut scene, AreaLightShape::Sphere { radius }, turned * facing_down(Vec3::ZERO));
            scene.lights[0].spread = Spread::Cone { inner: 0.7_f32.acos(), outer: 0.4_f32.acos() };
            renderer.set_scene(&scene).unwrap();
            let seen = renderer.render(&downward(0.1, 1e-3), 3, 3).unwrap().radiance.get(1, 1);
            let intensity = RADIANCE * PI * radius * radius;
            let expected = share * intensity / (height * height) / PI;
            let error = ((seen - expected) / (intensity / (height * height) / PI)).abs().max_element();
            println!("{shadows} {angle}: off by {error}");
            assert!(error <= tolerances::OPEN_PLANE_IRRADIANCE, "{shadows} {angle}: {seen} {expected}");
        }
    }
}

/// A profile that falls from the front to 80 degrees as the square of what is left.
#[test]
fn profiles_give_each_angle_its_intensity() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (radius, height, last) = (0.01_f32, 2.0_f32, 80_f32.to_radians());
    let profile = Profile::new(last, |angle| (1.0 - angle / last).powi(2)).unwrap();
    let floor = horizontal(Vec2::splat(-3.0), Vec2::splat(3.0), 0.0);
    let mut renderer = unlit_renderer(&gpu, "none");
    for angle in [0.0_f32, 0.21, 0.5, 0.9, 1.3, 1.5] {
        let mut scene = scene_of(vec![floor.clone()], lambert(1.0));
        let turned = Affine3A::from_translation(Vec3::Y * height) * Affine3A::from_rotation_z(angle);
        add_light(&mut scene, AreaLightShape::Sphere { radius }, turned * facing_down(Vec3::ZERO));
        scene.lights[0].spread = Spread::Profile(profile);
        renderer.set_scene(&scene).unwrap();
        let seen = renderer.render(&downward(0.1, 1e-3), 3, 3).unwrap().radiance.get(1, 1);
        let whole = RADIANCE * radius * radius / (height * height);
        let share = (1.0 - angle / last).max(0.0).powi(2);
        let error = (seen / whole - share).abs().max_element();
        println!("{angle}: {} of {share}", seen.x / whole.x);
        // A parabola between 24 places is off by a quarter of the square of half a step.
        assert!(error <= tolerances::OPEN_PLANE_IRRADIANCE, "{angle}: {} {share}", seen / whole);
        // The same on the CPU.
        assert!((profile.share(angle.cos()) - seen.x / whole.x).abs() < 1e-3);
    }
}

/// Visibility along x on the ground, 1 m in all, under an occluder over x < `edge` at `height` and a light 2 m up. `renderers` draw
/// shadows and none.
fn penumbra_profile(
    [shadowed, open]: [&mut Renderer; 2],
    shape: AreaLightShape,
    edge: f32,
    height: f32,
) -> Vec<f32> {
    let occluder = horizontal(Vec2::splat(-2.0), Vec2::new(edge, 2.0), height);
    let mut scene =
        scene_of(vec![horizontal(Vec2::splat(-2.0), Vec2::splat(2.0), 0.0), occluder], lambert(1.0));
    add_light(&mut scene, shape, facing_down(Vec3::Y * 2.0));
    let row = |renderer: &mut Renderer| {
        renderer.set_scene(&scene).unwrap();
        let image = renderer.render(&downward(0.5 * height, 0.5), 400, 5).unwrap().radiance;
        // Looking down, the camera has world -x to its right.
        (0..400).rev().map(|x| image.get(x, 2).x).collect::<Vec<_>>()
    };
    let open = row(open);
    row(shadowed).into_iter().zip(open).map(|(seen, open)| seen / open).collect()
}

/// Full width of a penumbra in metres: of a disk by its own profile, of a square by its linear ramp.
fn penumbra_width(shape: AreaLightShape, profile: &[f32]) -> f32 {
    let width = match shape {
        AreaLightShape::Rectangle { .. } => {
            penumbra::width_between(profile, 0.1, 0.9).map(|width| width / 0.8)
        }
        _ => penumbra::disk_penumbra_width(profile),
    };
    width.unwrap() / 400.0
}

#[test]
fn penumbrae_grow_with_blocker_distance_as_in_the_closed_form() {
    let Some(gpu) = gpu_or_skip() else { return };
    let renderers = ["convolution", "hard", "none"].map(|shadows| unlit_renderer(&gpu, shadows));
    let [mut soft, mut hard, mut open] = renderers;
    for shape in [AreaLightShape::Disk { radius: 0.25 }, AreaLightShape::Rectangle { size: Vec2::splat(0.5) }]
    {
        for height in [0.3_f32, 0.6, 0.9] {
            let expected = 0.5 * height / (2.0 - height);
            // Where the edge falls among the texels of a coarse level changes the width a little: several places.
            let edges = [0.0, 0.013, 0.03, 0.057];
            let widths = edges.map(|edge| {
                let profile = penumbra_profile([&mut soft, &mut open], shape, edge, height);
                let (dark, lit) = (profile[2], profile[397]);
                assert!(dark < 0.03 && (lit - 1.0).abs() < 0.03, "{shape:?} {height}: {dark} to {lit}");
                penumbra_width(shape, &profile)
            });
            let width = widths.iter().sum::<f32>() / widths.len() as f32;
            println!("{shape:?} blocker at {height}: penumbra {width:.4}, closed form {expected:.4}");
            assert!(
                (width / expected - 1.0).abs() <= tolerances::PENUMBRA_WIDTH,
                "{width} against {expected}"
            );
        }
    }
    // A planted fault: no penumbra at all.
    let width = penumbra_width(DISK, &penumbra_profile([&mut hard, &mut open], DISK, 0.03, 0.6));
    assert!((width / 0.171 - 1.0).abs() > tolerances::PENUMBRA_WIDTH, "{width}");
}

fn lamp_over_boxes(shape: AreaLightShape) -> Scene {
    let mut scene = builtin::by_name("three-boxes").unwrap();
    add_light(&mut scene, shape, facing(Vec3::new(-1.0, 3.5, 1.5), Vec3::new(0.0, 0.3, 0.0)));
    scene
}

/// Every shape against ray tracing. `GNOMON_PICTURES` names a folder for the pictures.
#[test]
fn lamps_over_three_boxes_match_ray_tracing() {
    let Some(gpu) = gpu_or_skip() else { return };
    let size = [160, 120];
    for (name, shape) in [
        ("disk", DISK),
        ("rectangle", AreaLightShape::Rectangle { size: Vec2::new(0.6, 0.3) }),
        ("sphere", AreaLightShape::Sphere { radius: 0.2 }),
        ("spot", AreaLightShape::Sphere { radius: 0.2 }),
        ("sun", AreaLightShape::Sun { angular_radius: 0.06 }),
    ] {
        let mut scene = lamp_over_boxes(shape);
        if name == "spot" {
            scene.lights[0].spread = Spread::Cone { inner: 0.25, outer: 0.6 };
        }
        let camera = &scene.cameras[0];
        let options =
            ReferenceOptions { width: size[0], height: size[1], samples_per_pixel: 64, ..Default::default() };
        let truth = gnomon_reference::render(&scene, camera, &no_light(), &options).unwrap().mean;
        let error = |shadows: &str| {
            let settings = settings(shadows).with(|s| s.techniques.supersample = 2);
            let seen = render(&gpu, settings, &scene, &no_light(), &dark_set(), camera, size).radiance;
            if let Ok(folder) = std::env::var("GNOMON_PICTURES") {
                for (what, image) in [(shadows, &seen), ("truth", &truth)] {
                    let shown = gnomon_picture::tonemap::tone_mapped(
                        image,
                        gnomon_picture::ToneMapping::Neutral,
                        4.5,
                    );
                    gnomon_picture::write(format!("{folder}/{name}_{what}.png"), &shown).unwrap();
                }
            }
            compare(&seen, &truth, None).unwrap().relative_rmse
        };
        let [soft, none] = ["convolution", "none"].map(error);
        println!("{name}: relative RMSE {soft:.4}, without shadows {none:.4}");
        assert!(soft <= tolerances::LAMP_RELATIVE_RMSE, "{name}: {soft}");
        // A planted fault: no shadows at all.
        assert!(none > 2.0 * tolerances::LAMP_RELATIVE_RMSE, "{name}: {none}");
    }
}

/// A panel that glows over the boxes, in front of a metal floor: its light, its shadows and its reflection, and the panel itself.
#[test]
fn a_glowing_panel_lights_as_ray_traced() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut scene = builtin::by_name("three-boxes").unwrap();
    let glow = Material { emissive: Vec3::new(6.0, 4.0, 2.0), ..lambert(0.2) };
    scene.materials.push(glow);
    let panel = Mesh {
        material: Some(MaterialId(scene.materials.len() - 1)),
        ..horizontal(Vec2::new(-0.5, -0.3), Vec2::new(0.5, 0.3), 0.0)
    };
    let node = scene.push_mesh("panel", panel);
    // Its front, which looks up, is turned towards the boxes.
    let place = facing(Vec3::new(-1.3, 1.5, 0.9), Vec3::new(0.0, 0.3, 0.0));
    scene.nodes[node.0].parent_from_node = place * Affine3A::from_rotation_x(-0.5 * PI);
    let seen_alone = scene.clone();
    scene.light_emission();
    // It is wide for what is so near.
    assert!(scene.placed_lights().len() > 1);
    let towards = (Vec3::new(0.0, 0.3, 0.0) - Vec3::new(-1.3, 1.5, 0.9)).normalize();
    assert!(scene.placed_lights()[0].normal.dot(towards) > 0.999, "{:?}", scene.placed_lights());
    let camera = &scene.cameras[0];
    let options = ReferenceOptions { width: 120, height: 90, samples_per_pixel: 1024, ..Default::default() };
    let truth = gnomon_reference::render(&scene, camera, &no_light(), &options).unwrap().mean;
    let error = |shadows: &str, scene: &Scene| {
        let settings = settings(shadows).with(|s| s.techniques.supersample = 2);
        let seen = render(&gpu, settings, scene, &no_light(), &dark_set(), camera, [120, 90]).radiance;
        if let Some(folder) = std::env::var_os("GNOMON_PICTURES") {
            let folder = std::path::Path::new(&folder);
            gnomon_picture::write(folder.join("panel_truth.exr"), &truth).unwrap();
            gnomon_picture::write(folder.join("panel_seen.exr"), &seen).unwrap();
        }
        // The panel's own edges are not what this is about.
        let [seen, truth] =
            [&seen, &truth].map(|image| RgbImage::from_fn(92, 90, |x, y| image.get(x + 28, y)));
        compare(&seen, &truth, None).unwrap().relative_rmse
    };
    let dark = error("rays", &seen_alone);
    println!("panel: without its light {dark:.4}");
    for (shadows, _) in shadow::names() {
        let lit = error(shadows, &scene);
        println!("panel {shadows}: {lit:.4}");
        if ["rays", "wedges"].contains(&shadows) {
            assert!(lit <= tolerances::LAMP_RELATIVE_RMSE, "{shadows}: {lit}");
        }
        // None takes the panel for what blocks its own light, so near to what it lights as it is.
        assert!(lit < 0.4 * dark, "{shadows}: {lit}");
    }
    assert!(dark > 2.0 * tolerances::LAMP_RELATIVE_RMSE, "{dark}");
}

/// The lamp's light comes on top of the environment's, whatever the compositing rule.
#[test]
fn lamps_add_to_the_environment_under_every_rule() {
    let Some(gpu) = gpu_or_skip() else { return };
    let lit = lamp_over_boxes(DISK);
    let dark = Scene { lights: Vec::new(), ..lit.clone() };
    let camera = &lit.cameras[0];
    let map = constant_map(Vec3::ONE);
    let mut set = one_disk(Vec3::new(0.5, 0.8, 0.2).normalize(), 0.3);
    set.residual = constant_map(Vec3::splat(0.3));
    for rule in composite::COMPOSITINGS {
        let settings = settings("hard").with(|s| {
            s.techniques.compositing = rule.name.to_owned();
            s.display.background = gnomon_renderer::Background::None;
            // Where lights are summed depends on what they give: all samples are lit.
            s.techniques.supersample = 2;
            s.techniques.shadow_sampling = 1;
        });
        let seen =
            |scene, map, set| render(&gpu, settings.clone(), scene, map, set, camera, [48, 36]).radiance;
        let both = seen(&lit, &map, &set);
        let sum = (seen(&dark, &map, &set), seen(&lit, &no_light(), &dark_set()));
        let parts = sum.0.texels().iter().zip(sum.1.texels()).map(|(a, b)| *a + *b);
        for (both, parts) in both.texels().iter().zip(parts) {
            assert!((*both - parts).abs().max_element() < 1e-4, "{}: {both} {parts}", rule.name);
        }
    }
}

#[test]
fn highlights_are_about_as_bright_as_ray_traced_ones() {
    let Some(gpu) = gpu_or_skip() else { return };
    for roughness in [0.15_f32, 0.4, 0.7] {
        let surface = Surface { base_color: Vec3::ONE, metallic: 1.0, roughness, ..Default::default() };
        let floor = horizontal(Vec2::splat(-3.0), Vec2::splat(3.0), 0.0);
        let mut scene = scene_of(vec![floor], Material { surface, ..Default::default() });
        add_light(&mut scene, AreaLightShape::Disk { radius: 0.3 }, facing_down(Vec3::new(0.0, 2.0, -1.0)));
        let camera = Camera::look_at(Vec3::new(0.0, 2.0, 3.0), Vec3::new(0.0, 0.0, 0.8), 0.9);
        let options = ReferenceOptions { width: 48, height: 36, samples_per_pixel: 64, ..Default::default() };
        let truth = gnomon_reference::render(&scene, &camera, &no_light(), &options).unwrap().mean;
        let seen = picture(&gpu, "none", &scene, &camera, [48, 36]);
        let sum = |image: &RgbImage| image.texels().iter().map(|texel| texel.x).sum::<f32>();
        let ratio = sum(&seen) / sum(&truth);
        println!("roughness {roughness}: {ratio} of the truth");
        assert!((ratio - 1.0).abs() <= tolerances::HIGHLIGHT_FLUX, "roughness {roughness}: {ratio}");
    }
}

#[test]
fn lamps_move_with_their_nodes() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut scene = lamp_over_boxes(DISK);
    let camera = scene.cameras[0].clone();
    let fresh = |scene: &Scene| picture(&gpu, "convolution", scene, &camera, [32, 24]);
    let mut renderer = unlit_renderer(&gpu, "convolution");
    renderer.set_scene(&scene).unwrap();
    let before = renderer.render(&camera, 32, 24).unwrap().radiance;
    assert_eq!(before, fresh(&scene));
    let node = scene.lights[0].node.0;
    scene.nodes[node].parent_from_node = facing(Vec3::new(1.5, 3.0, 1.0), Vec3::ZERO);
    renderer.move_scene(&scene).unwrap();
    let moved = renderer.render(&camera, 32, 24).unwrap().radiance;
    assert_ne!(moved, before);
    assert_eq!(moved, fresh(&scene));
    // A lamp goes out, another joins: as a new scene.
    scene.lights[0].radiance = Vec3::ZERO;
    renderer.move_scene(&scene).unwrap();
    assert!(renderer.render(&camera, 32, 24).unwrap().radiance.texels().iter().all(|t| *t == Vec3::ZERO));
    add_light(&mut scene, AreaLightShape::Sphere { radius: 0.1 }, Affine3A::from_translation(Vec3::Y * 3.0));
    renderer.move_scene(&scene).unwrap();
    assert_eq!(renderer.render(&camera, 32, 24).unwrap().radiance, fresh(&scene));
}

#[test]
fn odd_lamps_are_defined() {
    let Some(gpu) = gpu_or_skip() else { return };
    let boxes = builtin::by_name("three-boxes").unwrap();
    let camera = &boxes.cameras[0];
    for shadows in ["hard", "convolution"] {
        let mut renderer = unlit_renderer(&gpu, shadows);
        let mut picture = |shape, place| {
            let mut scene = boxes.clone();
            add_light(&mut scene, shape, place);
            renderer.set_scene(&scene).unwrap();
            let image = renderer.render(camera, 16, 12).unwrap().radiance;
            assert!(image.texels().iter().all(|texel| texel.is_finite() && texel.min_element() >= 0.0));
            image.texels().iter().all(|texel| *texel == Vec3::ZERO)
        };
        for shape in [
            AreaLightShape::Sphere { radius: 0.0 },
            AreaLightShape::Disk { radius: -1.0 },
            AreaLightShape::Rectangle { size: Vec2::new(f32::NAN, 1.0) },
        ] {
            assert!(picture(shape, facing_down(Vec3::Y * 3.0)), "{shape:?} is dark");
        }
        for shape in [
            DISK,
            AreaLightShape::Rectangle { size: Vec2::splat(0.1) },
            AreaLightShape::Sphere { radius: 0.1 },
        ] {
            assert!(!picture(shape, facing_down(Vec3::Y * 3.0)), "{shape:?} shines");
            let flat = !matches!(shape, AreaLightShape::Sphere { .. });
            let away = facing(Vec3::Y * 3.0, Vec3::Y * 9.0);
            assert_eq!(picture(shape, away), flat, "{shape:?} faces away");
            // Under the ground, inside a box, in the ground's very plane.
            for position in [Vec3::Y * -1.0, Vec3::new(0.6, 0.9, -0.7), Vec3::ZERO] {
                picture(shape, facing_down(position));
            }
        }
        let around = AreaLightShape::Sphere { radius: 100.0 };
        assert!(picture(around, Affine3A::IDENTITY), "inside a sphere there is none of its light");
    }
}

#[test]
fn a_scene_that_cannot_be_taken_leaves_the_one_before() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut renderer = unlit_renderer(&gpu, "hard");
    let floor = || scene_of(vec![horizontal(Vec2::splat(-1.0), Vec2::splat(1.0), 0.0)], lambert(0.5));
    let mut lit = floor();
    add_light(&mut lit, DISK, facing_down(2.0 * Vec3::Y));
    renderer.set_scene(&lit).unwrap();
    let before = renderer.render(&downward(3.0, 1.0), 16, 16).unwrap().display;
    assert!(before.iter().any(|texel| texel[0] > 20), "nothing is lit");

    let mut far = floor();
    far.nodes[0].parent_from_node = Affine3A::from_translation(Vec3::splat(1e20));
    let Err(error) = renderer.set_scene(&far) else { panic!("a scene out of all bounds was taken") };
    assert!(error.to_string().contains("origin"), "{error}");
    assert!(renderer.move_scene(&far).is_err());
    assert_eq!(renderer.render(&downward(3.0, 1.0), 16, 16).unwrap().display, before);

    let no_map =
        settings("hard").with(|s| (s.techniques.shadow_memory, s.techniques.shadow_resolution) = (1, 1024));
    let mut renderer = Renderer::new(&gpu, no_map).unwrap();
    renderer.set_lighting(&no_light(), &dark_set()).unwrap();
    renderer.set_scene(&floor()).unwrap();
    assert!(matches!(renderer.set_scene(&lit), Err(RenderError::OverBudget { .. })));
    renderer.render(&downward(3.0, 1.0), 16, 16).unwrap();
}
