//! What lies on the base of a surface, against the extensions' formulas and the laws of energy.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests and their helpers fail by panicking"
)]

mod support;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{Vec2, Vec3};
use gnomon_brdf::*;
use proptest::prelude::*;
use support::{direction, integrate};

/// Share of the light from `wo` that leaves again, by quadrature.
fn directional_albedo(f: impl Fn(Vec3) -> f64) -> f64 {
    integrate([0.0, FRAC_PI_2], [0.0, TAU], [800, 800], |wi| f(wi) * f64::from(wi.z))
}

/// `KHR_materials_clearcoat`, sections "Layering" and "Clearcoat BRDF", written out in 64 bits: what the coat reflects, and the share of the base.
fn coat(strength: f64, roughness: f64, wo: Vec3, wi: Vec3) -> (f64, f64) {
    let (wo, wi) = (wo.as_dvec3(), wi.as_dvec3());
    let h = (wo + wi).normalize();
    let share = strength * (0.04 + 0.96 * (1.0 - wo.z).powi(5));
    let alpha2 = roughness.powi(4);
    let d = alpha2 / (PI * (h.z * h.z * (alpha2 - 1.0) + 1.0).powi(2));
    let lambda = |c: f64| (alpha2 + (1.0 - alpha2) * c * c).sqrt();
    let v = 0.5 / (wi.z * lambda(wo.z) + wo.z * lambda(wi.z));
    (share * d * v, 1.0 - share)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn coats_are_the_extensions(
        strength in 0.01f32..1.0, roughness in 0.15f32..1.0, metallic in 0f32..1.0,
        theta in prop::array::uniform2(0f64..1.5), phi in prop::array::uniform2(0f64..TAU),
    ) {
        let bare = Surface { metallic, roughness: 0.5, specular: 1.0, ..Surface::default() };
        let coated = Surface { clearcoat: strength, clearcoat_roughness: roughness, ..bare };
        let (wo, wi) = (direction(theta[0], phi[0]), direction(theta[1], phi[1]));
        let (own, base) = coat(f64::from(strength), f64::from(roughness), wo, wi);
        let expected = bare.layers().evaluate(wo, wi) * base as f32 + Vec3::splat(own as f32);
        let found = coated.layers().evaluate(wo, wi);
        prop_assert!(found.distance(expected) <= 2e-3 * expected.length(), "{found} {expected}");
    }

    #[test]
    fn samples_are_consistent(
        strength in 0f32..1.0, roughness in 0f32..1.0, matte in 0f32..1.0, specular in 0f32..1.0, tilt in 0f64..0.8,
        theta in 0f64..1.7, u in prop::array::uniform3(0f32..1.0),
    ) {
        let surface = Surface {
            clearcoat: strength,
            clearcoat_roughness: roughness,
            base_color: Vec3::splat(matte),
            specular,
            ..Surface::default()
        };
        let mut layers = surface.layers();
        layers.finish.clearcoat_normal = direction(tilt, 2.0);
        let wo = direction(theta, 1.0);
        if let Some(sample) = layers.sample(wo, Vec2::new(u[0], u[1]), u[2]) {
            prop_assert!(sample.wi.z > 0.0 && (sample.wi.length() - 1.0).abs() < 1e-4);
            prop_assert!(sample.pdf > 0.0 && sample.pdf.is_finite() && sample.f.is_finite() && sample.f.min_element() >= 0.0);
            prop_assert_eq!(sample.f, layers.evaluate(wo, sample.wi));
        }
    }
}

#[test]
fn nothing_changes_without_a_finish() {
    let surface = Surface { roughness: 0.3, specular: 1.0, ..Surface::default() };
    let same = Surface { clearcoat_roughness: 0.7, ..surface };
    let (wo, wi) = (direction(0.7, 0.0), direction(0.4, 2.0));
    assert_eq!(surface.layers().evaluate(wo, wi), same.layers().evaluate(wo, wi));
    assert_eq!(surface.layers().pdf(wo, wi), same.layers().pdf(wo, wi));
    assert_eq!(Surface { clearcoat: 1.0, sheen_color: Vec3::ONE, ..surface }.without_finish(), surface);
}

/// A white matte base: the coat gives back less than it takes from it, by the split sum's loss alone.
#[test]
fn a_coated_furnace_loses_only_multiple_scattering() {
    for roughness in [0.4, 0.6, 1.0] {
        for strength in [0.5, 1.0] {
            let surface = Surface {
                model: Model::Lambert,
                base_color: Vec3::ONE,
                clearcoat: strength,
                clearcoat_roughness: roughness,
                ..Surface::default()
            };
            for theta in [0.0, 0.8, 1.4] {
                let (layers, wo) = (surface.layers(), direction(theta, 0.0));
                let albedo = directional_albedo(|wi| f64::from(layers.evaluate(wo, wi).x));
                let share = coat_share(strength, wo.z);
                let expected = f64::from(1.0 - share + share * dfg(wo.z, roughness).element_sum());
                assert!((albedo - expected).abs() < 4e-3, "{roughness} {theta}: {albedo} {expected}");
                assert!(albedo <= 1.001, "{roughness} {theta}: {albedo}");
            }
        }
    }
}

/// Over a base whose normal is another, it still gives back no more than it gets.
#[test]
fn a_tilted_coat_gains_nothing() {
    let surface =
        Surface { base_color: Vec3::ONE, clearcoat: 1.0, clearcoat_roughness: 0.4, ..Surface::default() };
    for tilt in [0.2, 0.5] {
        let mut layers = surface.layers();
        layers.finish.clearcoat_normal = direction(tilt, 1.0);
        for theta in [0.0, 0.8, 1.4] {
            let wo = direction(theta, 0.0);
            let albedo = directional_albedo(|wi| f64::from(layers.evaluate(wo, wi).x));
            assert!((0.6..=1.01).contains(&albedo), "{tilt} {theta}: {albedo}");
        }
    }
}

