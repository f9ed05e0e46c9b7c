//! What the reference promises beside the right answer: determinism, honest variance, both sides, holes, errors.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use glam::{Affine3A, Mat4, Vec3, Vec4};
use gnomon_brdf::Surface;
use gnomon_envmap::Equirect;
use gnomon_metrics::z_test;
use gnomon_picture::RgbImage;
use gnomon_reference::{Estimate, ReferenceError, ReferenceOptions, render};
use gnomon_scene::{AlphaMode, Camera, Scene};
use support::{constant_environment, downward_strip, floor, lambert, scene, sphere};

fn options(samples_per_pixel: u32) -> ReferenceOptions<'static> {
    ReferenceOptions { width: 32, height: 24, samples_per_pixel, seed: 1, ..ReferenceOptions::default() }
}

/// A sphere on a floor: glossy, matte, in shadow and in the light of a small bright window.
fn still_life() -> (Scene, Camera, Equirect) {
    let glossy = Surface { specular: 1.0, roughness: 0.4, ..lambert(0.6) };
    let mut scene = scene(vec![(floor(4.0, -1.0), lambert(0.5)), (sphere(24, 48), glossy)]);
    scene.materials[1].emissive = Vec3::new(0.0, 0.0, 0.02);
    let camera = Camera::look_at(Vec3::new(2.0, 1.5, 4.0), Vec3::ZERO, 0.9);
    let map = Equirect::new(RgbImage::from_fn(64, 32, |x, y| {
        if (20..24).contains(&x) && (6..9).contains(&y) {
            Vec3::new(40.0, 30.0, 20.0)
        } else {
            Vec3::splat(0.3)
        }
    }));
    (scene, camera, map)
}

fn on_threads(count: usize, work: impl FnOnce() -> Estimate + Send) -> Estimate {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap().install(work)
}

#[test]
fn the_seed_and_not_the_threads_decide() {
    let (scene, camera, map) = still_life();
    let picture = |seed| render(&scene, &camera, &map, &ReferenceOptions { seed, ..options(40) }).unwrap();
    let one = on_threads(1, || picture(3));
    assert_eq!(one, on_threads(3, || picture(3)));
    assert_ne!(one, picture(4));
    assert_eq!(one.samples_per_pixel, 64);
}

/// A pixel is that of the other picture, or else black.
#[test]
fn the_background_can_be_left_out() {
    let (scene, camera, map) = still_life();
    let with = |background| {
        let options = ReferenceOptions { background, ..options(2) };
        render(&scene, &camera, &map, &options).unwrap().mean
    };
    let (seen, hidden) = (with(true), with(false));
    assert_eq!(hidden.get(0, 0), Vec3::ZERO, "above the floor there is nothing");
    assert_eq!(hidden.get(16, 12), seen.get(16, 12), "the sphere is lit as ever");
    assert!(seen.get(0, 0).min_element() > 0.1);
}

/// Two seeds differ by as much as their variances say: z^2 averages 1, or 31/29 as 32 batches estimate each variance.
#[test]
fn the_variance_is_honest() {
    let (scene, _, map) = still_life();
    // No background in the picture: it has no noise.
    let camera = Camera::look_at(Vec3::new(1.0, 3.0, 2.0), Vec3::new(0.0, -0.5, 0.0), 0.7);
    let [a, b] =
        [1, 2].map(|seed| render(&scene, &camera, &map, &ReferenceOptions { seed, ..options(128) }).unwrap());
    let z = z_test((&a.mean, &a.variance), (&b.mean, &b.variance), 4.0).unwrap();
    assert!((0.85..1.25).contains(&z.mean_square) && z.passing > 0.99, "{z:?}");
    // Planted fault: a variance a quarter of its size is seen.
    let small = |image: &RgbImage| RgbImage::from_fn(32, 24, |x, y| 0.25 * image.get(x, y));
    let z = z_test((&a.mean, &small(&a.variance)), (&b.mean, &small(&b.variance)), 4.0).unwrap();
    assert!(z.mean_square > 3.0, "{z:?}");
}

