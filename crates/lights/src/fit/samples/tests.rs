use glam::{DVec3, Vec3};
use gnomon_picture::RgbImage;

use super::*;

/// A dim gradient, a round lamp, and a texel at the seam as bright.
fn lamps() -> Equirect {
    Equirect::new(RgbImage::from_fn(128, 64, |x, y| {
        let lamp = (x.abs_diff(40).pow(2) + y.abs_diff(20).pow(2) < 30) || (x, y) == (127, 31);
        let dim = Vec3::new(1.0, 0.5 + 0.01 * y as f32, 0.2 + 0.001 * x as f32);
        if lamp { dim + Vec3::new(80.0, 60.0, 30.0) } else { dim }
    }))
}

fn sample(name: &str, map: &Equirect, count: usize, seed: u64) -> Vec<Sample> {
    (sampler_by_name(name).unwrap().sample)(map, count, seed)
}

/// As many directions, evenly, each with the same flux: what ignores the map.
fn even(count: usize) -> Vec<Sample> {
    (0..count)
        .map(|i| {
            let y = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let (sin, cos) = (2.399_963 * i as f64).sin_cos();
            let ring = (1.0 - y * y).sqrt();
            Sample { direction: DVec3::new(ring * sin, y, ring * cos), flux: DVec3::ONE }
        })
        .collect()
}

#[test]
fn every_sampler_keeps_the_flux_of_each_channel_and_meets_the_count() {
    let map = lamps();
    for sampler in samplers() {
        for count in [1, 2, 3, 17, 500, 4096] {
            let samples = (sampler.sample)(&map, count, 5);
            assert_eq!(samples.len(), count, "{}", sampler.name);
            let sum: DVec3 = samples.iter().map(|sample| sample.flux).sum();
            assert!((sum / map.flux() - 1.0).abs().max_element() < 1e-9, "{} {count}", sampler.name);
            for sample in &samples {
                assert!((sample.direction.length() - 1.0).abs() < 1e-12, "{}", sampler.name);
                assert!(sample.flux.min_element() >= 0.0, "{}", sampler.name);
            }
        }
    }
}

#[test]
fn median_cut_and_stratified_samples_have_equal_luminous_flux() {
    let map = lamps();
    for (name, count) in [("median-cut", 17), ("median-cut", 4096), ("stratified", 17), ("stratified", 4096)]
    {
        let share = luminance(map.flux()) / count as f64;
        for sample in sample(name, &map, count, 3) {
            assert!((luminance(sample.flux) / share - 1.0).abs() < 1e-6, "{name} {count}");
        }
    }
}

/// Largest difference, over many caps, between the shares of luminous flux of samples and of the map inside.
fn discrepancy(map: &Equirect, samples: &[Sample]) -> f64 {
    let (total, sampled) =
        (luminance(map.flux()), samples.iter().map(|sample| luminance(sample.flux)).sum::<f64>());
    let mut worst: f64 = 0.0;
    for axis in even(60).iter().map(|sample| sample.direction) {
        for cos_radius in [0.95, 0.7, 0.2] {
            let mut inside = 0.0;
            for (x, y) in (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y))) {
                if map.texel_direction(x, y).as_dvec3().dot(axis) > cos_radius {
                    inside += luminance(map.radiance().get(x, y).as_dvec3()) * map.texel_solid_angle(y);
                }
            }
            let hit = samples.iter().filter(|sample| sample.direction.dot(axis) > cos_radius);
            let hit: f64 = hit.map(|sample| luminance(sample.flux)).sum();
            worst = worst.max((hit / sampled - inside / total).abs());
        }
    }
    worst
}

#[test]
fn samples_follow_the_luminance_far_closer_than_chance() {
    let map = lamps();
    for sampler in samplers() {
        for count in [64, 1000] {
            let found = discrepancy(&map, &(sampler.sample)(&map, count, 1));
            // Independent samples would be off by up to about 1.5 / sqrt(count).
            let factor = if sampler.name == "stratified" { 1.8 } else { 1.2 };
            assert!(found < factor * (count as f64).powf(-0.7), "{} {count}: {found}", sampler.name);
        }
    }
    assert!(discrepancy(&map, &even(64)) > 0.2 && discrepancy(&map, &even(1000)) > 0.2);
}

/// Pearson's statistic over its expectation, in standard deviations, of directions against luminous flux in 8 x 4 blocks
/// of texels.
fn chi_square_deviation(map: &Equirect, samples: &[Sample]) -> f64 {
    let bin = |u: f32, v: f32| (4.0 * v).min(3.0) as usize * 8 + (8.0 * u).min(7.0) as usize;
    let (mut expected, mut found) = ([0.0; 32], [0.0; 32]);
    for (x, y) in (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y))) {
        let (u, v) = ((x as f32 + 0.5) / map.width() as f32, (y as f32 + 0.5) / map.height() as f32);
        let flux = luminance(map.radiance().get(x, y).as_dvec3()) * map.texel_solid_angle(y);
        expected[bin(u, v)] += flux / luminance(map.flux()) * samples.len() as f64;
    }
    for sample in samples {
        let uv = Equirect::uv_from_direction(sample.direction.as_vec3());
        found[bin(uv.x, uv.y)] += 1.0;
    }
    let statistic: f64 = expected.iter().zip(found).map(|(e, f): (&f64, f64)| (f - e).powi(2) / e).sum();
    (statistic - 31.0) / (2.0 * 31.0_f64).sqrt()
}

