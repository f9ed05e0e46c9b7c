//! Poses, turning and streams.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use gnomon_envmap::Equirect;
use gnomon_metrics::relative_rmse;
use gnomon_options::Given;
use gnomon_picture::RgbImage;
use gnomon_reference::{ReferenceOptions, render};
use gnomon_renderer::{Gpu, GpuOptions};
use gnomon_scene::{Bounds, Ground, Projection};
use gnomon_studio::{Look, Project, Sequence, Stage, Studio, Timeline, Update, environment_named};
use gnomon_testing::tolerances::ROTATED_TEXELS_RMSE;

const SIZE: [u32; 2] = [48, 36];

fn gpu() -> Option<Gpu> {
    let gpu = Gpu::new(&GpuOptions::default());
    if gpu.is_err() {
        gnomon_testing::skip("no usable graphics adapter");
    }
    gpu.ok()
}

fn project(name: &str) -> Project {
    let mut look = Look::default();
    look.fit.light_count = Some(8);
    look.lighting.ambient = "unshadowed".to_owned();
    look.techniques.shadow_resolution = 64;
    look.techniques.supersample = 1;
    look.picture.size = SIZE;
    let mut project = Project::open(name, look, &Given::default()).unwrap();
    project.look.set_environment(environment_named("room"));
    project.look.scene.ground = Ground::Plane;
    project
}

fn picture(studio: &mut Studio) -> RgbImage {
    studio.frame(SIZE[0], SIZE[1]).unwrap().radiance
}

/// A skinned model, a morphed one, one whose nodes move.
const MODELS: [&str; 3] =
    ["models/RiggedSimple.glb", "models/AnimatedMorphCube.glb", "models/BoxAnimated.glb"];

#[test]
fn a_pose_taken_live_is_the_pose_opened_and_frames_depend_on_nothing_else() {
    let Some(gpu) = gpu() else { return };
    for model in MODELS {
        let Some(path) = gnomon_testing::data_file(model) else { return };
        let stage = Stage::new(project(path.to_str().unwrap())).unwrap();
        let timeline = Timeline { turntable: 60.0, environment_turn: 25.0, ..Timeline::new(5.0).unwrap() };
        let sequence = Sequence::new(&stage, timeline).unwrap();
        let mut live = Studio::new(&gpu, stage.clone()).unwrap();
        let rest = picture(&mut live);
        let drawn: Vec<_> = (0..4)
            .map(|frame| {
                live.set_look(sequence.look(frame)).unwrap();
                picture(&mut live)
            })
            .collect();
        for frame in [2, 0, 3] {
            let mut opened = stage.clone();
            opened.set_look(sequence.look(frame)).unwrap();
            let mut opened = Studio::new(&gpu, opened).unwrap();
            assert!(picture(&mut opened) == drawn[frame as usize], "{model}, frame {frame}");
        }
        assert!(drawn[1] != drawn[2] && drawn[2] != drawn[3], "{model} moves");
        live.set_look(stage.look().clone()).unwrap();
        assert!(picture(&mut live) == rest, "{model}: back to rest");
        // Another clip moves the ground, which uploads no mesh: a picture of the ground that stayed would be another.
        live.edit(|look| look.animation.clip = Some("0".to_owned())).unwrap();
        let mut opened = project(path.to_str().unwrap());
        opened.look = live.look().clone();
        let mut opened = Studio::new(&gpu, Stage::new(opened).unwrap()).unwrap();
        assert!(picture(&mut live) == picture(&mut opened), "{model}: the clip's ground");
        live.set_look(stage.look().clone()).unwrap();
        let error =
            live.edit(|look| look.animation.clip = Some("absent".to_owned())).unwrap_err().to_string();
        assert!(error.contains("clip"), "{error}");
        assert!(picture(&mut live) == rest);
    }
}

/// Ground and camera are those of the clip: they hold all of it, and do not move while it plays.
#[test]
fn a_clip_has_one_ground_and_one_camera_that_hold_all_of_it() {
    for (model, clip) in [
        ("models/RobotExpressive.glb", "Dance"),
        ("models/Fox.glb", "Run"),
        (MODELS[0], "0"),
        (MODELS[2], "0"),
    ] {
        let Some(path) = gnomon_testing::data_file(model) else { return };
        let rest = Stage::new(project(path.to_str().unwrap())).unwrap();
        let mut stage = rest.clone();
        let mut look = stage.look().clone();
        look.animation.clip = Some(clip.to_owned());
        stage.set_look(look).unwrap();
        let (camera, center) = (stage.camera().unwrap(), stage.center());
        let ground = |stage: &Stage| {
            let scene = stage.scene();
            scene.world_from_nodes()[scene.ground.unwrap().0]
        };
        let height = ground(&stage).translation.y;
        assert!(camera != rest.camera().unwrap(), "{model}");
        let Projection::Perspective { fov_x } = camera.projection else { panic!("no perspective") };
        let edge = (0.5 * fov_x).tan();
        let sequence = Sequence::new(&stage, Timeline::new(10.0).unwrap()).unwrap();
        let mut reach: Option<Bounds> = None;
        for frame in [3, 0, 17, 30, 8, 25, 12] {
            stage.set_look(sequence.look(frame)).unwrap();
            assert_eq!((stage.camera().unwrap(), stage.center()), (camera.clone(), center), "{model}");
            assert_eq!(ground(&stage).translation.y, height, "{model}");
            let pose = stage.scene().bounds_without_ground().unwrap();
            reach = Some(reach.map_or(pose, |reach| reach.union(pose)));
            let scene = stage.scene();
            for instance in scene.instances().iter().filter(|instance| Some(instance.node) != scene.ground) {
                for place in scene.world_vertices(&scene.pose(), instance).positions {
                    let place = camera.world_from_camera.inverse().transform_point3(place);
                    let (x, y) = (place.x / -place.z / edge, place.y / -place.z / edge * 4.0 / 3.0);
                    assert!(place.z < 0.0 && x.abs().max(y.abs()) < 1.0, "{model}: out of the picture");
                }
            }
        }
        let reach = reach.unwrap();
        let size = reach.max.y - reach.min.y;
        assert!((reach.min.y - height).abs() < 0.02 * size, "{model}: {} over {height}", reach.min.y);
        // A sequence of a stage without a clip plays the first, on its ground and with its turntable's middle.
        let mut first = rest.clone();
        first.set_look(Sequence::new(&rest, Timeline::new(10.0).unwrap()).unwrap().look(0)).unwrap();
        assert_eq!(first.look().animation.clip.as_ref(), Some(&first.scene().animations[0].name), "{model}");
        let mut back = first.clone();
        back.set_look(rest.look().clone()).unwrap();
        assert_eq!((back.camera().unwrap(), back.center()), (rest.camera().unwrap(), rest.center()));
        assert!(**back.scene() == **rest.scene(), "{model}: back to rest");
    }
}

