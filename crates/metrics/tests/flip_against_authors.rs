//! FLIP against the reference implementation of its authors.
//!
//! The expected figures come from `flip-evaluator` 1.7 (PyPI, NVIDIA's implementation), called as
//! `flip_evaluator.evaluate(reference, image, "LDR", applyMagma=False)` on the pictures below; integer arithmetic makes
//! them the same in every language. Mean over the returned map in double precision, then pixels (24, 16), (0, 0), (31, 5).

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use glam::Vec3;
use gnomon_metrics::{PIXELS_PER_DEGREE, flip};
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::srgb_decode;
use gnomon_testing::tolerances::FLIP_PIXEL;

const WIDTH: u32 = 48;
const HEIGHT: u32 = 32;

fn picture(code_values: impl Fn(u32, u32) -> [u32; 3]) -> RgbImage {
    RgbImage::from_fn(WIDTH, HEIGHT, |x, y| {
        Vec3::from(code_values(x, y).map(|value| srgb_decode(value as f32 / 255.0)))
    })
}

fn gradient(x: u32, y: u32) -> [u32; 3] {
    [40 + 4 * x, 30 + 6 * y, 200 - 3 * x]
}

fn tinted(x: u32, y: u32) -> [u32; 3] {
    let [r, g, b] = gradient(x, y);
    if (10..30).contains(&x) { [r, (g + 12).min(255), b] } else { [r, g, b] }
}

fn edge_at(column: u32) -> impl Fn(u32, u32) -> [u32; 3] {
    move |x, _| if x < column { [220, 210, 200] } else { [60, 70, 80] }
}

/// Thomas Wang's 32-bit integer hash.
fn hash(seed: u32) -> u32 {
    let n = (seed ^ 61) ^ (seed >> 16);
    let n = n.wrapping_add(n << 3);
    let n = (n ^ (n >> 4)).wrapping_mul(0x27d4_eb2d);
    n ^ (n >> 15)
}

fn noisy(x: u32, y: u32) -> [u32; 3] {
    let mut channel = 0;
    gradient(x, y).map(|value| {
        let noise = hash((y * WIDTH + x) * 3 + channel) % 41;
        channel += 1;
        (value + noise).saturating_sub(20).min(255)
    })
}

#[track_caller]
fn check(reference: &RgbImage, image: &RgbImage, pixels_per_degree: f32, mean: f64, pixels: [f32; 3]) {
    let map = flip(image, reference, pixels_per_degree).unwrap();
    let actual: f64 = map.errors.iter().map(|&e| f64::from(e)).sum::<f64>() / map.errors.len() as f64;
    assert!((actual - mean).abs() < 1e-4, "mean {actual}, expected {mean}");
    for ((x, y), expected) in [(24, 16), (0, 0), (31, 5)].into_iter().zip(pixels) {
        let actual = map.errors[(y * WIDTH + x) as usize];
        assert!((actual - expected).abs() < FLIP_PIXEL, "({x}, {y}): {actual}, expected {expected}");
    }
}

#[test]
fn tint() {
    check(
        &picture(gradient),
        &picture(tinted),
        PIXELS_PER_DEGREE,
        0.118_277,
        [0.279_260, 0.000_089, 0.042_813],
    );
}

#[test]
fn moved_edge() {
    check(
        &picture(edge_at(24)),
        &picture(edge_at(26)),
        PIXELS_PER_DEGREE,
        0.096_853,
        [0.702_155, 0.0, 0.056_027],
    );
}

#[test]
fn noise() {
    check(
        &picture(gradient),
        &picture(noisy),
        PIXELS_PER_DEGREE,
        0.101_890,
        [0.072_433, 0.104_685, 0.062_795],
    );
}

#[test]
fn noise_seen_from_nearer() {
    let map = flip(&picture(noisy), &picture(gradient), 30.0).unwrap();
    let mean: f64 = map.errors.iter().map(|&e| f64::from(e)).sum::<f64>() / map.errors.len() as f64;
    assert!((mean - 0.201_319).abs() < 1e-4, "{mean}");
    assert!((map.errors[(16 * WIDTH + 24) as usize] - 0.137_846).abs() < FLIP_PIXEL);
}

#[test]
fn unrelated_pictures() {
    let (gradient, edge) = (picture(gradient), picture(edge_at(24)));
    check(&gradient, &edge, PIXELS_PER_DEGREE, 0.901_873, [0.484_550, 0.966_827, 0.704_120]);
}

#[test]
fn black_against_white() {
    let (black, white) = (picture(|_, _| [0; 3]), picture(|_, _| [255; 3]));
    check(&black, &white, PIXELS_PER_DEGREE, 0.967_388, [0.967_388; 3]);
}

/// The expectations would not pass with another viewing distance: the check can fail.
#[test]
fn another_viewer_gives_another_figure() {
    let map = flip(&picture(noisy), &picture(gradient), 60.0).unwrap();
    let mean: f64 = map.errors.iter().map(|&e| f64::from(e)).sum::<f64>() / map.errors.len() as f64;
    assert!((mean - 0.101_890).abs() > 1e-3, "{mean}");
}

#[test]
fn one_pixel_pictures_and_bad_viewers() {
    let (black, white) = (RgbImage::filled(1, 1, Vec3::ZERO), RgbImage::filled(1, 1, Vec3::ONE));
    assert!(flip(&black, &white, PIXELS_PER_DEGREE).unwrap().errors[0] > 0.9);
    assert_eq!(flip(&white, &white, PIXELS_PER_DEGREE).unwrap().errors, [0.0]);
    for pixels_per_degree in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e9] {
        assert!(flip(&black, &white, pixels_per_degree).is_err());
    }
}
