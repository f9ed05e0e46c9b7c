//! Saved scenes, opened again.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::path::Path;

use glam::Vec3;
use gnomon_brdf::{Model, Surface};
use gnomon_lights::fit::FitSettings;
use gnomon_options::Given;
use gnomon_picture::tonemap::ToneMapping;
use gnomon_renderer::shadow::Prefilter;
use gnomon_scene::Ground;
use gnomon_studio::{CameraLook, Look, PictureSettings, Project, Stage, StudioError, environment_named};

fn open(name: &str, size: Option<[u32; 2]>) -> Result<Stage, StudioError> {
    let sizes = |size| PictureSettings { size };
    let given = size.map(|size| Given::changes(&sizes([0, 0]), &sizes(size)));
    let mut project = Project::open(name, Look::default(), &given.unwrap_or_default())?;
    if project.look.map.is_none() {
        project.look.set_environment(environment_named("room"));
    }
    Stage::new(project)
}

/// The same picture: scene, view and everything of the look but names of files, which are seen from elsewhere.
fn assert_same(saved: &Stage, opened: &Stage, what: &str) {
    assert_eq!(
        opened.camera().unwrap().world_from_camera,
        saved.camera().unwrap().world_from_camera,
        "{what}"
    );
    assert_eq!(opened.camera().unwrap().projection, saved.camera().unwrap().projection, "{what}");
    let (a, b) = (saved.scene(), opened.scene());
    assert_eq!(a.placed_lights(), b.placed_lights(), "{what}");
    assert!(a.meshes == b.meshes && a.textures == b.textures, "{what}");
    let surfaces =
        |materials: &[gnomon_scene::Material]| materials.iter().map(|m| m.surface).collect::<Vec<_>>();
    assert_eq!(surfaces(&a.materials), surfaces(&b.materials), "{what}");
    assert_eq!(a.bounds(), b.bounds(), "{what}");
    assert_eq!(a.ground.is_some(), b.ground.is_some(), "{what}");
    assert!(saved.environment().radiance() == opened.environment().radiance(), "{what}");
    let (a, b) = (saved.look(), opened.look());
    assert_eq!(
        (&a.fit, &a.lighting, &a.techniques, &a.picture, &a.display, &a.animation),
        (&b.fit, &b.lighting, &b.techniques, &b.picture, &b.display, &b.animation),
        "{what}"
    );
    assert_eq!((&a.scene, &a.surfaces, &a.reflectance), (&b.scene, &b.surfaces, &b.reflectance), "{what}");
    assert_eq!(a.environment.rotation, b.environment.rotation, "{what}");
}

fn changed(look: &Look) -> Look {
    let mut look = look.clone();
    look.fit = FitSettings { method: "disks".to_owned(), threshold: Some(0.1), seed: 3, ..look.fit };
    look.techniques.shadows = "moments".to_owned();
    look.techniques.shadow_settings.convolution.contact_samples = 3;
    look.display.exposure = Some(1.0 / 3.0);
    look.display.tone_mapping = ToneMapping::Linear;
    look.display.background = gnomon_renderer::Background::None;
    look.environment.rotation = 33.3;
    look.scene.ground = Ground::Plane;
    look.reflectance = Some("torrance-sparrow-beckmann:slope=0.31,specular=0.123".parse().unwrap());
    let surface = Surface {
        model: Model::Phong,
        shininess: 7.7,
        specular: 0.2,
        base_color: Vec3::splat(0.1),
        ..Surface::default()
    };
    look.set_surface(0, &surface).unwrap();
    look.camera = CameraLook::Free("eye=1.1,2.2,3.3; target=0.1,0.2,0.3; fov=33.3".parse().unwrap());
    look
}

fn check(name: &str, folder: &Path) {
    let mut stage = open(name, Some([96, 72])).unwrap();
    let looks = [
        stage.look().clone(),
        changed(stage.look()),
        // Another aspect than the one that the scene was loaded for.
        {
            let mut look = stage.look().clone();
            look.picture.size = [128, 64];
            look
        },
    ];
    for (index, look) in looks.into_iter().enumerate() {
        stage.set_look(look).unwrap();
        let path = folder.join("deep").join("scene.toml");
        stage.save_scene(&path).unwrap();
        let opened = open(path.to_str().unwrap(), None).unwrap();
        assert_same(&stage, &opened, &format!("{name} {index}"));
        // Once more, from elsewhere.
        let again = folder.join("again.toml");
        opened.save_scene(&again).unwrap();
        assert_same(&stage, &open(again.to_str().unwrap(), None).unwrap(), &format!("{name} {index}, again"));
    }
}

