//! `gnomon compare` on pictures made here.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod support;

use glam::Vec3;
use gnomon::picture::{RgbImage, write};
use support::{files, gnomon};

/// A floor with a round shadow.
fn floor(shadow: f32) -> RgbImage {
    RgbImage::from_fn(64, 48, |x, y| {
        let inside = (x as f32 - 30.0).hypot(y as f32 - 20.0) < 6.0;
        Vec3::splat(if inside { 2.0 * (1.0 - shadow) } else { 2.0 })
    })
}

#[test]
fn a_missing_shadow_is_measured_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write(at("truth.exr"), &floor(0.9)).unwrap();
    write(at("same.exr"), &floor(0.9)).unwrap();
    write(at("missing.exr"), &floor(0.0)).unwrap();
    write(at("mask.png"), &RgbImage::from_fn(64, 48, |x, _| Vec3::splat(if x >= 40 { 1.0 } else { 0.0 })))
        .unwrap();

    let same = gnomon(folder.path(), &["compare", "same.exr", "truth.exr"]).succeeded().json();
    assert_eq!(same["relative_rmse"], 0.0);
    assert_eq!(same["flip"]["mean"], 0.0);
    assert!(same["psnr"].is_null(), "infinite");

    let arguments =
        ["compare", "missing.exr", "truth.exr", "--region", "umbra=28,18,4x4", "--region", "light=0,0,10x10"];
    let outputs = ["--difference", "flip.png", "--signed-difference", "signed.png"];
    let missing = gnomon(folder.path(), &[&arguments[..], &outputs[..]].concat()).succeeded().json();
    assert!(missing["relative_rmse"].as_f64().unwrap() > 0.1);
    assert!(missing["flip"]["weighted_median"].as_f64().unwrap() > 0.3);
    // 2 against 0.2 everywhere in the umbra: nine times the reference.
    let umbra = &missing["regions"]["umbra"];
    assert!((umbra["relative_rmse"].as_f64().unwrap() - 9.0).abs() < 1e-3, "{umbra}");
    assert_eq!(missing["regions"]["light"]["relative_rmse"], 0.0);

    let difference = gnomon::picture::read(at("flip.png")).unwrap().image;
    assert_eq!((difference.width(), difference.height()), (64, 48));
    assert!(difference.get(30, 20).max_element() > 0.3 && difference.get(60, 40).max_element() < 0.01);
    let signed = gnomon::picture::read(at("signed.png")).unwrap().image;
    assert!(signed.get(30, 20).min_element() > 0.9, "the picture is brighter there");

    // The mask leaves only pixels that are equal.
    let masked = gnomon(folder.path(), &["compare", "missing.exr", "truth.exr", "--mask", "mask.png"])
        .succeeded()
        .json();
    assert_eq!(masked["pixels"], 24 * 48);
    assert_eq!(masked["relative_rmse"], 0.0);
}

#[test]
fn eight_bit_pictures_are_compared_as_displayed() {
    let folder = tempfile::tempdir().unwrap();
    let grey = |code: u8| Vec3::splat(gnomon::picture::tonemap::srgb_decode(f32::from(code) / 255.0));
    write(folder.path().join("a.png"), &RgbImage::filled(8, 8, grey(120))).unwrap();
    write(folder.path().join("b.png"), &RgbImage::filled(8, 8, grey(100))).unwrap();
    let json = gnomon(folder.path(), &["compare", "a.png", "b.png"]).succeeded().json();
    assert_eq!(json["exposure"], 0.0);
    let expected = 20.0 * (255.0_f64 / 20.0).log10();
    assert!((json["psnr"].as_f64().unwrap() - expected).abs() < 1e-3, "{json}");
}

#[test]
fn pictures_that_cannot_be_compared_are_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write(at("a.exr"), &floor(0.5)).unwrap();
    write(at("small.exr"), &RgbImage::filled(3, 2, Vec3::ONE)).unwrap();
    std::fs::write(at("text.png"), "no picture").unwrap();
    let before = files(folder.path());
    gnomon(folder.path(), &["compare", "a.exr", "small.exr", "--difference", "d.png"]).failed("3 x 2");
    gnomon(folder.path(), &["compare", "a.exr", "text.png"]).failed("text.png");
    gnomon(folder.path(), &["compare", "a.exr", "a.exr", "--mask", "small.exr"]).failed("mask has 3 x 2");
    gnomon(folder.path(), &["compare", "a.exr", "a.exr", "--region", "out=900,900,2x2"]).failed("no pixel");
    assert_eq!(files(folder.path()), before);
}
