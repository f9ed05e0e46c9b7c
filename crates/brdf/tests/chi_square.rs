//! Sampling against pdf by Pearson's chi-square test.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{Vec2, Vec3};
use gnomon_brdf::*;
use gnomon_testing::{glossy_models, glossy_surface, tabulated_surfaces};
use support::{Pcg, chi_square_p, direction, integrate};

/// Bins in theta and phi: fine enough to see a lobe's shape, coarse enough that most bins hold samples.
const BINS: [usize; 2] = [16, 32];
/// Samples: a density wrong by 3 % in half the bins gives a statistic about `200_000 * 0.03^2 / 2 = 90` above the
/// expected ~500 +- 32, nearly three standard deviations.
const SAMPLES: usize = 200_000;
/// Bins with fewer expected samples are pooled: below 5 the counts are not near normal (Cochran 1954).
const MIN_EXPECTED: f64 = 5.0;
/// Chance that a right sampler fails any of the tests of this file; shared among them by Bonferroni's rule.
const SIGNIFICANCE: f64 = 0.01;
/// Quadrature points in a bin and dimension for its expected count: the lobes are smooth over a bin of 5.6 x 11 degrees
/// at alpha 0.09 and wider; 24 leave less than 1e-3 of a bin.
const STEPS: usize = 24;

/// p-value of the samples of `model` against the pdf, one further bin taking the lost samples.
fn p_value(model: &Layers, pdf: &dyn Fn(Vec3) -> f64, wo: Vec3, seed: u64) -> f64 {
    p_value_of(&|u, part| model.sample(wo, u, part).map(|sample| sample.wi), pdf, seed)
}

fn p_value_of(draw: &dyn Fn(Vec2, f32) -> Option<Vec3>, pdf: &dyn Fn(Vec3) -> f64, seed: u64) -> f64 {
    let mut rng = Pcg(seed);
    let mut counts = vec![0.0; BINS[0] * BINS[1] + 1];
    for _ in 0..SAMPLES {
        let (u, lobe) = (Vec2::new(rng.next_f32(), rng.next_f32()), rng.next_f32());
        let bin = match draw(u, lobe) {
            None => BINS[0] * BINS[1],
            Some(wi) => {
                let theta = f64::from(wi.z).clamp(-1.0, 1.0).acos() / FRAC_PI_2;
                let phi = f64::from(wi.y).atan2(f64::from(wi.x)).rem_euclid(TAU) / TAU;
                let i = ((theta * BINS[0] as f64) as usize).min(BINS[0] - 1);
                i * BINS[1] + ((phi * BINS[1] as f64) as usize).min(BINS[1] - 1)
            }
        };
        counts[bin] += 1.0;
    }
    let mut expected: Vec<f64> = (0..BINS[0] * BINS[1])
        .map(|bin| {
            let (i, j) = ((bin / BINS[1]) as f64, (bin % BINS[1]) as f64);
            let (dt, dp) = (FRAC_PI_2 / BINS[0] as f64, TAU / BINS[1] as f64);
            let patch = [[i * dt, (i + 1.0) * dt], [j * dp, (j + 1.0) * dp]];
            SAMPLES as f64 * integrate(patch[0], patch[1], [STEPS, STEPS], pdf)
        })
        .collect();
    let kept: f64 = expected.iter().sum();
    assert!(kept <= SAMPLES as f64 * 1.002, "the pdf integrates to {}", kept / SAMPLES as f64);
    expected.push((SAMPLES as f64 - kept).max(0.0));

    let (mut statistic, mut used, mut pool) = (0.0, 0.0, [0.0; 2]);
    for (&count, &expected) in counts.iter().zip(&expected) {
        if expected < MIN_EXPECTED {
            pool = [pool[0] + count, pool[1] + expected];
        } else {
            statistic += (count - expected).powi(2) / expected;
            used += 1.0;
        }
    }
    if pool[1] >= MIN_EXPECTED {
        statistic += (pool[0] - pool[1]).powi(2) / pool[1];
        used += 1.0;
    } else {
        // Too few are expected for the law; more than 25 cannot be chance (Poisson, mean 5: 1e-10).
        assert!(pool[0] < 25.0, "{} samples where {} were expected", pool[0], pool[1]);
    }
    chi_square_p(statistic, used - 1.0)
}

