//! Physical laws and closed forms that every model must keep.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{Vec2, Vec3};
use gnomon_brdf::*;
use gnomon_testing::glossy_surface;
use proptest::prelude::*;
use support::{direction, integrate};

fn surface(base: f32, metallic: f32, roughness: f32, specular: f32, ior: f32) -> Surface {
    Surface {
        base_color: Vec3::new(base, 0.5 * base, 0.2),
        metallic,
        roughness,
        specular,
        specular_color: Vec3::new(1.0, 0.7, 2.0),
        ior,
        ..Surface::default()
    }
}

/// Share of the light from `wo` that leaves again, by quadrature.
fn directional_albedo(f: impl Fn(Vec3) -> f64) -> f64 {
    integrate([0.0, FRAC_PI_2], [0.0, TAU], [400, 400], |wi| f(wi) * f64::from(wi.z))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// Phong's too: in the form without a division by the cosine the angle to the mirrored direction is the same from both sides.
    #[test]
    fn reciprocity(
        base in 0f32..1.0, metallic in 0f32..1.0, roughness in 0.15f32..1.0, specular in 0f32..1.0, ior in 1f32..2.5,
        theta in prop::array::uniform2(0f64..1.55), phi in prop::array::uniform2(0f64..TAU),
    ) {
        let (a, b) = (direction(theta[0], phi[0]), direction(theta[1], phi[1]));
        for &model in Model::ALL {
            let shape = glossy_surface(model, roughness);
            let own = surface(base, metallic, roughness, specular, ior);
            let layers = Surface { model, shininess: shape.shininess, slope: shape.slope, ..own }.layers();
            let (ab, ba) = (layers.evaluate(a, b), layers.evaluate(b, a));
            prop_assert!(ab.is_finite() && ab.min_element() >= 0.0);
            prop_assert!(ab.distance(ba) <= 1e-3 * ab.length().max(1e-3), "{} {ab} {ba}", model.name());
        }
    }

    #[test]
    fn specular_zero_is_lambert_bit_for_bit(
        base in prop::array::uniform3(0f32..1.0), roughness in 0f32..1.0, ior in 1f32..2.5,
        theta in prop::array::uniform2(0f64..1.57), phi in prop::array::uniform2(0f64..TAU),
    ) {
        let surface = Surface { base_color: base.into(), roughness, ior, specular: 0.0, metallic: 0.0, ..Surface::default() };
        let (wo, wi) = (direction(theta[0], phi[0]), direction(theta[1], phi[1]));
        for &model in Model::ALL {
            let value = Surface { model, ..surface }.layers().evaluate(wo, wi);
            prop_assert_eq!(value, surface.base_color * std::f32::consts::FRAC_1_PI);
        }
    }

    #[test]
    fn samples_are_consistent(
        metallic in 0f32..1.0, place in 0f32..1.0, specular in 0f32..1.0, theta in 0f64..1.7, u in prop::array::uniform3(0f32..1.0),
    ) {
        let wo = direction(theta, 1.0);
        for &model in Model::ALL {
            let mut surface = Surface { model, ..surface(0.7, metallic, 0.0, specular, 1.5) };
            if let Some(shape) = model.shape() {
                (shape.set)(&mut surface, Vec3::splat(shape.range[0] + place * (shape.range[1] - shape.range[0])));
            }
            let layers = surface.layers();
            if let Some(sample) = layers.sample(wo, Vec2::new(u[0], u[1]), u[2]) {
                prop_assert!(sample.wi.z > 0.0 && (sample.wi.length() - 1.0).abs() < 1e-4);
                prop_assert!(sample.pdf > 0.0 && sample.pdf.is_finite() && sample.f.is_finite());
                prop_assert_eq!(sample.pdf, layers.pdf(wo, sample.wi));
                prop_assert_eq!(sample.f, layers.evaluate(wo, sample.wi));
            }
        }
    }
}

