//! Tables against the analytic models that they are made of, each written out here in 64 bits; laws of every tabulated model.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec2, Vec3, Vec4};
use gnomon_brdf::*;
use gnomon_testing::{tabulated_surfaces, tolerances};
use support::{Pcg, direction, integrate};

/// The half vector and its cosines to the normal and to the view.
fn half(wo: DVec3, wi: DVec3) -> (DVec3, f64, f64) {
    let h = (wo + wi).normalize();
    (h, h.z, wo.dot(h))
}

/// Fresnel of unpolarised light by complex numbers: `(cos - sqrt(m^2 - sin^2)) / (cos + ...)` and the like, a way of its own.
fn fresnel(n: f64, k: f64, cosine: f64) -> f64 {
    let multiply = |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
    let ratio2 = |a: [f64; 2], b: [f64; 2]| (a[0] * a[0] + a[1] * a[1]) / (b[0] * b[0] + b[1] * b[1]);
    let squared = multiply([n, k], [n, k]);
    let under = [squared[0] - (1.0 - cosine * cosine), squared[1]];
    let length = under[0].hypot(under[1]).sqrt();
    let angle = 0.5 * under[1].atan2(under[0]);
    let root = [length * angle.cos(), length * angle.sin()];
    let s = ratio2([cosine - root[0], -root[1]], [cosine + root[0], root[1]]);
    let m2c = [squared[0] * cosine, squared[1] * cosine];
    let p = ratio2([m2c[0] - root[0], m2c[1] - root[1]], [m2c[0] + root[0], m2c[1] + root[1]]);
    0.5 * (s + p)
}

fn smith_beckmann(cosine: f64, slope: f64) -> f64 {
    let a = cosine / (slope * (1.0 - cosine * cosine).max(1e-30).sqrt());
    if a >= 1.6 { 1.0 } else { (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a) }
}

fn slope_towards([along, across]: [f64; 2], w: DVec3) -> f64 {
    let length2 = (w.x * w.x + w.y * w.y).max(1e-30);
    ((along * along * w.x * w.x + across * across * w.y * w.y) / length2).sqrt()
}

/// The glossy part under a white tint, in the red channel.
fn analytic(surface: &Surface, wo: Vec3, wi: Vec3) -> f64 {
    let (wo, wi) = (wo.as_dvec3(), wi.as_dvec3());
    let (h, n_dot_h, v_dot_h) = half(wo, wi);
    let slope = f64::from(surface.slope);
    let slopes = [slope, (slope * f64::from(surface.aspect)).clamp(0.01, 1.0)];
    let f = fresnel(f64::from(surface.index.x), f64::from(surface.extinction.x), v_dot_h);
    let ellipse = |[along, across]: [f64; 2]| (h.x / along).powi(2) + (h.y / across).powi(2);
    match surface.model {
        Model::MicrofacetGaussian => {
            let angle = n_dot_h.min(1.0).acos();
            let d = (-(angle / slope).powi(2)).exp()
                / (PI * slope * slope * f64::from(gaussian_norm(surface.slope)));
            let masking = f64::from(gaussian_masking_slope(surface.slope));
            let g = smith_beckmann(wo.z, masking) * smith_beckmann(wi.z, masking);
            f * d * g / (4.0 * wo.z * wi.z)
        }
        Model::MicrofacetBeckmann => {
            let exponent = ellipse(slopes) / (n_dot_h * n_dot_h);
            let d = (-exponent).exp() / (PI * slopes[0] * slopes[1] * n_dot_h.powi(4));
            let g = smith_beckmann(wo.z, slope_towards(slopes, wo))
                * smith_beckmann(wi.z, slope_towards(slopes, wi));
            f * d * g / (4.0 * wo.z * wi.z)
        }
        Model::Ward => {
            let exponent = ellipse(slopes) / (n_dot_h * n_dot_h);
            (-exponent).exp() / (4.0 * PI * slopes[0] * slopes[1] * v_dot_h * v_dot_h * n_dot_h.powi(4))
        }
        Model::AnisotropicGgx => {
            let alpha = f64::from(surface.roughness).powi(2);
            let alphas = [alpha + (1.0 - alpha) * f64::from(surface.anisotropy).powi(2), alpha];
            let turn = glam::DQuat::from_rotation_z(-f64::from(surface.anisotropy_rotation));
            let (h, wo, wi) = (turn * h, turn * wo, turn * wi);
            let spread = (h.x / alphas[0]).powi(2) + (h.y / alphas[1]).powi(2) + h.z * h.z;
            let d = 1.0 / (PI * alphas[0] * alphas[1] * spread * spread);
            let g1 = |w: DVec3| {
                let a2_tan2 = slope_towards(alphas, w).powi(2) * (1.0 - w.z * w.z) / (w.z * w.z);
                2.0 / (1.0 + (1.0 + a2_tan2).sqrt())
            };
            d * g1(wo) * g1(wi) / (4.0 * wo.z * wi.z)
        }
        Model::Threads => {
            // The view turned about the thread into the plane of tangent and light, to the other side of its normal.
            let normal = DVec3::new(0.0, wi.y, wi.z).normalize();
            let turned = DVec3::X * wo.x + normal * (1.0 - wo.x * wo.x).max(0.0).sqrt();
            normal.dot((turned + wi).normalize()).max(0.0).powf(f64::from(surface.shininess))
        }
        Model::CosineLobe => {
            let axes = surface.axes.as_dvec3();
            let most = axes.abs().max_element();
            ((axes * wo).dot(wi) / most).max(0.0).powf(f64::from(surface.shininess))
        }
        other => panic!("{} has no tables", other.name()),
    }
}

