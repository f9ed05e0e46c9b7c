//! What Torrance and Sparrow's microfacets (1967) share, whatever the distribution of their normals: Smith's shadowing, as Heidrich
//! 2001, section 1.1, has them.

use std::f32::consts::FRAC_1_SQRT_2;

use glam::Vec3;

use crate::area::HalfVectorPatch;
use crate::{LightPatch, Lobe, MIN_N_DOT_V};

/// Smith's masking of one direction by Gaussian slopes, 0..1, in the rational form of Walter et al. 2007, eq. 27 (error 0.35 %); 0
/// under the surface.
pub fn g1_smith_beckmann(cosine: f32, slope: f32) -> f32 {
    if cosine <= 0.0 {
        return 0.0;
    }
    let sine = ((1.0 - cosine).max(0.0) * (1.0 + cosine)).sqrt();
    // cot / m, at least 1.6 where there is no masking.
    if cosine >= 1.6 * slope * sine {
        return 1.0;
    }
    let a = cosine / (slope * sine);
    a * (3.535 + 2.181 * a) / (1.0 + a * (2.276 + 2.577 * a))
}

/// Smith's shadowing and masking over the microfacet denominator, `G1 G1 / (4 n_dot_v n_dot_l)` (Walter et al. 2007, eqs. 20 and
/// 23; the 4 is today's, Torrance and Sparrow's pi belongs to another measure of D). Both cosines are positive.
pub fn v_smith_beckmann(n_dot_v: f32, n_dot_l: f32, slope: f32) -> f32 {
    g1_smith_beckmann(n_dot_v, slope) * g1_smith_beckmann(n_dot_l, slope) / (4.0 * n_dot_v * n_dot_l)
}

/// Angle of a cosine in `[0, 1]` [rad].
pub(crate) fn angle_from_cosine(cosine: f32) -> f32 {
    ((1.0 - cosine).max(0.0) * (1.0 + cosine)).sqrt().atan2(cosine)
}

/// The lobe over an area light of which `on_light` is the microfacets' share. Cosine, `masking` over the microfacet denominator, and Fresnel
/// are taken at the light's middle.
pub(crate) fn light_lobe(
    lobe: &Lobe,
    wo: Vec3,
    light: &LightPatch,
    masking: impl Fn(f32, f32) -> f32,
    on_light: impl Fn(&HalfVectorPatch) -> f32,
) -> Vec3 {
    let Some(patch) = HalfVectorPatch::new(wo, light) else { return Vec3::ZERO };
    let n_dot_l = light.direction.z;
    // The microfacet turns by half as much as the light: a quarter of its solid angle over v.h.
    let arriving = 4.0 * n_dot_l * masking(wo.z.max(MIN_N_DOT_V), n_dot_l) * patch.v_dot_h;
    lobe.schlick(on_light(&patch) * arriving, patch.v_dot_h)
}

/// Share of microfacets with Gaussian slopes of this root mean square that mirror a light. The slope's own plane would be exact, but
/// stretches a light at grazing half vectors without bound.
pub(crate) fn gaussian_slopes_on(patch: &HalfVectorPatch, slope: f32) -> f32 {
    let c = patch.n_dot_h;
    let tangent = ((1.0 - c).max(0.0) * (1.0 + c)).sqrt() / c;
    patch.share(tangent, slope * FRAC_1_SQRT_2) / (c * c * c * c)
}

/// Density of the mirrored direction, that of the microfacet's normal being `pdf_normal` (Walter et al. 2007, eq. 14).
pub(crate) fn pdf_mirrored(n_dot_h: f32, v_dot_h: f32, pdf_normal: impl Fn(f32) -> f32) -> f32 {
    if n_dot_h > 0.0 && v_dot_h > 0.0 { pdf_normal(n_dot_h) / (4.0 * v_dot_h) } else { 0.0 }
}
