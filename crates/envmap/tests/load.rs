//! Files of every projection: the data's own twins and expected results, cleaning, refusal.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

mod common;

use std::path::PathBuf;

use common::{MAPS, flux_error, rms, uneven};
use glam::{DVec3, Vec3};
use gnomon_envmap::{
    CleanReport, CubeMap, EnvMapError, Environment, Equirect, LoadOptions, Projection, load,
};
use gnomon_picture::RgbImage;
use gnomon_testing::data_file;

fn data(name: &str) -> Option<Environment> {
    Some(
        load(data_file(&format!("env/{name}"))?, LoadOptions::default())
            .unwrap_or_else(|error| panic!("{error}")),
    )
}

fn named(projection: Projection) -> LoadOptions<'static> {
    LoadOptions { projection: Some(projection), layer: None }
}

/// Writes a picture where the test's folder is and loads it.
fn reload(image: &RgbImage, forced: Option<Projection>) -> Result<Environment, EnvMapError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("map.exr");
    gnomon_picture::write(&path, image).unwrap();
    let options = LoadOptions { projection: forced, layer: None };
    let loaded = load(&path, options);
    // Bytes give what their file gives.
    let from_bytes = gnomon_envmap::from_bytes(&path, &std::fs::read(&path).unwrap(), options);
    let said = |result: &Result<Environment, EnvMapError>| match result {
        Ok(environment) => format!("{:?}", (&environment.map, environment.warnings())),
        Err(error) => error.to_string(),
    };
    assert_eq!(said(&loaded), said(&from_bytes));
    loaded
}

#[test]
fn every_map_of_the_test_data_is_finite_and_covers_the_sphere() {
    for name in MAPS {
        let Some(environment) = data(name) else { return };
        let map = &environment.map;
        assert!(
            map.radiance().texels().iter().all(|texel| texel.is_finite() && texel.min_element() >= 0.0),
            "{name}"
        );
        assert!(map.flux().min_element() > 0.0, "{name}");
        assert_eq!(map.width(), 2 * map.height(), "{name}");
    }
}

#[test]
fn lat_long_and_cube_of_openexr_give_the_same_radiance() {
    // Relative RMS difference as measured, with some room; the finer, the more it is the two files' own sampling.
    let twins =
        [("Kerner", 0.002, 0.03, "Env"), ("Orientation", 0.003, 0.006, ""), ("WavyLines", 0.005, 0.045, "")];
    for (name, coarse, fine, infix) in twins {
        let Some(lat_long) = data(&format!("openexr_{name}{infix}LatLong.exr")) else { return };
        let Some(cube) = data(&format!("openexr_{name}{infix}Cube.exr")) else { return };
        assert_eq!((lat_long.projection, cube.projection), (Projection::Equirect, Projection::SixFaces));
        assert!(flux_error(cube.map.flux(), lat_long.map.flux()) < 2e-4, "{name}");
        for (width, limit) in [(32, coarse), (128, fine)] {
            let off = rms(&cube.map.resized(width, width / 2), &lat_long.map.resized(width, width / 2));
            assert!(off < limit, "{name} at {width}: {off}");
        }
    }
}

#[test]
fn twins_disagree_when_their_samples_are_taken_as_areas() {
    // The planted fault of the test above: without the attribute, texels count as areas.
    let Some(lat_long) = data("openexr_WavyLinesLatLong.exr") else { return };
    let Some(cube) = data_file("env/openexr_WavyLinesCube.exr") else { return };
    let cube = reload(&gnomon_picture::read(cube).unwrap().image, None).unwrap();
    assert_eq!(cube.projection, Projection::SixFaces);
    let off = rms(&cube.map.resized(32, 16), &lat_long.map.resized(32, 16));
    assert!(off > 0.01, "{off}");
}