struct Errors {
    /// Root of the mean squared error over that of the value, both times both cosines.
    l2: f64,
    /// Largest error where both cosines exceed 0.2, relative to the value, or to a twentieth of the view's peak where that is larger.
    largest: f64,
}

fn white<'a>(surface: &Surface, tables: &'a Tables) -> Lobe<'a> {
    Lobe { tint: Vec4::ONE, tables: Some(tables), ..surface.layers().lobe }
}

/// Over pairs of directions that the lobe's own samples choose.
fn errors(surface: &Surface, tables: &Tables) -> Errors {
    const VIEWS: usize = 60;
    const LIGHTS: usize = 1500;
    let lobe = white(surface, tables);
    let mut rng = Pcg(1);
    let mut pairs = Vec::new();
    for _ in 0..VIEWS {
        let wo = sample_cosine_hemisphere(Vec2::new(rng.next_f32(), rng.next_f32()));
        let mut of_view = Vec::new();
        for _ in 0..LIGHTS {
            let wi = lobe.sample(wo, Vec2::new(rng.next_f32(), rng.next_f32()));
            if wi.z > 1e-3 && wo.z > 1e-3 {
                let pdf = f64::from(lobe.pdf(wo, wi));
                let weight = f64::from(wi.z * wo.z) / pdf;
                of_view.push((
                    analytic(surface, wo, wi),
                    f64::from(lobe.value(wo, wi).x),
                    weight,
                    wo.z.min(wi.z),
                ));
            }
        }
        pairs.push(of_view);
    }
    // Models without a scale of their own are compared up to theirs.
    let all = || pairs.iter().flatten();
    let scale = match surface.model {
        Model::Threads | Model::CosineLobe => {
            all().map(|p| p.0 * p.1 * p.2).sum::<f64>() / all().map(|p| p.0 * p.0 * p.2).sum::<f64>()
        }
        _ => 1.0,
    };
    let error2: f64 = all().map(|p| (p.1 - scale * p.0).powi(2) * p.2).sum();
    let value2: f64 = all().map(|p| (scale * p.0).powi(2) * p.2).sum();
    let mut largest = 0.0f64;
    for of_view in &pairs {
        let peak = of_view.iter().map(|p| scale * p.0).fold(0.0, f64::max);
        for p in of_view.iter().filter(|p| p.3 > 0.2) {
            largest = largest.max((p.1 - scale * p.0).abs() / (scale * p.0).max(0.05 * peak));
        }
    }
    Errors { l2: (error2 / value2).sqrt(), largest }
}

fn describe(surface: &Surface) -> String {
    let Surface { slope, aspect, index, roughness, anisotropy, shininess, .. } = surface;
    let name = surface.model.name();
    format!(
        "{name} slope {slope} aspect {aspect} index {:.2} roughness {roughness} anisotropy {anisotropy} shininess {shininess}",
        index.x
    )
}

#[test]
fn tables_are_their_models() {
    for surface in tabulated_surfaces() {
        let tables = surface.tables().unwrap();
        let Errors { l2, largest } = errors(&surface, &tables);
        let what = describe(&surface);
        println!(
            "{what}: relative L2 {l2:.4}, largest away from grazing {largest:.4}, {} bytes",
            tables.bytes()
        );
        assert!(
            l2 <= tolerances::TABLES_L2 && largest <= tolerances::TABLES_LARGEST,
            "{what}: {l2} {largest}"
        );
    }
}

/// The measure sees a lobe that is 2 % too wide.
#[test]
fn a_planted_fault_is_found() {
    let surface = tabulated_surfaces()[2];
    let wrong = Surface { slope: 1.02 * surface.slope, ..surface }.tables().unwrap();
    assert!(errors(&surface, &wrong).l2 > tolerances::TABLES_L2);
}

