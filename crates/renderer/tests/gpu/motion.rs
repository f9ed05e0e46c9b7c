//! Animated models drawn in a pose, against the reference tracer in the same pose.

use crate::common::*;
use gnomon_lights::FitOptions;
use gnomon_metrics::compare;
use gnomon_reference::ReferenceOptions;
use gnomon_renderer::{Reflections, RenderSettings, Renderer};
use gnomon_scene::{Ground, default_camera};
use gnomon_scene_files::LoadOptions;
use gnomon_testing::tolerances;

const SIZE: [u32; 2] = [128, 96];

/// `GNOMON_PICTURES=folder` keeps the pictures.
#[test]
fn poses_look_as_ray_traced() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = gnomon_envmap::builtin::sized("room", 256, 128).unwrap();
    let options = FitOptions { light_count: Some(tolerances::GPU_LIGHTS), ..Default::default() };
    let set = gnomon_lights::fit::by_name("partition", &options).unwrap().fit(&map).unwrap();
    let mut renderers = ["pcss", "rays"].map(|shadows| {
        let settings = RenderSettings::default().with(|s| {
            s.techniques.shadows = shadows.to_owned();
            // Reflections move along in some of the pictures.
            s.paths.reflections = if shadows == "rays" { Reflections::Scene } else { Reflections::Off };
        });
        let mut renderer = Renderer::new(&gpu, settings).unwrap();
        renderer.set_lighting(&map, &set).unwrap();
        renderer
    });
    for (name, clip, share, by_rays) in [
        ("BrainStem", 0, 0.45, false),
        ("RobotExpressive", 0, 0.3, false),
        ("RobotExpressive", 0, 0.3, true),
        ("Fox", 2, 0.3, true),
        ("AnimatedMorphCube", 0, 0.45, false),
        ("AnimatedMorphCube", 0, 0.45, true),
    ] {
        let renderer = &mut renderers[usize::from(by_rays)];
        let Some(path) = gnomon_testing::data_file(&format!("models/{name}.glb")) else { return };
        let mut scene =
            gnomon_scene_files::load(&path, &LoadOptions { aspect: 4.0 / 3.0, ..Default::default() })
                .unwrap()
                .scene;
        let seconds = share * scene.animations[clip].duration();
        // Some models rest with their feet in the ground: the clip decides where that is.
        scene.animate(clip, seconds).unwrap();
        scene.add_ground(Ground::Plane);
        let camera = default_camera(&scene, 4.0 / 3.0);
        scene.rest();
        renderer.set_scene(&scene).unwrap();
        let at_rest = renderer.render(&camera, SIZE[0], SIZE[1]).unwrap().radiance;
        scene.animate(clip, seconds).unwrap();
        renderer.move_scene(&scene).unwrap();
        let drawn = renderer.render(&camera, SIZE[0], SIZE[1]).unwrap().radiance;
        let traced = ReferenceOptions {
            width: SIZE[0],
            height: SIZE[1],
            samples_per_pixel: 48,
            reflections: by_rays,
            ..Default::default()
        };
        let truth = gnomon_reference::render(&scene, &camera, &map, &traced).unwrap().mean;
        if let Some(folder) = std::env::var_os("GNOMON_PICTURES") {
            let folder = std::path::Path::new(&folder);
            for (what, picture) in [("rest", &at_rest), ("drawn", &drawn), ("truth", &truth)] {
                gnomon_picture::write(folder.join(format!("{name}_{what}.png")), picture).unwrap();
            }
        }
        let error = |picture| compare(picture, &truth, None).unwrap().relative_rmse;
        let (pose, rest) = (error(&drawn), error(&at_rest));
        println!("{name}: {pose:.4}, at rest {rest:.4}");
        assert!(pose <= tolerances::GPU_MOVING_RELATIVE_RMSE, "{name}: {pose}");
        // Another pose is told apart.
        assert!(rest > 2.0 * pose, "{name}: {rest}");
    }
}