#[test]
fn the_angular_probe_gives_the_expected_lat_long() {
    let Some(probe) = data_file("env/oiio_uffizi_probe-128_angular.exr") else { return };
    let Some(expected) = data_file("env/oiio_uffizi_latlong_env-128_expected.exr") else { return };
    // OpenImageIO computed it for texels as areas, though the file's attribute says otherwise.
    let expected = Equirect::new(gnomon_picture::read(expected).unwrap().image);
    let compare = |map: Equirect| rms(&map.resized(expected.width(), expected.height()), &expected);

    let as_openimageio = load(&probe, named(Projection::MirroredProbe)).unwrap().map;
    let off = compare(as_openimageio);
    // 128 texels across: OpenImageIO interpolates where we average.
    assert!(off < 0.04, "{off}");

    // As Debevec describes the probe, the same with front and back exchanged.
    let as_debevec = load(&probe, LoadOptions::default()).unwrap();
    assert_eq!(as_debevec.projection, Projection::AngularProbe);
    assert!(compare(as_debevec.map.clone()) > 0.15);
    let (width, height) = (as_debevec.map.width(), as_debevec.map.height());
    let exchanged = |x: u32, y: u32| as_debevec.map.radiance().get((width / 2 + width - 1 - x) % width, y);
    assert!(compare(Equirect::new(RgbImage::from_fn(width, height, exchanged))) < 0.04);
}

#[test]
fn the_angular_probe_is_not_mirrored() {
    // The same place as photographed for a lat-long map: it must match after some turn, not after a reflection.
    let Some(probe) = data("oiio_uffizi_probe-128_angular.exr") else { return };
    let Some(photograph) = data("uffizi_latlong_1200x600.hdr") else { return };
    let (probe, photograph) = (probe.map.resized(128, 64), photograph.map.resized(128, 64));
    let best = |mirror: bool| {
        let off = |turn: u32| {
            let texel = |x: u32, y: u32| {
                let x = if mirror { 127 - x } else { x };
                probe.radiance().get((x + turn) % 128, y)
            };
            rms(&Equirect::new(RgbImage::from_fn(128, 64, texel)), &photograph)
        };
        (0..128).map(off).fold(f64::MAX, f64::min)
    };
    assert!(best(false) < 0.1, "{}", best(false));
    assert!(best(true) > 0.2, "{}", best(true));
}

#[test]
fn a_cross_matches_the_lat_long_that_another_program_made_of_it() {
    // Made for the reference renders with axes as in CONVENTIONS.md (renders.json).
    for name in ["grace", "galileo", "stpeters"] {
        let Some(cross) = data(&format!("debevec_{name}_cross.hdr")) else { return };
        let Some(theirs) = data_file(&format!("reference/env_{name}_latlong_512x256.exr")) else { return };
        let theirs = load(theirs, LoadOptions::default()).unwrap();
        assert_eq!(cross.projection, Projection::VerticalCross);
        // Theirs is interpolated, which does not keep flux.
        let off = flux_error(cross.map.flux(), theirs.map.flux());
        assert!(off < 6e-3, "{name}: {off}");
        let off = rms(&cross.map.resized(64, 32), &theirs.map.resized(64, 32));
        assert!(off < 0.05, "{name}: {off}");
    }
}

/// The layouts that a cube map can be written in.
fn layouts(cube: &CubeMap) -> Vec<(Projection, RgbImage)> {
    let size = cube.size();
    let face = |face: usize, x: u32, y: u32| cube.faces()[face].get(x % size, y % size);
    let vertical = RgbImage::from_fn(3 * size, 4 * size, |x, y| match (x / size, y / size) {
        (1, 0) => face(2, x, y),
        (0, 1) => face(1, x, y),
        (1, 1) => face(5, x, y),
        (2, 1) => face(0, x, y),
        (1, 2) => face(3, x, y),
        (1, 3) => face(4, size - 1 - x % size, size - 1 - y % size),
        _ => Vec3::splat(f32::NAN),
    });
    let horizontal = RgbImage::from_fn(4 * size, 3 * size, |x, y| match (x / size, y / size) {
        (1, 0) => face(2, x, y),
        (0, 1) => face(1, x, y),
        (1, 1) => face(5, x, y),
        (2, 1) => face(0, x, y),
        (3, 1) => face(4, x, y),
        (1, 2) => face(3, x, y),
        _ => Vec3::splat(f32::NAN),
    });
    let column = RgbImage::from_fn(size, 6 * size, |x, y| face((y / size) as usize, x, y));
    let row = RgbImage::from_fn(6 * size, size, |x, y| face((x / size) as usize, x, y));
    vec![
        (Projection::VerticalCross, vertical),
        (Projection::HorizontalCross, horizontal),
        (Projection::SixFaces, column),
        (Projection::SixFaces, row),
    ]
}

