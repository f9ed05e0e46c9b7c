//! Whole pictures against Mitsuba 3 (`reference/renders.json`): direct light only, Lambert 0.5, flat normals.
//!
//! `GNOMON_REFERENCE_SPP` sets the samples (64 unless told otherwise), `GNOMON_REFERENCE_OUT` a folder for pictures.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]
#![allow(clippy::print_stdout, reason = "the figures are what one runs this for")]

use std::time::Instant;

use glam::Vec3;
use gnomon_envmap::Equirect;
use gnomon_metrics::{Comparison, compare, signed_difference, z_test};
use gnomon_picture::tonemap::tone_mapped;
use gnomon_picture::{RgbImage, ToneMapping};
use gnomon_reference::{Estimate, ReferenceOptions, render};
use gnomon_scene::{Camera, Projection};
use gnomon_scene_files::LoadOptions;
use gnomon_testing::data_file;
use gnomon_testing::tolerances::{REFERENCE_MEAN, REFERENCE_RELATIVE_RMSE, Z_TEST_LIMIT, Z_TEST_PASSING};
use serde_json::Value;

/// Rows for each of the map's when it is resampled.
const FINER: u32 = 8;

struct Case {
    estimate: Estimate,
    truth: RgbImage,
    /// Square of Mitsuba's standard error of every pixel.
    truth_variance: RgbImage,
}

fn vector(value: &Value) -> Vec3 {
    let component = |i: usize| value[i].as_f64().unwrap() as f32;
    Vec3::new(component(0), component(1), component(2))
}

/// The map as Mitsuba reads it: its first and last rows of texels lie *on* the poles (`v (height - 1)` in `envmap.cpp`), where
/// the project's lie half a texel off. Resampled finely enough for the interpolation between texels to stay.
fn mitsuba_rows(map: &Equirect) -> Equirect {
    let (width, height) = (map.width(), map.height());
    let fine = FINER * height;
    let rows = RgbImage::from_fn(width, fine, |x, y| {
        let place = (y as f32 + 0.5) / fine as f32 * (height - 1) as f32;
        let row = (place as u32).min(height - 2);
        map.radiance().get(x, row).lerp(map.radiance().get(x, row + 1), place - row as f32)
    });
    Equirect::new(rows)
}

fn samples_per_pixel(default: u32) -> u32 {
    std::env::var("GNOMON_REFERENCE_SPP").ok().map_or(default, |samples| samples.parse().unwrap())
}

/// Renders the scene of a Mitsuba picture by the camera of the scene's own file, under a changed map.
fn run(picture: &str, glb: &str, samples_per_pixel: u32, change: fn(Equirect) -> Equirect) -> Option<Case> {
    let renders = data_file("reference/renders.json")?;
    let renders: Value = serde_json::from_slice(&std::fs::read(renders).unwrap()).unwrap();
    let entry = renders["images"].as_array().unwrap().iter().find(|image| image["file"] == picture).unwrap();
    let truth = gnomon_picture::read(data_file(&format!("reference/{picture}"))?).unwrap().image;
    let environment = data_file(&format!("reference/{}", entry["env"].as_str().unwrap()))?;
    let environment = change(Equirect::new(gnomon_picture::read(environment).unwrap().image));
    let path = data_file(&format!("scenes/{glb}"))?;
    let scene = gnomon_scene_files::load(&path, &LoadOptions::default()).unwrap().scene;
    check_camera(&scene.cameras[0], &entry["camera"]);

    let options = ReferenceOptions {
        width: truth.width(),
        height: truth.height(),
        samples_per_pixel,
        ..ReferenceOptions::default()
    };
    let start = Instant::now();
    let estimate = render(&scene, &scene.cameras[0], &environment, &options).unwrap();
    println!("{picture}: {samples_per_pixel} samples in {:.1} s", start.elapsed().as_secs_f64());

    // The file gives the median of the relative standard error; the noise is taken as proportional to the pixel.
    let relative = entry["median_rel_stderr"].as_f64().unwrap() as f32;
    let truth_variance = RgbImage::from_fn(truth.width(), truth.height(), |x, y| {
        let error = relative * truth.get(x, y);
        error * error
    });
    Some(Case { estimate, truth, truth_variance })
}

