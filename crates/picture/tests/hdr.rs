//! Radiance files: the damaged and unusual ones of the test data with their expected outcomes, and others made here.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

use std::fs::File;
use std::path::Path;

use glam::Vec3;
use gnomon_picture::{DecodeError, RgbImage, decode, read, rec709_from_xyz};
use gnomon_testing::data_file;
use proptest::prelude::*;

/// A header and its pixels.
fn file(header: &str, resolution: &str, pixels: &[u8]) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\n{header}FORMAT=32-bit_rle_rgbe\n\n{resolution}\n").into_bytes();
    bytes.extend_from_slice(pixels);
    bytes
}

/// Pixels of a 3 x 2 picture (flat code), all different.
fn six() -> Vec<u8> {
    (0..6).flat_map(|i| [10 + i, 20 + i, 30 + i, 136]).collect()
}

fn reds(image: &RgbImage) -> Vec<f32> {
    image.texels().iter().map(|texel| texel.x).collect()
}

fn error(bytes: &[u8]) -> DecodeError {
    let error = decode(bytes).err().unwrap_or_else(|| panic!("{} bytes decoded", bytes.len()));
    assert_eq!(error.to_string().lines().count(), 1);
    error
}

#[test]
fn files_end_as_the_manifest_says() {
    let Some(manifest) = data_file("bad_inputs/hdr/MANIFEST.tsv") else { return };
    let folder = manifest.parent().unwrap();
    let mut checked = 0;
    for line in std::fs::read_to_string(&manifest).unwrap().lines().skip(1) {
        let [name, expected, _] = line.split('\t').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let path = folder.join(name);
        if name.contains('*') || !path.exists() {
            continue;
        }
        let outcome = read(&path);
        match &outcome {
            Ok(decoded) => assert!(decoded.image.texels().iter().all(|texel| texel.is_finite()), "{name}"),
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{name}"),
        }
        assert!(
            match &outcome {
                Ok(_) =>
                    expected.starts_with("ok") || expected.contains("or ok") || expected.contains("ignored"),
                Err(_) => expected.contains("error"),
            },
            "{name}: expected {expected}, got {:?}",
            outcome.map(|decoded| (decoded.image.width(), decoded.image.height()))
        );
        checked += 1;
    }
    assert!(checked >= 14, "only {checked} files of the manifest are there");
}

#[test]
fn pictures_of_the_image_crate_have_their_expected_pixels() {
    let Some(manifest) = data_file("bad_inputs/hdr/MANIFEST.tsv") else { return };
    let mut compared = 0;
    for name in ["image1", "old-rle", "rgbr4x4", "scale", "overexposed_gradient"] {
        let path = manifest.with_file_name(format!("imagers_valid_{name}.hdr"));
        let image = read(&path).unwrap().image;
        let expected = manifest.with_file_name(format!("imagers_valid_{name}.expected.tiff"));
        if expected.exists() {
            let expected = read_tiff(&expected);
            let ours: Vec<f32> = image.texels().iter().flat_map(|texel| texel.to_array()).collect();
            assert_eq!(ours, expected, "{name}");
            compared += 1;
        }
    }
    assert_eq!(compared, 4);
}

fn read_tiff(path: &Path) -> Vec<f32> {
    let mut decoder = tiff::decoder::Decoder::new(File::open(path).unwrap()).unwrap();
    match decoder.read_image().unwrap() {
        tiff::decoder::DecodingResult::F32(values) => values,
        other => panic!("{other:?}"),
    }
}

#[test]
fn orientation_exposure_and_xyz_of_the_mutated_files() {
    let Some(folder) = data_file("bad_inputs/hdr") else { return };
    let open = |name: &str| read(folder.join(name)).unwrap().image;
    // The three files hold the same bytes of pixels.
    let mirrored = open("mut_ok_minusX.hdr");
    let plain = RgbImage::from_fn(mirrored.width(), mirrored.height(), |x, y| {
        mirrored.get(mirrored.width() - 1 - x, y)
    });
    // Red grows to the right in the bytes: 0x80, 0x81, ...
    assert_eq!(plain.get(1, 0).x * 128.0, plain.get(0, 0).x * 129.0);
    let quartered = open("mut_ok_exposure4.hdr");
    let xyz = open("mut_ok_xyze.hdr");
    for (index, &texel) in plain.texels().iter().enumerate() {
        assert_eq!(quartered.texels()[index] * 4.0, texel);
        assert!((xyz.texels()[index] - rec709_from_xyz(texel)).length() < 1e-6);
    }
}

#[test]
fn d65_white_in_xyz_is_grey_in_rgb() {
    // The white point of IEC 61966-2-1: x = 0.3127, y = 0.3290.
    let white = rec709_from_xyz(Vec3::new(0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290));
    assert!((white - 1.0).abs().max_element() < 2e-3, "{white}");
}

