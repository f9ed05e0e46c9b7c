//! Whole files: recognised by content, written whole, with errors that name them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

use std::fs;

use glam::Vec3;
use gnomon_picture::{ImageError, RgbImage, ToneMapping, formats, read, read_mask, tonemap, write};

fn gradient() -> RgbImage {
    RgbImage::from_fn(256, 2, |x, y| Vec3::splat(tonemap::srgb_decode(x as f32 / 255.0)) * (1.0 - y as f32))
}

#[test]
fn png_keeps_every_code() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.png");
    write(&path, &gradient()).unwrap();
    let decoded = read(&path).unwrap();
    assert_eq!((decoded.format, decoded.image), ("PNG", gradient()));
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[test]
fn png_clips_what_a_display_cannot_show() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.PNG");
    let image = RgbImage::filled(1, 1, Vec3::new(f32::NAN, -3.0, f32::INFINITY));
    write(&path, &image).unwrap();
    assert_eq!(read(&path).unwrap().image.get(0, 0), Vec3::new(0.0, 0.0, 1.0));
}

#[test]
fn content_and_not_the_name_decides() {
    let dir = tempfile::tempdir().unwrap();
    let (exr, lie) = (dir.path().join("a.exr"), dir.path().join("a.png"));
    write(&exr, &gradient()).unwrap();
    fs::rename(&exr, &lie).unwrap();
    assert_eq!(read(&lie).unwrap().format, "OpenEXR");
}

#[test]
fn errors_name_the_file_and_the_fault_in_one_line() {
    let dir = tempfile::tempdir().unwrap();
    let absent = dir.path().join("absent.hdr");
    let text = dir.path().join("text.hdr");
    fs::write(&text, "hello").unwrap();
    let cut = dir.path().join("cut.png");
    write(&cut, &gradient()).unwrap();
    let bytes = fs::read(&cut).unwrap();
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let empty = RgbImage::filled(0, 0, Vec3::ZERO);
    let cases = [
        (read(&absent).err(), "absent.hdr"),
        (read(dir.path()).err(), "cannot read"),
        (read(&text).err(), "known format"),
        (read(&cut).err(), "damaged PNG"),
        (write(dir.path().join("a.tga"), &gradient()).err(), ".exr, .hdr, .png"),
        (write(dir.path().join("none/a.exr"), &gradient()).err(), "cannot write"),
        (write(dir.path().join("a.exr"), &empty).err(), "empty"),
        (write(dir.path().join("a.png"), &empty).err(), "empty"),
    ];
    for (error, part) in cases {
        let text = error.map(|error| error.to_string()).unwrap();
        assert!(text.contains(part) && text.lines().count() == 1, "{text}");
    }
    assert!(matches!(read(&text), Err(ImageError::Decode { .. })));
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2, "a failed write left a file");
}

#[test]
fn a_mask_counts_what_is_stored_brighter_than_half() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("mask.png");
    write(&path, &gradient()).unwrap();
    let mask = read_mask(&path).unwrap();
    assert_eq!((mask.width, mask.height), (256, 2));
    assert_eq!(mask.inside.iter().position(|&inside| inside), Some(128));
    assert_eq!(mask.inside.iter().filter(|&&inside| inside).count(), 128);
}

#[test]
fn the_table_of_formats_is_complete() {
    let names: Vec<_> = formats().iter().map(|format| format.name).collect();
    assert_eq!(names, ["OpenEXR", "Radiance", "PNG", "JPEG"]);
    let writable: Vec<_> =
        formats().iter().filter(|format| format.writable).map(|format| format.extensions[0]).collect();
    assert_eq!(writable, ["exr", "hdr", "png"]);
}

#[test]
fn a_bright_picture_is_tone_mapped_before_it_is_written() {
    let bright = RgbImage::filled(1, 1, Vec3::splat(8.0));
    let shown = tonemap::tone_mapped(&bright, ToneMapping::Neutral, -1.0).get(0, 0).x;
    // Radiance 4, peak 3.96: 1 - 0.0576 / (3.96 + 0.24 - 0.76) = 0.98326.
    assert!((shown - 0.983_26).abs() < 1e-4, "{shown}");
}
