//! Scenes whose picture is known in closed form.

use crate::common::*;
use glam::{DVec2, DVec3, Vec2, Vec3};
use gnomon_brdf::Surface;
use gnomon_envmap::Equirect;
use gnomon_lights::form_factor::rectangle_form_factor;
use gnomon_lights::{DistantLight, FitOptions, LightSet, LightShape};
use gnomon_metrics::{compare, penumbra};
use gnomon_picture::RgbImage;
use gnomon_renderer::{RenderSettings, composite, shadow};
use gnomon_scene::{Camera, Material, Mesh, Projection, Scene};
use gnomon_testing::tolerances;

fn material(surface: Surface) -> Material {
    Material { surface, ..Default::default() }
}

fn fitted(map: &Equirect) -> LightSet {
    // A uniform map gives lights as wide as a cube face, where one average blocker depth means little: cap them.
    let options = FitOptions { max_extent: Some(0.45), ..Default::default() };
    let fit = gnomon_lights::fit::by_name("partition", &options).unwrap();
    fit.fit(map).unwrap()
}

#[test]
fn constant_environment_over_lambert_is_albedo_times_radiance() {
    let Some(gpu) = gpu_or_skip() else { return };
    let radiance = Vec3::new(0.5, 1.0, 2.0);
    let albedo = Vec3::new(0.8, 0.5, 0.2);
    let map = constant_map(radiance);
    let set = fitted(&map);
    let scene = scene_of(vec![sphere()], material(Surface { base_color: albedo, ..Default::default() }));
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 20_f32.to_radians());
    // A sphere shadows nothing that its own horizon does not, so every technique must agree.
    for (shadows, _) in shadow::names() {
        for rule in composite::COMPOSITINGS {
            let settings = RenderSettings::default().with(|s| {
                s.techniques.shadows = shadows.to_owned();
                s.techniques.compositing = rule.name.to_owned();
            });
            let frame = render(&gpu, settings, &scene, &map, &set, &camera, [16, 16]);
            let worst = frame
                .radiance
                .texels()
                .iter()
                .map(|texel| ((*texel - albedo * radiance).abs() / (albedo * radiance)).max_element())
                .fold(0.0, f32::max);
            // Shadow maps of finite resolution darken the terminator of each light a little.
            println!("{shadows} {}: off by {worst}", rule.name);
            let tolerance =
                if shadows == "none" { tolerances::FURNACE as f32 } else { tolerances::GPU_FURNACE };
            assert!(worst <= tolerance, "{shadows} {}: off by {worst}", rule.name);
        }
    }
}

#[test]
fn a_ggx_furnace_gives_its_directional_albedo() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = constant_map(Vec3::ONE);
    let set = LightSet::new("test", Vec::new(), map.clone());
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 5_f32.to_radians());
    for roughness in [0.1, 0.4, 0.7, 1.0] {
        let surface =
            Surface { base_color: Vec3::ONE, metallic: 1.0, roughness, specular: 1.0, ..Default::default() };
        let scene = scene_of(vec![sphere()], material(surface));
        let settings = RenderSettings::default().with(|s| s.techniques.shadows = "none".to_owned());
        let frame = render(&gpu, settings, &scene, &map, &set, &camera, [4, 4]);
        let albedo = gnomon_brdf::dfg(1.0, roughness).element_sum();
        let seen = frame.radiance.get(2, 2).x;
        assert!(
            (seen - albedo).abs() < 2.0 * tolerances::FURNACE as f32,
            "roughness {roughness}: {seen}, {albedo}"
        );
    }
}

