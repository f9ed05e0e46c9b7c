//! Whole pictures against ray-traced truth: Mitsuba's, and the project's own reference tracer.

use std::path::Path;

use crate::common::*;
use gnomon_envmap::Equirect;
use gnomon_lights::{FitOptions, LightSet};
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_reference::ReferenceOptions;
use gnomon_renderer::RenderSettings;
use gnomon_testing::tolerances;

/// The default, and the method of Annen et al. 2008.
const SOFT: [&str; 2] = ["pcss", "convolution"];

fn fit(map: &Equirect) -> LightSet {
    fit_by("partition", FitOptions { light_count: Some(tolerances::GPU_LIGHTS), ..Default::default() }, map)
}

fn fit_by(method: &str, options: FitOptions, map: &Equirect) -> LightSet {
    gnomon_lights::fit::by_name(method, &options).unwrap().fit(map).unwrap()
}

/// Relative RMSE of pictures against Mitsuba's: of the command's default, and of every soft technique with many lights of a simple fit.
fn against_mitsuba(scene: &str, environment: &str, truth: &str) {
    let Some((gpu, scene, camera, map, truth)) = of_mitsuba(scene, environment, truth) else { return };
    let set = fit(&map);
    assert!(set.lights.len() <= tolerances::GPU_LIGHTS);
    let error = |settings: RenderSettings, set: &LightSet| {
        let frame = render(&gpu, settings, &scene, &map, set, &camera, [truth.width(), truth.height()]);
        compare(&frame.radiance, &truth, None).unwrap().relative_rmse
    };
    let by = |shadows: &str| RenderSettings::default().with(|s| s.techniques.shadows = shadows.to_owned());
    let options = FitOptions { ground: scene.stands_on_ground(), ..Default::default() };
    let default = fit_by("optimized", options, &map);
    let of_default = error(RenderSettings::default(), &default);
    println!("{} lights, the default: {of_default:.4}", default.lights.len());
    assert!(of_default <= tolerances::GPU_DEFAULT_RELATIVE_RMSE_AT_256, "{of_default}");
    let none = error(by("none"), &set);
    for shadows in SOFT {
        let soft = error(by(shadows), &set);
        println!("{} lights: {shadows} {soft:.4}, no shadows {none:.4}", set.lights.len());
        assert!(soft <= tolerances::GPU_RELATIVE_RMSE_AT_256, "{shadows}: {soft}");
    }
    // Without shadows the same gate must fail, or it would not be looking.
    assert!(none > 2.0 * tolerances::GPU_RELATIVE_RMSE_AT_256, "{none}");
}

#[test]
fn three_boxes_under_galileo() {
    against_mitsuba("three_boxes", "galileo", "three_boxes_galileo");
}

#[test]
fn three_boxes_under_grace() {
    against_mitsuba("three_boxes", "grace", "three_boxes_grace");
}

#[test]
fn bunny_under_st_peters() {
    against_mitsuba("bunny_on_ground", "stpeters", "bunny_flat_stpeters");
}

#[test]
fn few_optimized_lights_are_better_than_a_partition_s() {
    let Some((gpu, scene, camera, map, truth)) = of_mitsuba("three_boxes", "grace", "three_boxes_grace")
    else {
        return;
    };
    let error = |method: &str| {
        let options = FitOptions { light_count: Some(30), ground: true, ..Default::default() };
        let set = fit_by(method, options, &map);
        let size = [truth.width(), truth.height()];
        let frame = render(&gpu, RenderSettings::default(), &scene, &map, &set, &camera, size);
        compare(&frame.radiance, &truth, None).unwrap().relative_rmse
    };
    let (partition, optimized) = (error("partition"), error("optimized"));
    println!("30 lights: partition {partition:.4}, optimized {optimized:.4}");
    assert!(optimized <= tolerances::OPTIMIZED_ERROR_RATIO * partition, "{optimized} {partition}");
}

/// Built-in scenes under built-in environments, against the reference tracer: needs no external data.
#[test]
fn built_in_scenes_against_the_reference() {
    let Some(gpu) = gpu_or_skip() else { return };
    for (scene, environment) in [("three-boxes", "room"), ("column", "sky")] {
        let scene = gnomon_scene::builtin::by_name(scene).unwrap();
        let camera = scene.cameras[0].clone();
        let map = gnomon_envmap::builtin::sized(environment, 256, 128).unwrap();
        let set = fit(&map);
        let options = ReferenceOptions { width: 96, height: 72, samples_per_pixel: 64, ..Default::default() };
        let truth = gnomon_reference::render(&scene, &camera, &map, &options).unwrap().mean;
        let error = |shadows: &str| {
            let settings = RenderSettings::default().with(|s| s.techniques.shadows = shadows.to_owned());
            let frame = render(&gpu, settings, &scene, &map, &set, &camera, [96, 72]);
            // The sun's disk in the background would drown the picture it lights.
            let lit = |picture: &RgbImage| {
                RgbImage::from_fn(96, 72, |x, y| picture.get(x, y).min(glam::Vec3::splat(4.0 * mean(&truth))))
            };
            compare(&lit(&frame.radiance), &lit(&truth), None).unwrap().relative_rmse
        };
        let none = error("none");
        for shadows in SOFT {
            let soft = error(shadows);
            println!("{environment}: {shadows} {soft:.4}, no shadows {none:.4}");
            assert!(soft <= tolerances::GPU_RELATIVE_RMSE, "{environment}, {shadows}: {soft}");
            assert!(none > 1.5 * soft, "{environment}, {shadows}: {none} against {soft}");
        }
    }
}

fn mean(picture: &RgbImage) -> f32 {
    let sum: glam::Vec3 = picture.texels().iter().copied().sum();
    sum.element_sum() / (3 * picture.texels().len()) as f32
}

/// What the renderer drew when the picture was last looked at. `GNOMON_UPDATE_GOLDENS=1` writes the files anew.
#[test]
fn goldens() {
    let Some(gpu) = gpu_or_skip() else { return };
    for (scene, environment, method, compositing) in [
        ("three-boxes", "room", "partition", "ratio"),
        ("three-boxes", "sky", "disks", "additive"),
        ("column", "room", "squares", "subtractive"),
    ] {
        let scene_name = scene;
        let scene = gnomon_scene::builtin::by_name(scene).unwrap();
        let map = gnomon_envmap::builtin::sized(environment, 256, 128).unwrap();
        let set =
            gnomon_lights::fit::by_name(method, &FitOptions { light_count: Some(16), ..Default::default() });
        let set = set.unwrap().fit(&map).unwrap();
        let settings = RenderSettings::default().with(|s| {
            s.techniques.shadows = "convolution".to_owned();
            s.techniques.compositing = compositing.to_owned();
            s.techniques.supersample = 2;
            s.techniques.shadow_sampling = 1;
        });
        let frame = render(&gpu, settings, &scene, &map, &set, &scene.cameras[0], [96, 72]);
        let name = format!("{scene_name}_{environment}_{method}_{compositing}.exr");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(&name);
        if std::env::var_os("GNOMON_UPDATE_GOLDENS").is_some() {
            gnomon_picture::write(&path, &frame.radiance).unwrap();
        }
        let golden =
            gnomon_picture::read(&path).unwrap_or_else(|error| panic!("golden {name}: {error}")).image;
        let error = compare(&frame.radiance, &golden, None).unwrap().relative_rmse;
        assert!(error <= tolerances::GOLDEN_RELATIVE_RMSE, "{name}: {error}");
    }
}