/// `KHR_materials_sheen`, sections "Sheen distribution" and "Sheen visibility", written out in 64 bits.
fn sheen(roughness: f64, wo: [f64; 3], wi: [f64; 3]) -> f64 {
    let alpha = roughness * roughness;
    let h = [0, 1, 2].map(|i| wo[i] + wi[i]);
    let cos2_h = h[2] * h[2] / h.iter().map(|x| x * x).sum::<f64>();
    let d = (2.0 + 1.0 / alpha) * (1.0 - cos2_h).powf(0.5 / alpha) / (2.0 * PI);
    let t = (1.0 - alpha) * (1.0 - alpha);
    let mix = |x: f64, y: f64| x * (1.0 - t) + y * t;
    let l = |x: f64| {
        mix(21.5473, 25.3245) / (1.0 + mix(3.82987, 3.32435) * x.powf(mix(0.19823, 0.16801)))
            + mix(-1.97760, -1.27393) * x
            + mix(-4.32054, -4.85967)
    };
    let lambda = |c: f64| if c < 0.5 { l(c).exp() } else { (2.0 * l(0.5) - l(1.0 - c)).exp() };
    d / ((1.0 + lambda(wo[2]) + lambda(wi[2])) * 4.0 * wo[2] * wi[2])
}

/// Share of uniform light that white sheen reflects, by quadrature with points towards the horizon.
fn sheen_albedo_truth(n_dot_v: f64, roughness: f64) -> f64 {
    let wo = [(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v];
    let steps = [600, 300];
    let mut sum = 0.0;
    for i in 0..steps[0] {
        let rim = 1.0 - (i as f64 + 0.5) / steps[0] as f64;
        let theta = FRAC_PI_2 * (1.0 - rim * rim);
        for j in 0..steps[1] {
            let phi = (j as f64 + 0.5) * PI / steps[1] as f64;
            let wi = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
            sum += sheen(roughness, wo, wi) * wi[2] * theta.sin() * 2.0 * rim;
        }
    }
    sum * FRAC_PI_2 / steps[0] as f64 * TAU / steps[1] as f64
}

#[test]
fn the_albedo_of_sheen_is_that_of_quadrature() {
    let mut worst = 0.0f64;
    for roughness in [0.1, 0.13, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0] {
        for n_dot_v in [0.002, 0.01, 0.03, 0.07, 0.15, 0.3, 0.5, 0.75, 0.98] {
            let truth = sheen_albedo_truth(n_dot_v, roughness);
            let error = (f64::from(sheen_albedo(n_dot_v as f32, roughness as f32)) - truth).abs();
            assert!(error < 6e-3, "{roughness} {n_dot_v}: {error} of {truth}");
            worst = worst.max(error);
        }
    }
    println!("albedo of sheen: worst error {worst:.1e}");
}

#[test]
fn sheen_is_the_extensions() {
    for roughness in [0.2f32, 0.5, 1.0] {
        let base = Surface { base_color: Vec3::splat(0.3), ..Surface::default() };
        let color = Vec3::new(0.8, 0.4, 0.1);
        let cloth = Surface { sheen_color: color, sheen_roughness: roughness, ..base };
        for (theta, phi) in [(0.1, 0.5), (0.7, 3.0), (1.3, 2.0), (1.45, 0.1)] {
            let (wo, wi) = (direction(0.8, 0.0), direction(theta, phi));
            let own = sheen(f64::from(roughness), wo.as_dvec3().into(), wi.as_dvec3().into()) as f32;
            let scaling = 1.0 - 0.8 * sheen_albedo_truth(f64::from(wo.z), f64::from(roughness)) as f32;
            let expected = scaling * base.layers().evaluate(wo, wi) + own * color;
            let found = cloth.layers().evaluate(wo, wi);
            assert!(
                found.distance(expected) < 4e-3 * expected.length() + 1e-3,
                "{roughness}: {found} {expected}"
            );
        }
    }
}

/// A white base under white sheen gives back all it gets, at most 1 % more, under a coat as well.
#[test]
fn a_furnace_of_sheen_is_white() {
    for (clearcoat, least) in [(0.0, 0.99), (1.0, 0.5)] {
        for sheen_roughness in [0.0, 0.15, 0.3, 0.6, 1.0] {
            let surface = Surface {
                model: Model::Lambert,
                base_color: Vec3::ONE,
                sheen_color: Vec3::ONE,
                sheen_roughness,
                clearcoat,
                clearcoat_roughness: 0.6,
                ..Surface::default()
            };
            for theta in [0.0, 0.6, 1.2, 1.45, 1.54] {
                let (layers, wo) = (surface.layers(), direction(theta, 0.0));
                let albedo = directional_albedo(|wi| f64::from(layers.evaluate(wo, wi).x));
                assert!((least..=1.01).contains(&albedo), "{sheen_roughness} {theta}: {albedo}");
            }
        }
    }
}

#[test]
fn emission_passes_the_coat() {
    let finish = Surface { clearcoat: 0.5, ..Surface::default() }.finish();
    assert!((finish.emission_weight(Vec3::Z) - 0.98).abs() < 1e-6);
    assert!((finish.emission_weight(Vec3::X) - 0.5).abs() < 1e-6);
}