#[test]
fn the_background_is_the_environment() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map =
        Equirect::new(RgbImage::from_fn(32, 16, |x, y| Vec3::new(x as f32, y as f32, (x * y % 7) as f32)));
    let set = LightSet::new("test", Vec::new(), map.clone());
    let settings = RenderSettings::default().with(|s| s.techniques.supersample = 1);
    for target in [Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::new(0.1, 0.9, 0.2), Vec3::new(-0.3, -0.9, 0.1)] {
        let camera = Camera::look_at(Vec3::ZERO, target, 80_f32.to_radians());
        let frame = render(&gpu, settings.clone(), &Scene::default(), &map, &set, &camera, [33, 21]);
        for (x, y) in [(0, 0), (16, 10), (32, 20), (5, 17)] {
            let across = 40_f32.to_radians().tan();
            let screen = Vec2::new((x as f32 + 0.5) / 33.0 * 2.0 - 1.0, 1.0 - (y as f32 + 0.5) / 21.0 * 2.0);
            let ray = Vec3::new(screen.x * across, screen.y * across * 21.0 / 33.0, -1.0);
            let direction = camera.world_from_camera.transform_vector3(ray).normalize();
            let difference = (frame.radiance.get(x, y) - map.lookup(direction)).abs().max_element();
            assert!(difference < 0.02, "{target} ({x}, {y}): {difference}");
        }
    }
}

/// Visibility along x, from -0.5 to 0.5, on the ground under an occluder over x < `edge` at `height` and a disk light straight
/// above.
fn penumbra_profile(
    gpu: &gnomon_renderer::Gpu,
    shadows: &str,
    edge: f32,
    height: f32,
    angular_radius: f32,
) -> Vec<f32> {
    let half = 2.0;
    let scene = scene_of(
        vec![
            horizontal(Vec2::splat(-half), Vec2::splat(half), 0.0),
            horizontal(Vec2::splat(-half), Vec2::new(edge, half), height),
        ],
        material(Surface { base_color: Vec3::ONE, ..Default::default() }),
    );
    let set = one_disk(Vec3::Y, angular_radius);
    // From below the occluder.
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.5 },
        ..Camera::look_at(Vec3::new(0.0, 0.5 * height, 0.0), Vec3::ZERO, 1.0)
    };
    let settings = RenderSettings::default().with(|s| {
        s.techniques.shadows = shadows.to_owned();
        s.techniques.compositing = "additive".to_owned();
        s.techniques.shadow_resolution = 512;
        s.techniques.supersample = 1;
    });
    let frame = render(gpu, settings, &scene, &no_light(), &set, &camera, [400, 5]);
    let sine = angular_radius.sin();
    // Irradiance pi sin^2 r over a white Lambert surface reflects sin^2 r.
    // Looking down, the camera has world -x to its right.
    (0..400).rev().map(|x| frame.radiance.get(x, 2).x / (sine * sine)).collect()
}

#[test]
fn convolution_shadows_give_the_closed_form_penumbra() {
    let Some(gpu) = gpu_or_skip() else { return };
    for (height, degrees) in [(1.0, 5.0), (1.0, 10.0), (0.6, 10.0)] {
        let radius = f32::to_radians(degrees);
        let expected = 2.0 * height * radius.tan();
        // Where the edge falls among the texels of a coarse level changes the width a little: several places.
        let widths: Vec<f32> = [0.0, 0.013, 0.03, 0.057, 0.09]
            .into_iter()
            .map(|edge| {
                let profile = penumbra_profile(&gpu, "convolution", edge, height, radius);
                assert!(profile[2] < 0.02, "umbra {}", profile[2]);
                assert!((profile[397] - 1.0).abs() < 0.01, "full light {}", profile[397]);
                penumbra::disk_penumbra_width(&profile).unwrap() / 400.0
            })
            .collect();
        let mean = widths.iter().sum::<f32>() / widths.len() as f32;
        println!("height {height} radius {degrees}: penumbrae {widths:.4?}, closed form {expected:.4}");
        assert!((mean / expected - 1.0).abs() <= tolerances::PENUMBRA_WIDTH, "{mean} against {expected}");
    }
}

#[test]
fn a_hard_shadow_fails_the_penumbra_check() {
    let Some(gpu) = gpu_or_skip() else { return };
    let profile = penumbra_profile(&gpu, "hard", 0.03, 1.0, 5_f32.to_radians());
    let width = penumbra::disk_penumbra_width(&profile).unwrap() / 400.0;
    assert!((width / (2.0 * 5_f32.to_radians().tan()) - 1.0).abs() > tolerances::PENUMBRA_WIDTH, "{width}");
}

