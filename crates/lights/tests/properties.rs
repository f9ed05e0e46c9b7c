//! Laws that hold for every fit on every map.

mod common;

use common::{flux_error, is_physical, quarter_turn, turn_error};
use glam::{DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::fit::{FitError, by_name, methods, sampler_by_name, samplers};
use gnomon_lights::{DistantLight, FitOptions, LightFit, LightSet, LightShape};
use gnomon_picture::RgbImage;
use gnomon_testing::tolerances::{FIT_ROTATION, FLUX};
use proptest::prelude::*;

/// Every registered fit, once with its defaults and once with each of the other ways to stop.
fn all_fits() -> Vec<Box<dyn LightFit>> {
    let none = FitOptions::default();
    let options = [
        none.clone(),
        FitOptions { light_count: Some(13), ..none.clone() },
        FitOptions { threshold: Some(0.03), ..none.clone() },
        FitOptions { max_extent: Some(0.7), ..none.clone() },
        FitOptions { max_extent: Some(0.7), threshold: Some(0.03), ..none.clone() },
        FitOptions { ground: true, light_count: Some(13), ..none.clone() },
        FitOptions { ground: true, light_count: Some(30), ..none.clone() },
    ];
    let sampled = samplers().iter().map(|&sampler| FitOptions { sampler: Some(sampler), ..none.clone() });
    let options: Vec<FitOptions> = options.into_iter().chain(sampled).collect();
    methods()
        .iter()
        .flat_map(|method| options.iter().map(|options| method.build(options)))
        .filter(|fit| !matches!(fit, Err(FitError::NoThreshold(_) | FitError::NoSampler(_))))
        .map(Result::unwrap)
        .collect()
}

/// A dim gradient with bright spots of any size, so that no two texels tie.
fn spotted(width: u32, height: u32, spots: &[(f32, f32, f32, f32)]) -> Equirect {
    Equirect::new(RgbImage::from_fn(width, height, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let noise = ((x * 7919 + y * 104_729) % 1013) as f32 / 1013.0;
        let dim = Vec3::new(0.2 + 0.1 * noise, 0.3 * v + 0.1 * noise, 0.1 + 0.2 * noise);
        spots.iter().fold(dim, |sum, &(at_u, at_v, radius, strength)| {
            let du = (u - at_u).abs().min(1.0 - (u - at_u).abs());
            let inside = (2.0 * du).hypot(v - at_v) < radius;
            if inside { sum + strength * Vec3::new(1.0, 0.8 + 0.1 * noise, 0.5) } else { sum }
        })
    }))
}

fn spots() -> impl Strategy<Value = Vec<(f32, f32, f32, f32)>> {
    prop::collection::vec((0.0_f32..1.0, 0.05_f32..0.95, 0.01_f32..0.15, 1.0_f32..1e4), 0..5)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4, max_shrink_iters: 20, ..ProptestConfig::default() })]

    #[test]
    fn flux_is_kept_and_radiance_stays_physical(spots in spots(), width in 1_u32..90, height in 1_u32..50) {
        let map = spotted(width, height, &spots);
        for fit in all_fits() {
            let set = fit.fit(&map).unwrap();
            prop_assert!(flux_error(&map, &set) < FLUX, "{}: {}", fit.name(), flux_error(&map, &set));
            prop_assert!(is_physical(&map, &set), "{}", fit.name());
        }
    }

    #[test]
    fn a_quarter_turn_of_the_map_turns_the_lights(spots in spots()) {
        let map = spotted(128, 64, &spots);
        for fit in all_fits() {
            let (before, after) = (fit.fit(&map).unwrap(), fit.fit(&quarter_turn(&map)).unwrap());
            let error = turn_error(&before, &after);
            prop_assert!(error < FIT_ROTATION, "{} {:?}: {error}", fit.name(), fit.parameters());
        }
    }

    #[test]
    fn a_light_count_is_met(spots in spots(), count in 6_usize..150) {
        let options = FitOptions { light_count: Some(count), ..FitOptions::default() };
        let map = spotted(128, 64, &spots);
        let found = |method| by_name(method, &options).unwrap().fit(&map).unwrap().lights.len();
        prop_assert_eq!([found("partition"), found("optimized")], [count; 2]);
        // One threshold for all faces: the count jumps, by two or three where a light a face is already most of it.
        for method in ["squares", "rectangles"] {
            let found = found(method);
            prop_assert!(found <= count && found + 2 + count / 6 >= count, "{} {} of {}", method, found, count);
        }
    }
}

#[test]
fn disks_give_as_many_lights_as_asked_for() {
    let map = spotted(128, 64, &[(0.3, 0.4, 0.05, 50.0)]);
    for count in [1, 2, 10, 50] {
        let options = FitOptions { light_count: Some(count), ..FitOptions::default() };
        assert_eq!(by_name("disks", &options).unwrap().fit(&map).unwrap().lights.len(), count);
    }
}

#[test]
fn the_flux_checker_notices_a_lost_light_and_a_dimmed_residual() {
    let map = spotted(64, 32, &[(0.3, 0.4, 0.05, 50.0)]);
    let set = by_name("disks", &FitOptions::default()).unwrap().fit(&map).unwrap();
    assert!(!set.lights.is_empty() && flux_error(&map, &set) < FLUX);
    let mut lost = set.clone();
    lost.lights.pop();
    assert!(flux_error(&map, &lost) > FLUX);
    let texels =
        set.residual.radiance().texels().iter().map(|texel| *texel * Vec3::new(1.0, 0.999, 1.0)).collect();
    let dimmed = Equirect::new(RgbImage::from_texels(64, 32, texels).unwrap());
    assert!(flux_error(&map, &LightSet { residual: dimmed, ..set }) > FLUX);
}