/// Everything scales by a power of two, and so do all roundings: a length fixed in metres anywhere would show.
#[test]
fn size_does_not_matter() {
    let (scene, camera, map) = still_life();
    let expected = render(&scene, &camera, &map, &options(32)).unwrap();
    for scale in [1.0 / 1024.0, 1024.0] {
        let mut scaled = scene.clone();
        for node in &mut scaled.nodes {
            node.parent_from_node = Affine3A::from_scale(Vec3::splat(scale)) * node.parent_from_node;
        }
        let mut world_from_camera = camera.world_from_camera;
        world_from_camera.w_axis = (camera.eye() * scale).extend(1.0);
        let view = Camera { world_from_camera, ..camera.clone() };
        let found = render(&scaled, &view, &map, &options(32)).unwrap();
        let different =
            found.mean.texels().iter().zip(expected.mean.texels()).filter(|(a, b)| a != b).count();
        assert!(different < 8, "{different} pixels change at scale {scale}");
    }
}

/// Neither winding, nor a mirroring transform, nor the side of the normals changes what is seen.
#[test]
fn both_sides_are_alike() {
    let map = constant_environment(Vec3::ONE);
    let camera = Camera::look_at(Vec3::new(0.3, 0.2, 3.0), Vec3::ZERO, 0.8);
    let ball = scene(vec![(sphere(16, 32), lambert(0.5))]);
    let expected = render(&ball, &camera, &map, &options(16)).unwrap();
    let mut turned = ball.clone();
    for triangle in &mut Arc::make_mut(&mut turned.meshes[0]).triangles {
        triangle.swap(0, 1);
    }
    let mut inside_out = ball.clone();
    for normal in &mut Arc::make_mut(&mut inside_out.meshes[0]).normals {
        *normal = -*normal;
    }
    for changed in [turned, inside_out] {
        let found = render(&changed, &camera, &map, &options(16)).unwrap();
        let z = z_test((&found.mean, &found.variance), (&expected.mean, &expected.variance), 4.0).unwrap();
        assert!(z.passing > 0.99, "{z:?}");
        let mean = |e: &Estimate| e.mean.texels().iter().map(|t| t.x).sum::<f32>() / 768.0;
        assert!((mean(&found) - mean(&expected)).abs() < 2e-3);
    }
    // A floor seen from below is lit from below.
    let sheet = scene(vec![(floor(5.0, 0.0), lambert(0.5))]);
    let below = Camera {
        world_from_camera: Mat4::from_rotation_x(std::f32::consts::PI)
            * downward_strip(1.0, 1.0).world_from_camera,
        ..downward_strip(1.0, 1.0)
    };
    let found = render(&sheet, &below, &map, &options(64)).unwrap();
    assert!((found.mean.get(16, 12).x - 0.5).abs() < 0.1);
}

#[test]
fn holes_let_camera_and_shadow_rays_pass() {
    let (mut plain, camera, map) = still_life();
    let expected = render(&plain, &camera, &map, &options(16)).unwrap();
    // A sheet over everything, all of it hole.
    let mut sheet = scene(vec![(floor(50.0, 1.2), lambert(0.5))]);
    Arc::make_mut(&mut sheet.meshes[0]).colors = vec![Vec4::new(1.0, 1.0, 1.0, 0.2); 4];
    let mut material = sheet.materials.remove(0);
    material.alpha = 1.0;
    material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    let mut mesh = sheet.meshes.remove(0);
    Arc::make_mut(&mut mesh).material = Some(gnomon_scene::MaterialId(plain.materials.len()));
    plain.materials.push(material);
    plain.nodes.push(support::node(gnomon_scene::MeshId(plain.meshes.len()), Affine3A::IDENTITY));
    plain.meshes.push(mesh);
    assert_eq!(render(&plain, &camera, &map, &options(16)).unwrap(), expected);
    // Without the holes it is another picture.
    Arc::make_mut(&mut plain.meshes[2]).colors.clear();
    assert_ne!(render(&plain, &camera, &map, &options(16)).unwrap(), expected);
}