#[test]
fn moved_instances_draw_as_a_new_scene_does() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut scene =
        scene_of(vec![sphere(), horizontal(Vec2::splat(-3.0), Vec2::splat(3.0), -1.0)], Material::default());
    let map = constant_map(Vec3::ONE);
    let set = one_disk(Vec3::new(0.3, 0.9, 0.1).normalize(), 0.1);
    let camera = Camera::look_at(Vec3::new(2.0, 3.0, 5.0), Vec3::ZERO, 0.8);
    let mut renderer = gnomon_renderer::Renderer::new(&gpu, RenderSettings::default()).unwrap();
    renderer.set_scene(&scene).unwrap();
    renderer.set_lighting(&map, &set).unwrap();
    let before = renderer.render(&camera, 32, 24).unwrap().radiance;
    scene.nodes[0].parent_from_node = glam::Affine3A::from_translation(Vec3::new(1.0, 0.5, 0.0));
    renderer.move_scene(&scene).unwrap();
    let moved = renderer.render(&camera, 32, 24).unwrap().radiance;
    let fresh = render(&gpu, RenderSettings::default(), &scene, &map, &set, &camera, [32, 24]).radiance;
    assert_ne!(moved, before);
    assert_eq!(moved, fresh);
}

#[test]
fn nothing_to_draw_and_wrong_settings_are_defined() {
    let Some(gpu) = gpu_or_skip() else { return };
    let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, 1.0);
    let black = LightSet::new("test", Vec::new(), no_light());
    let frame =
        render(&gpu, RenderSettings::default(), &Scene::default(), &no_light(), &black, &camera, [8, 8]);
    assert!(frame.radiance.texels().iter().all(|texel| *texel == Vec3::ZERO));

    let wrong = |change: &dyn Fn(&mut RenderSettings)| {
        let mut settings = RenderSettings::default();
        change(&mut settings);
        gnomon_renderer::Renderer::new(&gpu, settings).err().map(|error| error.to_string())
    };
    let names = shadow::names().map(|(name, _)| name).collect::<Vec<_>>().join(", ");
    assert!(wrong(&|s| s.techniques.shadows = "moonlight".to_owned()).unwrap().contains(&names));
    assert!(wrong(&|s| s.techniques.compositing = "xor".to_owned()).unwrap().contains("additive"));
    assert!(wrong(&|s| s.techniques.shadow_resolution = 100).unwrap().contains("power of two"));
    assert!(wrong(&|s| s.techniques.supersample = 0).unwrap().contains("1 to 8"));
    assert!(wrong(&|s| s.display.exposure = Some(f32::NAN)).is_some());
    let mut renderer = gnomon_renderer::Renderer::new(&gpu, RenderSettings::default()).unwrap();
    assert!(renderer.render(&camera, 8, 8).is_err(), "no lighting was set");
    renderer.set_lighting(&no_light(), &black).unwrap();
    assert!(renderer.render(&camera, 0, 8).is_err());
    assert!(renderer.render(&camera, 8, 1 << 20).is_err());
}

