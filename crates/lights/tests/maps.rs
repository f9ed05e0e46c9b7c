//! The fits on captured environments, against what their papers report.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic like tests")]

mod common;

use common::{flux_error, is_physical, quarter_turn, turn_error};
use gnomon_envmap::Equirect;
use gnomon_lights::fit::{by_name, methods};
use gnomon_lights::{FitOptions, LightDocument};
use gnomon_testing::tolerances::{DISK_COUNT, FIT_ROTATION, FLUX, RECTANGLE_COUNT};
use gnomon_testing::{data_dir, data_file};

fn load(name: &str) -> Option<Equirect> {
    let path = data_file(&format!("env/{name}"))?;
    Some(gnomon_envmap::load(path, Default::default()).unwrap().map)
}

fn count(map: &Equirect, method: &str, threshold: Option<f32>) -> usize {
    let options = FitOptions { threshold, ..FitOptions::default() };
    by_name(method, &options).unwrap().fit(map).unwrap().lights.len()
}

/// Arbree 2005, table 1.
#[test]
fn disks_are_as_many_as_in_the_paper() {
    for (map, expected) in [("galileo", 8_usize), ("grace", 10), ("kitchen", 4), ("stpeters", 17)] {
        let Some(map) = load(&format!("debevec_{map}_cross.hdr")) else { return };
        let found = count(&map, "disks", None);
        assert!(
            found.abs_diff(expected) as f64 <= DISK_COUNT * expected as f64,
            "{found} disks, {expected} in the paper"
        );
    }
}

/// Annen 2008, figure 10: 30, 45 and 60 lights.
#[test]
fn squares_and_rectangles_are_as_many_as_in_the_paper() {
    let Some(map) = load("debevec_rnl_cross.hdr") else { return };
    for method in ["squares", "rectangles"] {
        for (threshold, expected) in [(0.015, 30_usize), (0.025, 45), (0.035, 60)] {
            let found = count(&map, method, Some(threshold));
            assert!(
                found.abs_diff(expected) as f64 <= RECTANGLE_COUNT * expected as f64,
                "{found} {method} at {threshold}, paper {expected}"
            );
        }
    }
}

#[test]
fn every_map_keeps_its_flux_in_every_fit() {
    let Some(dir) = data_dir() else { return gnomon_testing::skip("no external data") };
    let mut checked = 0;
    for entry in std::fs::read_dir(dir.join("env")).unwrap() {
        let path = entry.unwrap().path();
        // What cannot be read as an environment is the loader's matter.
        let Ok(environment) = gnomon_envmap::load(&path, Default::default()) else { continue };
        let map = environment.map;
        for method in methods() {
            let set = method.build(&FitOptions::default()).unwrap().fit(&map).unwrap();
            let error = flux_error(&map, &set);
            assert!(error < FLUX, "{} of {}: {error}", method.name, path.display());
            assert!(is_physical(&map, &set), "{} of {}", method.name, path.display());
            let document = LightDocument::from_json(&set.document().to_json()).unwrap();
            assert_eq!(document.lights.len(), set.lights.len());
        }
        checked += 1;
    }
    assert!(checked >= 20, "only {checked} maps could be read");
}

#[test]
fn a_captured_map_turned_by_a_quarter_has_turned_lights() {
    for name in ["debevec_grace_cross.hdr", "debevec_kitchen_cross.hdr"] {
        let Some(map) = load(name) else { return };
        for method in methods() {
            let fit = method.build(&FitOptions::default()).unwrap();
            let error = turn_error(&fit.fit(&map).unwrap(), &fit.fit(&quarter_turn(&map)).unwrap());
            assert!(error < FIT_ROTATION, "{} of {name}: {error}", method.name);
        }
    }
}