/// Sheets of an alpha stop that share of what is seen through them and of the light that falls through them.
#[test]
fn what_blends_stops_its_share_of_camera_and_shadow_rays() {
    let map = constant_environment(Vec3::ONE);
    let sheet = |height: f32| (floor(500.0, height), lambert(0.0));
    // From below two sheets: the floor is lit through both.
    let mut scene = scene(vec![(floor(5.0, 0.0), lambert(0.5)), sheet(1.0), sheet(2.0)]);
    for (material, alpha) in scene.materials[1..].iter_mut().zip([0.3, 0.5]) {
        (material.alpha, material.alpha_mode) = (alpha, AlphaMode::Blend);
    }
    let found = render(&scene, &downward_strip(0.9, 0.4), &map, &options(256)).unwrap().mean;
    assert!((found.get(16, 12).x / (0.5 * 0.7 * 0.5) - 1.0).abs() < 0.02, "{}", found.get(16, 12));
    // From above them: black sheets, and the floor through them.
    let found = render(&scene, &downward_strip(3.0, 0.4), &map, &options(4096)).unwrap().mean;
    let mean = found.texels().iter().sum::<Vec3>() / found.texels().len() as f32;
    assert!((mean.x / (0.5 * 0.35 * 0.35) - 1.0).abs() < 0.02, "{mean}");
}

#[test]
fn darkness_is_black_and_emission_shines() {
    let (mut scene, camera, _) = still_life();
    let night = constant_environment(Vec3::ZERO);
    let found = render(&scene, &camera, &night, &options(16)).unwrap();
    assert!(found.mean.texels().iter().all(|t| t.x == 0.0 && t.y == 0.0 && (0.0..=0.0201).contains(&t.z)));
    assert!(found.mean.texels().iter().any(|t| (t.z - 0.02).abs() < 1e-6));
    scene.materials[1].emissive = Vec3::ZERO;
    let found = render(&scene, &camera, &night, &options(16)).unwrap();
    assert!(found.mean.texels().iter().chain(found.variance.texels()).all(|t| *t == Vec3::ZERO));
}

#[test]
fn an_empty_scene_shows_the_environment() {
    let (_, camera, map) = still_life();
    let constant = constant_environment(Vec3::new(1.0, 2.0, 3.0));
    let found = render(&Scene::default(), &camera, &constant, &options(2)).unwrap();
    assert!(found.mean.texels().iter().all(|t| t.distance(Vec3::new(1.0, 2.0, 3.0)) < 1e-5));
    // A scene of nothing but degenerate triangles is as empty.
    let mut flat = scene(vec![(floor(1.0, 0.0), lambert(0.5))]);
    flat.nodes[0].parent_from_node = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
    let expected = render(&Scene::default(), &camera, &map, &options(8)).unwrap();
    assert_eq!(render(&flat, &camera, &map, &options(8)).unwrap(), expected);
}

#[test]
fn bad_requests_are_refused() {
    let (scene, camera, map) = still_life();
    let attempt = |options: &ReferenceOptions| render(&scene, &camera, &map, options).unwrap_err();
    let size = |width, height| ReferenceOptions { width, height, ..options(4) };
    assert_eq!(attempt(&size(0, 5)), ReferenceError::EmptyPicture { width: 0, height: 5 });
    let huge = ReferenceError::PictureTooLarge { width: u32::MAX, height: u32::MAX };
    assert_eq!(attempt(&size(u32::MAX, u32::MAX)), huge);
    assert_eq!(attempt(&options(0)), ReferenceError::NoSamples);
    let empty = Equirect::new(RgbImage::filled(0, 0, Vec3::ZERO));
    assert_eq!(render(&scene, &camera, &empty, &options(4)).unwrap_err(), ReferenceError::EmptyEnvironment);
    let blind = Camera { world_from_camera: Mat4::ZERO, ..camera.clone() };
    let error = render(&scene, &blind, &map, &options(4)).unwrap_err();
    assert!(matches!(error, ReferenceError::BadCamera { .. }));
    assert!(!error.to_string().contains('\n'));
}

#[test]
fn progress_is_told_and_cancelling_stops() {
    let (scene, camera, map) = still_life();
    let told = Mutex::new(Vec::new());
    let progress = |share: f32| told.lock().unwrap().push(share);
    render(&scene, &camera, &map, &ReferenceOptions { progress: Some(&progress), ..options(2) }).unwrap();
    let told = told.into_inner().unwrap();
    assert_eq!(told.len(), 24);
    assert!(told.contains(&1.0) && told.iter().all(|share| (0.0..=1.0).contains(share)));

    let cancel = AtomicBool::new(true);
    let stopped = ReferenceOptions { cancel: Some(&cancel), ..options(1 << 20) };
    assert_eq!(render(&scene, &camera, &map, &stopped).unwrap_err(), ReferenceError::Cancelled);
}