#[test]
fn all_eight_orientations_show_the_same_picture() {
    // What the file's pixels look like when they are stored in each orientation: 3 wide, 2 high.
    let cases: [(&str, [u8; 6]); 8] = [
        ("-Y 2 +X 3", [0, 1, 2, 3, 4, 5]),
        ("-Y 2 -X 3", [2, 1, 0, 5, 4, 3]),
        ("+Y 2 +X 3", [3, 4, 5, 0, 1, 2]),
        ("+Y 2 -X 3", [5, 4, 3, 2, 1, 0]),
        ("+X 3 -Y 2", [0, 3, 1, 4, 2, 5]),
        ("-X 3 -Y 2", [2, 5, 1, 4, 0, 3]),
        ("+X 3 +Y 2", [3, 0, 4, 1, 5, 2]),
        ("-X 3 +Y 2", [5, 2, 4, 1, 3, 0]),
    ];
    for (resolution, stored) in cases {
        let pixels: Vec<u8> = stored.iter().flat_map(|&i| [10 + i, 20 + i, 30 + i, 136]).collect();
        let image = decode(&file("", resolution, &pixels)).unwrap().image;
        assert_eq!((image.width(), image.height()), (3, 2), "{resolution}");
        assert_eq!(reds(&image), [10.0, 11.0, 12.0, 13.0, 14.0, 15.0], "{resolution}");
    }
}

#[test]
fn exposure_lines_multiply_and_unusable_ones_are_ignored_aloud() {
    let red = |header: &str| {
        let decoded = decode(&file(header, "-Y 2 +X 3", &six())).unwrap();
        (decoded.image.get(0, 0).x, decoded.warnings.len())
    };
    assert_eq!(red(""), (10.0, 0));
    assert_eq!(red("EXPOSURE=4\n"), (2.5, 0));
    assert_eq!(red("EXPOSURE= 4.0 \r\nEXPOSURE=0.25\n"), (10.0, 0));
    for bad in ["nan", "0", "-1", "inf", "", "1e300", "1e-300", "four"] {
        assert_eq!(red(&format!("EXPOSURE={bad}\n")), (10.0, 1), "{bad}");
        assert_eq!(red(&format!("EXPOSURE=2\nEXPOSURE={bad}\n")), (5.0, 1), "{bad}");
    }
}

#[test]
fn colour_corrections_and_primaries_count_and_unusable_ones_are_ignored_aloud() {
    let first = |header: &str| {
        let decoded = decode(&file(header, "-Y 2 +X 3", &six())).unwrap();
        (decoded.image.get(0, 0), decoded.warnings.len())
    };
    let (plain, _) = first("");
    assert_eq!(first("COLORCORR= 2 0.5 1\nCOLORCORR=1 1 4\n"), (plain * Vec3::new(0.5, 2.0, 0.25), 0));
    for bad in ["COLORCORR=1 1\n", "COLORCORR=0 1 1\n", "PRIMARIES=1 2 3\n", "PRIMARIES=0 0 0 0 0 0 0 0\n"] {
        assert_eq!(first(bad), (plain, 1), "{bad}");
    }
    // Those of Rec. 709 change nothing; Radiance's own keep grey grey.
    assert_eq!(first("PRIMARIES= 0.640 0.330 0.300 0.600 0.150 0.060 0.3127 0.3290\n"), (plain, 0));
    let own = "PRIMARIES= 0.640 0.330 0.290 0.600 0.150 0.060 0.3333 0.3333\n";
    let grey = decode(&file(own, "-Y 1 +X 1", &[128, 128, 128, 129])).unwrap().image.get(0, 0);
    assert!((grey - 1.0).abs().max_element() < 1e-5, "{grey}");
}

#[test]
fn a_header_may_begin_with_any_word_or_none() {
    for start in ["#?AUTOPANO11\n", "#?\n", "#?rgbe by hand\n", ""] {
        let mut bytes = format!("{start}FORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 3\n").into_bytes();
        bytes.extend(six());
        assert_eq!(reds(&decode(&bytes).unwrap().image)[5], 15.0, "{start}");
    }
    assert!(matches!(error(b"# made by hand\n\n-Y 2 +X 3\n"), DecodeError::UnknownFormat { .. }));
}

#[test]
fn the_least_and_the_largest_texels_are_finite() {
    let decoded = decode(&file("", "-Y 1 +X 3", &[255, 255, 255, 255, 1, 1, 0, 1, 9, 9, 9, 0])).unwrap();
    assert_eq!(decoded.image.get(0, 0).x, 255.0 * 2f32.powi(119));
    assert_eq!(decoded.image.get(1, 0), Vec3::new(2f32.powi(-135), 2f32.powi(-135), 0.0));
    assert_eq!(decoded.image.get(2, 0), Vec3::ZERO);
    let dark = decode(&file("EXPOSURE=1e-20\n", "-Y 1 +X 1", &[255, 0, 0, 255])).unwrap();
    assert_eq!(dark.image.get(0, 0).x, f32::MAX);
}