#[test]
fn the_turn_checker_notices_a_turn_the_wrong_way_and_a_wrong_size() {
    let map = spotted(128, 64, &[(0.3, 0.4, 0.05, 50.0), (0.7, 0.2, 0.1, 20.0)]);
    for method in methods() {
        let fit = method.build(&FitOptions::default()).unwrap();
        let set = fit.fit(&map).unwrap();
        let wrong_way = quarter_turn(&quarter_turn(&quarter_turn(&map)));
        assert!(turn_error(&set, &fit.fit(&wrong_way).unwrap()) > 0.1, "{}", method.name);
    }
    let light = |radius: f64| vec![DistantLight::disk(DVec3::Y, radius, DVec3::ONE)];
    let set = |radius: f64| LightSet::new("disks", light(radius), map.clone());
    assert!(turn_error(&set(0.1), &set(0.1)) < 1e-6 && turn_error(&set(0.1), &set(0.11)) > FIT_ROTATION);
}

#[test]
fn a_black_map_has_no_lights() {
    for (width, height) in [(1, 1), (2, 1), (64, 32)] {
        let map = Equirect::new(RgbImage::filled(width, height, Vec3::ZERO));
        for fit in all_fits() {
            let set = fit.fit(&map).unwrap();
            assert!(set.lights.is_empty() && set.residual == map, "{}", fit.name());
        }
    }
}

#[test]
fn tiny_constant_and_single_texel_maps_keep_their_flux() {
    for (width, height) in [(1, 1), (2, 1), (1, 2), (4, 2), (64, 32)] {
        let constant = Equirect::new(RgbImage::filled(width, height, Vec3::new(1.0, 0.5, 0.0)));
        let hot = Equirect::new(RgbImage::from_fn(width, height, |x, y| {
            if (x, y) == (width / 2, height / 3) { Vec3::new(1e5, 2e4, 3.0) } else { Vec3::ZERO }
        }));
        for map in [constant, hot] {
            for fit in all_fits() {
                let set = fit.fit(&map).unwrap();
                assert!(
                    flux_error(&map, &set) < FLUX,
                    "{} {width}x{height}: {}",
                    fit.name(),
                    flux_error(&map, &set)
                );
                assert!(is_physical(&map, &set), "{}", fit.name());
            }
        }
    }
}

#[test]
fn a_single_hot_texel_becomes_one_disk_around_it() {
    let hot = (700, 130);
    let map = Equirect::new(RgbImage::from_fn(1024, 512, |x, y| {
        if (x, y) == hot { Vec3::splat(1e6) } else { Vec3::splat(1e-3) }
    }));
    let set = by_name("disks", &FitOptions::default()).unwrap().fit(&map).unwrap();
    assert_eq!(set.lights.len(), 1);
    assert!(set.lights[0].direction.dot(map.texel_direction(hot.0, hot.1)) > 0.999_99);
    assert_eq!(set.residual.radiance().get(hot.0, hot.1), Vec3::ZERO);
}

#[test]
fn maps_that_are_no_radiance_are_refused() {
    for value in [f32::NAN, f32::INFINITY, -1.0] {
        let map = Equirect::new(RgbImage::from_fn(4, 2, |x, y| {
            Vec3::splat(if (x, y) == (3, 1) { value } else { 1.0 })
        }));
        for fit in all_fits() {
            assert_eq!(fit.fit(&map).unwrap_err(), FitError::InvalidTexel { x: 3, y: 1 });
        }
    }
    let empty = Equirect::new(RgbImage::filled(0, 0, Vec3::ZERO));
    assert!(matches!(all_fits()[0].fit(&empty), Err(FitError::EmptyMap { .. })));
}

/// Diameter of a disk, longest side of a rectangle [rad].
fn width(light: &DistantLight) -> f32 {
    match light.shape {
        LightShape::Disk { angular_radius } => 2.0 * angular_radius,
        LightShape::Rectangle { corners } => {
            (0..4).map(|i| corners[i].angle_between(corners[(i + 1) % 4])).fold(0.0, f32::max)
        }
    }
}

#[test]
fn no_light_is_wider_than_allowed() {
    let map = spotted(128, 64, &[(0.3, 0.4, 0.15, 50.0)]);
    for method in methods() {
        for threshold in [None, Some(0.02)] {
            let options = FitOptions { max_extent: Some(0.5), threshold, ..FitOptions::default() };
            let Ok(fit) = method.build(&options) else { continue };
            let set = fit.fit(&map).unwrap();
            let widest = set.lights.iter().map(width).fold(0.0, f32::max);
            assert!(widest < 0.501, "{}: {widest}", method.name);
        }
    }
}

#[test]
fn options_out_of_range_are_refused_in_words() {
    let none = FitOptions::default();
    for (name, options, words) in [
        ("rectangles", FitOptions { light_count: Some(3), ..none.clone() }, "at least 6"),
        ("disks", FitOptions { light_count: Some(0), ..none.clone() }, "1 to 4096"),
        ("disks", FitOptions { max_extent: Some(0.01), ..none.clone() }, "out of range"),
        ("squares", FitOptions { max_extent: Some(f32::NAN), ..none.clone() }, "out of range"),
        ("partition", FitOptions { threshold: Some(0.1), ..none.clone() }, "no threshold"),
        ("disks", FitOptions { sampler: sampler_by_name("structured").ok(), ..none.clone() }, "no sampler"),
        ("squares", FitOptions { light_count: Some(9), threshold: Some(0.1), ..none.clone() }, "exclude"),
    ] {
        let message = by_name(name, &options).err().unwrap().to_string();
        assert!(message.contains(words) && !message.contains('\n'), "{message}");
    }
}
