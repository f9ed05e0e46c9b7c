//! What ellipses and horizons say of directions against rays that are cast through the height field.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use glam::{Vec2, Vec3};
use gnomon_bumps::{Ellipse, Field, Prepared, Shape, horizon_between};
use gnomon_scene::{HeightMap, Wrap};
use gnomon_testing::tolerances::{BUMP_ELLIPSES_WRONG, BUMP_HORIZONS_WRONG};
use gnomon_testing::{data_file, skip};

/// A height field and how it lies.
struct Case {
    name: &'static str,
    map: HeightMap,
    scale: f32,
    extent: Vec2,
}

fn made(name: &'static str, side: u32, height: impl Fn(Vec2) -> f32) -> Case {
    let place = |i: u32| Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
    let values = (0..side * side).map(|i| height(place(i))).collect();
    let map = HeightMap::new(side, side, values, [Wrap::Repeat; 2]).unwrap();
    Case { name, map, scale: 1.0, extent: Vec2::ONE }
}

/// Three by three hemispheres of 0.13 m on a square metre, and grooves 0.05 m deep.
fn by_code() -> [Case; 2] {
    let hemispheres = |p: Vec2| {
        let squared = ((3.0 * p).fract() / 3.0 - 1.0 / 6.0).length_squared();
        (0.13 * 0.13 - squared).max(0.0).sqrt()
    };
    let grooves = |p: Vec2| 0.025 * (std::f32::consts::TAU * 4.0 * p.x).cos();
    [made("hemispheres", 96, hemispheres), made("grooves", 96, grooves)]
}

/// Those of the data: how a picture's codes become metres is known.
fn of_data() -> Vec<Case> {
    let read = |name: &str, wrap| {
        let picture = data_file(&format!("height/{name}"))?;
        let text =
            format!("[material.m]\nheight = {{ file = {picture:?}, scale = 1.0, wrap = \"{wrap}\" }}\n");
        let file = tempfile(&text);
        let scene = gnomon_scene_files::load(&file, &Default::default()).unwrap().scene;
        Some(HeightMap::clone(&scene.height_maps[0]))
    };
    let cube = read("bevy_parallax_cube_depth.png", "repeat").map(|map| Case {
        // White is deep.
        name: "parallax cube",
        map,
        scale: -0.1,
        extent: Vec2::ONE,
    });
    let mountain = read("dem_sthelens_327x466_30m_u16.png", "clamp").map(|map| Case {
        name: "St Helens",
        map,
        scale: 2543.0 - 682.0,
        extent: 30.0 * Vec2::new(327.0, 466.0),
    });
    cube.into_iter().chain(mountain).collect()
}

fn tempfile(text: &str) -> std::path::PathBuf {
    let thread = std::thread::current();
    let name = format!("{}.toml", thread.name().unwrap_or("bumps").replace(':', "-"));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Whether a ray from a texel's centre towards `d` leaves the field: steps of a third of a texel.
fn leaves(field: &Field<'_>, [x, y]: [usize; 2], d: Vec3) -> bool {
    let per_metre = d.truncate() / field.spacing;
    let step = 1.0 / (3.0 * per_metre.abs().max_element());
    let start = Vec2::new(x as f32, y as f32);
    let from = field.texel(x as i64, y as i64);
    let highest = field.map.range().map(|value| field.scale * value).into_iter().fold(f32::MIN, f32::max);
    let across = (field.size()[0] + field.size()[1]) as f32;
    for i in 1.. {
        let t = i as f32 * step;
        let z = from + t * d.z;
        if z > highest || t * per_metre.length() > 2.0 * across {
            return true;
        }
        let Some(ground) = field.at(start + t * per_metre) else { return true };
        // A hundredth of a texel's length is rounding.
        if ground > z + 1e-3 * field.spacing.min_element() {
            return false;
        }
    }
    true
}

/// Directions with the density of their cosine.
fn directions() -> impl Iterator<Item = Vec3> {
    (0..64).map(|i| {
        let squared = (i as f32 + 0.5) / 64.0;
        (squared.sqrt() * Vec2::from_angle(2.399_963_2 * i as f32)).extend((1.0 - squared).sqrt())
    })
}

/// Share of pairs of a texel and a direction that ellipses and horizons are wrong about.
fn wrong_shares(case: &Case) -> [f64; 2] {
    let [ellipses, horizons] = [Shape::Ellipses, Shape::Horizons]
        .map(|shape| Prepared::new(&case.map, case.scale, case.extent, shape, false).lit);
    let field = Field::new(&case.map, case.scale, case.extent);
    let [width, height] = field.size();
    let (mut wrong, mut pairs) = ([0u32; 2], 0u32);
    // Every so manyth texel, prime so that no column is left out.
    for texel in (0..width * height).step_by((width * height / 1500).max(1) | 1) {
        let [cx, cy, xx, xy, yy, ..] = ellipses[texel];
        let form = glam::Mat2::from_cols(Vec2::new(xx, xy), Vec2::new(xy, yy)).inverse();
        for d in directions() {
            let lit = leaves(&field, [texel % width, texel / width], d);
            let p = d.truncate() - Vec2::new(cx, cy);
            let in_ellipse = p.dot(form * p) <= 1.0;
            let tangents = horizons[texel].map(|hidden| hidden / (1.0 - hidden));
            let above = d.z > horizon_between(&tangents, d.truncate()) * d.truncate().length();
            wrong[0] += u32::from(in_ellipse != lit);
            wrong[1] += u32::from(above != lit);
            pairs += 1;
        }
    }
    wrong.map(|wrong| f64::from(wrong) / f64::from(pairs))
}

#[test]
fn ellipses_and_horizons_against_rays() {
    let data = of_data();
    if data.is_empty() {
        skip("the height maps of the data are absent: those made by code alone");
    }
    for case in by_code().iter().chain(&data) {
        let [ellipses, horizons] = wrong_shares(case);
        println!(
            "{}: ellipses (12 bytes a texel) {ellipses:.4}, horizons (8 bytes) {horizons:.4}",
            case.name
        );
        assert!(ellipses <= BUMP_ELLIPSES_WRONG, "{}: ellipses {ellipses}", case.name);
        assert!(horizons <= BUMP_HORIZONS_WRONG, "{}: horizons {horizons}", case.name);
    }
}

#[test]
fn flat_fields_hide_and_scatter_nothing() {
    for side in [1, 7] {
        let flat = HeightMap::new(side, side, vec![0.3; (side * side) as usize], [Wrap::Repeat; 2]).unwrap();
        let prepared = Prepared::new(&flat, 2.0, Vec2::ONE, Shape::Ellipses, true);
        for lit in &prepared.lit {
            let [cx, cy, xx, xy, yy, open, ..] = *lit;
            let form = Ellipse { center: Vec2::ZERO, axis: Vec2::X, radii: Vec2::ONE }.shape();
            let off = [cx, cy, xx - form[0], xy, yy - form[2], open - 1.0].map(f32::abs);
            assert!(off.into_iter().all(|off| off < 1e-3), "{lit:?}");
        }
        assert!(prepared.scattered.iter().all(|s| s.irradiance(Vec3::Z, 0.8) == 0.0));
    }
}