#[test]
fn builtin_scenes_and_files_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("deep")).unwrap();
    std::fs::write(folder.path().join("quad.obj"), "v -1 0 -1\nv 1 0.5 -1\nv 1 0.2 1\nv -1 0 1\nf 1 4 3 2\n")
        .unwrap();
    let text = "ground = \"plane\"\n[camera]\neye = [3, 2, 1]\ntarget = [0, 0, 0]\nfov = 41.7\n[environment]\nbuiltin = \"sky\"\n\
        [[model]]\nfile = \"quad.obj\"\nname = \"sheet\"\nmaterial = \"clay\"\n[material.clay]\nroughness = 0.3\n\
        [[light]]\nshape = \"disk\"\nradius = 0.2\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\nradiance = [3, 2, 1]\n";
    std::fs::write(folder.path().join("lit.toml"), text).unwrap();
    for name in ["three-boxes", "column", "terrain"] {
        check(name, folder.path());
    }
    for name in ["quad.obj", "lit.toml"] {
        check(folder.path().join(name).to_str().unwrap(), folder.path());
    }
}

#[test]
fn models_with_cameras_and_clips_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("deep")).unwrap();
    for name in ["scenes/three_boxes.glb", "models/CornellBox.glb"] {
        let Some(path) = gnomon_testing::data_file(name) else { return };
        check(path.to_str().unwrap(), folder.path());
    }
    let Some(path) = gnomon_testing::data_file("models/RiggedSimple.glb") else { return };
    let mut stage = open(path.to_str().unwrap(), Some([96, 72])).unwrap();
    let mut look = stage.look().clone();
    look.animation.clip = Some("0".to_owned());
    look.animation.time = 0.4;
    // Under the whole clip, as the camera frames it.
    look.scene.ground = Ground::Plane;
    stage.set_look(look).unwrap();
    let saved = folder.path().join("posed.toml");
    stage.save_scene(&saved).unwrap();
    assert_same(&stage, &open(saved.to_str().unwrap(), None).unwrap(), "posed");
}

#[test]
fn a_flat_table_of_techniques_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flat.toml");
    let text = "[environment]\nbuiltin = \"room\"\n[[model]]\nbuiltin = \"column\"\n[fit]\nmethod = \"disks\"\n[render]\n\
        shadows = \"convolution\"\norder = 8\nprefilter = \"sat\"\ncontact_samples = 0\nambient_cells = 12\ncaster_deviation = 1\n\
        [display]\nsize = [64, 48]\ntone_mapping = \"linear\"\n";
    std::fs::write(&path, text).unwrap();
    let stage = open(path.to_str().unwrap(), None).unwrap();
    let look = stage.look();
    let mut expected = Look::default();
    expected.fit.method = "disks".to_owned();
    expected.lighting.ambient_cells = 12;
    expected.techniques.shadows = "convolution".to_owned();
    expected.techniques.caster_deviation = 1.0;
    let convolution = &mut expected.techniques.shadow_settings.convolution;
    (convolution.order, convolution.prefilter) = (8, Prefilter::SummedAreaTable);
    convolution.contact_samples = 0;
    expected.picture.size = [64, 48];
    expected.display.tone_mapping = ToneMapping::Linear;
    // The environment's own.
    expected.display.exposure = Some(0.0);
    assert_eq!(
        (&look.fit, &look.lighting, &look.techniques, &look.picture, &look.display),
        (&expected.fit, &expected.lighting, &expected.techniques, &expected.picture, &expected.display)
    );
}

#[test]
fn what_is_changed_is_not_the_default() {
    let (before, after) = (Look::default(), changed(&Look::default()));
    assert!(before.fit != after.fit && before.techniques.shadows != after.techniques.shadows);
    assert_ne!(
        before.techniques.shadow_settings.convolution.contact_samples,
        after.techniques.shadow_settings.convolution.contact_samples
    );
    let (before, after) = (before.display, after.display);
    assert!(before.exposure != after.exposure && before.tone_mapping != after.tone_mapping);
    assert_ne!(before.background, after.background);
}

#[test]
fn a_failed_save_leaves_the_file_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let names = || {
        let mut names: Vec<_> =
            std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let stage = open("column", None).unwrap();
    let error = stage.save_scene(&folder.path().join("absent/scene.toml")).unwrap_err();
    assert!(matches!(error, StudioError::Write { .. }), "{error}");
    assert!(names().is_empty());
    // A scene that is saved over its own file, and again when that can no longer be read.
    let path = folder.path().join("scene.toml");
    stage.save_scene(&path).unwrap();
    let own = open(path.to_str().unwrap(), None).unwrap();
    own.save_scene(&path).unwrap();
    assert_same(&stage, &open(path.to_str().unwrap(), None).unwrap(), "over itself");
    std::fs::write(&path, "no = scene = file").unwrap();
    let error = own.save_scene(&path).unwrap_err().to_string();
    assert!(error.contains("no scene file any more") && !error.contains('\n'), "{error}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "no = scene = file");
    assert_eq!(names(), ["scene.toml"], "nothing half-written");
}