#[test]
fn nothing_between_the_models_and_the_light_is_shadowed() {
    let Some(gpu) = gpu_or_skip() else { return };
    // A wall whose shadow falls to -x; the ground on the other side lies between the light and the wall, in part in front of the
    // map's near plane. Half a metre at the wall's foot is left out.
    let wall = |x: f32| Mesh {
        positions: vec![
            Vec3::new(x, 0.0, -0.5),
            Vec3::new(x, 0.0, 0.5),
            Vec3::new(x, 1.0, 0.5),
            Vec3::new(x, 1.0, -0.5),
        ],
        normals: vec![Vec3::X; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    };
    let ground = horizontal(Vec2::splat(-4.0), Vec2::splat(4.0), 0.0);
    let scene = scene_of(vec![ground, wall(0.0), wall(-0.1)], edge::white());
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 1.75 },
        ..Camera::look_at(Vec3::new(2.25, 3.0, 1e-3), Vec3::new(2.25, 0.0, 0.0), 1.0)
    };
    for (elevation, turn) in [(10.0_f32, 30.0_f32), (35.0, 0.0)] {
        let (sin, cos) = elevation.to_radians().sin_cos();
        let (side, ahead) = turn.to_radians().sin_cos();
        let set = one_disk(Vec3::new(cos * ahead, sin, cos * side), 0.1);
        let picture = |shadows: &str| {
            let settings = edge::settings(shadows).with(|s| s.techniques.shadow_sampling = 1);
            render(&gpu, settings, &scene, &no_light(), &set, &camera, [96, 96]).radiance
        };
        let unshadowed = picture("none");
        // A kernel of fixed size meets the ground itself where light only grazes it.
        for (technique, _) in shadow::names().filter(|(name, _)| *name != "pcf" || elevation > 15.0) {
            let shadowed = picture(technique);
            let least = (shadowed.texels().iter().zip(unshadowed.texels()))
                .map(|(shadowed, unshadowed)| shadowed.x / unshadowed.x)
                .fold(f32::INFINITY, f32::min);
            let lost = if technique == "convolution" { tolerances::SERIES_RIPPLE } else { tolerances::UMBRA };
            assert!(least >= 1.0 - lost, "{technique}, {elevation}, {turn}: {least}");
        }
    }
}

#[test]
fn a_shadow_of_what_stands_near_the_horizon_costs_little_of_a_low_light() {
    let Some(gpu) = gpu_or_skip() else { return };
    // On the cube face of +x the light reaches from the horizon up to 0.9, and a wall blocks what is below its middle.
    let (wall_distance, wall_height) = (3.0, 1.35);
    let quad_at = |x: f32, first: u32| {
        let corner = |y, z| Vec3::new(x, y, z);
        let corners =
            [corner(0.0, -4.0), corner(0.0, 4.0), corner(wall_height, 4.0), corner(wall_height, -4.0)];
        (corners, [[first, first + 1, first + 2], [first, first + 2, first + 3]])
    };
    let (front, back) = (quad_at(wall_distance, 0), quad_at(wall_distance + 0.2, 4));
    let wall = Mesh {
        positions: [front.0, back.0].concat(),
        normals: vec![Vec3::NEG_X; 8],
        triangles: [front.1, back.1].concat(),
        ..Default::default()
    };
    let ground = horizontal(Vec2::splat(-5.0), Vec2::splat(5.0), 0.0);
    let scene =
        scene_of(vec![ground, wall], material(Surface { base_color: Vec3::ONE, ..Default::default() }));
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.02 },
        ..Camera::look_at(Vec3::new(0.0, 1.0, 0.0), Vec3::ZERO, 1.0)
    };
    let above = |from: f64| {
        let axes = [DVec3::Z, DVec3::Y, DVec3::X];
        DistantLight::rectangle(axes, DVec2::new(-0.4, from), DVec2::new(0.4, 0.9), DVec3::ONE)
    };
    let light = above(0.0);
    let form_factor = |light: &DistantLight| {
        let LightShape::Rectangle { corners } = light.shape else { panic!("not a rectangle") };
        rectangle_form_factor(Vec3::Y, corners)
    };
    let expected = form_factor(&above(f64::from(wall_height / wall_distance))) / form_factor(&light);
    let set = LightSet::new("test", vec![light], no_light());
    let visible = |shadows: &str| {
        let picture = |shadows: &str| {
            let settings = RenderSettings::default().with(|s| {
                s.techniques.shadows = shadows.to_owned();
                s.techniques.compositing = "additive".to_owned();
            });
            render(&gpu, settings, &scene, &no_light(), &set, &camera, [3, 3]).radiance.get(1, 1).x
        };
        picture(shadows) / picture("none")
    };
    for shadows in ["pcss", "convolution", "moments"] {
        let found = visible(shadows);
        println!("{shadows}: {found}, closed form {expected}");
        assert!(
            (found - expected).abs() <= tolerances::LOW_LIGHT_VISIBILITY,
            "{shadows}: {found}, {expected}"
        );
    }
}

