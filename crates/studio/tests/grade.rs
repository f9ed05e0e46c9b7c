//! Strength and tint of an environment: factors of its radiance, for which nothing is made anew.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::path::Path;

use glam::Vec3;
use gnomon_envmap::Grade;
use gnomon_lights::LightSet;
use gnomon_options::Given;
use gnomon_picture::RgbImage;
use gnomon_reference::{ReferenceOptions, render};
use gnomon_renderer::{Gpu, GpuOptions, RenderError};
use gnomon_studio::{Look, Project, Stage, Studio, Surroundings, environment_named};
use gnomon_testing::tolerances;

const SIZE: [u32; 2] = [64, 48];

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

fn project(scene: &str, environment: &str, change: impl FnOnce(&mut Look)) -> Project {
    let mut look = Look { map: Some(environment_named(environment)), ..Look::default() };
    look.fit.light_count = Some(12);
    look.lighting.ambient_cells = 8;
    look.techniques.shadow_resolution = 64;
    look.picture.size = SIZE;
    change(&mut look);
    let mut project = Project::open(scene, Look::default(), &Given::default()).unwrap();
    project.look = look;
    project
}

/// Three walls, floor and ceiling about a box: less than half of the sky is open.
fn room(folder: &Path) -> String {
    let path = folder.join("room.obj");
    let corners = |half: f32, y: f32| -> String {
        let corner = |i: u32| {
            let side = |bit: u32| if i >> bit & 1 == 1 { half } else { -half };
            format!("v {} {} {}\n", side(0), side(1) + y, side(2))
        };
        (0..8).map(corner).collect()
    };
    let faces = "f 1 3 4 2\nf 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\n\
        f 9 11 12 10\nf 9 13 15 11\nf 10 12 16 14\nf 13 14 16 15\nf 11 15 16 12\n";
    std::fs::write(&path, corners(1.0, 0.0) + &corners(0.25, -0.7) + faces).unwrap();
    path.to_string_lossy().into_owned()
}

fn drawn(studio: &mut Studio) -> RgbImage {
    studio.frame(SIZE[0], SIZE[1]).unwrap().radiance
}

/// Waits for nothing: what is made anew would come later.
fn drawn_with(studio: &mut Studio, strength: f32, tint: [f32; 3]) -> RgbImage {
    let lights: *const LightSet = studio.lights();
    studio.edit(|look| (look.environment.strength, look.environment.tint) = (strength, tint)).unwrap();
    assert!(!studio.is_busy() && studio.poll().is_empty(), "lights are fitted");
    assert_eq!(std::ptr::from_ref(studio.lights()), lights, "other lights were fitted");
    drawn(studio)
}

fn times(picture: &RgbImage, factor: Vec3) -> RgbImage {
    RgbImage::from_fn(picture.width(), picture.height(), |x, y| picture.get(x, y) * factor)
}

fn glossy(look: &mut Look) {
    look.reflectance = Some("metallic-roughness:roughness=0.3,metallic=0.5".parse().unwrap());
}

/// Every way that an environment lights a picture.
fn projects(folder: &Path) -> Vec<(&'static str, Project)> {
    let boxes = |change: fn(&mut Look)| project("three-boxes", "room", change);
    vec![
        ("matte", boxes(|_| {})),
        ("a sun", project("column", "sky", |_| {})),
        ("traced gloss", boxes(glossy)),
        ("gloss by prefiltered maps", {
            boxes(|look| {
                glossy(look);
                look.techniques.shadows = "none".to_owned();
                look.techniques.unshadowed = "prefiltered".to_owned();
            })
        }),
        ("gloss by the radiance cache", {
            boxes(|look| {
                glossy(look);
                look.techniques.shadows = "none".to_owned();
                look.techniques.unshadowed = "cache".to_owned();
            })
        }),
        ("gloss of lights", {
            boxes(|look| {
                glossy(look);
                look.techniques.gloss = gnomon_renderer::GlossPath::Lights;
            })
        }),
        ("rest as it is", {
            boxes(|look| {
                glossy(look);
                look.lighting.ambient = "unshadowed".to_owned();
                look.techniques.compositing = "additive".to_owned();
                look.techniques.gloss = gnomon_renderer::GlossPath::Lights;
            })
        }),
        ("spherical harmonics", boxes(|look| look.techniques.unshadowed = "sh".to_owned())),
        ("bright texels as lights", {
            project("three-boxes", "sky", |look| {
                glossy(look);
                look.environment.clamp = Some(10.0);
            })
        }),
        ("an interior", project(&room(folder), "sky", |look| look.environment.rotation = 180.0)),
    ]
}

