//! Laws of the glossy lobes, of every model in the list, against brute-force integration; closed forms of single ones.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{Vec2, Vec3, Vec4};
use gnomon_brdf::*;
use gnomon_testing::{glossy_models, glossy_surface};
use support::{direction, integrate};

/// A lobe of the strength `white` over a matte part of the albedo `matte`.
fn layers(surface: Surface, white: f32, matte: f32) -> Layers<'static> {
    let tint = Vec4::splat(white);
    let layers = surface.layers();
    Layers { diffuse: Vec3::splat(matte), interface: tint, lobe: Lobe { tint, ..layers.lobe }, ..layers }
}

/// Share of the light from `wo` that leaves again; the grid resolves lobes of 2 degrees.
fn directional_albedo(f: impl Fn(Vec3) -> f64) -> f64 {
    integrate([0.0, FRAC_PI_2], [0.0, TAU], [700, 700], |wi| f(wi) * f64::from(wi.z))
}

/// No lobe gives back more than it gets; the Phong ones give back all of it along the normal, as they are normalised.
#[test]
fn energy_is_conserved() {
    for model in glossy_models() {
        for roughness in [0.25, 0.45, 0.7, 1.0] {
            let surface = glossy_surface(model, roughness);
            let lobe = layers(surface, 1.0, 0.0);
            let albedos = [0.0, 0.5, 1.0, 1.4].map(|theta| {
                let wo = direction(theta, 0.0);
                directional_albedo(|wi| f64::from(lobe.evaluate(wo, wi).x))
            });
            let what = format!("{} {roughness}: {albedos:?}", model.name());
            assert!(albedos.iter().all(|a| (0.02..=1.0 + 2e-3).contains(a)), "{what}");
            if matches!(model, Model::Phong | Model::BlinnPhong) {
                assert!((albedos[0] - 1.0).abs() < 1e-3, "{what}");
            }
            // A matte part takes what the lobe leaves of 1; glTF's lies under its interface besides.
            let least = if model == Model::MetallicRoughness { 0.6 * 0.6 } else { 0.6 };
            let both = layers(surface, 0.4, 0.6);
            let wo = direction(0.5, 0.0);
            let albedo = directional_albedo(|wi| f64::from(both.evaluate(wo, wi).x));
            assert!(albedo > least && albedo < 1.0 + 2e-3, "{what}, over a matte part {albedo}");
        }
    }
}

/// Closed form: Phong's exponent 0 seen along the normal is Lambert, and so is Blinn's.
#[test]
fn exponent_zero_is_matte() {
    for model in [Model::Phong, Model::BlinnPhong] {
        let lobe = layers(Surface { model, shininess: 0.0, ..Surface::default() }, 1.0, 0.0);
        let value = lobe.evaluate(direction(0.4, 1.0), direction(0.9, 3.0)).x;
        assert!((f64::from(value) - 1.0 / PI).abs() < 1e-6, "{model:?}: {value}");
    }
}

