//! Torrance and Sparrow's microfacets with Beckmann's distribution: Gaussian slopes. The slope m is their root mean square.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec2, Vec3};

use super::ReflectanceModel;
use crate::sampling::{half_vector, reflect};
use crate::torrance_sparrow::{gaussian_slopes_on, light_lobe, pdf_mirrored};
use crate::{
    BASE_COLOR, IOR, LightPatch, Lobe, METALLIC, MIN_N_DOT_V, Parameter, SLOPE, SPECULAR, SPECULAR_COLOR,
    v_smith_beckmann,
};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct TorranceSparrowBeckmann;

/// Beckmann's distribution [1/sr of the microfacet normal] (Walter et al. 2007, eq. 25).
pub fn d_beckmann(n_dot_h: f32, slope: f32) -> f32 {
    if n_dot_h <= 1e-4 {
        return 0.0;
    }
    let c2 = n_dot_h * n_dot_h;
    let tan2 = (1.0 - n_dot_h).max(0.0) * (1.0 + n_dot_h) / c2;
    let m2 = slope * slope;
    (-tan2 / m2).exp() * FRAC_1_PI / (m2 * c2 * c2)
}

impl ReflectanceModel for TorranceSparrowBeckmann {
    const NAME: &'static str = "torrance-sparrow-beckmann";
    const SUMMARY: &'static str = "Lambert and microfacets of Gaussian slopes";
    const REQUIRED: &'static [&'static Parameter] = &[&SLOPE, &SPECULAR];
    const OPTIONAL: &'static [&'static Parameter] = &[&BASE_COLOR, &METALLIC, &SPECULAR_COLOR, &IOR];
    const SHAPE: Option<&'static Parameter> = Some(&SLOPE);

    fn lobe(lobe: &Lobe, wo: Vec3, wi: Vec3) -> Vec3 {
        let h = half_vector(wo, wi);
        let masking = v_smith_beckmann(wo.z.max(MIN_N_DOT_V), wi.z, lobe.shape);
        lobe.schlick(d_beckmann(h.z, lobe.shape) * masking, wo.dot(h))
    }

    /// `wo` mirrored about a microfacet drawn from `D (n . h)` (Walter et al. 2007, eq. 28).
    fn sample(lobe: &Lobe, wo: Vec3, u: Vec2) -> Vec3 {
        let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
        let tangent = lobe.shape * (-(1.0 - u.x).ln()).max(0.0).sqrt();
        let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
        let sine = tangent * cosine;
        reflect(Vec3::new(sine * cos_phi, sine * sin_phi, cosine), wo)
    }

    /// Walter et al. 2007, eqs. 24 and 14.
    fn pdf(lobe: &Lobe, wo: Vec3, wi: Vec3) -> f32 {
        let h = half_vector(wo, wi);
        pdf_mirrored(h.z, wo.dot(h), |n_dot_h| d_beckmann(n_dot_h, lobe.shape) * n_dot_h)
    }

    fn light_lobe(lobe: &Lobe, wo: Vec3, light: &LightPatch) -> Vec3 {
        let masking = |n_dot_v, n_dot_l| v_smith_beckmann(n_dot_v, n_dot_l, lobe.shape);
        light_lobe(lobe, wo, light, masking, |patch| gaussian_slopes_on(patch, lobe.shape))
    }

    fn equivalent_roughness(lobe: &Lobe) -> f32 {
        lobe.shape.sqrt()
    }
}