#[test]
fn time_beyond_a_clip_starts_it_again() {
    let Some(path) = gnomon_testing::data_file(MODELS[2]) else { return };
    let stage = Stage::new(project(path.to_str().unwrap())).unwrap();
    let at = |time: f32| {
        let mut stage = stage.clone();
        let mut look = stage.look().clone();
        look.animation.clip = Some("0".to_owned());
        look.animation.time = time;
        stage.set_look(look).unwrap();
        stage.scene().nodes.clone()
    };
    let duration = stage.scene().animations[0].duration();
    assert_ne!(at(0.0), at(0.5 * duration));
    assert_eq!(at(0.25 * duration + duration), at((0.25 * duration + duration).rem_euclid(duration)));
    assert_eq!(at(-0.25 * duration), at((-0.25 * duration).rem_euclid(duration)));
    assert_ne!(at(duration), at(0.0), "the end is the last pose");
}

/// The reference turns the scene instead of the environment: skins, morphs and all.
#[test]
fn the_references_turned_scene_sees_what_a_turned_map_shows() {
    let Some(path) = gnomon_testing::data_file(MODELS[0]) else { return };
    let mut stage = Stage::new(project(path.to_str().unwrap())).unwrap();
    let mut look = stage.look().clone();
    look.animation.clip = Some("0".to_owned());
    look.animation.time = 0.7;
    // A whole number of texels, so that none is resampled.
    let yaw = 100.0 * 360.0 / stage.environment().width() as f32;
    look.environment.rotation = yaw;
    stage.set_look(look).unwrap();
    let options = ReferenceOptions {
        width: SIZE[0],
        height: SIZE[1],
        samples_per_pixel: 512,
        ..ReferenceOptions::default()
    };
    let (scene, camera) = stage.for_reference().unwrap();
    let turned = render(&scene, &camera, stage.environment(), &options).unwrap();
    let map = stage.environment().rotated(yaw.to_radians());
    let expected = render(stage.scene(), &stage.camera().unwrap(), &map, &options).unwrap();
    let mean = |picture: &RgbImage| {
        let sum: f32 = picture.texels().iter().map(|texel| texel.element_sum()).sum();
        f64::from(sum) / (3 * picture.texels().len()) as f64
    };
    // Two independent estimates.
    let noise = (mean(&turned.variance) + mean(&expected.variance)).sqrt() / mean(&expected.mean);
    let error = relative_rmse(&turned.mean, &expected.mean).unwrap();
    assert!(error < 1.3 * noise + ROTATED_TEXELS_RMSE, "{error}, noise {noise}");
    let planted = render(stage.scene(), &stage.camera().unwrap(), stage.environment(), &options).unwrap();
    assert!(relative_rmse(&planted.mean, &expected.mean).unwrap() > 3.0 * (noise + ROTATED_TEXELS_RMSE));
}

#[test]
fn an_environment_that_changes_every_frame_is_refitted_behind_the_frames() {
    let Some(gpu) = gpu() else { return };
    let mut studio = Studio::new(&gpu, Stage::new(project("three-boxes")).unwrap()).unwrap();
    let map = |step: f32| {
        let sky = |x: u32, y: u32| {
            let bright = x / 16 == step as u32 % 4 && (8..16).contains(&y);
            Vec3::splat(if bright { 20.0 } else { 0.1 + 0.01 * step })
        };
        Arc::new(Equirect::new(RgbImage::from_fn(64, 32, sky)))
    };
    let (mut step, mut taken) = (0, 0);
    let start = Instant::now();
    // Frames may be far quicker than fits.
    while step < 40 || taken == 0 && start.elapsed() < Duration::from_secs(30) {
        studio.stream_environment(map(step as f32));
        taken += studio.poll().len();
        picture(&mut studio);
        step += 1;
    }
    assert!(taken > 0, "lights keep coming while requests do");
    let updates = studio.wait();
    assert!(updates.iter().all(|update| matches!(update, Update::Lighting)), "{updates:?}");
    assert!(!studio.is_busy());
    assert_eq!(studio.environment().radiance(), map((step - 1) as f32).radiance(), "the last one counts");
    let streamed = picture(&mut studio);
    studio.reload_environment();
    assert!(matches!(&studio.wait()[..], [Update::Lighting]));
    let mut opened = Studio::new(&gpu, Stage::new(project("three-boxes")).unwrap()).unwrap();
    let shown = picture(&mut studio);
    assert!(shown == picture(&mut opened) && shown != streamed, "back to the file's");
}