#[test]
fn other_magics_line_ends_and_long_comments_are_read() {
    let mut bytes = b"#?RGBE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 2 +X 3\r\n".to_vec();
    bytes.extend(six());
    assert_eq!(reds(&decode(&bytes).unwrap().image)[5], 15.0);
    let comment = format!("# {}\n", "x".repeat(200_000));
    assert!(decode(&file(&comment, "-Y 2 +X 3", &six())).is_ok());
    let comment = format!("# {}\n", "x".repeat(2_000_000));
    assert!(matches!(error(&file(&comment, "-Y 2 +X 3", &six())), DecodeError::Malformed { .. }));
}

#[test]
fn old_runs_of_more_than_one_digit() {
    // 1, 300 repeats as the digits 44 and 1, then one more texel: 302 in all.
    let pixels = [7, 7, 7, 136, 1, 1, 1, 44, 1, 1, 1, 1, 9, 9, 9, 136];
    let image = decode(&file("", "-Y 1 +X 302", &pixels)).unwrap().image;
    assert_eq!(reds(&image)[300..], [7.0, 9.0]);
    assert!(decode(&file("", "-Y 1 +X 301", &pixels[..12])).is_ok());
    error(&file("", "-Y 1 +X 300", &pixels));
}

#[test]
fn damage_is_refused_without_large_allocations() {
    let claims = [
        "-Y 40000 +X 40000",
        "-Y 8888888 +X 8888888",
        "-Y 4294967295 +X 4294967295",
        "-Y 65536 +X 65536",
        "-Y 1 +X 100000000",
    ];
    for resolution in claims {
        assert!(matches!(error(&file("", resolution, &six())), DecodeError::TooLarge { .. }), "{resolution}");
    }
    let shapes = [
        "-Y 0 +X 3",
        "-Y -2 +X 3",
        "-Y two +X 3",
        "-Y 2",
        "-Y 2 -Y 3",
        "-Y 99999999999 +X 3",
        "",
        "-Y 2 +X +3",
    ];
    for resolution in shapes {
        assert!(
            matches!(error(&file("", resolution, &six())), DecodeError::Malformed { .. }),
            "{resolution}"
        );
    }
    assert!(matches!(
        error(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n-Y 2 +X 3\n"),
        DecodeError::Malformed { .. }
    ));
    assert!(matches!(error(b"#?RADIANCE\nFORMAT=rgbx\n\n-Y 2 +X 3\n"), DecodeError::Unsupported { .. }));
    assert!(matches!(error(b""), DecodeError::UnknownFormat { .. }));
    error(b"#?RADIANCE\nFORMAT=32-bit_rle_rg");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn no_damage_panics(
        at in 0usize..400, to in any::<u8>(), keep in 0usize..400, again in 0usize..400, other in any::<u8>(),
    ) {
        // New code, 16 x 4, with runs and literals.
        let mut pixels = Vec::new();
        for _ in 0..4 {
            pixels.extend([2, 2, 0, 16, 128 + 16, 5, 16]);
            pixels.extend(100..116);
            pixels.extend([128 + 8, 1, 128 + 8, 2, 128 + 16, 136]);
        }
        let mut bytes = file("EXPOSURE=2\n", "-Y 4 +X 16", &pixels);
        prop_assert!(decode(&bytes).is_ok());
        let length = bytes.len();
        bytes[at % length] = to;
        bytes[again % length] = other;
        if let Ok(decoded) = decode(&bytes[..length - keep % 8]) {
            prop_assert!(decoded.image.texels().iter().all(|texel| texel.is_finite()));
        }
    }
}

#[test]
fn what_is_written_is_read_back_to_the_last_bit_of_a_mantissa() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.hdr");
    // From below what an exponent holds to a sun, and a value that rounds up to the next power of two.
    let value = |x: u32, y: u32| match (x, y) {
        (0, 0) => Vec3::ZERO,
        (1, 0) => Vec3::new(0.999_99, 0.5, 0.0),
        (2, 0) => Vec3::new(f32::NAN, -1.0, 2.0),
        _ => Vec3::new(1.0, 0.3, 0.01) * 10_f32.powi(x as i32 * 2 - 8) * (1.0 + y as f32),
    };
    let picture = RgbImage::from_fn(9, 5, value);
    gnomon_picture::write(&path, &picture).unwrap();
    let back = read(&path).unwrap().image;
    assert_eq!((back.width(), back.height()), (9, 5));
    for (found, expected) in back.texels().iter().zip(picture.texels()) {
        let expected = expected.max(Vec3::ZERO);
        let step = expected.max_element() / 255.0;
        assert!((*found - expected).abs().max_element() <= step, "{found} {expected}");
    }
    assert!(gnomon_picture::hdr::encode(&RgbImage::filled(0, 0, Vec3::ONE)).is_err());
}