/// An edge that crosses one column of pixels over the picture's height. On a rotated grid of 2 x 2 samples it comes in four steps,
/// on 4 x 4 in eight: in rows and columns these would be two and four, and twice the error.
#[test]
fn an_almost_upright_edge_has_as_many_steps_as_samples_allow() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = constant_map(Vec3::ONE);
    let set = fitted(&map);
    const SIZE: u32 = 64;
    let pixel = 2.0 / SIZE as f32;
    let corners = [(-9.0, -1.0), (0.0, -1.0), (pixel, 1.0), (-9.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
    let black = Surface { base_color: Vec3::ZERO, ..Default::default() };
    let edge = Mesh {
        positions: corners.to_vec(),
        normals: vec![Vec3::Z; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let scene = scene_of(vec![edge], material(black));
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 2.0 * 0.25_f32.atan());
    for (samples, steps) in [(1, 1), (2, 4), (3, 3), (4, 8)] {
        let settings = RenderSettings::default().with(|s| {
            s.techniques.supersample = samples;
            s.techniques.shadows = "none".to_owned();
        });
        let frame = render(&gpu, settings, &scene, &map, &set, &camera, [SIZE, SIZE]);
        let worst = (0..SIZE)
            .map(|row| {
                let open = (row as f32 + 0.5) / SIZE as f32;
                (frame.radiance.get(SIZE / 2, row).x - open).abs()
            })
            .fold(0.0, f32::max);
        let expected = 0.5 / steps as f32;
        println!("{samples} x {samples}: off by {worst}");
        // A row is not one height.
        assert!((worst - expected).abs() < 1.0 / SIZE as f32, "{samples}: {worst} against {expected}");
    }
}

/// Light below a surface does not shine on it, wherever its shading normals look: normal maps tilt them far.
#[test]
fn a_surface_hides_light_below_it_from_its_own_shading_normals() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut tilted = horizontal(Vec2::splat(-1.0), Vec2::splat(1.0), 0.0);
    tilted.normals.fill(Vec3::new(60_f32.to_radians().sin(), 0.5, 0.0));
    let scene = scene_of(vec![tilted], material(Surface { base_color: Vec3::ONE, ..Default::default() }));
    let camera = Camera::look_at(Vec3::new(0.0, 3.0, 0.01), Vec3::ZERO, 30_f32.to_radians());
    let lit = |shadows: &str, elevation: f32| {
        let towards = Vec3::new(elevation.to_radians().cos(), elevation.to_radians().sin(), 0.0);
        let settings = RenderSettings::default().with(|s| {
            s.techniques.shadows = shadows.to_owned();
            s.techniques.compositing = "additive".to_owned();
            s.display.background = gnomon_renderer::Background::None;
        });
        let set = one_disk(towards, 5_f32.to_radians());
        render(&gpu, settings, &scene, &no_light(), &set, &camera, [8, 8]).radiance.get(4, 4).x
    };
    for shadows in ["pcss", "convolution"] {
        let [below, above] = [-15.0, 15.0].map(|elevation| lit(shadows, elevation) / lit("none", elevation));
        println!("{shadows}: {below:.3} from below, {above:.3} from above");
        assert!(below <= tolerances::LIGHT_LEAK && above >= 1.0 - tolerances::LIGHT_LEAK, "{shadows}");
    }
}

/// A tower far away fills much of the cone towards the light, but a low wall hides all of it: the penumbra is not the tower's.
#[test]
fn a_low_wall_hides_a_wide_light_in_front_of_a_tower() {
    let Some(gpu) = gpu_or_skip() else { return };
    let ground = horizontal(Vec2::new(-8.0, -4.0), Vec2::new(4.0, 4.0), 0.0);
    let upright = |x: f32, height: f32, [from, to]: [f32; 2]| {
        let mut wall = horizontal(Vec2::new(0.0, from), Vec2::new(height, to), 0.0);
        wall.positions.iter_mut().for_each(|p| *p = Vec3::new(x, p.x, p.z));
        wall.normals.fill(Vec3::X);
        wall
    };
    let scene =
        scene_of(vec![ground, upright(0.0, 1.0, [-2.0, 2.0]), upright(-6.0, 8.0, [0.1, 3.0])], edge::white());
    let (sin, cos) = 30_f32.to_radians().sin_cos();
    let set = one_disk(Vec3::new(-cos, sin, 0.0), 15_f32.to_radians());
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.15 },
        ..Camera::look_at(Vec3::new(0.25, 0.9, 0.0), Vec3::new(0.25, 0.0, 0.001), 1.0)
    };
    let row = |shadows: &str| -> Vec<f32> {
        let frame = render(&gpu, edge::settings(shadows), &scene, &no_light(), &set, &camera, [32, 32]);
        (0..32).map(|x| frame.radiance.get(x, 16).x).collect()
    };
    let (found, open) = (row("pcss"), row("none"));
    let leak = found.iter().zip(&open).map(|(found, open)| found / open).fold(0.0, f32::max);
    println!("{leak:.4} of the light");
    assert!(leak <= tolerances::LIGHT_LEAK, "{leak} in {found:?}");
}

