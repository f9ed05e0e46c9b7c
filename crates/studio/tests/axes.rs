//! Axes, unit and place of files that do not say.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::path::Path;

use glam::{DVec3, Vec3};
use gnomon_options::Given;
use gnomon_scene_files::UpAxis;
use gnomon_studio::{CameraLook, Look, Project, SceneLook, Stage, environment_named};

/// A triangle of a survey, z up, in UTM metres.
const SURVEY: &str =
    "v 500000.5 4500000.25 310\nv 500002.5 4500000.25 310\nv 500000.5 4500001.25 313\nf 1 2 3\n";

fn stage(path: &Path, look: &SceneLook) -> Stage {
    let given = Given::changes(&SceneLook::default(), look);
    let mut project = Project::open(path.to_str().unwrap(), Look::default(), &given).unwrap();
    if project.look.map.is_none() {
        project.look.set_environment(environment_named("room"));
    }
    Stage::new(project).unwrap()
}

fn z_up(unit: f32) -> SceneLook {
    SceneLook { up: UpAxis::Z, unit, ..SceneLook::default() }
}

fn size(stage: &Stage) -> Vec3 {
    let bounds = stage.scene().bounds_without_ground().unwrap();
    bounds.max - bounds.min
}

/// Where a stage's camera is, in file coordinates.
fn eye(stage: &Stage) -> DVec3 {
    let camera = stage.camera().unwrap();
    assert_eq!(camera.origin, stage.scene().origin);
    camera.origin + camera.eye().as_dvec3()
}

#[test]
fn a_live_change_is_as_good_as_another_opening() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("survey.obj");
    std::fs::write(&path, SURVEY).unwrap();
    let plain = stage(&path, &SceneLook::default());
    let turned = stage(&path, &z_up(0.01));
    assert!((size(&plain) - Vec3::new(2.0, 1.0, 3.0)).length() < 1e-6, "{}", size(&plain));
    assert!((size(&turned) - Vec3::new(0.02, 0.03, 0.01)).length() < 1e-6, "{}", size(&turned));
    let mut live = plain.clone();
    for (scene, opened) in [(z_up(0.01), &turned), (SceneLook::default(), &plain)] {
        let ground = opened.look().scene.ground;
        live.set_look(Look { scene: SceneLook { ground, ..scene }, ..live.look().clone() }).unwrap();
        assert!(live.scene().meshes == opened.scene().meshes && live.scene().origin == opened.scene().origin);
        assert_eq!((eye(&live), &live.look().scene), (eye(opened), &opened.look().scene));
    }
}

#[test]
fn a_far_scene_is_seen_and_saved_in_file_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("survey.obj");
    std::fs::write(&path, SURVEY).unwrap();
    let mut stage = stage(&path, &z_up(1.0));
    assert!(eye(&stage).distance(DVec3::new(500_001.5, 311.5, -4_500_000.75)) < 20.0, "it frames the model");
    let camera = "eye=500001.5,312.125,-4499996.5;target=500001.5,311.5,-4500000.75;fov=40".parse().unwrap();
    stage.set_look(Look { camera: CameraLook::Free(camera), ..stage.look().clone() }).unwrap();
    assert_eq!(eye(&stage), DVec3::new(500_001.5, 312.125, -4_499_996.5));
    let saved = folder.path().join("saved.toml");
    stage.save_scene(&saved).unwrap();
    let text = std::fs::read_to_string(&saved).unwrap();
    assert!(text.contains("up = \"z\"") && text.contains("500001.5"), "{text}");
    let opened = self::stage(&saved, &SceneLook::default());
    assert_eq!((eye(&opened), &opened.look().scene), (eye(&stage), &stage.look().scene));
    let bounds = |stage: &Stage| stage.scene().bounds().unwrap().min.as_dvec3() + stage.scene().origin;
    assert!(bounds(&opened).distance(bounds(&stage)) < 1e-6);
}