#[test]
fn every_layout_of_a_cube_gives_the_same_map_and_its_flux() {
    let cube = CubeMap::from_equirect(&uneven(64, 32), 16);
    let expected = Equirect::from_cube(&cube, 64, 32);
    for (projection, image) in layouts(&cube) {
        let environment = reload(&image, None).unwrap();
        assert_eq!(environment.projection, projection);
        assert_eq!(environment.source_size, (image.width(), image.height()));
        // The empty corners of a cross are no part of the map.
        assert_eq!(environment.report, CleanReport::default(), "{}", projection.name());
        assert!(rms(&environment.map, &expected) < 1e-6, "{}", projection.name());
        assert!(flux_error(environment.map.flux(), cube.flux()) < 1e-6);
    }
}

#[test]
fn a_probe_keeps_its_flux() {
    // Solid angle of a texel of the disc by brute force, independent of the loader's own sum.
    let size = 24;
    let image = RgbImage::from_fn(size, size, |x, y| Vec3::new(1.0, (x * y % 7) as f32, (x / 5) as f32));
    let mut flux = DVec3::ZERO;
    let fine = 40;
    for (i, j) in (0..size * fine).flat_map(|j| (0..size * fine).map(move |i| (i, j))) {
        let at = |k: u32| 2.0 * (f64::from(k) + 0.5) / f64::from(size * fine) - 1.0;
        let r = at(i).hypot(at(j));
        if r < 1.0 {
            let angle = std::f64::consts::PI * (std::f64::consts::PI * r).sin() / r;
            flux += image.get(i / fine, j / fine).as_dvec3() * angle * (2.0 / f64::from(size * fine)).powi(2);
        }
    }
    for projection in [Projection::AngularProbe, Projection::MirroredProbe] {
        let environment = reload(&image, Some(projection)).unwrap();
        let off = flux_error(environment.map.flux(), flux);
        assert!(off < 2e-3, "{off}");
        let red =
            environment.map.radiance().texels().iter().map(|texel| (texel.x - 1.0).abs()).fold(0.0, f32::max);
        assert!(red < 2e-3, "a constant varies by {red}");
    }
}

#[test]
fn what_is_no_radiance_is_cleaned_and_counted() {
    let mut image = RgbImage::filled(8, 4, Vec3::splat(2.0));
    *image.get_mut(0, 0) = Vec3::new(f32::NAN, 1.0, 1.0);
    *image.get_mut(1, 0) = Vec3::new(-3.0, 1.0, f32::NEG_INFINITY);
    *image.get_mut(2, 0) = Vec3::new(f32::INFINITY, 1.0, 1.0);
    *image.get_mut(3, 0) = Vec3::new(1.0, 50.0, 1.0);
    let environment = reload(&image, None).unwrap();
    assert_eq!(environment.report, CleanReport { nan: 1, negative: 1, infinite: 1 });
    assert_eq!(environment.warnings().len(), 3);
    let row: Vec<Vec3> = (0..4).map(|x| environment.map.radiance().get(x, 0)).collect();
    assert_eq!(row[..2], [Vec3::new(0.0, 1.0, 1.0), Vec3::new(0.0, 1.0, 0.0)]);
    assert_eq!(row[2..], [Vec3::new(50.0, 1.0, 1.0), Vec3::new(1.0, 50.0, 1.0)]);
    // Nothing finite at all is black.
    let environment = reload(&RgbImage::filled(2, 1, Vec3::INFINITY), None).unwrap();
    assert_eq!((environment.map.flux(), environment.report.infinite), (DVec3::ZERO, 2));
}

/// Wider than light is worked out from; low, so that tests stay quick.
fn large(texel: impl Fn(u32, u32) -> Vec3) -> (RgbImage, Environment) {
    let image = RgbImage::from_fn(4100, 7, texel);
    let environment = reload(&image, Some(Projection::Equirect)).unwrap();
    (image, environment)
}

#[test]
fn large_maps_are_averaged_by_exact_area_and_seen_as_they_are() {
    let texel = |x: u32, y: u32| Vec3::new((x * 37 % 101) as f32, 1.0 + y as f32, (x * x % 7) as f32 * 0.1);
    let (image, environment) = large(texel);
    let whole = Equirect::new(image);
    assert_eq!(environment.source_size, (4100, 7));
    let expected = whole.resized(2050, 4);
    assert!(rms(&environment.map, &expected) < 1e-6, "{}", rms(&environment.map, &expected));
    assert!(flux_error(environment.map.flux(), whole.flux()) < 1e-6);
    let backdrop = environment.map.backdrop().unwrap();
    assert_eq!((backdrop.width(), backdrop.height()), (4100, 7));
    for i in 0..500_u32 {
        let direction = whole.texel_direction(i * 8 + i % 8, i % 7);
        let (seen, right) = (environment.map.seen(direction), whole.lookup(direction));
        assert!((seen - right).abs().max_element() < right.max_element() / 256.0, "{seen} {right}");
    }
    // Of what is no larger nothing changes.
    let image = RgbImage::from_fn(4096, 3, texel);
    let kept = reload(&image, Some(Projection::Equirect)).unwrap().map;
    assert!(kept.backdrop().is_none() && *kept.radiance() == image);
}