/// Metals and the dielectric's reflection on its own never give back more than they get. Under a diffuse base the glTF mix
/// weighs the base by Fresnel at the half vector, which at grazing views gives back more than the reflection took (up to 1.3 for a
/// white base): the format's own rule, held here to its bound, the sum of both layers.
#[test]
fn energy_is_conserved() {
    let albedo = |base: f32, metallic: f32, roughness: f32, ior: f32, theta: f64| {
        let surface = Surface {
            base_color: Vec3::splat(base),
            metallic,
            roughness,
            specular: 1.0,
            specular_color: Vec3::ONE,
            ior,
            ..Surface::default()
        };
        let (model, wo) = (surface.layers(), direction(theta, 0.0));
        directional_albedo(|wi| f64::from(model.evaluate(wo, wi).x))
    };
    for roughness in [0.3, 0.6, 1.0] {
        for theta in [0.0, 0.8, 1.4] {
            let metal = albedo(1.0, 1.0, roughness, 1.5, theta);
            assert!((0.3..=1.0 + 1e-4).contains(&metal), "metal {metal}");
            for ior in [1.0, 1.5, 2.4] {
                let reflection = albedo(0.0, 0.0, roughness, ior, theta);
                assert!((0.0..=metal).contains(&reflection), "reflection {reflection} metal {metal}");
                let both = albedo(1.0, 0.0, roughness, ior, theta);
                assert!(both <= 1.0 + reflection && both > 0.7, "both {both}");
                if theta == 0.0 {
                    assert!(both <= 1.0 + 1e-3, "both {both} seen along the normal");
                }
            }
        }
    }
}

#[test]
fn lambert_albedo_is_exact() {
    // The integral of cos / pi over the hemisphere is 1: quadrature and f32 leave 1e-5.
    let base_color = Vec3::new(0.18, 0.5, 1.0);
    let lambert = Surface { model: Model::Lambert, base_color, ..Surface::default() }.layers();
    for (channel, expected) in [(0, 0.18), (1, 0.5), (2, 1.0)] {
        let albedo = directional_albedo(|wi| f64::from(lambert.evaluate(Vec3::Z, wi)[channel]));
        assert!((albedo - expected).abs() < 1e-5);
    }
    // Importance sampling has no variance: f cos / pdf is the albedo for every sample.
    let sample = lambert.sample(Vec3::Z, Vec2::new(0.3, 0.8), 0.0).unwrap();
    assert!((sample.f * sample.wi.z / sample.pdf).distance(base_color) < 1e-6);
}

/// Weak white furnace (Heitz 2014, section 5.2): without shadowing of `wi`, the visible microfacets reflect all light.
/// Directions under the surface count: the law holds over the whole sphere.
#[test]
fn weak_furnace_is_one() {
    let weak = |alpha: f32, theta: f64, wo: Vec3| {
        let pdf = |wi: Vec3| f64::from(pdf_ggx_vndf(wo, wi, alpha));
        let total = integrate([0.0, PI], [0.0, TAU], [1600, 800], pdf);
        assert!((total - 1.0).abs() < 2e-3, "alpha {alpha} theta {theta}: {total}");
    };
    for alpha in [0.1, 0.3, 1.0] {
        for theta in [0.0, 0.7, 1.3] {
            weak(alpha, theta, direction(theta, 0.4));
        }
    }
}

/// `D cos` integrates to 1 over the hemisphere of microfacet normals (Walter et al. 2007, eq. 4).
#[test]
fn microfacet_areas_project_to_one() {
    for alpha in [0.1, 0.5, 1.0] {
        let total = directional_albedo(|h| f64::from(d_ggx(h.z, alpha)));
        assert!((total - 1.0).abs() < 1e-3, "{total}");
    }
}

