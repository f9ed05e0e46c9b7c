//! Resampling keeps flux, constants and places.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

mod common;

use std::f64::consts::PI;

use common::{flux_error, rms, uneven};
use glam::{DVec3, Vec3};
use gnomon_envmap::{CubeMap, Equirect};
use gnomon_picture::RgbImage;
use proptest::prelude::*;

fn constant(width: u32, height: u32) -> Equirect {
    Equirect::new(RgbImage::filled(width, height, Vec3::new(0.5, 1.0, 2.0)))
}

/// Largest relative deviation of any texel from the constant.
fn deviation<'a>(texels: impl IntoIterator<Item = &'a Vec3>) -> f32 {
    let off = |texel: &Vec3| (*texel / Vec3::new(0.5, 1.0, 2.0) - 1.0).abs().max_element();
    texels.into_iter().map(off).fold(0.0, f32::max)
}

fn cube_texels(cube: &CubeMap) -> impl Iterator<Item = &Vec3> {
    cube.faces().iter().flat_map(|face| face.texels())
}

/// Flux-weighted mean direction of what is not black.
fn centre(map: &Equirect) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for y in 0..map.height() {
        for x in 0..map.width() {
            let weight = f64::from(map.radiance().get(x, y).x) * map.texel_solid_angle(y);
            sum += map.texel_direction(x, y).as_dvec3() * weight;
        }
    }
    sum.normalize()
}

#[test]
fn solid_angles_of_cube_texels_are_those_of_their_area() {
    let cube = CubeMap::new(std::array::from_fn(|_| RgbImage::filled(8, 8, Vec3::ONE))).unwrap();
    let mut total = 0.0;
    for y in 0..8 {
        for x in 0..8 {
            // The area element of a plane at distance 1 has (1 + s^2 + t^2)^(-3/2) of solid angle.
            let at = |i: u32, k: u32| 2.0 * (f64::from(i) + (f64::from(k) + 0.5) / 64.0) / 8.0 - 1.0;
            let points = (0..64 * 64).map(|k| (at(x, k % 64), at(y, k / 64)));
            let sum: f64 = points.map(|(s, t)| (1.0 + s * s + t * t).powf(-1.5)).sum();
            let numeric = sum * (0.25 / 64.0) * (0.25 / 64.0);
            assert!((cube.texel_solid_angle(x, y) / numeric - 1.0).abs() < 1e-4);
            total += cube.texel_solid_angle(x, y);
        }
    }
    assert!((6.0 * total - 4.0 * PI).abs() < 1e-12);
    assert!(flux_error(cube.flux(), DVec3::splat(4.0 * PI)) < 1e-6);
}

#[test]
fn directions_and_faces_are_inverse_and_unmirrored() {
    let cube = CubeMap::new(std::array::from_fn(|_| RgbImage::filled(5, 5, Vec3::ZERO))).unwrap();
    for face in 0..6 {
        for (x, y) in (0..25).map(|i| (i % 5, i / 5)) {
            let direction = cube.texel_direction(face, x, y);
            let (found, position) = CubeMap::face_and_position(direction);
            let texel = (position + 1.0) * 2.5;
            assert_eq!((found, texel.x as u32, texel.y as u32), (face, x, y));
        }
        // Seen from inside, right x up points back at the viewer.
        let [middle, right, below] = [(2, 2), (3, 2), (2, 3)].map(|(x, y)| cube.texel_direction(face, x, y));
        assert!((right - middle).cross(middle - below).dot(middle) < 0.0);
    }
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    for (face, axis) in axes.into_iter().enumerate() {
        assert!((cube.texel_direction(face, 2, 2) - axis).length() < 1e-6);
    }
}

#[test]
fn cube_lookup_has_no_seam() {
    let map = uneven(64, 32);
    let cube = CubeMap::from_equirect(&map, 16);
    // Along circles that cross every edge, and through the corners, a small step is a small change.
    let brightest = cube_texels(&cube).fold(0.0f32, |a, texel| a.max(texel.max_element()));
    let circles: [fn(f32, f32) -> Vec3; 3] =
        [|a, b| Vec3::new(a, b, 0.31), |a, b| Vec3::new(0.77, a, b), |a, b| Vec3::new(a, a, b)];
    for circle in circles {
        let steps = 20_000;
        let at = |i: u32| {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / steps as f32).sin_cos();
            cube.lookup(circle(sin, cos))
        };
        let jump = (0..steps).map(|i| (at(i) - at(i + 1)).abs().max_element()).fold(0.0, f32::max);
        // A texel is 0.06 rad at least, so a step of 0.0003 rad changes at most a 100th of the range or so.
        assert!(jump < 0.02 * brightest, "{jump} of {brightest}");
    }
    for face in 0..6 {
        assert!(
            (cube.lookup(cube.texel_direction(face, 3, 9)) - cube.faces()[face].get(3, 9)).length() < 1e-3
        );
    }
}

