//! Pictures as other programs write them: each against what a plain file of the same picture holds.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

use std::path::PathBuf;

use glam::Vec3;
use gnomon_picture::{Decoded, RgbImage, read};
use gnomon_testing::data_file;

fn case(name: &str) -> Option<PathBuf> {
    data_file(&format!("field/{name}"))
}

/// Root mean square difference over the mean.
fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!((a.width(), a.height()), (b.width(), b.height()));
    let squares = a.texels().iter().zip(b.texels()).map(|(a, b)| f64::from((*a - *b).length_squared()));
    let sum = b.texels().iter().map(|texel| f64::from(texel.element_sum())).sum::<f64>();
    let count = (3 * b.texels().len()) as f64;
    (squares.sum::<f64>() / count).sqrt() / (sum / count)
}

#[test]
fn files_of_other_programs_hold_what_their_plain_twins_hold() {
    for (name, limit) in [
        ("exr_blender_multilayer/case.exr", 1e-6),
        ("exr_vray_spelled_channels/case.exr", 1e-6),
        ("exr_multipart_rgb_second/case.exr", 1e-6),
        ("exr_data_window_inside/case.exr", 1e-6),
        ("exr_half_uint_mixed/case.exr", 1e-6),
        // Chroma of a quarter of the texels, around a sun.
        ("exr_luminance_chroma/case.exr", 0.01),
        ("hdr_old_rle_long/case.hdr", 1e-6),
        ("hdr_no_format_rgbe_crlf/case.hdr", 1e-6),
        ("hdr_magic_other/case.hdr", 1e-6),
        ("hdr_no_blank_resolution_spaces/case.hdr", 1e-6),
    ] {
        let Some(path) = case(name) else { return };
        let Decoded { image, warnings, .. } = read(&path).unwrap_or_else(|error| panic!("{error}"));
        let off = difference(&image, &read(path.with_file_name("plain.exr")).unwrap().image);
        assert!(off < limit, "{name}: {off}");
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
    }
}

#[test]
fn every_order_of_rows_and_columns_gives_the_same_picture() {
    let Some(plain) = case("hdr_orientations/plain.exr") else { return };
    let expected = read(&plain).unwrap().image;
    for order in ["mXmY", "mXpY", "mYmX", "mYpX", "pXmY", "pXpY", "pYmX", "pYpX"] {
        let image = read(plain.with_file_name(format!("o_{order}.hdr"))).unwrap().image;
        assert!(difference(&image, &expected) < 1e-6, "{order}");
    }
    for width in [4, 7, 8, 33_000] {
        let at = |end: &str| case(&format!("hdr_narrow_and_wide/w{width}{end}")).unwrap();
        let off = difference(&read(at(".hdr")).unwrap().image, &read(at("_plain.exr")).unwrap().image);
        assert!(off < 1e-6, "{width}");
    }
}

#[test]
fn every_compression_is_read_or_named() {
    let Some(plain) = case("exr_compressions/plain.exr") else { return };
    let expected = read(&plain).unwrap().image;
    for (method, limit) in [
        ("NO", 1e-6),
        ("RLE", 1e-6),
        ("ZIPS", 1e-6),
        ("ZIP", 1e-6),
        ("PIZ", 1e-6),
        ("PXR24", 1e-4),
        ("B44", 0.03),
        ("B44A", 0.03),
        ("DWAA", 0.05),
        ("DWAB", 0.05),
    ] {
        for blocks in ["s", "t"] {
            let path = plain.with_file_name(format!("{method}_{blocks}.exr"));
            let off = difference(&read(path).unwrap_or_else(|error| panic!("{error}")).image, &expected);
            assert!(off < limit, "{method}_{blocks}: {off}");
        }
    }
    for name in ["HTJ2K32_s", "HTJ2K256_t"] {
        let error = read(plain.with_file_name(format!("{name}.exr"))).unwrap_err().to_string();
        assert!(error.contains("HTJ2K") && error.contains("oiiotool"), "{error}");
    }
}

#[test]
fn colours_of_wide_primaries_become_rec_709() {
    // ITU-R BT.2087-0; its fourth digit is what the file's eight bits are far from.
    let rows = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
    let Some(path) = case("hdr_xyze_primaries/case.hdr") else { return };
    let plain = read(path.with_file_name("plain.exr")).unwrap().image;
    let image = read(&path).unwrap().image;
    assert!(difference(&image, &plain) < 0.01, "{}", difference(&image, &plain));
    // The same file without the line holds the colours before.
    let bytes = std::fs::read(&path).unwrap();
    let start = bytes.windows(9).position(|bytes| bytes == b"PRIMARIES").unwrap();
    let end = start + bytes[start..].iter().position(|&byte| byte == b'\n').unwrap();
    let without = gnomon_picture::decode(&[&bytes[..start], &bytes[end + 1..]].concat()).unwrap().image;
    for (color, before) in image.texels().iter().zip(without.texels()) {
        let expected = Vec3::from_array(rows.map(|row| Vec3::from_array(row).dot(*before)));
        assert!((*color - expected).abs().max_element() < 1e-3 * before.max_element());
    }
}

#[test]
fn acescg_is_converted_with_its_white() {
    let Some(path) = case("exr_acescg/case.exr") else { return };
    let Decoded { image, warnings, .. } = read(path).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    // Grey is grey in both.
    assert!(image.texels().iter().all(|texel| texel.is_finite()));
}
