//! Scenes under light rigs, and environments whose light is changed.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::f32::consts::PI;
use std::path::Path;

use glam::{DVec3, Vec3};
use gnomon_envmap::{Equirect, Grade, builtin};
use gnomon_lights::{DistantLight, LightDocument, LightEntry, LightSet};
use gnomon_metrics::compare;
use gnomon_options::Given;
use gnomon_picture::RgbImage;
use gnomon_reference::{ReferenceOptions, render};
use gnomon_renderer::{Background, Gpu, GpuOptions};
use gnomon_studio::{
    EditedRig, EnvironmentLook, Look, Project, Sequence, Stage, Studio, StudioError, Timeline,
    environment_named,
};

/// A disk of a milliradian straight above, of irradiance `pi`, and an even rest of radiance 0.25.
fn write_rig(folder: &Path, change: impl FnOnce(&mut LightDocument)) -> String {
    let rest = RgbImage::filled(16, 8, Vec3::splat(0.25));
    let flux = DVec3::splat(std::f64::consts::PI);
    let lights = vec![DistantLight::disk(DVec3::Y, 1e-3, flux)];
    let set = LightSet::new("disks", lights, Equirect::new(rest));
    gnomon_picture::write(folder.join("rest.exr"), set.residual.radiance()).unwrap();
    let mut document = LightDocument { residual: Some("rest.exr".to_owned()), ..set.document() };
    change(&mut document);
    let path = folder.join("rig.json");
    std::fs::write(&path, document.to_json()).unwrap();
    path.to_string_lossy().into_owned()
}

/// A matt white floor of 2 m.
fn floor(folder: &Path) -> String {
    let path = folder.join("floor.obj");
    std::fs::write(&path, "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nf 1 2 3 4\n").unwrap();
    let scene = folder.join("floor.toml");
    let text = "[[model]]\nfile = 'floor.obj'\nmaterial = 'white'\n[material.white]\nbase_color = [1, 1, 1]\n\
        [camera]\neye = [0, 3, 0.01]\ntarget = [0, 0, 0]\nfov = 20\n";
    std::fs::write(&scene, text).unwrap();
    scene.to_string_lossy().into_owned()
}

fn stage(scene: &str, environment: EnvironmentLook) -> Result<Stage, StudioError> {
    let mut project = Project::open(scene, Look::default(), &Given::default())?;
    if environment.rig.is_none() {
        project.look.set_environment(environment_named("room"));
    }
    project.look.environment = environment;
    Stage::new(project)
}

/// Mean radiance of the whole picture.
fn traced(stage: &Stage) -> Vec3 {
    let options =
        ReferenceOptions { width: 4, height: 3, samples_per_pixel: 1024, ..ReferenceOptions::default() };
    let (scene, camera) = stage.for_reference().unwrap();
    let mean = render(&scene, &camera, stage.sky(), &options).unwrap().mean;
    mean.texels().iter().sum::<Vec3>() / 12.0
}

fn rigged(rig: String) -> EnvironmentLook {
    EnvironmentLook { rig: Some(rig), ..EnvironmentLook::default() }
}

/// White under irradiance E shows E / pi: 1 of the light and 0.25 of the rest.
#[test]
fn the_reference_shows_a_floor_under_a_rig_as_closed_forms_have_it() {
    let folder = tempfile::tempdir().unwrap();
    let floor = floor(folder.path());
    let shown = |change: fn(&mut LightDocument)| {
        traced(&stage(&floor, rigged(write_rig(folder.path(), change))).unwrap())
    };
    let near = |shown: Vec3, expected: Vec3| {
        assert!((shown / expected - 1.0).abs().max_element() < 0.01, "{shown} is not {expected}");
    };
    near(shown(|_| {}), Vec3::splat(1.25));
    near(shown(|rig| rig.lights[0].enabled = false), Vec3::splat(0.25));
    near(shown(|rig| rig.lights[0].radiance[1] *= 2.0), Vec3::new(1.25, 2.25, 1.25));
    near(shown(|rig| rig.lights[0].direction = [3.0, 4.0, 0.0]), Vec3::splat(0.8 + 0.25));
    near(shown(|rig| rig.lights.push(rig.lights[0].clone())), Vec3::splat(2.25));
    let graded = |strength: f32, tint: [f32; 3]| {
        let rig = write_rig(folder.path(), |_| {});
        traced(&stage(&floor, EnvironmentLook { strength, tint, ..rigged(rig) }).unwrap())
    };
    near(graded(2.0, [1.0, 0.5, 2.0]), Vec3::new(2.5, 1.25, 5.0));
}

