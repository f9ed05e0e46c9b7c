use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec2, Vec3};

/// Smallest GGX alpha: a perceptual roughness of 0.0447. `d_ggx` forms `1 - n_dot_h^2` in 32 bits, whose rounding (6e-8)
/// stays under 2 % of alpha^2 = 4e-6; a narrower lobe would be noise. Its width is 0.1 degrees.
pub const MIN_ALPHA: f32 = 0.002;

/// Smallest cosine towards the viewer. An interpolated normal can face away from the viewer near a silhouette; the surface
/// is then seen at this grazing angle instead of being black.
pub const MIN_N_DOT_V: f32 = 1e-4;

/// GGX alpha of a perceptual roughness: its square (glTF 2.0 appendix B.2.3), at least [`MIN_ALPHA`].
pub fn alpha_from_roughness(roughness: f32) -> f32 {
    (roughness * roughness).clamp(MIN_ALPHA, 1.0)
}

/// GGX normal distribution [1/sr of the microfacet normal] (Walter et al. 2007, eq. 33).
pub fn d_ggx(n_dot_h: f32, alpha: f32) -> f32 {
    if n_dot_h <= 0.0 {
        return 0.0;
    }
    let a2 = alpha * alpha;
    // (1 - c)(1 + c) rather than 1 - c^2: one rounding less where the lobe is narrow.
    let d = (1.0 - n_dot_h).max(0.0) * (1.0 + n_dot_h) + n_dot_h * n_dot_h * a2;
    a2 * FRAC_1_PI / (d * d)
}

/// Smith's auxiliary function `(sqrt(1 + alpha^2 tan^2) - 1) / 2` of a positive cosine (Heitz 2014, eq. 72).
pub fn lambda_ggx(cos_theta: f32, alpha: f32) -> f32 {
    let c2 = cos_theta * cos_theta;
    let a2_tan2 = alpha * alpha * (1.0 - c2).max(0.0) / c2;
    // sqrt(1 + t) - 1 = t / (sqrt(1 + t) + 1) keeps its digits for small t.
    0.5 * a2_tan2 / ((1.0 + a2_tan2).sqrt() + 1.0)
}

/// Smith masking of one direction, 0..1: `1 / (1 + Lambda)` (Heitz 2014, eq. 43); 0 under the surface.
pub fn g1_smith_ggx(cos_theta: f32, alpha: f32) -> f32 {
    if cos_theta <= 0.0 { 0.0 } else { 1.0 / (1.0 + lambda_ggx(cos_theta, alpha)) }
}

/// Height-correlated masking-shadowing over the microfacet denominator, `G2 / (4 n_dot_v n_dot_l)` (Heitz 2014, eq. 99; glTF
/// 2.0 appendix B.3.2). Both cosines are positive.
pub fn v_smith_ggx_correlated(n_dot_v: f32, n_dot_l: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let v = n_dot_l * (n_dot_v * n_dot_v * (1.0 - a2) + a2).sqrt();
    let l = n_dot_v * (n_dot_l * n_dot_l * (1.0 - a2) + a2).sqrt();
    0.5 / (v + l)
}

/// Microfacet normal distributed as those that `wo` sees (Heitz 2018, appendix A), local frame, `wo.z > 0`.
pub fn sample_ggx_vndf(wo: Vec3, alpha: f32, u: Vec2) -> Vec3 {
    // Stretch the view so that alpha becomes 1.
    let v = Vec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalize();
    let length2 = v.x * v.x + v.y * v.y;
    let t1 = if length2 > 0.0 { Vec3::new(-v.y, v.x, 0.0) / length2.sqrt() } else { Vec3::X };
    let t2 = v.cross(t1);
    // A point of the projected hemisphere: a disk whose lower half is foreshortened.
    let r = u.x.sqrt();
    let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
    let p1 = r * cos_phi;
    let s = 0.5 * (1.0 + v.z);
    let p2 = (1.0 - s) * (1.0 - p1 * p1).max(0.0).sqrt() + s * r * sin_phi;
    let h = t1 * p1 + t2 * p2 + v * (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
    // Unstretch. z stays positive so that the normal can always be formed.
    Vec3::new(alpha * h.x, alpha * h.y, h.z.max(1e-7)).normalize()
}

/// Density [1/sr of `wi`] of the reflection of `wo` about a normal from [`sample_ggx_vndf`]: `G1(wo) D(h) / (4 n_dot_v)` (Heitz
/// 2018, eqs. 3 and 17). Zero for a `wi` that needs a microfacet facing away.
pub fn pdf_ggx_vndf(wo: Vec3, wi: Vec3, alpha: f32) -> f32 {
    let h = (wo + wi).normalize_or_zero();
    if wo.z <= 0.0 || wo.dot(h) <= 0.0 {
        return 0.0;
    }
    g1_smith_ggx(wo.z, alpha) * d_ggx(h.z, alpha) / (4.0 * wo.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms() {
        // D at its peak is 1 / (pi alpha^2).
        assert!((d_ggx(1.0, 0.25) * std::f32::consts::PI * 0.0625 - 1.0).abs() < 1e-6);
        // Alpha 1 is the uniform-projected hemisphere: D = 1 / pi everywhere.
        assert!((d_ggx(0.3, 1.0) - FRAC_1_PI).abs() < 1e-6);
        assert_eq!(d_ggx(-0.5, 0.3), 0.0);
        // tan 60 degrees = sqrt 3: Lambda = (sqrt(1 + 3) - 1) / 2 for alpha 1.
        assert!((lambda_ggx(0.5, 1.0) - 0.5).abs() < 1e-6);
        assert_eq!(g1_smith_ggx(1.0, 0.7), 1.0);
        assert_eq!(g1_smith_ggx(-0.1, 0.7), 0.0);
    }

    #[test]
    fn correlated_visibility_is_smith_g2() {
        for alpha in [0.01, 0.2, 1.0] {
            for (v, l) in [(1.0, 1.0), (0.9, 0.1), (0.05, 0.4)] {
                let g2 = 1.0 / (1.0 + lambda_ggx(v, alpha) + lambda_ggx(l, alpha));
                let expected = g2 / (4.0 * v * l);
                assert!((v_smith_ggx_correlated(v, l, alpha) / expected - 1.0).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn alpha_is_clamped() {
        assert_eq!(alpha_from_roughness(0.0), MIN_ALPHA);
        assert_eq!(alpha_from_roughness(1.0), 1.0);
        assert_eq!(alpha_from_roughness(3.0), 1.0);
        assert_eq!(alpha_from_roughness(0.5), 0.25);
    }
}