/// Sharp lights have maps of their own for what is near.
#[test]
fn the_shadow_of_a_small_thing_is_the_same_in_a_large_scene() {
    let Some(gpu) = gpu_or_skip() else { return };
    let set = one_disk(Vec3::new(0.3, 0.9, 0.2).normalize(), 0.25_f32.to_radians());
    let camera = Camera::look_at(Vec3::new(0.0, 3.0, 4.0), Vec3::ZERO, 40_f32.to_radians());
    let settings = RenderSettings::default().with(|s| s.techniques.compositing = "additive".to_owned());
    let picture = |size: f32| {
        let ground = horizontal(Vec2::splat(-size), Vec2::splat(size), 0.0);
        let plate = horizontal(Vec2::splat(-0.25), Vec2::splat(0.25), 0.5);
        // Behind the camera.
        let far = horizontal(Vec2::new(-size, 0.9 * size), Vec2::splat(size), 0.5 * size);
        let scene = scene_of(vec![ground, plate, far], edge::white());
        render(&gpu, settings.clone(), &scene, &no_light(), &set, &camera, [160, 120]).radiance
    };
    let difference = compare(&picture(1000.0), &picture(10.0), None).unwrap().relative_rmse;
    println!("off by {difference:.4}");
    assert!(difference <= tolerances::LARGE_SCENE, "{difference}");
}

#[test]
fn a_wall_that_stands_on_a_ground_is_lit_down_to_its_foot() {
    let Some(gpu) = gpu_or_skip() else { return };
    let ground = horizontal(Vec2::splat(-3.0), Vec2::splat(3.0), 0.0);
    let upright = |p: Vec3| Vec3::new(p.x, 0.5 * (1.0 - p.z), 0.0);
    let mut wall = horizontal(Vec2::splat(-1.0), Vec2::splat(1.0), 0.0);
    wall.positions.iter_mut().for_each(|p| *p = upright(*p));
    wall.normals.fill(Vec3::Z);
    let scene = scene_of(vec![ground, wall], edge::white());
    let set = one_disk(Vec3::new(0.3, 0.6, 0.74).normalize(), 0.2);
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.1 },
        ..Camera::look_at(Vec3::new(0.0, 0.1, 4.0), Vec3::new(0.0, 0.1, 0.0), 1.0)
    };
    for shadows in ["hard", "pcf", "pcss", "moments"] {
        let frame = render(&gpu, edge::settings(shadows), &scene, &no_light(), &set, &camera, [64, 64]);
        // From a millimetre and a half above the foot upwards.
        let column: Vec<f32> = (0..64).rev().map(|y| frame.radiance.get(32, y).x).collect();
        let darkest = column.iter().copied().fold(f32::INFINITY, f32::min);
        let lit = column[60];
        println!("{shadows}: {}", darkest / lit);
        assert!(darkest > (1.0 - tolerances::UMBRA) * lit, "{shadows}: {darkest} instead of {lit}");
    }
}
