//! What lies on the base of a surface, against the extensions' formulas and the laws of energy.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

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
    assert_eq!(Surface { clearcoat: 1.0, ..surface }.without_finish(), surface);
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

#[test]
fn emission_passes_the_coat() {
    let finish = Surface { clearcoat: 0.5, ..Surface::default() }.finish();
    assert!((finish.emission_weight(Vec3::Z) - 0.98).abs() < 1e-6);
    assert!((finish.emission_weight(Vec3::X) - 0.5).abs() < 1e-6);
}