/// Independent truth for the split sum: GGX written out in 64 bits and integrated over `wi` by the midpoint rule.
fn dfg_truth(n_dot_v: f64, alpha: f64) -> [f64; 2] {
    let wo = [(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v];
    let steps = [1200, 600];
    let mut sum = [0.0; 2];
    for i in 0..steps[0] {
        let theta = (i as f64 + 0.5) * FRAC_PI_2 / steps[0] as f64;
        for j in 0..steps[1] {
            let phi = (j as f64 + 0.5) * PI / steps[1] as f64;
            let wi = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
            let h = [wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]];
            let length = (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]).sqrt();
            let (n_dot_h, v_dot_h) = (h[2] / length, (wo[0] * h[0] + wo[1] * h[1] + wo[2] * h[2]) / length);
            let tan2 = |c: f64| (1.0 - c * c) / (c * c);
            let d = 1.0
                / (PI * alpha * alpha * n_dot_h.powi(4) * (1.0 + tan2(n_dot_h) / (alpha * alpha)).powi(2));
            let lambda = |c: f64| 0.5 * ((1.0 + alpha * alpha * tan2(c)).sqrt() - 1.0);
            let g2 = 1.0 / (1.0 + lambda(n_dot_v) + lambda(wi[2]));
            let value = d * g2 / (4.0 * n_dot_v) * theta.sin();
            let fresnel = (1.0 - v_dot_h).powi(5);
            sum[0] += value * (1.0 - fresnel);
            sum[1] += value * fresnel;
        }
    }
    let patch = 2.0 * (FRAC_PI_2 / steps[0] as f64) * (PI / steps[1] as f64);
    sum.map(|s| s * patch)
}

#[test]
fn split_sum_matches_quadrature() {
    let mut worst = 0.0f64;
    for n_dot_v in [0.05f32, 0.2, 0.5, 0.9, 1.0] {
        for roughness in [0.25f32, 0.5, 0.75, 1.0] {
            let table = dfg(n_dot_v, roughness);
            let truth = dfg_truth(f64::from(n_dot_v), f64::from(roughness).powi(2));
            let error = (f64::from(table.x) - truth[0]).abs().max((f64::from(table.y) - truth[1]).abs());
            assert!(error < 3e-3, "n_dot_v {n_dot_v} roughness {roughness}: {table} against {truth:?}");
            worst = worst.max(error);
        }
    }
    println!("split sum: worst error {worst:.1e}");
}

/// White furnace with F = 1: what is missing from 1 is the single-scattering loss, which grows with roughness.
#[test]
fn furnace_loses_only_multiple_scattering() {
    let white_metal = |roughness: f32, theta: f64| {
        let surface = Surface { base_color: Vec3::ONE, metallic: 1.0, roughness, ..Surface::default() };
        let model = surface.layers();
        let wo = direction(theta, 0.0);
        directional_albedo(|wi| f64::from(model.evaluate(wo, wi).x))
    };
    for theta in [0.0, 0.7, 1.2] {
        let albedos = [0.3, 0.6, 1.0].map(|roughness| white_metal(roughness, theta));
        for (albedo, roughness) in albedos.into_iter().zip([0.3f32, 0.6, 1.0]) {
            let truth = dfg_truth(theta.cos(), f64::from(roughness).powi(2));
            assert!((albedo - truth[0] - truth[1]).abs() < 2e-3, "{albedo} {truth:?}");
        }
        assert!(albedos[0] > albedos[1] && albedos[1] > albedos[2] && albedos[0] > 0.95, "{albedos:?}");
    }
    // Alpha 1 seen along the normal: D = 1 / pi and G2 = 2 / (1 + 1 / cos) reduce the albedo to
    // the integral of cos / (1 + cos) over cos in 0..1, which is 1 - ln 2.
    let albedo = white_metal(1.0, 0.0);
    assert!((albedo - (1.0 - std::f64::consts::LN_2)).abs() < 1e-3, "{albedo}");
}

#[test]
fn table_is_laid_out_and_quick() {
    let start = std::time::Instant::now();
    let table = dfg_table(64);
    let seconds = start.elapsed().as_secs_f64();
    println!("64 x 64 split-sum table: {:.1} ms", 1e3 * seconds);
    assert_eq!(table.len(), 64 * 64);
    assert_eq!(table[3 * 64 + 40], dfg(40.5 / 64.0, 3.5 / 64.0));
    assert!(table.iter().all(|t| t.is_finite() && t.min_element() >= 0.0 && t.x + t.y <= 1.0 + 1e-4));
    // The goal is 50 ms; a loaded test machine is given ten times that.
    assert!(seconds < 0.5, "{seconds} s");
}

#[test]
fn a_normal_that_faces_away_still_reflects() {
    let surface = surface(0.8, 0.0, 0.4, 1.0, 1.5);
    let wo = direction(1.7, 0.0);
    let f = surface.layers().evaluate(wo, direction(0.3, 2.0));
    assert!(f.is_finite() && f.min_element() > 0.0);
}
