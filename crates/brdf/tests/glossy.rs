//! Laws of the Phong models and of Torrance and Sparrow's, against brute-force integration.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{Vec2, Vec3};
use gnomon_brdf::*;
use proptest::prelude::*;
use support::{direction, integrate};

const GLOSSY: [Model; 4] =
    [Model::Phong, Model::BlinnPhong, Model::TorranceSparrowBeckmann, Model::TorranceSparrowGaussian];

/// Nothing but a lobe of full strength, f0 = f90 = 1. `parameter` is a shininess or a slope.
fn white(model: Model, parameter: f32) -> Surface {
    Surface {
        model,
        shininess: parameter,
        slope: parameter,
        base_color: Vec3::ZERO,
        specular: 1.0,
        specular_color: match model {
            Model::Phong | Model::BlinnPhong => Vec3::ONE,
            _ => Vec3::splat(f32::MAX),
        },
        ..Surface::default()
    }
}

fn parameters(model: Model) -> [f32; 4] {
    match model {
        Model::Phong | Model::BlinnPhong => [0.0, 1.0, 40.0, 500.0],
        _ => [0.06, 0.2, 0.5, 1.0],
    }
}

/// Share of the light from `wo` that leaves again; the grid resolves lobes of 2 degrees.
fn directional_albedo(f: impl Fn(Vec3) -> f64) -> f64 {
    integrate([0.0, FRAC_PI_2], [0.0, TAU], [700, 700], |wi| f(wi) * f64::from(wi.z))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// Phong's too: in the form without a division by the cosine the angle to the mirrored direction is the same from both sides.
    #[test]
    fn reciprocity(
        shininess in 0f32..2000.0, slope in 0.02f32..1.0, metallic in 0f32..1.0,
        theta in prop::array::uniform2(0f64..1.55), phi in prop::array::uniform2(0f64..TAU),
    ) {
        let (a, b) = (direction(theta[0], phi[0]), direction(theta[1], phi[1]));
        for model in GLOSSY {
            let surface = Surface { model, shininess, slope, metallic, specular: 0.7, ..Surface::default() };
            let model = surface.reflectance();
            let (ab, ba) = (model.evaluate(a, b), model.evaluate(b, a));
            prop_assert!(ab.is_finite() && ab.min_element() >= 0.0);
            prop_assert!(ab.distance(ba) <= 1e-3 * ab.length().max(1e-3), "{ab} {ba}");
        }
    }

    #[test]
    fn samples_are_consistent(
        shininess in 0f32..10_000.0, slope in 0.01f32..1.0, theta in 0f64..1.7, u in prop::array::uniform3(0f32..1.0),
    ) {
        let wo = direction(theta, 1.0);
        for model in GLOSSY {
            let surface = Surface { model, shininess, slope, specular: 0.4, ..Surface::default() };
            let model = surface.reflectance();
            if let Some(sample) = model.sample(wo, Vec2::new(u[0], u[1]), u[2]) {
                prop_assert!(sample.wi.z > 0.0 && (sample.wi.length() - 1.0).abs() < 1e-4);
                prop_assert!(sample.pdf > 0.0 && sample.pdf.is_finite() && sample.f.is_finite());
                prop_assert_eq!(sample.pdf, model.pdf(wo, sample.wi));
                prop_assert_eq!(sample.f, model.evaluate(wo, sample.wi));
            }
        }
    }
}

/// No lobe gives back more than it gets; the Phong ones give back all of it along the normal, as they are normalised.
#[test]
fn energy_is_conserved() {
    for model in GLOSSY {
        for parameter in parameters(model) {
            let surface = white(model, parameter);
            let lobe = surface.reflectance();
            let albedos = [0.0, 0.5, 1.0, 1.4].map(|theta| {
                let wo = direction(theta, 0.0);
                directional_albedo(|wi| f64::from(lobe.evaluate(wo, wi).x))
            });
            assert!(
                albedos.iter().all(|a| (0.02..=1.0 + 2e-3).contains(a)),
                "{model:?} {parameter}: {albedos:?}"
            );
            if matches!(model, Model::Phong | Model::BlinnPhong) {
                assert!((albedos[0] - 1.0).abs() < 1e-3, "{model:?} {parameter}: {albedos:?}");
            }
            // A matte part takes what the lobe leaves of 1.
            let both = Surface { specular: 0.4, base_color: Vec3::splat(0.6), ..surface }.reflectance();
            let wo = direction(0.5, 0.0);
            let albedo = directional_albedo(|wi| f64::from(both.evaluate(wo, wi).x));
            assert!(albedo > 0.6 && albedo < 1.0 + 2e-3, "{model:?} {parameter}: {albedo}");
        }
    }
}

/// Closed form: Phong's exponent 0 seen along the normal is Lambert, and so is Blinn's.
#[test]
fn exponent_zero_is_matte() {
    for model in [Model::Phong, Model::BlinnPhong] {
        let lobe = white(model, 0.0).reflectance();
        let value = lobe.evaluate(direction(0.4, 1.0), direction(0.9, 3.0)).x;
        assert!((f64::from(value) - 1.0 / PI).abs() < 1e-6, "{model:?}: {value}");
    }
}

