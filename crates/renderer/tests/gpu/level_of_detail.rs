//! A live renderer whose level of detail changes, and a controller on real times.

use crate::common::*;
use glam::{Affine3A, Mat3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::{FitOptions, LightSet, fit};
use gnomon_metrics::compare;
use gnomon_renderer::lod::{FrameTimes, LevelOfDetail, LodController, LodRange, LodState};
use gnomon_renderer::{PassTiming, RenderSettings, Renderer};
use gnomon_scene::{AreaLight, AreaLightShape, Node, NodeId, Scene, builtin};

const SIZE: [u32; 2] = [96, 72];

fn sky() -> Equirect {
    gnomon_envmap::builtin::sized("sky", 128, 64).unwrap()
}

fn lights(method: &str, map: &Equirect, count: u32) -> LightSet {
    let options = FitOptions { light_count: Some(count as usize), ..Default::default() };
    fit::by_name(method, &options).unwrap().fit(map).unwrap()
}

#[test]
fn a_live_renderer_at_another_level_draws_what_a_fresh_one_draws() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (scene, map) = (builtin::by_name("three-boxes").unwrap(), sky());
    let camera = scene.cameras[0].clone();
    // Disks leave an ambient rest, which changes with their number.
    for (method, ambient) in [("partition", "cells"), ("disks", "unshadowed")] {
        let settings = RenderSettings::default().with(|s| {
            s.techniques.supersample = 1;
            s.lighting.ambient = ambient.to_owned();
        });
        let mut live = Renderer::new(&gpu, settings.clone()).unwrap();
        live.set_scene(&scene).unwrap();
        live.set_lighting(&map, &lights(method, &map, 8)).unwrap();
        let first = live.render(&camera, SIZE[0], SIZE[1]).unwrap().radiance;
        for (count, shadow_resolution, shadow_sampling) in [(20, 128, 4), (12, 64, 1), (8, 256, 8)] {
            let level = LevelOfDetail { lights: count, shadow_resolution, shadow_sampling };
            let set = lights(method, &map, count);
            live.set_level_of_detail(level, &set).unwrap();
            let found = live.render(&camera, SIZE[0], SIZE[1]).unwrap().radiance;
            let fresh = settings.clone().with(|s| level.set(&mut s.techniques));
            let expected = render(&gpu, fresh, &scene, &map, &set, &camera, SIZE).radiance;
            let error = compare(&found, &expected, None).unwrap().relative_rmse;
            assert!(error < 1e-5, "{method} {level:?}: {error}");
            let change = compare(&found, &first, None).unwrap().relative_rmse;
            assert_eq!(change > 1e-3, count != 8, "{method} {level:?}: {change}");
        }
        let wrong = LevelOfDetail { lights: 8, shadow_resolution: 100, shadow_sampling: 2 };
        assert!(live.set_level_of_detail(wrong, &lights(method, &map, 8)).is_err());
    }
}

/// Lamps of its own under which the boxes stand.
fn with_lamps(count: usize) -> Scene {
    let mut scene = builtin::by_name("three-boxes").unwrap();
    for lamp in 0..count {
        let (sin, cos) = (lamp as f32 * 2.4).sin_cos();
        let position = Vec3::new(2.0 * cos, 4.0, 2.0 * sin);
        let facing_down = Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y);
        scene.nodes.push(Node {
            parent_from_node: Affine3A::from_mat3_translation(facing_down, position),
            ..Node::default()
        });
        let shape = AreaLightShape::Disk { radius: 0.2 };
        scene.lights.push(AreaLight {
            node: NodeId(scene.nodes.len() - 1),
            shape,
            radiance: Vec3::ONE,
            spread: Default::default(),
        });
    }
    scene
}

/// Times of the passes of one frame, each the least of a few draws: what else the machine does only adds to them.
fn times(renderer: &mut Renderer, scene: &Scene) -> FrameTimes {
    let mut least: Vec<PassTiming> = Vec::new();
    for _ in 0..4 {
        let passes = renderer.draw(&scene.cameras[0], SIZE[0], SIZE[1]).unwrap();
        if least.is_empty() {
            least = passes;
            continue;
        }
        for (least, pass) in least.iter_mut().zip(passes) {
            least.milliseconds = least.milliseconds.min(pass.milliseconds);
        }
    }
    FrameTimes::from_passes(&least)
}

#[test]
fn real_frames_settle_at_the_budget_also_with_twice_the_lamps_and_replay_exactly() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = sky();
    let settings = RenderSettings::default().with(|s| {
        s.techniques.supersample = 1;
        s.measure.profile = true;
    });
    let mut renderer = Renderer::new(&gpu, settings).unwrap();
    renderer.set_scene(&with_lamps(4)).unwrap();
    let range = LodRange::default();
    let least = lights("partition", &map, range.least.lights);
    renderer.set_lighting(&map, &least).unwrap();
    renderer.set_level_of_detail(range.least, &least).unwrap();
    let budget = 3.0 * times(&mut renderer, &with_lamps(4)).total();
    let mut controller = LodController::new(budget, range).unwrap();
    let mut replayed = controller.clone();
    for lamps in [4, 8] {
        let scene = with_lamps(lamps);
        renderer.set_scene(&scene).unwrap();
        let (mut last, mut frames) = (Vec::new(), 0);
        while last.len() < 20 {
            let level = controller.level();
            let times = times(&mut renderer, &scene);
            let next = controller.next(level, &times);
            assert_eq!((level, next), (replayed.level(), replayed.next(level, &times)));
            last.push(times.total());
            if next != level {
                last.clear();
                renderer.set_level_of_detail(next, &lights("partition", &map, next.lights)).unwrap();
            }
            frames += 1;
            assert!(frames < 200, "no level stays: {next:?}, {:?}", controller.state());
        }
        last.sort_by(f64::total_cmp);
        let (found, state) = (last[last.len() / 2] / budget, controller.state());
        println!(
            "{lamps} lamps: {:?}, {found:.3} of {budget:.1} ms, {frames} frames, {state:?}",
            controller.level()
        );
        assert!(found < 1.15, "{found} of {budget} ms");
        assert!(found > 0.75 || state == LodState::Best, "{found} of {budget} ms: {state:?}");
    }
}