/// Density of microfacets and the slope that masks them, of Torrance and Sparrow's models.
type Microfacets = (&'static str, fn(f32, f32) -> f32, fn(f32) -> f32);
const BECKMANN: Microfacets = ("beckmann", d_beckmann, |slope| slope);
const GAUSSIAN: Microfacets = ("gaussian", d_gaussian, gaussian_masking_slope);

/// `D cos` integrates to 1 over the hemisphere of microfacet normals (Walter et al. 2007, eq. 4).
#[test]
fn microfacet_areas_project_to_one() {
    for (name, density, _) in [BECKMANN, GAUSSIAN] {
        for slope in [0.06, 0.1, 0.3, 0.6, 1.0] {
            let total = directional_albedo(|h| f64::from(density(h.z, slope)));
            assert!((total - 1.0).abs() < 1e-3, "{name} {slope}: {total}");
        }
    }
}

/// Weak white furnace (Heitz 2014, section 5.2): without shadowing of `wi`, the visible microfacets reflect all light. Beckmann's
/// masking in rational form errs by 0.35 %; of Gaussian angles it is an approximation.
#[test]
fn weak_furnace() {
    let weak = |(_, density, masking_slope): Microfacets, slope: f32, theta: f64| {
        let wo = direction(theta, 0.4);
        integrate([0.0, PI], [0.0, TAU], [600, 1600], |wi| {
            let h = (wo + wi).normalize_or_zero();
            let masking = g1_smith_beckmann(wo.z, masking_slope(slope));
            if wo.dot(h) > 0.0 { f64::from(masking * density(h.z, slope) / (4.0 * wo.z)) } else { 0.0 }
        })
    };
    for (slope, gaussian_error) in [(0.1, 0.01), (0.3, 0.01), (0.5, 0.012), (1.0, 0.03)] {
        for theta in [0.0, 0.7, 1.0, 1.4] {
            let beckmann = weak(BECKMANN, slope, theta);
            assert!((beckmann - 1.0).abs() < 5e-3, "slope {slope} theta {theta}: {beckmann}");
            let gaussian = weak(GAUSSIAN, slope, theta);
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
    assert_eq!((phong.diffuse, phong.lobe.tint), (surface.base_color, Vec4::new(0.5, 0.5, 0.25, 0.5)));
    let facets = layers(Model::TorranceSparrowBeckmann);
    assert_eq!(facets.diffuse, 0.75 * surface.base_color);
    let tint = facets.lobe.tint;
    assert!((tint.x - (0.75 * 0.02 + 0.25 * 0.8)).abs() < 1e-6 && (tint.w - 0.625).abs() < 1e-6);
    assert!(Surface { model: Model::Lambert, metallic: 1.0, ..surface }.is_matte());
    assert!(!Surface { model: Model::Phong, ..surface }.is_matte());
}

/// A parameter that a model does not list changes nothing, and one that it lists changes something.
#[test]
fn the_parameters_that_a_model_lists_are_those_that_it_reads() {
    let all = [
        &BASE_COLOR,
        &METALLIC,
        &ROUGHNESS,
        &SPECULAR,
        &SPECULAR_COLOR,
        &IOR,
        &SHININESS,
        &SLOPE,
        &ASPECT,
        &INDEX,
        &EXTINCTION,
        &ANISOTROPY,
        &ANISOTROPY_ROTATION,
        &AXES,
        &CLEARCOAT,
        &CLEARCOAT_ROUGHNESS,
        &SHEEN_COLOR,
        &SHEEN_ROUGHNESS,
    ];
    for &model in Model::ALL {
        let surface = Surface { model, specular: 0.5, metallic: 0.3, roughness: 0.5, ..Surface::default() };
        for parameter in all {
            let mut changed = surface;
            (parameter.set)(&mut changed, 0.77 * (parameter.get)(&surface) + 0.1);
            let listed = model.parameters().any(|other| other == parameter);
            let differs = changed.layers() != surface.layers() || changed.tables() != surface.tables();
            assert_eq!(differs, listed, "{} {}", model.name(), parameter.name);
        }
    }
}

#[test]
fn models_are_found_by_name() {
    for &model in Model::ALL {
        assert_eq!(Model::named(model.name()), Some(model));
        let kebab = |c: char| c.is_ascii_lowercase() || c == '-';
        assert!(model.name().chars().all(kebab) && !model.summary().is_empty());
        assert!(model.shape().is_none_or(|shape| model.parameters().any(|listed| listed == shape)));
    }
    assert_eq!(Model::named("phong-but-misspelt"), None);
}

/// Out of range parameters are taken at the range's end; a view from under the surface stays finite.
#[test]
fn nothing_is_infinite() {
    for model in glossy_models() {
        for parameter in [0.0, -3.0, 1e9, f32::INFINITY, f32::NAN] {
            let mut surface = Surface { model, ..Surface::default() };
            (model.shape().unwrap().set)(&mut surface, Vec3::splat(parameter));
            let lobe = layers(surface, 1.0, 0.0);
            for theta in [0.0, 1.55, 1.5707964, 1.8, 3.1] {
                let value = lobe.evaluate(direction(theta, 0.0), direction(0.6, PI));
                let sound = value.is_finite() && value.min_element() >= 0.0;
                assert!(sound, "{model:?} {parameter} {theta}: {value}");
            }
        }
        let black = Surface { base_color: Vec3::ZERO, model, ..Surface::default() };
        assert!(black.layers().sample(Vec3::Z, Vec2::splat(0.5), 0.5).is_none());
    }
}