/// `D cos` integrates to 1 over the hemisphere of microfacet normals (Walter et al. 2007, eq. 4).
#[test]
fn microfacet_areas_project_to_one() {
    for distribution in [SlopeDistribution::Beckmann, SlopeDistribution::Gaussian] {
        for slope in [0.06, 0.1, 0.3, 0.6, 1.0] {
            let total = directional_albedo(|h| f64::from(distribution.density(h.z, slope)));
            assert!((total - 1.0).abs() < 1e-3, "{distribution:?} {slope}: {total}");
        }
    }
}

/// Weak white furnace (Heitz 2014, section 5.2): without shadowing of `wi`, the visible microfacets reflect all light. Beckmann's
/// masking in rational form errs by 0.35 %; of Gaussian angles it is an approximation.
#[test]
fn weak_furnace() {
    let weak = |distribution: SlopeDistribution, slope: f32, theta: f64| {
        let wo = direction(theta, 0.4);
        integrate([0.0, PI], [0.0, TAU], [600, 1600], |wi| {
            let h = (wo + wi).normalize_or_zero();
            let masking = g1_smith_beckmann(wo.z, distribution.masking_slope(slope));
            if wo.dot(h) > 0.0 {
                f64::from(masking * distribution.density(h.z, slope) / (4.0 * wo.z))
            } else {
                0.0
            }
        })
    };
    for (slope, gaussian_error) in [(0.1, 0.01), (0.3, 0.01), (0.5, 0.012), (1.0, 0.03)] {
        for theta in [0.0, 0.7, 1.0, 1.4] {
            let beckmann = weak(SlopeDistribution::Beckmann, slope, theta);
            assert!((beckmann - 1.0).abs() < 5e-3, "slope {slope} theta {theta}: {beckmann}");
            let gaussian = weak(SlopeDistribution::Gaussian, slope, theta);
            println!("slope {slope} theta {theta}: beckmann {beckmann:.4}, gaussian {gaussian:.4}");
            assert!((gaussian - 1.0).abs() < gaussian_error, "slope {slope} theta {theta}: {gaussian}");
        }
    }
}

/// The polynomial against brute force.
#[test]
fn gaussian_normalisation() {
    for slope in [0.01, 0.1, 0.35, 0.7, 1.0f32] {
        let (steps, m) = (200_000, f64::from(slope));
        let width = FRAC_PI_2 / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|i| {
                let delta = (f64::from(i) + 0.5) * width;
                (-(delta / m).powi(2)).exp() * (2.0 * delta).sin()
            })
            .sum();
        let expected = sum * width / (m * m);
        assert!((f64::from(gaussian_norm(slope)) / expected - 1.0).abs() < 2e-5, "{slope}");
    }
}

#[test]
fn models_take_what_concerns_them() {
    let surface = Surface {
        base_color: Vec3::new(0.8, 0.4, 0.2),
        metallic: 0.25,
        specular: 0.5,
        specular_color: Vec3::new(1.0, 3.0, 0.5),
        ..Surface::default()
    };
    let layers = |model| Surface { model, ..surface }.layers();
    let phong = layers(Model::Phong);
    assert_eq!((phong.diffuse, phong.f0), (surface.base_color, Vec3::new(0.5, 0.5, 0.25)));
    let facets = layers(Model::TorranceSparrowBeckmann);
    assert_eq!(facets.diffuse, 0.75 * surface.base_color);
    assert!((facets.f0.x - (0.75 * 0.02 + 0.25 * 0.8)).abs() < 1e-6 && facets.f90 == 0.625);
    assert!(Surface { model: Model::Lambert, metallic: 1.0, ..surface }.is_matte());
    assert!(!Surface { model: Model::Phong, ..surface }.is_matte());
    for entry in MODELS {
        assert_eq!(entry.model.name(), entry.name);
        assert_eq!(model(entry.name).unwrap().model, entry.model);
    }
}

/// Out of range parameters are taken at the range's end; a view from under the surface stays finite.
#[test]
fn nothing_is_infinite() {
    for model in GLOSSY {
        for parameter in [0.0, -3.0, 1e9, f32::INFINITY, f32::NAN] {
            let lobe = white(model, parameter).reflectance();
            for theta in [0.0, 1.55, 1.5707964, 1.8, 3.1] {
                let value = lobe.evaluate(direction(theta, 0.0), direction(0.6, PI));
                let sound = value.is_finite() && value.min_element() >= 0.0;
                assert!(sound, "{model:?} {parameter} {theta}: {value}");
            }
        }
    }
    let black = Surface { base_color: Vec3::ZERO, model: Model::Phong, ..Surface::default() };
    assert!(black.reflectance().sample(Vec3::Z, Vec2::splat(0.5), 0.5).is_none());
}