#[test]
fn a_small_sun_in_a_large_map_keeps_its_flux_and_its_place() {
    let (image, environment) =
        large(|x, y| if (x, y) == (1001, 2) { Vec3::new(9e6, 8e6, 7e6) } else { Vec3::splat(0.5) });
    let whole = Equirect::new(image);
    assert!(flux_error(environment.map.flux(), whole.flux()) < 1e-6);
    let map = &environment.map;
    let brightest = (0..4).flat_map(|y| (0..2050).map(move |x| (x, y))).max_by(|a, b| {
        let at = |&(x, y): &(u32, u32)| map.radiance().get(x, y).x;
        at(a).total_cmp(&at(b))
    });
    assert_eq!(brightest, Some((500, 1)));
    // What is seen is as bright as the file's texel.
    let seen = map.seen(whole.texel_direction(1001, 2));
    assert!((seen / Vec3::new(9e6, 8e6, 7e6) - 1.0).abs().max_element() < 0.01, "{seen}");
}

#[test]
fn large_maps_are_cleaned_like_small_ones() {
    let (_, environment) = large(|x, _| match x {
        100 => Vec3::new(f32::NAN, 2.0, 2.0),
        200 => Vec3::new(2.0, -2.0, f32::NEG_INFINITY),
        300 | 301 => Vec3::new(f32::INFINITY, 2.0, 2.0),
        400 => Vec3::splat(70.0),
        _ => Vec3::splat(2.0),
    });
    assert_eq!(environment.report, CleanReport { nan: 7, negative: 7, infinite: 14 });
    let at = |x: u32| environment.map.radiance().get(x, 1);
    assert_eq!(at(150), Vec3::new(70.0, 2.0, 2.0));
    assert_eq!([at(50).x, at(100).y, at(100).z, at(200).x], [1.0, 1.0, 1.0, 36.0]);
}

#[test]
fn nan_and_infinity_of_the_test_data_are_counted() {
    let Some(path) = data_file("env/openexr_BrightRingsNanInf.exr") else { return };
    let environment = load(&path, named(Projection::Equirect)).unwrap();
    let CleanReport { nan, infinite, .. } = environment.report;
    assert!(nan > 0 && infinite > 0 && environment.warnings().len() >= 2);
    assert!(environment.map.radiance().texels().iter().all(|texel| texel.is_finite()));
}

#[test]
fn tiny_maps_have_a_meaning_and_odd_shapes_an_error() {
    for (width, height, projection) in [
        (1, 1, "angular-probe"),
        (2, 1, "equirect"),
        (3, 4, "vertical-cross"),
        (4, 3, "horizontal-cross"),
        (1, 6, "six-faces"),
    ] {
        let environment = reload(&RgbImage::filled(width, height, Vec3::ONE), None).unwrap();
        assert_eq!(environment.projection.name(), projection);
        let flux = DVec3::splat(4.0 * std::f64::consts::PI);
        assert!(flux_error(environment.map.flux(), flux) < 1e-6, "{projection}");
    }
    for (width, height) in [(1000, 1), (1, 1000), (7, 5)] {
        let text = reload(&RgbImage::filled(width, height, Vec3::ONE), None).unwrap_err().to_string();
        for &projection in Projection::ALL {
            assert!(text.contains(projection.name()), "{text}");
        }
        assert_eq!(text.lines().count(), 1);
        // Named, any shape is a lat-long map, and nothing else.
        let image = RgbImage::filled(width, height, Vec3::ONE);
        assert!(reload(&image, Some(Projection::Equirect)).is_ok());
        let refused = reload(&image, Some(Projection::SixFaces));
        assert!(matches!(refused, Err(EnvMapError::WrongShape { .. })));
    }
    let absent = load(PathBuf::from("absent.hdr"), LoadOptions::default());
    assert!(matches!(absent, Err(EnvMapError::Image(_))));
}
