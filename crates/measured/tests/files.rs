//! Files of the RGL and of MERL against what their authors' loaders find, damaged ones, and the tables that are made of them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

use std::path::PathBuf;

use glam::Vec3;
use gnomon_measured::*;
use gnomon_testing::{data_dir, skip, tolerances};

fn folder() -> Option<PathBuf> {
    let found = data_dir().map(|data| data.join("brdf")).filter(|folder| folder.is_dir());
    if found.is_none() {
        skip("there are no measured reflectances among the data");
    }
    found
}

const RGL: [&str; 4] = ["cc_ibiza_sunset", "colodur_napoli_4f", "paper_white", "satin_rosaline"];

fn rgl(folder: &std::path::Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(format!("rgl_{name}_rgb.bsdf"))).unwrap()
}

#[test]
fn rgl_files_have_the_values_of_their_authors_loader() {
    let Some(folder) = folder() else { return };
    let text = std::fs::read_to_string(folder.join("expected_rgl_eval.csv")).unwrap();
    let files = RGL.map(|name| (format!("rgl_{name}_rgb.bsdf"), Rgl::parse(&rgl(&folder, name)).unwrap()));
    let (mut rows, mut worst) = (0, 0.0f32);
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f32>().unwrap();
        let direction = |theta: f32, phi: f32| {
            let (theta, phi) = (theta.to_radians(), phi.to_radians());
            Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        };
        let rgl = &files.iter().find(|(name, _)| name == cells[0]).unwrap().1;
        let found = rgl.value_times_cosine(direction(number(1), number(2)), direction(number(3), number(4)));
        let expected = Vec3::new(number(5), number(6), number(7));
        let error = (found - expected).abs().max_element() / expected.max_element().max(1.0);
        assert!(error <= tolerances::RGL_VALUES, "{line}: {found}");
        worst = worst.max(error);
        rows += 1;
    }
    println!("{rows} values, worst error {worst:.1e}");
    assert!(rows > 1000);
}

/// A MERL file whose values tell where they stand.
fn merl_bytes(value: impl Fn(usize, usize) -> f64) -> Vec<u8> {
    let mut bytes: Vec<u8> = [90, 90, 180].into_iter().flat_map(i32::to_le_bytes).collect();
    for channel in 0..3 {
        bytes.extend((0..90 * 90 * 180).flat_map(|place| value(channel, place).to_le_bytes()));
    }
    bytes
}

#[test]
fn merl_files_read_exactly() {
    let merl = Merl::parse(&merl_bytes(|channel, place| place as f64 + 0.25 * channel as f64)).unwrap();
    for (half, difference, azimuth) in [(0, 0, 0), (3, 40, 179), (89, 89, 17)] {
        let place = ((half * 90 + difference) * 180 + azimuth) as f64;
        let expected = [1.0, 1.15, 1.66].map(|scale| scale / 1500.0);
        let stored = merl.stored(half, difference, azimuth).unwrap();
        for channel in 0..3 {
            let expected = expected[channel] * (place + 0.25 * channel as f64);
            assert!((f64::from(stored[channel]) / expected.max(1e-9) - 1.0).abs() < 1e-6 || expected == 0.0);
        }
    }
    assert!(merl.stored(90, 0, 0).is_none());
    // A value that is a function of the half vector's step alone is found again between directions.
    let by_half =
        Measurement::Merl(Box::new(Merl::parse(&merl_bytes(|_, place| (place / 16_200) as f64)).unwrap()));
    let wi = Vec3::new(0.3f32.sin(), 0.0, 0.3f32.cos());
    let [half, ..] = Merl::angles(20, 0, 0);
    let wo = glam::Quat::from_rotation_y(2.0 * half - 0.6) * Vec3::new(-wi.x, 0.0, wi.z);
    let step = by_half.value(wo, wi).x * 1500.0;
    let h = (wo + wi).normalize();
    let expected = (h.z.acos() / std::f32::consts::FRAC_PI_2).sqrt() * 90.0 - 0.5;
    assert!((step - expected).abs() < 0.1, "{step} {expected}");
}