/// The scene file and Mitsuba's record must mean the same view.
fn check_camera(camera: &Camera, record: &Value) {
    let fov_x = (record["fov_x_deg"].as_f64().unwrap() as f32).to_radians();
    let expected = Camera::look_at(vector(&record["origin"]), vector(&record["target"]), fov_x);
    assert!(camera.world_from_camera.abs_diff_eq(expected.world_from_camera, 1e-5), "{camera:?}");
    let Projection::Perspective { fov_x: found } = camera.projection else { panic!("{camera:?}") };
    assert!((found - fov_x).abs() < 1e-5, "{found} {fov_x}");
}

/// Largest relative difference of the channels' means.
fn mean_error(comparison: &Comparison) -> f64 {
    (0..3).map(|c| (comparison.mean[c] / comparison.reference_mean[c] - 1.0).abs()).fold(0.0, f64::max)
}

/// Pixel by pixel, under Mitsuba's own reading of the map: nothing but noise may be left.
fn check(picture: &str, glb: &str) {
    let change = |map: Equirect| mitsuba_rows(&map);
    let Some(case) = run(picture, glb, samples_per_pixel(64), change) else { return };
    let Case { estimate, truth, truth_variance } = case;
    let comparison = compare(&estimate.mean, &truth, None).unwrap();
    let z = z_test((&estimate.mean, &estimate.variance), (&truth, &truth_variance), Z_TEST_LIMIT).unwrap();
    println!(
        "{picture}: mean off by {:.3} %, relative RMSE {:.4}, z-test {:.3} % of pixels (mean z^2 {:.2}), worst {:?}",
        100.0 * mean_error(&comparison),
        comparison.relative_rmse,
        100.0 * z.passing,
        z.mean_square,
        comparison.worst,
    );
    if let Ok(folder) = std::env::var("GNOMON_REFERENCE_OUT") {
        write_pictures(&folder, picture.trim_end_matches(".exr"), &estimate.mean, &truth);
    }
    assert!(
        mean_error(&comparison) <= REFERENCE_MEAN,
        "{picture}: the mean is off by {}",
        mean_error(&comparison)
    );
    assert!(z.passing >= Z_TEST_PASSING, "{picture}: {z:?}");
    assert!(estimate.samples_per_pixel < 1024 || comparison.relative_rmse <= REFERENCE_RELATIVE_RMSE);

    // Planted fault: 5 % too bright must not pass.
    let brighter = RgbImage::from_fn(truth.width(), truth.height(), |x, y| 1.05 * estimate.mean.get(x, y));
    let z = z_test((&brighter, &estimate.variance), (&truth, &truth_variance), Z_TEST_LIMIT).unwrap();
    assert!(z.passing < Z_TEST_PASSING, "{z:?}");
}

/// The project's own reading of the map, half a texel off towards the poles, leaves the mean within tolerance.
fn check_own_rows(picture: &str, glb: &str) {
    let Some(Case { estimate, truth, .. }) = run(picture, glb, samples_per_pixel(16), |map| map) else {
        return;
    };
    let comparison = compare(&estimate.mean, &truth, None).unwrap();
    println!(
        "{picture}, own rows: mean off by {:.3} %, relative RMSE {:.4}",
        100.0 * mean_error(&comparison),
        comparison.relative_rmse
    );
    assert!(
        mean_error(&comparison) <= REFERENCE_MEAN,
        "{picture}: the mean is off by {}",
        mean_error(&comparison)
    );
    assert!(estimate.samples_per_pixel < 1024 || comparison.relative_rmse <= REFERENCE_RELATIVE_RMSE);
}

fn write_pictures(folder: &str, name: &str, ours: &RgbImage, truth: &RgbImage) {
    let shown = |image: &RgbImage| tone_mapped(image, ToneMapping::Neutral, 0.0);
    let difference = signed_difference(ours, truth, 0.1).unwrap();
    for (suffix, image) in [("ours", shown(ours)), ("mitsuba", shown(truth)), ("difference", difference)] {
        gnomon_picture::write(format!("{folder}/{name}_{suffix}.png"), &image).unwrap();
    }
}

#[test]
fn three_boxes_under_galileo() {
    check("three_boxes_galileo.exr", "three_boxes.glb");
}

#[test]
fn three_boxes_under_grace() {
    check("three_boxes_grace.exr", "three_boxes.glb");
}

#[test]
fn bunny_under_st_peters() {
    check("bunny_flat_stpeters.exr", "bunny_on_ground.glb");
}

#[test]
fn means_hold_under_the_projects_own_rows() {
    check_own_rows("three_boxes_galileo.exr", "three_boxes.glb");
    check_own_rows("three_boxes_grace.exr", "three_boxes.glb");
    check_own_rows("bunny_flat_stpeters.exr", "bunny_on_ground.glb");
}
