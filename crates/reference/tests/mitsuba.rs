//! Whole pictures against Mitsuba 3 (`reference/renders.json`): direct light only, Lambert 0.5, flat normals.
//!
//! `GNOMON_REFERENCE_SPP` sets the samples (64 unless told otherwise), `GNOMON_REFERENCE_OUT` a folder for pictures.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use std::time::Instant;

use glam::Vec3;
use gnomon_image::RgbImage;
use gnomon_metrics::{compare, signed_difference, z_test};
use gnomon_reference::{Estimate, ReferenceOptions, render};
use gnomon_scene::Camera;
use gnomon_testing::data_file;
use serde_json::Value;

/// Means differ by no more than this share of the reference, in every channel.
const MEAN_TOLERANCE: f64 = 0.005;
/// Root mean square difference at 1024 samples, relative to the mean. Mitsuba's own noise is 0.008 of it.
const RMSE_TOLERANCE: f64 = 0.02;
/// Least share of pixels whose three channels all lie within [`Z_LIMIT`] standard errors.
const Z_PASSING: f64 = 0.995;
/// Chance puts one of three channels beyond 3.5 for a normal law in 0.14 % of the pixels, and in about 0.3 % with a variance
/// from 32 batches; an error of one standard deviation everywhere would put 1.5 % there.
const Z_LIMIT: f32 = 3.5;

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

fn run(picture: &str, glb: &str) -> Option<Case> {
    let renders = data_file("reference/renders.json")?;
    let renders: Value = serde_json::from_slice(&std::fs::read(renders).unwrap()).unwrap();
    let entry = renders["images"].as_array().unwrap().iter().find(|image| image["file"] == picture).unwrap();
    let truth = gnomon_image::read(data_file(&format!("reference/{picture}"))?).unwrap().image;
    let environment = data_file(&format!("reference/{}", entry["env"].as_str().unwrap()))?;
    let environment = support::read_environment(&environment);
    let scene = support::read_plain_glb(&data_file(&format!("scenes/{glb}"))?);

    let camera = &entry["camera"];
    let fov_x = (camera["fov_x_deg"].as_f64().unwrap() as f32).to_radians();
    let camera = Camera::look_at(vector(&camera["origin"]), vector(&camera["target"]), fov_x);
    let samples_per_pixel =
        std::env::var("GNOMON_REFERENCE_SPP").ok().map_or(64, |samples| samples.parse().unwrap());
    let options = ReferenceOptions {
        width: truth.width(),
        height: truth.height(),
        samples_per_pixel,
        ..ReferenceOptions::default()
    };
    let start = Instant::now();
    let estimate = render(&scene, &camera, &environment, &options).unwrap();
    println!("{picture}: {samples_per_pixel} samples in {:.1} s", start.elapsed().as_secs_f64());

    // The file gives the median of the relative standard error; Monte Carlo noise is taken as proportional to the pixel.
    let relative = entry["median_rel_stderr"].as_f64().unwrap() as f32;
    let truth_variance = RgbImage::from_fn(truth.width(), truth.height(), |x, y| {
        let error = relative * truth.get(x, y);
        error * error
    });
    Some(Case { estimate, truth, truth_variance })
}

fn check(picture: &str, glb: &str) {
    let Some(Case { estimate, truth, truth_variance }) = run(picture, glb) else { return };
    let comparison = compare(&estimate.mean, &truth, None).unwrap();
    let z = z_test((&estimate.mean, &estimate.variance), (&truth, &truth_variance), Z_LIMIT).unwrap();
    let mean_error =
        (0..3).map(|c| (comparison.mean[c] / comparison.reference_mean[c] - 1.0).abs()).fold(0.0, f64::max);
    println!(
        "{picture}: mean off by {:.3} %, relative RMSE {:.4}, z-test {:.3} % of pixels (mean z^2 {:.2}), worst {:?}",
        100.0 * mean_error,
        comparison.relative_rmse,
        100.0 * z.passing,
        z.mean_square,
        comparison.worst,
    );
    if let Ok(folder) = std::env::var("GNOMON_REFERENCE_OUT") {
        let name = picture.trim_end_matches(".exr");
        let difference = signed_difference(&estimate.mean, &truth, 10.0).unwrap();
        let shown = |image: &RgbImage| {
            gnomon_image::tonemap::tone_mapped(image, gnomon_image::ToneMapping::Neutral, 0.0)
        };
        for (suffix, image) in
            [("ours", shown(&estimate.mean)), ("mitsuba", shown(&truth)), ("difference", difference)]
        {
            gnomon_image::write(format!("{folder}/{name}_{suffix}.png"), &image).unwrap();
        }
    }
    assert!(mean_error <= MEAN_TOLERANCE, "{picture}: the mean is off by {mean_error}");
    assert!(
        z.passing >= Z_PASSING
            || (estimate.samples_per_pixel >= 1024 && comparison.relative_rmse <= RMSE_TOLERANCE),
        "{picture}: {z:?}, relative RMSE {}",
        comparison.relative_rmse
    );
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