#[test]
fn a_rig_that_cannot_be_is_one_clear_error() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |change: fn(&mut LightDocument)| {
        let rig = write_rig(folder.path(), change);
        let error = stage("column", rigged(rig)).err().unwrap().to_string();
        assert_eq!(error.lines().count(), 1, "{error}");
        error
    };
    assert!(refused(|rig| rig.residual = None).contains("names none (residual)"));
    assert!(refused(|rig| rig.residual = Some("none.exr".to_owned())).contains("none.exr"));
    assert!(
        refused(|rig| rig.lights[0].radiance[0] = -1.0)
            .contains("light 0 of the document has an invalid radiance")
    );
    std::fs::write(folder.path().join("bad.json"), "{\"lights\": [], \"moon\": 1}").unwrap();
    let bad = folder.path().join("bad.json").to_string_lossy().into_owned();
    let error = stage("column", rigged(bad)).err().unwrap().to_string();
    assert!(error.contains("is no light rig") && error.contains("moon"), "{error}");
    assert!(stage("column", rigged("none.json".to_owned())).is_err());
}

/// A floor under edits of its rig, and under the file that they are saved to.
#[test]
fn a_rig_is_edited_and_saved() {
    let folder = tempfile::tempdir().unwrap();
    let rig = write_rig(folder.path(), |_| {});
    let mut opened = stage(&floor(folder.path()), rigged(rig)).unwrap();
    let near = |stage: &Stage, expected: Vec3| {
        let shown = traced(stage);
        assert!((shown / expected - 1.0).abs().max_element() < 0.01, "{shown} is not {expected}");
    };
    let edit = |stage: &mut Stage, change: &dyn Fn(&mut EditedRig)| {
        let mut edited = stage.rig().unwrap();
        change(&mut edited);
        stage.set_look(Look { rig: Some(edited), ..stage.look().clone() })
    };
    edit(&mut opened, &|rig| rig.lights[0].direction = [3.0, 4.0, 0.0]).unwrap();
    edit(&mut opened, &|rig| rig.lights[0].radiance[1] *= 2.0).unwrap();
    near(&opened, Vec3::new(0.8, 1.6, 0.8) + 0.25);
    edit(&mut opened, &|rig| {
        rig.lights.push(LightEntry { direction: [0.0, 2.0, 0.0], ..rig.lights[0].clone() })
    })
    .unwrap();
    near(&opened, Vec3::new(1.8, 3.6, 1.8) + 0.25);
    edit(&mut opened, &|rig| rig.solo = Some(1)).unwrap();
    near(&opened, Vec3::new(1.0, 2.0, 1.0));
    edit(&mut opened, &|rig| (rig.solo, rig.lights[1].enabled) = (None, false)).unwrap();
    near(&opened, Vec3::new(0.8, 1.6, 0.8) + 0.25);
    let refused = edit(&mut opened, &|rig| rig.lights[0].radiance[0] = -1.0).unwrap_err().to_string();
    assert!(refused.contains("light 0") && refused.contains("radiance"), "{refused}");

    let unsaved = opened.save_scene(&folder.path().join("scene.toml")).unwrap_err().to_string();
    assert!(unsaved.contains("save the rig first"), "{unsaved}");
    std::fs::create_dir(folder.path().join("saved")).unwrap();
    let saved = folder.path().join("saved/edited.json");
    opened.save_rig(&saved).unwrap();
    let document = LightDocument::from_json(&std::fs::read_to_string(&saved).unwrap()).unwrap();
    assert_eq!(document.residual.as_deref(), Some("../rest.exr"));
    assert!((document.lights_flux[1] / (2.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3, "{document:?}");
    let again = stage(&floor(folder.path()), rigged(saved.to_string_lossy().into_owned())).unwrap();
    near(&again, Vec3::new(0.8, 1.6, 0.8) + 0.25);
    // Edits belong to the file that they were made of.
    opened.set_look(Look { environment: again.look().environment.clone(), ..opened.look().clone() }).unwrap();
    assert!(opened.look().edited_rig().is_none());
    assert_eq!(opened.rig().unwrap().lights, again.rig().unwrap().lights);
}

/// What is clamped comes back as lights: matt boxes, and glossy metal under a sun that is its highlights, are as bright as under the whole map but for what
/// lights of any fit are off by (0.4 % here). A wide panel becomes a disk: its highlights have another outline.
#[test]
fn a_clamped_map_lights_a_picture_as_the_whole_one_does() {
    let gpu = match Gpu::new(&GpuOptions::default()) {
        Ok(gpu) => gpu,
        Err(_) => return gnomon_testing::skip("no usable graphics adapter"),
    };
    let size = [64, 48];
    let metal = "metallic-roughness: base_color=0.9, metallic=1, roughness=0.3";
    for (name, limit, reflectance, most_bias) in
        [("studio", 4.0, None, 0.015), ("sky", 4.0, Some(metal), 0.02)]
    {
        let lit = |clamp: Option<f32>| {
            let mut project = Project::open("three-boxes", Look::default(), &Given::default()).unwrap();
            project.look.set_environment(environment_named(name));
            project.look.environment.clamp = clamp;
            project.look.display.background = Background::None;
            project.look.reflectance = reflectance.map(|text| text.parse().unwrap());
            Stage::new(project).unwrap()
        };
        let (whole, clamped) = (lit(None), lit(Some(limit)));
        let (brightest, kept) = (whole.environment().radiance(), clamped.environment().radiance());
        let most = |map: &RgbImage| map.texels().iter().map(|t| t.max_element()).fold(0.0, f32::max);
        assert!(
            most(brightest) > 1.5 * limit && most(kept) < 1.001 * limit,
            "{} {}",
            most(brightest),
            most(kept)
        );
        let options = ReferenceOptions {
            width: size[0],
            height: size[1],
            samples_per_pixel: 64,
            background: false,
            ..ReferenceOptions::default()
        };
        let traced = |stage: &Stage| {
            let (scene, camera) = stage.for_reference().unwrap();
            render(&scene, &camera, stage.sky(), &options).unwrap().mean
        };
        let truth = traced(&whole);
        let drawn = Studio::new(&gpu, clamped.clone()).unwrap().frame(size[0], size[1]).unwrap().radiance;
        for (who, picture) in [("traced", &traced(&clamped)), ("drawn", &drawn)] {
            let bias = compare(picture, &truth, None).unwrap().relative_bias;
            println!("{name}, {reflectance:?}, {who}: {bias:+.4}");
            assert!(bias.abs() < most_bias, "{reflectance:?}, {who}: {bias}");
        }
        // Without the lights it is plainly darker.
        let dark = {
            let (scene, camera) = clamped.for_reference().unwrap();
            render(&scene, &camera, &**clamped.environment(), &options).unwrap().mean
        };
        let bias = compare(&dark, &truth, None).unwrap().relative_bias;
        assert!(bias < -2.0 * most_bias, "{reflectance:?}: {bias}");
    }
}

/// The strength does not vanish in the exposure, and another background lights nothing.
#[test]
fn strength_and_background_change_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let plain = stage("column", EnvironmentLook::default()).unwrap();
    let graded = EnvironmentLook { strength: 3.0, tint: [1.0, 0.5, 0.0], ..EnvironmentLook::default() };
    let strong = stage("column", graded).unwrap();
    assert_eq!(strong.exposure(), plain.exposure());
    let room = builtin::by_name("room").unwrap();
    let light = Vec3::new(3.0, 1.5, 0.0);
    assert_eq!((strong.grade(), plain.grade()), (Grade { light, background: light }, Grade::NONE));

    let path = folder.path().join("green.exr");
    gnomon_picture::write(&path, &RgbImage::filled(8, 4, Vec3::Y)).unwrap();
    let background_map = Some(path.to_string_lossy().into_owned());
    let behind =
        stage("column", EnvironmentLook { background_map, strength: 3.0, ..EnvironmentLook::default() })
            .unwrap();
    assert_eq!(behind.grade(), Grade { light: Vec3::splat(3.0), background: Vec3::ONE });
    let sky = behind.sky();
    assert_eq!(sky.background.lookup(Vec3::X), Vec3::Y);
    assert_eq!((sky.map.radiance(), sky.lights.len()), (room.radiance(), 0));
    assert_eq!(plain.sky().background.radiance(), room.radiance());
}

#[test]
fn scene_files_name_rigs_from_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let rig = write_rig(folder.path(), |_| {});
    let opened =
        stage(&floor(folder.path()), EnvironmentLook { tint: [1.0, 0.5, 0.25], ..rigged(rig) }).unwrap();
    std::fs::create_dir(folder.path().join("saved")).unwrap();
    let saved = folder.path().join("saved/scene.toml");
    opened.save_scene(&saved).unwrap();
    let text = std::fs::read_to_string(&saved).unwrap();
    assert!(text.contains("rig = \"../rig.json\""), "{text}");
    let project = Project::open(&saved.to_string_lossy(), Look::default(), &Given::default()).unwrap();
    assert!(project.look.map.is_none() && project.look.has_environment());
    let again = Stage::new(project).unwrap();
    assert_eq!(again.sky().lights, opened.sky().lights);
    assert_eq!(again.look().environment.tint, [1.0, 0.5, 0.25]);
    let light = &again.sky().lights[0];
    let blue = again.grade().light.z * light.radiance.z;
    assert!((light.irradiance(Vec3::Y) * blue / (0.25 * PI) - 1.0).abs() < 1e-4);
}

/// Frames under a rig that has been edited since are others.
#[test]
fn frames_know_the_lights_of_a_rig_by_what_is_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let digest = |change: fn(&mut LightDocument)| {
        let stage = stage("column", rigged(write_rig(folder.path(), change))).unwrap();
        let timeline = Timeline { frames_per_second: 25.0, turntable: 0.0, environment_turn: 0.0 };
        Sequence::new(&stage, timeline).unwrap().description(&stage, serde_json::Value::Null).1
    };
    assert_eq!(digest(|_| {}), digest(|_| {}));
    assert_ne!(digest(|_| {}), digest(|rig| rig.lights[0].radiance[0] *= 2.0));
}
