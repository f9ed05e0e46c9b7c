//! Glossy lobes over area lights: the lobe is taken as Gaussian in a plane in which the light is flat, so that its integral over
//! the light has a closed form. As exact as the light is small or the lobe narrow, whichever of them is the wider one.

use std::f32::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI, FRAC_PI_4};

use glam::{Vec2, Vec3};

/// A light as a surface point sees it, in the point's tangent frame.
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
pub(crate) fn power_distance(peak_cosine: f32, s: f32) -> f32 {
    (-2.0 * s / (s + 1.0) * peak_cosine.clamp(1e-20, 1.0).ln()).sqrt()
}

/// From `to`, `distance` away, to `origin`, in the plane across `origin`.
pub(crate) fn away(origin: Vec3, to: Vec3, distance: f32) -> Vec3 {
    -distance * (to - origin * origin.dot(to)).normalize_or_zero()
}

/// A light in the plane across the half vector to its middle: what the half vector turns by as `wi` goes over the light.
pub(crate) struct HalfVectorPatch {
    /// Half vector to the light's middle.
    h: Vec3,
    half_width: Vec3,
    half_height: Vec3,
    is_disk: bool,
    pub n_dot_h: f32,
    pub v_dot_h: f32,
}

impl HalfVectorPatch {
    /// `None` where the light's middle is under the surface, or the half vector about perpendicular to the normal or the view.
    pub fn new(wo: Vec3, light: &LightPatch) -> Option<Self> {
        let sum = wo + light.direction;
        let length = sum.length().max(1e-6);
        let h = sum / length;
        let turn = |e: Vec3| (e - h * h.dot(e)) / length;
        let (half_width, half_height) = (turn(light.half_width), turn(light.half_height));
        let (n_dot_h, v_dot_h) = (h.z, wo.dot(h));
        let is_seen = light.direction.z > 0.0 && n_dot_h > 1e-2 && v_dot_h > 1e-3;
        is_seen.then_some(Self { h, half_width, half_height, is_disk: light.is_disk, n_dot_h, v_dot_h })
    }

    /// Share of a normal distribution about the normal, which is `distance` away, that lies on the light.
    pub fn share(&self, distance: f32, sigma: f32) -> f32 {
        let at = away(self.h, Vec3::Z, distance);
        gaussian_patch(at, self.half_width, self.half_height, sigma, self.is_disk)
    }
}