/// White furnace: no tabulated lobe gives back more than it gets, the table of albedos is what quadrature finds, and a perfect conductor
/// loses only what is reflected between facets.
#[test]
fn furnace() {
    for surface in tabulated_surfaces() {
        let tables = surface.tables().unwrap();
        let lobe = white(&surface, &tables);
        for theta in [0.2, 0.8, 1.3] {
            let quadrature = |azimuth: f64| {
                let wo = direction(theta, azimuth);
                integrate([0.0, FRAC_PI_2], [0.0, TAU], [180, 180], |wi| {
                    f64::from(lobe.value(wo, wi).x * wi.z)
                })
            };
            // The table's entry is a mean over azimuths.
            let azimuths = 3;
            let found: Vec<f64> =
                (0..azimuths).map(|i| quadrature(TAU * (f64::from(i) + 0.2) / f64::from(azimuths))).collect();
            let mean = found.iter().sum::<f64>() / f64::from(azimuths);
            let table = f64::from(lobe.model.albedo(&lobe, theta.cos() as f32, Vec2::ZERO).x);
            let what = format!("{} theta {theta}: {found:.3?}, table {table:.3}", describe(&surface));
            println!("{what}");
            assert!(found.iter().all(|albedo| *albedo <= 1.02), "{what}");
            assert!((table - mean).abs() <= 0.03, "{what}");
        }
    }
    let mirror = Surface {
        model: Model::MicrofacetBeckmann,
        slope: 0.1,
        index: Vec3::splat(0.01),
        extinction: Vec3::splat(1000.0),
        specular: 1.0,
        ..Surface::default()
    };
    let tables = mirror.tables().unwrap();
    assert!(tables.most() > 0.97 && tables.most() < 1.01, "{}", tables.most());
}

#[test]
fn tables_are_reciprocal() {
    let mut rng = Pcg(9);
    for surface in tabulated_surfaces() {
        let tables = surface.tables().unwrap();
        let lobe = white(&surface, &tables);
        for _ in 0..300 {
            let wo = sample_cosine_hemisphere(Vec2::new(rng.next_f32(), rng.next_f32()));
            let wi = lobe.sample(wo, Vec2::new(rng.next_f32(), rng.next_f32()));
            if wi.z <= 0.0 || wo.z <= 0.0 {
                continue;
            }
            let (ab, ba) = (lobe.value(wo, wi), lobe.value(wi, wo));
            assert!(ab.distance(ba) <= 1e-3 * ab.length().max(1e-3), "{}: {ab} {ba}", describe(&surface));
        }
    }
}

/// Fresnel's closed forms: normal incidence, Brewster's angle, grazing incidence.
#[test]
fn exact_fresnel() {
    for n in [1.5f32, 5.0, 200.0] {
        let r = (n - 1.0) / (n + 1.0);
        let of = |cosine: f32| f_exact(Vec3::splat(n), Vec3::ZERO, cosine).x;
        assert!((of(1.0) - r * r).abs() < 1e-6 && (of(0.0) - 1.0).abs() < 1e-6, "{n}");
        // At Brewster's angle only one polarisation is left: ((n^2 - 1) / (n^2 + 1))^2 / 2.
        let brewster = (1.0 / (1.0 + n * n)).sqrt();
        let expected = 0.5 * ((n * n - 1.0) / (n * n + 1.0)).powi(2);
        assert!((of(brewster) - expected).abs() < 1e-5, "{n}: {} {expected}", of(brewster));
    }
    for metal in METALS {
        for cosine in [1.0, 0.7, 0.3, 0.05] {
            let found = f_exact(metal.index, metal.extinction, cosine);
            for channel in 0..3 {
                let expected =
                    fresnel(metal.index[channel].into(), metal.extinction[channel].into(), cosine.into());
                assert!((f64::from(found[channel]) - expected).abs() < 1e-5, "{} {cosine}", metal.name);
            }
        }
    }
}

/// A light's highlight against brute force, from points to lights much wider than the lobe.
#[test]
fn highlights() {
    for surface in
        [tabulated_surfaces()[2], tabulated_surfaces()[4], tabulated_surfaces()[8], tabulated_surfaces()[11]]
    {
        let tables = surface.tables().unwrap();
        let lobe = white(&surface, &tables);
        for (half, limit) in [(0.01, 0.02), (0.08, 0.2), (0.25, 0.2)] {
            let (mut error2, mut value2) = (0.0, 0.0);
            for i in 0..40 {
                let wo = direction(0.1 + 0.02 * f64::from(i), f64::from(i));
                let aside = Vec3::new((i % 5 - 2) as f32, (i % 7 - 3) as f32, 0.0) * 0.04;
                let middle = (Vec3::new(-wo.x, -wo.y, wo.z) + aside).normalize();
                let (x, y) = middle.any_orthonormal_pair();
                let (half_width, half_height) = (x * half, y * half);
                let light = LightPatch { direction: middle, half_width, half_height, is_disk: false };
                let steps = 64;
                let truth = (0..steps * steps)
                    .map(|j| {
                        let [a, b] =
                            [j % steps, j / steps].map(|j| 2.0 * (j as f32 + 0.5) / steps as f32 - 1.0);
                        let wi = (middle + half_width * a + half_height * b).normalize();
                        f64::from(lobe.value(wo, wi).x * wi.z.max(0.0))
                    })
                    .sum::<f64>()
                    * f64::from(4.0 * half * half)
                    / f64::from(steps * steps);
                error2 += (f64::from(lobe.over_light(wo, &light).x) - truth).powi(2);
                value2 += truth * truth;
            }
            let error = (error2 / value2).sqrt();
            println!("{} half side {half}: {error:.3}", describe(&surface));
            assert!(error < limit, "{} half side {half}: {error}", describe(&surface));
        }
    }
}