/// Every model with lobes from narrow to wide, alone and over a matte part, as dielectric and as metal where it is one.
fn cases() -> Vec<(Surface, f64)> {
    let analytic = Model::ALL.iter().filter(|model| !model.is_tabulated());
    let surfaces = analytic.flat_map(|&model| {
        let of = |roughness, metallic, base_color| Surface {
            metallic,
            base_color,
            ..glossy_surface(model, roughness)
        };
        [
            of(0.5, 0.0, Vec3::splat(0.5)),
            of(0.33, 0.0, Vec3::ZERO),
            of(0.4, 1.0, Vec3::new(0.9, 0.6, 0.3)),
            of(0.95, 0.4, Vec3::splat(0.5)),
        ]
    });
    let lit = surfaces.filter(|surface| surface.layers().strength() != Vec3::ZERO);
    let analytic = lit.flat_map(|surface| [0.0, 0.6, 1.3].map(|theta| (surface, theta)));
    // One sampler draws from all tables.
    analytic.chain(tabulated_surfaces().into_iter().map(|surface| (surface, 0.6))).collect()
}

#[test]
fn samples_follow_the_pdf() {
    let cases = cases();
    for (index, (surface, theta)) in cases.iter().enumerate() {
        let tables = surface.tables();
        let layers = surface.layers().with_tables(tables.as_ref());
        let wo = direction(*theta, 0.3);
        let p = p_value(&layers, &|wi| f64::from(layers.pdf(wo, wi)), wo, 7 + index as u64);
        assert!(p > SIGNIFICANCE / cases.len() as f64, "p {p}: {surface:?}, theta {theta}");
    }
}

/// Parts of a base under a finish, all of them and the glossy ones alone.
#[test]
fn samples_of_finished_surfaces_follow_the_pdf() {
    let base = Surface { roughness: 0.6, specular: 1.0, ..Surface::default() };
    let coat = Surface { clearcoat: 1.0, clearcoat_roughness: 0.4, ..base };
    let lambert = Surface { model: Model::Lambert, ..coat };
    let metal = Surface { metallic: 1.0, ..coat };
    let cloth = Surface { sheen_color: Vec3::ONE, sheen_roughness: 0.4, clearcoat: 0.0, ..lambert };
    let both = Surface { sheen_color: Vec3::ONE, sheen_roughness: 0.4, ..metal };
    let cases = [(coat, 0.0), (lambert, 0.0), (metal, 0.3), (cloth, 0.0), (both, 0.2)];
    for (index, (surface, tilt)) in cases.into_iter().enumerate() {
        let mut layers = surface.layers();
        layers.finish.clearcoat_normal = direction(tilt, 1.0);
        for theta in [0.2, 1.2] {
            let (wo, seed) = (direction(theta, 0.3), 100 + index as u64);
            let all = p_value(&layers, &|wi| f64::from(layers.pdf(wo, wi)), wo, seed);
            let draw = |u, _| Some(layers.gloss_sample(wo, u)).filter(|wi| layers.gloss_pdf(wo, *wi) > 0.0);
            let gloss = p_value_of(&draw, &|wi| f64::from(layers.gloss_pdf(wo, wi)), seed);
            assert!(all.min(gloss) > SIGNIFICANCE / 20.0, "p {all} {gloss}: {surface:?}, theta {theta}");
        }
    }
}

/// The test must see a sampler whose lobe is 3 % too wide.
#[test]
fn a_wrong_pdf_is_caught() {
    let wo = direction(0.6, 0.3);
    for model in glossy_models() {
        let layers =
            |roughness| Surface { base_color: Vec3::ZERO, ..glossy_surface(model, roughness) }.layers();
        let wrong = layers(0.515);
        let p = p_value(&layers(0.5), &|wi| f64::from(wrong.pdf(wo, wi)), wo, 3);
        assert!(p < 1e-6, "{model:?}: p {p}");
    }
}

#[test]
fn the_chi_square_law_is_right() {
    // Tabulated 95 % and 99 % points (Abramowitz and Stegun, table 26.8): 50 and 100 degrees of freedom.
    for (statistic, degrees, p) in [(67.505, 50.0, 0.05), (76.154, 50.0, 0.01), (124.342, 100.0, 0.05)] {
        assert!((chi_square_p(statistic, degrees) / p - 1.0).abs() < 0.02);
    }
}
