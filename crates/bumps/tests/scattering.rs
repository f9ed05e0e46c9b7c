//! Interreflection of a pit against the closed form of a cavity.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use glam::{Vec2, Vec3};
use gnomon_bumps::{Bounces, Field, Horizons, Prepared, Shape};
use gnomon_scene::{HeightMap, Wrap};
use gnomon_testing::tolerances::BUMP_PIT;

const SIDE: u32 = 144;

/// A pit in a plane, a cap of a sphere with this share of the sphere's area, and the texels in it with the area that each stands for. The
/// sphere's radius is 1 m.
fn pit(share: f32) -> (HeightMap, f32, Vec<(usize, f32)>) {
    // A cap of height h has the area 2 pi h of the sphere's 4 pi.
    let depth = 2.0 * share;
    let rim = (1.0 - (1.0 - depth) * (1.0 - depth)).sqrt();
    let extent = 2.6 * rim;
    let offset =
        |i: u32| extent * (Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32 - 0.5);
    let z = |p: Vec2| (1.0 - depth) - (1.0 - p.length_squared()).max(0.0).sqrt();
    let values = (0..SIDE * SIDE).map(|i| if offset(i).length() < rim { z(offset(i)) } else { 0.0 });
    let map = HeightMap::new(SIDE, SIDE, values.collect(), [Wrap::ClampToEdge; 2]).unwrap();
    // Texels at the rim belong to both.
    let inside = (0..SIDE * SIDE).filter(|&i| offset(i).length() < rim - extent / SIDE as f32);
    let texels = inside.map(|i| (i as usize, 1.0 / (1.0 - offset(i).length_squared()).sqrt()));
    (map, extent, texels.collect())
}

fn mean(texels: &[(usize, f32)], value: impl Fn(usize) -> f32) -> f32 {
    let weights: f32 = texels.iter().map(|(_, area)| area).sum();
    texels.iter().map(|&(texel, area)| area * value(texel)).sum::<f32>() / weights
}

/// Every point of a sphere sees every other with the form factor dA / (4 pi r^2): under a uniform sky of unit irradiance the direct
/// irradiance of a cap of share s is 1 - s everywhere, and that by scattered light (1 - s) rho s / (1 - rho s).
#[test]
fn a_spherical_pit_scatters_as_its_closed_form() {
    for share in [0.2, 0.4] {
        let (map, extent, texels) = pit(share);
        let prepared = Prepared::new(&map, 1.0, Vec2::splat(extent), Shape::Ellipses, true);
        assert_eq!(prepared.scattered_size, [SIDE; 2]);
        let field = Field::new(&map, 1.0, Vec2::splat(extent));
        let bounces = Bounces::new(&field, &Horizons::new(&field, 16));
        for albedo in [0.2, 0.8] {
            let expected = (1.0 - share) * albedo * share / (1.0 - albedo * share);
            // A uniform sky gives an open surface the irradiance 1 and has no mean direction.
            let found = mean(&texels, |texel| prepared.scattered[texel].irradiance(Vec3::Z, albedo));
            // Four bounces of the same, one after the other: each has rho s of the one before, so that what is beyond them is known, too.
            let of_four = expected * (1.0 - (albedo * share).powi(4));
            let open = vec![[1.0 - share]; (SIDE * SIDE) as usize];
            let (mut left, mut chained) =
                (open.iter().map(|e| e.map(|e| e * albedo)).collect::<Vec<_>>(), 0.0);
            for _ in 0..4 {
                let next = bounces.gathered(&left);
                chained += mean(&texels, |texel| next[texel][0]);
                left = next.iter().map(|e| e.map(|e| e * albedo)).collect();
            }
            println!(
                "share {share}, albedo {albedo}: {found:.4}, four bounces {chained:.4}, closed form {expected:.4}"
            );
            assert!(
                (found / expected - 1.0).abs() < BUMP_PIT,
                "share {share}, albedo {albedo}: {found} {expected}"
            );
            assert!(
                (chained / of_four - 1.0).abs() < BUMP_PIT,
                "share {share}, albedo {albedo}: {chained} {of_four}"
            );
        }
    }
}

/// What leaves a patch, absorbed light included, is no more than what came.
#[test]
fn energy_never_grows() {
    let side = 48u32;
    let height = |i: u32| {
        0.08 * ((0.7 * (i % side) as f32).sin()
            + (0.5 * (i / side) as f32).cos() * ((i * i) % 7) as f32 * 0.2)
    };
    let map = HeightMap::new(side, side, (0..side * side).map(height).collect(), [Wrap::Repeat; 2]).unwrap();
    let prepared = Prepared::new(&map, 1.0, Vec2::ONE, Shape::Ellipses, true);
    let field = Field::new(&map, 1.0, Vec2::ONE);
    for l in [Vec3::Z, Vec3::new(0.8, 0.0, 0.6), Vec3::new(-0.3, -0.9, 0.3).normalize()] {
        for albedo in [0.5, 0.9] {
            // Per area of the base: a texel's own area is larger by the cosine of its slope.
            let absorbed: f32 = (0..(side * side) as usize)
                .map(|texel| {
                    let slope =
                        field.normal((texel % side as usize) as i64, (texel / side as usize) as i64).z;
                    prepared.scattered[texel].irradiance(l, albedo) * (1.0 - albedo) / slope
                })
                .sum::<f32>()
                / (side * side) as f32;
            assert!((0.0..=albedo).contains(&absorbed), "{l} {albedo}: {absorbed}");
        }
    }
}