#[test]
fn flux_is_exact_and_constants_stay_constant() {
    for (width, height, size) in [
        (1024, 512, 128),
        (512, 256, 256),
        (64, 32, 100),
        (256, 128, 7),
        (3, 2, 5),
        (1, 1, 1),
        (8, 4, 64),
        (33, 71, 16),
    ] {
        let map = uneven(width, height);
        let cube = CubeMap::from_equirect(&map, size);
        assert!(flux_error(cube.flux(), map.flux()) < 1e-6, "{width} x {height} to {size}");
        let back = Equirect::from_cube(&cube, width, height);
        assert!(flux_error(back.flux(), map.flux()) < 1e-6, "{size} to {width} x {height}");

        let flat = CubeMap::from_equirect(&constant(width, height), size);
        let off = deviation(cube_texels(&flat));
        assert!(off < 1e-3, "{width} x {height} to {size}: {off}");
        let faces = std::array::from_fn(|_| RgbImage::filled(size, size, Vec3::new(0.5, 1.0, 2.0)));
        let flat = Equirect::from_cube(&CubeMap::new(faces).unwrap(), width, height);
        let off = deviation(flat.radiance().texels());
        assert!(off < 1e-3, "{size} to {width} x {height}: {off}");
    }
}

#[test]
fn a_bright_texel_stays_where_it_was() {
    for (x, y) in [(0, 0), (130, 3), (255, 64), (64, 127), (200, 90), (31, 32), (96, 63)] {
        let mut image = RgbImage::filled(256, 128, Vec3::ZERO);
        *image.get_mut(x, y) = Vec3::splat(1e4);
        let map = Equirect::new(image);
        let cube = CubeMap::from_equirect(&map, 64);
        for face in 0..6 {
            for (column, row) in (0..64 * 64).map(|i| (i % 64, i / 64)) {
                let far = cube.texel_direction(face, column, row).angle_between(map.texel_direction(x, y));
                // Half the diagonals of a texel of either map.
                let lit = cube.faces()[face].get(column, row).x > 0.0;
                assert!(!lit || far < 0.018 + 0.023, "({x}, {y}) reaches {far} rad");
            }
        }
        let back = Equirect::from_cube(&cube, 256, 128);
        let moved = centre(&back).angle_between(centre(&map));
        // Half the diagonal of the cube's texels, inside which a texel loses its place.
        assert!(moved < 0.018, "({x}, {y}) moved by {moved} rad");
    }
}

#[test]
fn a_finer_grid_and_back_gives_the_map() {
    let map = uneven(64, 32);
    assert!(rms(&map.resized(320, 160).resized(64, 32), &map) < 1e-6);
    let cube = CubeMap::from_equirect(&map, 256);
    assert!(rms(&Equirect::from_cube(&cube, 64, 32), &map) < 0.05);
}

#[test]
fn resizing_is_exact() {
    let map = uneven(60, 30);
    for (width, height) in [(60, 30), (15, 10), (7, 3), (121, 64), (1, 1), (1024, 5)] {
        let resized = map.resized(width, height);
        assert!(flux_error(resized.flux(), map.flux()) < 1e-6, "{width} x {height}");
        assert!(deviation(constant(60, 30).resized(width, height).radiance().texels()) < 1e-6);
    }
    // Two rows of unequal solid angle: the mean is weighted by it.
    let two = Equirect::new(RgbImage::from_fn(1, 4, |_, y| Vec3::splat(y as f32)));
    let expected = (two.texel_solid_angle(1) / (two.texel_solid_angle(0) + two.texel_solid_angle(1))) as f32;
    assert!((two.resized(1, 2).radiance().get(0, 0).x - expected).abs() < 1e-6);
}

#[test]
fn turning_moves_what_was_seen() {
    let map = uneven(64, 32);
    let quarter = map.rotated(std::f32::consts::FRAC_PI_2);
    for (x, y) in [(0, 5), (17, 16), (63, 30)] {
        let direction = map.texel_direction(x, y);
        let turned = glam::Quat::from_rotation_y(std::f32::consts::FRAC_PI_2) * direction;
        assert!((quarter.lookup(turned) - map.radiance().get(x, y)).length() < 0.02);
    }
    // Whole texels move without a change of a bit.
    let back = quarter.rotated(-std::f32::consts::FRAC_PI_2);
    assert_eq!(back, map);
    assert_eq!(map.rotated(std::f32::consts::TAU), map);
    assert_eq!(map.rotated(0.0), map);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn turning_keeps_flux(yaw in -20.0f32..20.0) {
        let map = uneven(48, 24);
        let turned = map.rotated(yaw);
        prop_assert!(flux_error(turned.flux(), map.flux()) < 1e-6);
        let expected = glam::DQuat::from_rotation_y(f64::from(yaw)) * centre(&map);
        prop_assert!(centre(&turned).angle_between(expected) < 0.01);
    }

    #[test]
    fn any_pair_of_sizes_keeps_flux(width in 1u32..40, height in 1u32..40, size in 1u32..20) {
        let map = uneven(width, height);
        let cube = CubeMap::from_equirect(&map, size);
        prop_assert!(flux_error(cube.flux(), map.flux()) < 1e-6);
        prop_assert!(cube_texels(&cube).all(|texel| texel.is_finite() && texel.min_element() >= 0.0));
        prop_assert!(deviation(cube_texels(&CubeMap::from_equirect(&constant(width, height), size))) < 1e-3);
    }
}