#[test]
fn stratified_directions_have_the_density_of_luminance() {
    let lamps = lamps();
    let map = lamps.resized(32, 16);
    let alone: Vec<Sample> = (0..4000).flat_map(|seed| sample("stratified", &map, 1, seed)).collect();
    let deviation = chi_square_deviation(&map, &alone);
    assert!(deviation.abs() < 3.5, "{deviation}");
    // Strata spread samples more evenly than chance does, but keep their density.
    let together: Vec<Sample> = (0..40).flat_map(|seed| sample("stratified", &map, 100, seed)).collect();
    let deviation = chi_square_deviation(&map, &together);
    assert!((-4.0..0.0).contains(&deviation), "{deviation}");
    // A density that is too high by half in one half shows.
    let tilted = Equirect::new(RgbImage::from_fn(32, 16, |x, y| {
        map.radiance().get(x, y) * if y < 8 { 1.0 } else { 1.5 }
    }));
    let wrong: Vec<Sample> = (0..4000).flat_map(|seed| sample("stratified", &tilted, 1, seed)).collect();
    assert!(chi_square_deviation(&map, &wrong) > 3.5, "{}", chi_square_deviation(&map, &wrong));
}

#[test]
fn only_stratified_samples_depend_on_the_seed_and_the_same_seed_repeats_them() {
    let map = lamps();
    for sampler in samplers() {
        let with = |seed| (sampler.sample)(&map, 100, seed);
        assert_eq!(with(1), with(1));
        assert_eq!(with(1) == with(2), sampler.name != "stratified", "{}", sampler.name);
    }
}

#[test]
fn a_sun_of_one_texel_has_all_samples_and_a_black_map_none() {
    let (column, row) = (37, 9);
    let sun = |dim: f32| {
        Equirect::new(RgbImage::from_fn(64, 32, move |x, y| {
            Vec3::splat(if (x, y) == (column, row) { 1e5 } else { dim })
        }))
    };
    let alone = sun(0.0);
    let towards = alone.texel_direction(column, row).as_dvec3();
    let texel = std::f64::consts::PI / 32.0;
    for sampler in samplers() {
        let samples = (sampler.sample)(&alone, 300, 0);
        let is_whole = matches!(sampler.name, "variance-cut" | "structured");
        assert_eq!(samples.len(), if is_whole { 1 } else { 300 }, "{}", sampler.name);
        assert!(samples.iter().all(|sample| sample.direction.angle_between(towards) < texel));
        let with_sky = (sampler.sample)(&sun(1e-3), 300, 0);
        assert_eq!(with_sky.len(), 300, "{}", sampler.name);
        let near = with_sky.iter().filter(|sample| sample.direction.angle_between(towards) < texel);
        let flux: f64 = near.map(|sample| sample.flux.x).sum();
        assert!(flux > 0.999 * alone.flux().x, "{}", sampler.name);
        assert!((sampler.sample)(&sun(0.0).resized(4, 2), 3, 0).len() <= 3);
        let black = Equirect::new(RgbImage::filled(8, 4, Vec3::ZERO));
        assert!((sampler.sample)(&black, 4096, 0).is_empty(), "{}", sampler.name);
    }
}

/// Figure 2 of the paper: two lamps of different intensities, each in a region of its own.
#[test]
fn variance_cut_puts_each_of_two_lamps_into_its_own_cell_where_median_cut_does_not() {
    let lamp = |x: u32, y: u32, at: (u32, u32)| x.abs_diff(at.0) <= 2 && y.abs_diff(at.1) <= 2;
    let map = Equirect::new(RgbImage::from_fn(64, 32, |x, y| {
        Vec3::splat(if lamp(x, y, (30, 15)) {
            9.0
        } else if lamp(x, y, (40, 17)) {
            3.0
        } else {
            0.0
        })
    }));
    let is_on_lamp = |sample: &Sample| {
        [(30, 15), (40, 17)].iter().any(|&(x, y)| {
            let towards = map.texel_direction(x, y).as_dvec3();
            sample.direction.angle_between(towards) < 0.02
        })
    };
    assert!(sample("variance-cut", &map, 2, 0).iter().all(is_on_lamp));
    assert!(!sample("median-cut", &map, 2, 0).iter().all(is_on_lamp));
}

#[test]
fn an_unknown_sampler_is_refused_with_the_known_ones() {
    let message = sampler_by_name("random").err().map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("random") && message.contains("median-cut, variance-cut"), "{message}");
}
