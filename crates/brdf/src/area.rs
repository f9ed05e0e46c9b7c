//! Glossy lobes over area lights: the lobe is taken as Gaussian in a plane in which the light is flat, so that its integral over
//! the light has a closed form. As exact as the light is small or the lobe narrow, whichever of them is the wider one.

use std::f32::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI, FRAC_PI_4, TAU};

use glam::{Vec2, Vec3};

use crate::lobe::schlick_share;
use crate::sampling::reflect;
use crate::torrance_sparrow::angle_from_cosine;
use crate::{
    MIN_N_DOT_V, Model, SlopeDistribution, blinn_phong_norm, g1_smith_beckmann, gaussian_norm,
    reflectance_lobe,
};

/// A light as a surface point sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPatch {
    /// Unit vector to its middle.
    pub direction: Vec3,
    /// From its middle to the middle of one side, at a distance of 1, perpendicular to `direction`; of a disk a radius.
    pub half_width: Vec3,
    /// The same to the next side.
    pub half_height: Vec3,
    /// Whether it is an ellipse rather than a parallelogram.
    pub is_disk: bool,
}

/// Error function, absolute error 1.5e-7 (Abramowitz and Stegun 1964, 7.1.26), its series where that is the better.
pub fn erf(x: f32) -> f32 {
    let z = x.abs();
    if z < 0.1 {
        return FRAC_2_SQRT_PI * x * (1.0 + z * z * (z * z * 0.1 - 1.0 / 3.0));
    }
    let t = 1.0 / (1.0 + 0.327_591_1 * z);
    let poly =
        t * (0.254_829_6 + t * (-0.284_496_74 + t * (1.421_413_7 + t * (-1.453_152 + t * 1.061_405_4))));
    (1.0 - poly * (-z * z).exp()) * x.signum()
}

/// Share of a normal distribution within 1 of `center`.
pub fn gaussian_interval(center: f32, sigma: f32) -> f32 {
    if sigma > 5.0 {
        // The difference of two error functions would lose its digits; the curvature's term leaves 1e-3.
        let t2 = (center / sigma) * (center / sigma);
        let curvature = 1.0 + (t2 - 1.0) / (6.0 * sigma * sigma);
        return FRAC_2_SQRT_PI * FRAC_1_SQRT_2 / sigma * (-0.5 * t2).exp() * curvature;
    }
    let scale = FRAC_1_SQRT_2 / sigma;
    0.5 * (erf((center + 1.0) * scale) - erf((center - 1.0) * scale))
}

/// Share of an isotropic normal distribution of the plane that lies on a parallelogram or ellipse, whose middle is at `at` from the
/// distribution's and whose half sides (radii) are `a` and `b`.
///
/// Exact for a rectangle; of a parallelogram the shear is left out; of an ellipse the limits of a small and of a large one are
/// exact, between them the chord through both middles decides, and a mean width across it.
pub fn gaussian_patch(at: Vec3, a: Vec3, b: Vec3, sigma: f32, is_disk: bool) -> f32 {
    let (aa, bb, ab) = (a.length_squared(), b.length_squared(), a.dot(b));
    let area2 = (aa * bb - ab * ab).max(1e-30);
    if is_disk {
        // `at` in radii.
        let (along_a, along_b) = (at.dot(a), at.dot(b));
        let q = Vec2::new(along_a * bb - along_b * ab, along_b * aa - along_a * ab) / area2;
        let distance = q.length();
        let area = area2.sqrt();
        let radius = if distance > 1e-4 { at.length() / distance } else { area.sqrt() };
        let sigma_across = sigma * radius / area;
        return gaussian_interval(distance, sigma / radius) * erf(FRAC_PI_4 * FRAC_1_SQRT_2 / sigma_across);
    }
    // The longer side keeps its direction.
    let (a, b, aa, ab) = if aa >= bb { (a, b, aa, ab) } else { (b, a, bb, ab) };
    let across = b - a * (ab / aa.max(1e-30));
    let across2 = (area2 / aa.max(1e-30)).max(1e-30);
    let first = gaussian_interval(at.dot(a) / aa.max(1e-30), sigma / aa.sqrt().max(1e-15));
    first * gaussian_interval(at.dot(across) / across2, sigma / across2.sqrt())
}

