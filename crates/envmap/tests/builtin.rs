//! The environments made by code.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

mod common;

use common::flux_error;
use glam::{DVec3, Vec3};
use gnomon_envmap::builtin;

#[test]
fn they_are_the_same_every_time_and_sound() {
    for name in builtin::names() {
        let map = builtin::by_name(name).unwrap();
        assert_eq!((map.width(), map.height()), (1024, 512));
        assert_eq!(builtin::by_name(name).unwrap(), map, "{name}");
        assert!(map.radiance().texels().iter().all(|texel| texel.is_finite() && texel.min_element() >= 0.0));
        let small = builtin::sized(name, 256, 128).unwrap();
        assert!(flux_error(small.flux(), map.flux()) < 0.02, "{name}: {} {}", small.flux(), map.flux());
        for (width, height) in [(1, 1), (2, 1), (5, 9), (0, 0)] {
            let tiny = builtin::sized(name, width, height).unwrap();
            assert!(tiny.flux().is_finite(), "{name}");
        }
    }
    assert!(builtin::by_name("garage").is_none());
}

#[test]
fn the_sun_has_its_size_and_brightness() {
    let map = builtin::sized("sky", 4096, 2048).unwrap();
    let brightest = map.radiance().texels().iter().fold(0.0f32, |a, texel| a.max(texel.y));
    let (mut angle, mut flux, mut towards) = (0.0, 0.0, Vec3::ZERO);
    for (x, y) in (0..2048).flat_map(|y| (0..4096).map(move |x| (x, y))) {
        let texel = map.radiance().get(x, y).y;
        if texel > 0.02 * brightest {
            flux += f64::from(texel) * map.texel_solid_angle(y);
            towards += map.texel_direction(x, y) * texel;
            angle += map.texel_solid_angle(y) * f64::from(texel / brightest);
        }
    }
    // A disc of 0.533 degrees: 2 pi (1 - cos(0.2665 degrees)) sr.
    let exact = std::f64::consts::TAU * (1.0 - 0.2665f64.to_radians().cos());
    assert!((angle / exact - 1.0).abs() < 0.03, "{angle} for {exact}");
    // At noon the sun gives some five to twelve times the light of a clear sky.
    let sky: f64 = map.flux().y - flux;
    assert!((towards.normalize().y.asin().to_degrees() - 38.0).abs() < 0.1);
    assert!(flux > 0.5 * sky && flux < 2.0 * sky, "sun {flux}, sky and ground {sky}");
    // Its flux is the same however few texels it covers.
    let sun = |width: u32| {
        let map = builtin::sized("sky", width, width / 2).unwrap();
        map.flux() - without_sun(&map)
    };
    assert!(flux_error(sun(1024), sun(4096)) < 0.01, "{} {}", sun(1024), sun(4096));
}

/// Flux of everything dimmer than ten times the zenith.
fn without_sun(map: &gnomon_envmap::Equirect) -> DVec3 {
    let limit = 10.0 * map.radiance().get(0, 0).y;
    let mut sum = DVec3::ZERO;
    for (x, y) in (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y))) {
        let texel = map.radiance().get(x, y);
        if texel.y < limit {
            sum += texel.as_dvec3() * map.texel_solid_angle(y);
        }
    }
    sum
}
