//! A ground that is only seen by the shadows on it, against the ray tracer's.

use crate::common::*;
use glam::{Affine3A, Vec2, Vec3};
use gnomon_lights::FitOptions;
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_reference::{ReferenceOptions, render_with_alpha};
use gnomon_renderer::{Background, RenderSettings, Renderer};
use gnomon_scene::{AreaLight, AreaLightShape, Camera, Ground, Material, Node, NodeId, builtin};
use gnomon_testing::tolerances;

const SIZE: [u32; 2] = [96, 72];

fn renderer(gpu: &gnomon_renderer::Gpu, background: Background, map: &gnomon_envmap::Equirect) -> Renderer {
    let settings = RenderSettings::default().with(|s| s.display.background = background);
    let mut renderer = Renderer::new(gpu, settings).unwrap();
    let options = FitOptions { light_count: Some(24), ..FitOptions::default() };
    let set = gnomon_lights::fit::by_name("optimized", &options).unwrap().fit(map).unwrap();
    renderer.set_lighting(map, &set).unwrap();
    renderer
}

#[test]
fn a_catcher_without_shadows_is_not_seen() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = gnomon_envmap::builtin::sized("sky", 128, 64).unwrap();
    let mut renderer = renderer(&gpu, Background::Environment, &map);
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO, 0.9);
    let empty = renderer.render(&camera, SIZE[0], SIZE[1]).unwrap();
    assert!(empty.alpha.iter().all(|alpha| *alpha == 0.0));
    let material = Material { catches: true, ..Material::default() };
    renderer.set_scene(&scene_of(vec![horizontal(Vec2::NEG_ONE, Vec2::ONE, 0.0)], material)).unwrap();
    let caught = renderer.render(&camera, SIZE[0], SIZE[1]).unwrap();
    let error = compare(&caught.radiance, &empty.radiance, None).unwrap().relative_rmse;
    let most = caught.alpha.iter().copied().fold(0.0, f32::max);
    println!("without shadows: {error:.1e}, alpha at most {most:.1e}");
    assert!(error < 2e-3 && most < 4e-3, "{error} {most}");
}

#[test]
fn a_catcher_is_as_dark_as_ray_traced() {
    is_as_ray_traced(Ground::Catcher);
}

#[test]
fn a_ground_fades_as_ray_traced() {
    is_as_ray_traced(Ground::Fade);
}

#[test]
fn a_ground_is_projected_as_ray_traced() {
    is_as_ray_traced(Ground::Projected);
}

/// Before the environment, and laid over it by its alpha. `GNOMON_PICTURES=folder` keeps the pictures.
fn is_as_ray_traced(ground: Ground) {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut scene = match ground {
        Ground::Catcher => builtin::by_name("three-boxes").unwrap(),
        _ => builtin::without_ground("three-boxes").unwrap(),
    };
    scene.add_ground(ground);
    if ground == Ground::Fade {
        // Its light ends with the ground.
        let direction = Affine3A::from_rotation_x(-0.9);
        scene.nodes.push(Node { parent_from_node: direction, ..Node::default() });
        scene.lights.push(AreaLight {
            node: NodeId(scene.nodes.len() - 1),
            shape: AreaLightShape::Sun { angular_radius: 0.1 },
            radiance: Vec3::new(9.0, 12.0, 18.0),
            spread: Default::default(),
        });
    }
    let camera = &scene.cameras[0];
    let map = gnomon_envmap::builtin::sized("sky", 256, 128).unwrap();
    let options =
        ReferenceOptions { width: SIZE[0], height: SIZE[1], samples_per_pixel: 256, ..Default::default() };
    let truth = gnomon_reference::render(&scene, camera, &map, &options).unwrap().mean;
    let (traced, true_alpha) = render_with_alpha(&scene, camera, &map, &options).unwrap();

    let mut over_map = renderer(&gpu, Background::Environment, &map);
    let behind = over_map.render(camera, SIZE[0], SIZE[1]).unwrap().radiance;
    over_map.set_scene(&scene).unwrap();
    let drawn = over_map.render(camera, SIZE[0], SIZE[1]).unwrap().radiance;
    let mut alone = renderer(&gpu, Background::Transparent, &map);
    alone.set_scene(&scene).unwrap();
    let frame = alone.render(camera, SIZE[0], SIZE[1]).unwrap();
    // One alpha has no colour, the shadow of a blue sky has: laid over the map both lose it alike.
    let over = |picture: &RgbImage, alpha: &[f32]| {
        RgbImage::from_fn(SIZE[0], SIZE[1], |x, y| {
            let alpha = alpha[(y * SIZE[0] + x) as usize];
            picture.get(x, y) + (1.0 - alpha) * behind.get(x, y)
        })
    };
    let composite = over(&frame.radiance, &frame.alpha);
    let true_composite = over(&traced.mean, &true_alpha);
    if let Some(folder) = std::env::var_os("GNOMON_PICTURES") {
        let folder = std::path::Path::new(&folder);
        for (what, picture) in [("drawn", &drawn), ("composite", &composite), ("truth", &truth)] {
            gnomon_picture::write(folder.join(format!("{ground:?}_{what}.png")), picture).unwrap();
        }
    }
    let error = |picture: &RgbImage| compare(picture, &truth, None).unwrap().relative_rmse;
    let drawn = error(&drawn);
    let composite = compare(&composite, &true_composite, None).unwrap().relative_rmse;
    let pairs = frame.alpha.iter().zip(&true_alpha);
    let square: f64 = pairs.map(|(a, b)| f64::from((a - b) * (a - b))).sum();
    let alpha = (square / frame.alpha.len() as f64).sqrt();
    println!("{ground:?}: over the map {drawn:.4}, by alpha {composite:.4}, alpha itself {alpha:.4}");
    assert!(drawn < tolerances::CATCHER_RELATIVE_RMSE, "{drawn}");
    assert!(composite < tolerances::CATCHER_RELATIVE_RMSE, "{composite}");
    assert!(alpha < tolerances::CATCHER_RELATIVE_RMSE, "{alpha}");
    // Of what is projected the alpha knows nothing: it is a picture of the map itself that is another.
    if ground == Ground::Projected {
        assert!(error(&behind) > 3.0 * drawn);
        return;
    }
    // It is seen, and hides nothing where no shadow falls.
    assert!(error(&behind) > 3.0 * drawn);
    assert!(frame.alpha.iter().any(|alpha| (0.2..0.9).contains(alpha)));
}
