//! A ground that is only seen by the shadows on it, against the ray tracer's.

use crate::common::*;
use glam::{Affine3A, Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::FitOptions;
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_reference::{ReferenceOptions, render_with_alpha};
use gnomon_renderer::{Background, RenderSettings, Renderer};
use gnomon_scene::{AreaLight, AreaLightShape, Camera, Ground, Material, Node, NodeId, builtin};
use gnomon_testing::tolerances;

const SIZE: [u32; 2] = [96, 72];

fn renderer(gpu: &gnomon_renderer::Gpu, background: Background, map: &Equirect) -> Renderer {
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

/// The map goes on where a matt ground ends, as a photograph of the ground does: what lies on the ground and on the catcher is one picture. The truth
/// knows no catcher: it is the models without a ground, and the ground with black models on it. One alpha has no colour; under grey light the
/// shadow has none either.
#[test]
fn a_composite_is_what_a_ground_that_goes_on_in_the_map_shows() {
    let Some(gpu) = gpu_or_skip() else { return };
    for (name, is_grey) in [("sky", false), ("room", true)] {
        let on_ground = builtin::by_name("three-boxes").unwrap();
        let map = continued(&gnomon_envmap::builtin::sized(name, 256, 128).unwrap(), is_grey);
        let camera = &on_ground.cameras[0];
        let options = ReferenceOptions {
            width: SIZE[0],
            height: SIZE[1],
            samples_per_pixel: 256,
            ..Default::default()
        };
        let mut black = on_ground.clone();
        let ground =
            black.instances().iter().map(|i| i.mesh).min_by_key(|m| black.meshes[m.0].triangles.len());
        for (index, mesh) in black.meshes.iter_mut().enumerate() {
            if Some(index) != ground.map(|mesh| mesh.0) {
                std::sync::Arc::make_mut(mesh).material =
                    Some(gnomon_scene::MaterialId(black.materials.len()));
            }
        }
        black.materials.push(Material {
            surface: gnomon_brdf::Surface { base_color: Vec3::ZERO, ..gnomon_brdf::Surface::default() },
            ..Material::default()
        });
        let floor = gnomon_reference::render(&black, camera, &map, &options).unwrap().mean;
        let free = builtin::without_ground("three-boxes").unwrap();
        let (models, _) = render_with_alpha(&free, camera, &map, &options).unwrap();
        let truth = RgbImage::from_fn(SIZE[0], SIZE[1], |x, y| floor.get(x, y) + models.mean.get(x, y));

        let mut caught = on_ground.clone();
        caught.add_ground(Ground::Catcher);
        let mut over_map = renderer(&gpu, Background::Environment, &map);
        let plate = over_map.render(camera, SIZE[0], SIZE[1]).unwrap().radiance;
        over_map.set_scene(&caught).unwrap();
        let drawn = over_map.render(camera, SIZE[0], SIZE[1]).unwrap().radiance;
        let mut alone = renderer(&gpu, Background::Transparent, &map);
        alone.set_scene(&caught).unwrap();
        let frame = alone.render(camera, SIZE[0], SIZE[1]).unwrap();
        let composite = over(&frame.radiance, &frame.alpha, &plate);
        let error = |picture: &RgbImage| compare(picture, &truth, None).unwrap().relative_rmse;
        let [drawn, composite, plate] = [&drawn, &composite, &plate].map(error);
        println!("{name}: over the map {drawn:.4}, by alpha {composite:.4}, the map alone {plate:.4}");
        assert!(drawn < tolerances::CATCHER_RELATIVE_RMSE, "{name}: {drawn}");
        assert!(!is_grey || composite < tolerances::CATCHER_RELATIVE_RMSE, "{name}: {composite}");
        assert!(plate > 5.0 * drawn, "{name}: there is nothing to be seen");
    }
}

/// A map below whose horizon is what a matt ground of the built-in scenes reflects without a shadow.
fn continued(map: &Equirect, is_grey: bool) -> Equirect {
    let grey = |c: Vec3| if is_grey { Vec3::splat(c.dot(gnomon_picture::LUMINANCE)) } else { c };
    let (width, height) = (map.width(), map.height());
    let above = RgbImage::from_fn(width, height, |x, y| {
        if y < height / 2 { grey(map.radiance().get(x, y)) } else { Vec3::ZERO }
    });
    let flux = |y: u32| {
        let cosine = |v: u32| (std::f32::consts::PI * v as f32 / height as f32).cos();
        // Of the projected solid angle of a row.
        std::f32::consts::PI * (cosine(y) * cosine(y) - cosine(y + 1) * cosine(y + 1)) / width as f32
    };
    let rows = (0..height / 2).map(|y| (0..width).map(|x| above.get(x, y)).sum::<Vec3>() * flux(y));
    let ground = 0.5 * rows.sum::<Vec3>() / std::f32::consts::PI;
    Equirect::new(RgbImage::from_fn(
        width,
        height,
        |x, y| {
            if y < height / 2 { above.get(x, y) } else { ground }
        },
    ))
}

/// A premultiplied picture over another.
fn over(picture: &RgbImage, alpha: &[f32], behind: &RgbImage) -> RgbImage {
    RgbImage::from_fn(SIZE[0], SIZE[1], |x, y| {
        let alpha = alpha[(y * SIZE[0] + x) as usize];
        picture.get(x, y) + (1.0 - alpha) * behind.get(x, y)
    })
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
    let composite = over(&frame.radiance, &frame.alpha, &behind);
    let true_composite = over(&traced.mean, &true_alpha, &behind);
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