/// Bit by bit: powers of two change no rounding. A tint weighs the directions of a lobe and the rays to a light otherwise, where these follow luminance.
#[test]
fn radiance_follows_strength_and_tint() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let tint = [0.25, 1.0, 1.5];
    for (name, project) in projects(folder.path()) {
        let mut studio = Studio::new(&gpu, Stage::new(project).unwrap()).unwrap();
        let plain = drawn(&mut studio);
        assert!(plain.texels().iter().any(|texel| *texel != Vec3::ZERO), "{name} is dark");
        assert_eq!(studio.lights().omits_hidden, name == "an interior");
        let double = drawn_with(&mut studio, 2.0, [1.0; 3]);
        assert!(double == times(&plain, Vec3::splat(2.0)), "{name}: not twice the radiance");
        let tinted = drawn_with(&mut studio, 1.0, tint);
        let error = gnomon_metrics::relative_rmse(&tinted, &times(&plain, Vec3::from(tint))).unwrap();
        assert!(error <= tolerances::TINT, "{name}: {error}");
        assert!(drawn_with(&mut studio, 1.0, [1.0; 3]) == plain, "{name}: the way back");
    }
}

/// The reference follows, and a background of its own stays as it is.
#[test]
fn the_reference_and_what_is_seen_behind_the_scene_follow() {
    let options =
        ReferenceOptions { width: 16, height: 12, samples_per_pixel: 16, ..ReferenceOptions::default() };
    let folder = tempfile::tempdir().unwrap();
    let green = folder.path().join("green.exr");
    gnomon_picture::write(&green, &RgbImage::filled(8, 4, Vec3::Y)).unwrap();
    let seen = |strength: f32, background: bool| {
        let mut project = project("three-boxes", "sky", |look| {
            look.environment.strength = strength;
            look.environment.clamp = Some(10.0);
        });
        if background {
            project.look.environment.background_map = Some(green.to_string_lossy().into_owned());
        }
        let stage = Stage::new(project).unwrap();
        let (scene, camera) = stage.for_reference().unwrap();
        let traced = render(&scene, &camera, stage.sky(), &options).unwrap().mean;
        let shown = gpu().map(|gpu| drawn(&mut Studio::new(&gpu, stage).unwrap()));
        (traced, shown)
    };
    let (plain, _) = seen(1.0, false);
    assert!(seen(2.0, false).0 == times(&plain, Vec3::splat(2.0)));
    let (traced, shown) = seen(4.0, true);
    let pictures = [Some(traced), shown];
    for picture in pictures.iter().flatten() {
        assert_eq!(picture.get(0, 0), Vec3::Y, "a background of its own is graded");
    }
}

/// Of the same surroundings, as those of a data set's items.
#[test]
fn another_stage_of_another_strength_keeps_the_lights() {
    let Some(gpu) = gpu() else { return };
    let first = Stage::new(project("three-boxes", "room", glossy)).unwrap();
    let strong = project("three-boxes", "room", |look| {
        glossy(look);
        (look.environment.strength, look.environment.tint) = (0.7, [1.0, 0.8, 0.6]);
    });
    let surroundings: Surroundings = first.surroundings().clone();
    let strong = Stage::under(strong, surroundings, Vec::new()).unwrap();
    assert_ne!(strong.grade(), Grade::NONE);
    let mut studio = Studio::new(&gpu, first).unwrap();
    let before = drawn(&mut studio);
    let lights: *const LightSet = studio.lights();
    studio.set_stage(strong.clone()).unwrap();
    assert_eq!(std::ptr::from_ref(studio.lights()), lights, "other lights were fitted");
    let opened = drawn(&mut Studio::new(&gpu, strong).unwrap());
    let shown = drawn(&mut studio);
    assert!(shown == opened && shown != before);
}
