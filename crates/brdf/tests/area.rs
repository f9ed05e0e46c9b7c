//! Lobes over area lights against brute-force integration.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use glam::{Vec3, Vec4};
use gnomon_brdf::*;
use gnomon_testing::{glossy_models, glossy_surface, tolerances};
use support::direction;

/// Lobes by the roughness of GGX ones as wide.
const ROUGHNESSES: [f32; 3] = [0.5, 0.33, 0.18];

/// Lobes of every model.
fn cases() -> impl Iterator<Item = (Model, [Lobe<'static>; 3])> {
    glossy_models().map(|model| (model, ROUGHNESSES.map(|roughness| white(model, roughness))))
}

/// A white lobe.
fn white(model: Model, roughness: f32) -> Lobe<'static> {
    Lobe { tint: Vec4::ONE, ..glossy_surface(model, roughness).layers().lobe }
}

/// A light of some half extents about a direction, turned about it.
fn patch(middle: Vec3, half: [f32; 2], turn: f32, is_disk: bool) -> LightPatch {
    let (x, y) = middle.any_orthonormal_pair();
    let (sin, cos) = turn.sin_cos();
    LightPatch {
        direction: middle,
        half_width: (x * cos + y * sin) * half[0],
        half_height: (y * cos - x * sin) * half[1],
        is_disk,
    }
}

/// Of a small light [sr].
fn solid_angle(light: &LightPatch) -> f32 {
    let shape = if light.is_disk { std::f32::consts::PI } else { 4.0 };
    shape * light.half_width.length() * light.half_height.length()
}

/// Lobe times cosine summed over the light.
fn brute_force(lobe: &Lobe, wo: Vec3, light: &LightPatch) -> f64 {
    const STEPS: i32 = 96;
    let mut sum = 0.0;
    for i in 0..STEPS * STEPS {
        let [x, y] = [i % STEPS, i / STEPS].map(|i| 2.0 * (i as f32 + 0.5) / STEPS as f32 - 1.0);
        if light.is_disk && x * x + y * y > 1.0 {
            continue;
        }
        let to = light.direction + light.half_width * x + light.half_height * y;
        let wi = to.normalize();
        // A piece of the tangent plane subtends the cube of the cosine.
        let solid_angle = f64::from(to.length()).powi(-3);
        sum += f64::from(lobe.value(wo, wi).x * wi.z.max(0.0)) * solid_angle;
    }
    let cell = 4.0 / f64::from(STEPS * STEPS);
    sum * cell * f64::from(light.half_width.cross(light.half_height).length())
}

/// Relative root mean square error over lights all around the mirrored view: what a highlight's picture is wrong by.
fn error_around(
    lobe: &Lobe,
    theta: f64,
    half: [f32; 2],
    is_disk: bool,
    estimate: impl Fn(Vec3, &LightPatch) -> f32,
) -> f64 {
    let wo = direction(theta, 0.2);
    let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
    let (x, y) = mirrored.any_orthonormal_pair();
    let lobe_width = 1.4 * lobe.model.equivalent_roughness(lobe).powi(2);
    let reach = 1.5 * half[0].max(half[1]) + 2.0 * lobe_width;
    let (mut squared, mut total) = (0.0, 0.0);
    for i in 0..49 {
        let [u, v] = [i % 7, i / 7].map(|i| (i as f32 - 3.0) / 3.0 * reach);
        let middle = (mirrored + x * u + y * v).normalize();
        if middle.z < half[0].max(half[1]) {
            continue;
        }
        let light = patch(middle, half, 0.5 + 0.1 * i as f32, is_disk);
        let truth = brute_force(lobe, wo, &light);
        squared += (f64::from(estimate(wo, &light)) - truth).powi(2);
        total += truth * truth;
    }
    (squared / total).sqrt()
}

#[test]
fn highlights_of_disks_and_rectangles() {
    let lights: [([f32; 2], bool); 7] = [
        ([0.02, 0.02], true),
        ([0.08, 0.08], true),
        ([0.25, 0.25], true),
        ([0.02, 0.03], false),
        ([0.1, 0.05], false),
        ([0.25, 0.06], false),
        ([0.3, 0.2], false),
    ];
    for (model, lobes) in cases() {
        for (half, is_disk) in lights {
            let mut worst = 0.0f64;
            for lobe in &lobes {
                for theta in [0.0, 0.5, 1.0] {
                    let estimate = |wo, light: &LightPatch| lobe.over_light(wo, light).x;
                    let error = error_around(lobe, theta, half, is_disk, estimate);
                    worst = worst.max(error);
                }
            }
            println!("{model:?} {half:?} disk {is_disk}: {worst:.3}");
            let limit = match half[0] {
                small if small < 0.05 => tolerances::AREA_LOBE_SMALL_LIGHT,
                medium if medium <= 0.1 => tolerances::AREA_LOBE_MEDIUM_LIGHT,
                _ => tolerances::AREA_LOBE_WIDE_LIGHT,
            };
            assert!(worst < limit, "{model:?} {half:?} disk {is_disk}: {worst}");
        }
    }
}

/// A light of an angular radius of 1 mrad is a point: the bare lobe times its solid angle.
#[test]
fn a_point_like_light_gives_the_bare_lobe() {
    for (model, lobes) in cases() {
        // A sum of Gaussians stands for GGX's slopes.
        let fit = if model == Model::MetallicRoughness { tolerances::AREA_LOBE_GGX_FIT } else { 0.0 };
        for lobe in &lobes {
            for (theta, phi) in [(0.6, 3.3), (0.75, 3.0), (0.9, 3.6)] {
                let wo = direction(0.7, 0.2);
                for is_disk in [true, false] {
                    let light = patch(direction(theta, phi), [1e-3; 2], 0.3, is_disk);
                    let bare = lobe.value(wo, light.direction).x * light.direction.z * solid_angle(&light);
                    let found = lobe.over_light(wo, &light).x;
                    let peak = lobe.value(wo, direction(0.7, 3.3416)).x * solid_angle(&light);
                    let limit = (tolerances::AREA_LOBE_POINT_LIGHT + fit) * bare.max(0.01 * peak);
                    assert!((found - bare).abs() <= limit, "{lobe:?}: {found} {bare}");
                }
            }
        }
    }
}

/// The measure sees a lobe that the light does not widen.
#[test]
fn a_bare_lobe_is_caught() {
    let narrow = white(Model::Phong, 0.18);
    let bare = |wo: Vec3, light: &LightPatch| {
        narrow.value(wo, light.direction).x * light.direction.z * solid_angle(light)
    };
    let error = error_around(&narrow, 0.5, [0.1, 0.05], false, bare);
    assert!(error > 2.0 * tolerances::AREA_LOBE_MEDIUM_LIGHT, "{error}");
}

#[test]
fn error_function() {
    // Abramowitz and Stegun, table 7.1.
    for (x, expected) in [(0.0, 0.0), (0.05, 0.056_372), (0.5, 0.520_500), (1.0, 0.842_701), (2.0, 0.995_322)]
    {
        assert!((erf(x) - expected).abs() < 2e-6 && (erf(-x) + expected).abs() < 2e-6, "{x}: {}", erf(x));
    }
    // Both branches meet.
    assert!((erf(0.0999) - erf(0.1001)).abs() < 3e-4);
    assert!((gaussian_interval(3.0, 4.99) / gaussian_interval(3.0, 5.01) - 1.0).abs() < 5e-3);
}