/// The bytes of a file, damaged by a seeded generator (Marsaglia's xorshift): bytes overwritten, most of them in its head, and every fifth file
/// cut.
fn damaged(seed: &[u8], number: u64) -> Vec<u8> {
    let mut state = 0x9e37_79b9_7f4a_7c15 ^ (number + 1).wrapping_mul(0x2545_f491_4f6c_dd1d);
    let mut next = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below.max(1) as u64) as usize
    };
    let mut bytes = seed.to_vec();
    for _ in 0..=next(6) {
        let end = if next(3) > 0 { bytes.len().min(512) } else { bytes.len() };
        let place = next(end);
        bytes[place] = next(256) as u8;
    }
    if number.is_multiple_of(5) {
        bytes.truncate(next(seed.len()));
    }
    bytes
}

/// Fifty damaged files of each kind: an error of one line, or values that are numbers.
#[test]
fn damaged_files_are_one_clear_error() {
    let mut seeds =
        vec![("json", to_text(&gnomon_testing::tabulated_surfaces()[0].tables().unwrap()).into_bytes())];
    seeds.push(("binary", merl_bytes(|channel, place| (channel + place % 7) as f64)));
    seeds.extend(folder().map(|folder| ("bsdf", rgl(&folder, "paper_white"))));
    for (extension, seed) in seeds {
        let mut errors = 0;
        for number in 0..50 {
            let bytes = damaged(&seed, number);
            let found = match extension {
                "json" => parse(&bytes).map(|_| ()),
                _ => Measurement::parse(extension, &bytes).map(|measurement| {
                    let value = measurement.value(Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.28, 0.96));
                    assert!(value.is_finite(), "{extension} {number}: {value}");
                }),
            };
            if let Err(error) = found {
                let text = error.to_string();
                assert!(!text.is_empty() && !text.contains('\n') && text.len() < 300, "{text}");
                errors += 1;
            }
        }
        println!("{extension}: {errors} of 50 damaged files are errors, the others differ in values");
        assert!(errors >= 10, "{extension}: {errors}");
    }
}

#[test]
fn tables_of_measurements_come_near_them() {
    let Some(folder) = folder() else { return };
    for name in RGL {
        let measurement = Measurement::parse("bsdf", &rgl(&folder, name)).unwrap();
        let mut last = [f64::INFINITY; 2];
        for terms in 1..=4 {
            let tables = factorize(&measurement, terms);
            let FitError { relative_l2, mean } = fit_error(&measurement, &tables);
            println!(
                "{name}: {terms} terms, relative L2 {relative_l2:.3}, mean error {mean:.3}, {} bytes, most {:.3}",
                tables.bytes(),
                tables.most()
            );
            assert!(mean <= 1.02 * last[1], "{name}: a further term makes it worse: {last:?} {mean}");
            last = [relative_l2, mean];
        }
        assert!(last[0] <= tolerances::FACTORIZATION_L2, "{name}: {last:?}");
        let tables = homomorphic(&measurement);
        let FitError { relative_l2, mean } = fit_error(&measurement, &tables);
        println!(
            "{name}: homomorphic, relative L2 {relative_l2:.3}, mean error {mean:.3}, {} bytes, most {:.3}",
            tables.bytes(),
            tables.most()
        );
        assert!(mean <= tolerances::HOMOMORPHIC_MEAN, "{name}: {mean}");
    }
}

#[test]
fn tables_survive_their_file() {
    for surface in gnomon_testing::tabulated_surfaces() {
        let tables = surface.tables().unwrap();
        let read = parse(to_text(&tables).as_bytes()).unwrap();
        assert_eq!(read.terms(), tables.terms(), "{surface:?}");
    }
}
