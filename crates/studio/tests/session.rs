//! A live session against sessions that are opened with the look right away.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use gnomon_brdf::Surface;
use gnomon_options::Given;
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::ToneMapping;
use gnomon_renderer::{Gpu, GpuOptions, RenderError, RenderSettings};
use gnomon_scene::{Camera, Ground};
use gnomon_scene_files::EnvironmentSource;
use gnomon_studio::{
    CameraLook, Look, Project, SceneSource, Stage, Studio, StudioError, Update, environment_named,
};
use gnomon_testing::tolerances::GPU_RELATIVE_RMSE;

const SIZE: [u32; 2] = [96, 72];

fn gpu() -> Option<Gpu> {
    match Gpu::new(&GpuOptions::default()) {
        Ok(gpu) => Some(gpu),
        Err(RenderError::NoAdapter { .. } | RenderError::MissingFeature { .. }) => {
            gnomon_testing::skip("no usable graphics adapter");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

fn base() -> Look {
    let mut look = Look { map: Some(environment_named("room")), ..Look::default() };
    look.fit.light_count = Some(12);
    look.lighting.ambient_cells = 8;
    look.techniques.shadow_resolution = 64;
    look.techniques.supersample = 1;
    look.picture.size = SIZE;
    look
}

fn project(look: &Look) -> Project {
    let mut project = Project::open("three-boxes", base(), &Given::default()).unwrap();
    project.look = look.clone();
    project
}

fn picture(studio: &mut Studio) -> (RgbImage, Vec<[u8; 4]>) {
    let frame = studio.frame(SIZE[0], SIZE[1]).unwrap();
    (frame.radiance, frame.display)
}

#[test]
fn the_default_look_is_the_default_settings() {
    let settings = Look::default().settings(0.0);
    assert_eq!(settings, RenderSettings::default().with(|s| s.display.exposure = Some(0.0)));
    let text = toml::to_string(&Look::default()).unwrap();
    assert_eq!(toml::from_str::<Look>(&text).unwrap(), Look::default());
}

type Edit = (&'static str, fn(&mut Look));

const EDITS: [Edit; 11] = [
    ("nothing", |_| {}),
    ("exposure", |look| look.display.exposure = Some(1.5)),
    ("tone mapping", |look| look.display.tone_mapping = ToneMapping::Linear),
    ("camera", |look| {
        let camera: Camera = "eye=2,4,3; target=0,0.5,0; fov=50".parse().unwrap();
        look.camera = CameraLook::Free(camera);
    }),
    ("rotation, strength and tint", |look| {
        look.environment.rotation = 77.0;
        (look.environment.strength, look.environment.tint) = (1.7, [1.0, 0.9, 0.7]);
    }),
    ("technique", |look| look.techniques.shadows = "pcf".to_owned()),
    ("reflectance", |look| look.reflectance = Some("phong:shininess=30,specular=0.4".parse().unwrap())),
    ("one surface", |look| {
        let surface = Surface { base_color: Vec3::new(0.9, 0.1, 0.1), ..Surface::default() };
        look.set_surface(0, &surface).unwrap();
    }),
    ("fit", |look| look.fit.method = "disks".to_owned()),
    ("ambient rest", |look| look.lighting.ambient = "occlusion".to_owned()),
    ("environment", |look| look.map = Some(environment_named("sky"))),
];

#[test]
fn a_look_set_live_gives_the_picture_of_one_opened_with_it() {
    let Some(gpu) = gpu() else { return };
    let mut live = Studio::new(&gpu, Stage::new(project(&base())).unwrap()).unwrap();
    let mut last = None;
    for (name, edit) in EDITS {
        // One after the other, so that each starts from what the one before left.
        live.edit(edit).unwrap();
        let failed = live.wait().into_iter().find(|update| matches!(update, Update::Failed(_)));
        assert!(failed.is_none(), "{name}: {failed:?}");
        let shown = picture(&mut live);
        let fresh = Stage::new(project(live.look())).unwrap();
        let opened = picture(&mut Studio::new(&gpu, fresh).unwrap());
        assert!(shown == opened, "{name}: the live picture is another");
        assert!(name == "nothing" || last.as_ref() != Some(&shown), "{name} changes nothing");
        last = Some(shown);
    }
    // And all the way back.
    live.set_look(base()).unwrap();
    live.wait();
    let mut opened = Studio::new(&gpu, Stage::new(project(&base())).unwrap()).unwrap();
    assert!(picture(&mut live) == picture(&mut opened));
}

#[test]
fn a_ground_laid_or_taken_away_live_has_lights_fitted_for_it() {
    let Some(gpu) = gpu() else { return };
    let bare = |look: &Look| {
        let mut project = project(look);
        // Without the ground of its own.
        project.scene.ground = None;
        project
            .scene
            .nodes
            .iter_mut()
            .filter(|node| node.name == "ground")
            .for_each(|node| node.meshes.clear());
        Stage::new(project).unwrap()
    };
    let mut look = base();
    look.fit.light_count = Some(40);
    let mut live = Studio::new(&gpu, bare(&look)).unwrap();
    for ground in [Ground::None, Ground::Plane, Ground::None] {
        live.edit(|look| look.scene.ground = ground).unwrap();
        live.wait();
        look.scene.ground = ground;
        let mut opened = Studio::new(&gpu, bare(&look)).unwrap();
        assert_eq!(live.stage().stands_on_ground(), ground == Ground::Plane);
        assert_eq!(live.lights().parameters["ground"], ground == Ground::Plane);
        assert!(picture(&mut live) == picture(&mut opened), "{ground:?}: the live picture is another");
    }
}

#[test]
fn what_cannot_be_leaves_everything_as_it_was() {
    let Some(gpu) = gpu() else { return };
    let mut studio = Studio::new(&gpu, Stage::new(project(&base())).unwrap()).unwrap();
    let before = picture(&mut studio);
    let refused: [Edit; 11] = [
        ("technique", |look| look.techniques.shadows = "candles".to_owned()),
        ("'light_count'", |look| look.fit.light_count = Some(0)),
        ("fit", |look| look.fit.method = "candles".to_owned()),
        ("texels", |look| look.techniques.shadow_resolution = 100),
        ("memory", |look| {
            look.techniques.shadow_memory = 1;
            look.techniques.shadow_resolution = 4096;
        }),
        ("material", |look| drop(look.surfaces.insert(99, "lambert".parse().unwrap()))),
        ("camera", |look| look.camera = CameraLook::Named("absent".to_owned())),
        ("clip", |look| look.animation.clip = Some("absent".to_owned())),
        ("time", |look| look.animation.time = f32::NAN),
        ("rotation", |look| look.environment.rotation = f32::NAN),
        ("exposure", |look| look.display.exposure = Some(f32::INFINITY)),
    ];
    let scene = Arc::clone(studio.stage().scene());
    for (name, edit) in refused {
        // With what is good, none of which is taken over either.
        for with_more in [false, true] {
            let edited = studio.edit(|look| {
                if with_more {
                    look.reflectance = Some("phong:shininess=30,specular=0.4".parse().unwrap());
                    look.scene.ground = Ground::Plane;
                    look.fit.light_count = Some(20);
                    look.environment.rotation = 90.0;
                    look.display.tone_mapping = ToneMapping::Linear;
                }
                edit(look);
            });
            let error = edited.unwrap_err().to_string();
            assert!(!error.contains('\n'), "{name}: {error}");
            assert_eq!(studio.look(), &base(), "{name}");
            assert!(Arc::ptr_eq(&scene, studio.stage().scene()) && !studio.is_busy(), "{name}");
            assert!(picture(&mut studio) == before, "{name}");
        }
    }
    assert!(studio.take_warnings().is_empty());
    // What only a thread finds out.
    let absent = EnvironmentSource::File(PathBuf::from("absent.hdr"));
    studio.edit(|look| look.map = Some(absent)).unwrap();
    assert!(picture(&mut studio) == before, "frames go on");
    let updates = studio.wait();
    assert!(matches!(&updates[..], [Update::Failed(StudioError::Request(_))]), "{updates:?}");
    assert_eq!(studio.look(), &base());
    studio.load_scene(SceneSource::File(PathBuf::from("absent.glb")));
    assert!(matches!(&studio.wait()[..], [Update::Failed(_)]));
    assert!(picture(&mut studio) == before);
}

#[test]
fn another_scene_is_loaded_on_a_thread_and_keeps_the_look() {
    let Some(gpu) = gpu() else { return };
    let mut studio = Studio::new(&gpu, Stage::new(project(&base())).unwrap()).unwrap();
    let before = picture(&mut studio);
    studio.edit(|look| look.scene.ground = Ground::Plane).unwrap();
    studio.load_scene(SceneSource::Builtin("column".to_owned()));
    studio.edit(|look| look.display.exposure = Some(0.7)).unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    let mut updates = Vec::new();
    while updates.is_empty() && Instant::now() < deadline {
        updates = studio.poll();
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(matches!(&updates[..], [Update::Scene]), "{updates:?}");
    assert_eq!(studio.look().fit, base().fit);
    let mut column = Project::open("column", base(), &Given::default()).unwrap();
    column.look = base();
    column.look.display.exposure = Some(0.7);
    let mut opened = Studio::new(&gpu, Stage::new(column).unwrap()).unwrap();
    let shown = picture(&mut studio);
    assert!(shown == picture(&mut opened) && shown != before);
}

#[test]
fn a_scene_whose_lights_do_not_fit_leaves_the_one_before_lit() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let text = "[camera]\neye = [3, 2, 1]\ntarget = [0, 0, 0]\nfov = 40\n[[model]]\nbuiltin = \"column\"\n\
        [[light]]\nshape = \"sphere\"\nradius = 0.1\nposition = [0, 4, 0]\nradiance = [3, 2, 1]\n";
    let path = folder.path().join("lit.toml");
    std::fs::write(&path, text).unwrap();
    let mut look = base();
    // Enough for the wide lights of the environment, not for a small one at full resolution.
    look.fit.method = "none".to_owned();
    (look.techniques.shadow_memory, look.techniques.shadow_resolution) = (8, 2048);
    let mut studio = Studio::new(&gpu, Stage::new(project(&look)).unwrap()).unwrap();
    let before = picture(&mut studio);
    studio.load_scene(SceneSource::File(path));
    let updates = studio.wait();
    assert!(
        matches!(&updates[..], [Update::Failed(StudioError::Render(RenderError::OverBudget { .. }))]),
        "{updates:?}"
    );
    assert!(picture(&mut studio) == before && studio.look() == &look);
}

#[test]
fn the_reference_converges_and_starts_anew_when_something_changes() {
    let Some(gpu) = gpu() else { return };
    let mut studio = Studio::new(&gpu, Stage::new(project(&base())).unwrap()).unwrap();
    let deadline = Instant::now() + Duration::from_secs(120);
    let until = |studio: &mut Studio, samples: u32| loop {
        studio.converge(SIZE[0], SIZE[1]).unwrap();
        let so_far = studio.reference().unwrap();
        if let Some(picture) = so_far.filter(|picture| picture.samples_per_pixel >= samples) {
            return picture;
        }
        assert!(Instant::now() < deadline);
        std::thread::sleep(Duration::from_millis(5));
    };
    assert!(studio.reference().unwrap().is_none());
    let (first, later) = (until(&mut studio, 8), until(&mut studio, 64));
    assert!(later.noise < first.noise && later.noise > 0.0, "{} {}", first.noise, later.noise);
    let (drawn, _) = picture(&mut studio);
    let error = later.relative_rmse(&drawn).unwrap();
    // Twelve lights and eight cells in maps of 64 texels are coarse.
    assert!(error < 2.0 * GPU_RELATIVE_RMSE + later.noise, "{error}");
    assert_eq!(later.difference(&drawn).unwrap().width(), SIZE[0]);

    // Turned: another picture, and as near to that of the GPU.
    studio.edit(|look| look.environment.rotation = 120.0).unwrap();
    studio.converge(SIZE[0], SIZE[1]).unwrap();
    assert!(studio.reference().unwrap().is_none_or(|anew| anew.samples_per_pixel < later.samples_per_pixel));
    let turned = until(&mut studio, 64);
    assert!(
        turned.relative_rmse(&drawn).unwrap() > 2.0 * error,
        "the planted fault: an environment that was not turned"
    );
    let (drawn, _) = picture(&mut studio);
    let error = turned.relative_rmse(&drawn).unwrap();
    assert!(error < 2.0 * GPU_RELATIVE_RMSE + turned.noise, "{error}");
    let refused = loop {
        studio.converge(0, 4).unwrap();
        match studio.reference() {
            Err(error) => break error.to_string(),
            Ok(_) => assert!(Instant::now() < deadline),
        }
    };
    assert!(refused.contains("empty"), "{refused}");
    studio.stop_converging();
    assert!(studio.reference().unwrap().is_none());
}

/// A reference that is being traced holds the scene, so that it cannot be changed in place.
#[test]
fn a_look_that_is_set_while_the_scene_is_held_copies_no_mesh() {
    let mut project = project(&base());
    // As files without materials bring it.
    for mesh in &mut project.scene.meshes {
        Arc::make_mut(mesh).material = None;
    }
    project.look.reflectance = Some("lambert".parse().unwrap());
    let mut stage = Stage::new(project).unwrap();
    let edits: [Edit; 4] = [
        ("reflectance", |look| look.reflectance = Some("phong:shininess=30,specular=0.4".parse().unwrap())),
        ("one surface", |look| drop(look.surfaces.insert(0, "lambert".parse().unwrap()))),
        ("time", |look| look.animation.time = 1.0),
        ("nothing", |look| look.surfaces.clear()),
    ];
    for (name, edit) in edits {
        let held = Arc::clone(stage.scene());
        let mut look = stage.look().clone();
        edit(&mut look);
        stage.set_look(look).unwrap();
        assert!(!Arc::ptr_eq(&held, stage.scene()), "{name}");
        let mut meshes = held.meshes.iter().zip(&stage.scene().meshes);
        assert!(meshes.all(|(before, after)| Arc::ptr_eq(before, after)), "{name} copies meshes");
    }
}

/// Also where lights stay, and where an interior's are worked out anew.
#[test]
fn another_stage_gives_the_picture_of_a_new_session() {
    let Some(gpu) = gpu() else { return };
    let stage = |change: &dyn Fn(&mut Project)| {
        let mut project = project(&base());
        change(&mut project);
        Stage::new(project).unwrap()
    };
    let first = stage(&|_| {});
    let moved = {
        let mut project = project(&base());
        project.scene = gnomon_scene::Scene::clone(first.scene());
        project.scene.nodes[1].parent_from_node.translation.x += 0.3;
        project.look.environment.rotation = 20.0;
        Stage::under(project, first.surroundings().clone(), Vec::new()).unwrap()
    };
    let other_light = stage(&|project| project.look.set_environment(environment_named("sky")));
    let other_techniques = stage(&|project| project.look.techniques.shadows = "rays".to_owned());
    let mut studio = Studio::new(&gpu, first.clone()).unwrap();
    for stage in [&moved, &other_light, &other_techniques, &first] {
        studio.set_stage(stage.clone()).unwrap();
        assert_eq!(studio.look(), stage.look());
        let opened = picture(&mut Studio::new(&gpu, stage.clone()).unwrap());
        assert!(picture(&mut studio) == opened);
    }
    let lights = std::ptr::from_ref(studio.lights());
    studio.set_stage(moved).unwrap();
    assert_eq!(std::ptr::from_ref(studio.lights()), lights, "the lights of the same environment stay");
    studio.set_stage(first).unwrap();
    let before = picture(&mut studio);
    let refused = stage(&|project| {
        (project.look.techniques.shadow_memory, project.look.techniques.shadow_resolution) = (1, 4096);
    });
    assert!(matches!(studio.set_stage(refused), Err(StudioError::Render(RenderError::OverBudget { .. }))));
    assert!(picture(&mut studio) == before);
}