/// From the peak of a lobe of variance `1 / (s + 1)` to a direction `peak_cosine` away from it, such that a Gaussian of this distance
/// is `cos^s`.
fn power_distance(peak_cosine: f32, s: f32) -> f32 {
    (-2.0 * s / (s + 1.0) * peak_cosine.clamp(1e-20, 1.0).ln()).sqrt()
}

/// Integral of [`reflectance_lobe`] times the cosine over an area light: radiance reflected per unit of the light's, `x f0 + y f90`. Tends
/// to the lobe times the solid angle as the light shrinks.
///
/// Cosine, shadowing and Fresnel are taken at the light's middle, the lobe over all of it: about the mirrored view for Phong,
/// of the half vector for the others. The lobe of
/// [`Model::MetallicRoughness`] is not integrated but taken at the middle.
pub fn light_lobe(model: Model, parameter: f32, n: Vec3, wo: Vec3, light: &LightPatch) -> Vec2 {
    let wi = light.direction;
    let (a, b) = (light.half_width, light.half_height);
    let n_dot_l = n.dot(wi);
    if n_dot_l <= 0.0 {
        return Vec2::ZERO;
    }
    let sum = wo + wi;
    let length = sum.length();
    let h = sum / length.max(1e-6);
    let n_dot_h = n.dot(h);
    let v_dot_h = wo.dot(h);
    // The half vector's derivative: what it turns by as wi does.
    let turn = |e: Vec3| (e - h * h.dot(e)) / length.max(1e-6);
    let away =
        |from: Vec3, to: Vec3, distance: f32| -distance * (to - from * from.dot(to)).normalize_or_zero();
    let microfacets = |share_on_light: f32, masking_slope: f32| {
        let n_dot_v = n.dot(wo).max(MIN_N_DOT_V);
        let masking =
            g1_smith_beckmann(n_dot_v, masking_slope) * g1_smith_beckmann(n_dot_l, masking_slope) / n_dot_v;
        let share = schlick_share(v_dot_h);
        share_on_light * v_dot_h * masking * Vec2::new(1.0 - share, share)
    };
    match model {
        Model::Lambert => Vec2::ZERO,
        Model::MetallicRoughness => {
            let flat_area = if light.is_disk { 0.5 * TAU } else { 4.0 } * a.cross(b).length();
            reflectance_lobe(model, parameter, n, wo, wi) * n_dot_l * flat_area
        }
        Model::Phong => {
            let mirrored = reflect(n, wo);
            let distance = power_distance(mirrored.dot(wi), parameter);
            let sigma = 1.0 / (parameter + 1.0).sqrt();
            let share = gaussian_patch(away(wi, mirrored, distance), a, b, sigma, light.is_disk);
            Vec2::new((parameter + 2.0) / (parameter + 1.0) * share * n_dot_l, 0.0)
        }
        _ if n_dot_h <= 1e-2 || v_dot_h <= 1e-3 => Vec2::ZERO,
        Model::BlinnPhong => {
            let distance = power_distance(n_dot_h, parameter);
            let sigma = 1.0 / (parameter + 1.0).sqrt();
            let share = gaussian_patch(away(h, n, distance), turn(a), turn(b), sigma, light.is_disk);
            let norm = blinn_phong_norm(parameter) * TAU / (parameter + 1.0);
            Vec2::new(norm * 4.0 * v_dot_h * share * n_dot_l, 0.0)
        }
        Model::TorranceSparrowBeckmann => {
            // The slope's own plane would be exact, but stretches a light at grazing half vectors without bound.
            let tangent = ((1.0 - n_dot_h).max(0.0) * (1.0 + n_dot_h)).sqrt() / n_dot_h;
            let at = away(h, n, tangent);
            let share = gaussian_patch(at, turn(a), turn(b), parameter * FRAC_1_SQRT_2, light.is_disk);
            let c2 = n_dot_h * n_dot_h;
            microfacets(share / (c2 * c2), parameter)
        }
        Model::TorranceSparrowGaussian => {
            let at = away(h, n, angle_from_cosine(n_dot_h));
            let share = gaussian_patch(at, turn(a), turn(b), parameter * FRAC_1_SQRT_2, light.is_disk);
            microfacets(
                share / gaussian_norm(parameter),
                SlopeDistribution::Gaussian.masking_slope(parameter),
            )
        }
    }
}
