//! Torrance and Sparrow's microfacets with their own distribution: Gaussian angles. The slope m is the angle [rad] at which the
//! density has fallen to 1/e.

use std::f32::consts::{FRAC_1_PI, FRAC_1_SQRT_2, FRAC_PI_2, TAU};

use glam::{Vec2, Vec3};

use super::ReflectanceModel;
use crate::sampling::{half_vector, reflect};
use crate::torrance_sparrow::{angle_from_cosine, light_lobe, pdf_mirrored};
use crate::{
    BASE_COLOR, IOR, LightPatch, Lobe, METALLIC, MIN_N_DOT_V, Parameter, SLOPE, SPECULAR, SPECULAR_COLOR,
    v_smith_beckmann,
};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct TorranceSparrowGaussian;

/// The Gaussian distribution `c exp(-(delta / m)^2)` of the angle delta to the surface's normal [1/sr of the microfacet normal]
/// (Torrance and Sparrow 1967, eq. 6), with the c that makes the microfacets' projected area 1.
pub fn d_gaussian(n_dot_h: f32, slope: f32) -> f32 {
    if n_dot_h <= 0.0 {
        return 0.0;
    }
    let angle = angle_from_cosine(n_dot_h);
    let m2 = slope * slope;
    (-angle * angle / m2).exp() * FRAC_1_PI / (m2 * gaussian_norm(slope))
}

/// Integral of `exp(-(delta / m)^2) sin(2 delta)` over delta from 0 to pi/2, divided by m^2: what [`d_gaussian`] is normalised by.
///
/// A least-squares polynomial in m^2; relative error 1e-5 for m from 0.005 to 1.
pub fn gaussian_norm(slope: f32) -> f32 {
    let t = slope * slope;
    let high = 0.192_542_94 + t * (-0.144_136_78 + t * 0.039_562_38);
    1.000_008 + t * (-0.667_482_3 + t * (0.280_081_72 + t * (-0.152_889_54 + t * high)))
}

/// The slope whose masking by [`crate::g1_smith_beckmann`] fits that of Gaussian angles, which have more steep facets: by brute force
/// within 1 % up to a slope of 0.5 and 3 % up to 1.
pub fn gaussian_masking_slope(slope: f32) -> f32 {
    slope * (1.0 + 0.1 * slope)
}

/// Share of a Gaussian in the plane that lies within pi/2.
fn gaussian_share(slope: f32) -> f32 {
    let t = FRAC_PI_2 / slope;
    1.0 - (-t * t).exp()
}

impl ReflectanceModel for TorranceSparrowGaussian {
    const NAME: &'static str = "torrance-sparrow-gaussian";
    const SUMMARY: &'static str = "Lambert and microfacets of Gaussian angles";
    const REQUIRED: &'static [&'static Parameter] = &[&SLOPE, &SPECULAR];
    const OPTIONAL: &'static [&'static Parameter] = &[&BASE_COLOR, &METALLIC, &SPECULAR_COLOR, &IOR];
    const SHAPE: Option<&'static Parameter> = Some(&SLOPE);

    fn lobe(lobe: &Lobe, wo: Vec3, wi: Vec3) -> Vec3 {
        let h = half_vector(wo, wi);
        let masking = v_smith_beckmann(wo.z.max(MIN_N_DOT_V), wi.z, gaussian_masking_slope(lobe.shape));
        lobe.schlick(d_gaussian(h.z, lobe.shape) * masking, wo.dot(h))
    }

    /// `wo` mirrored about a microfacet drawn from what has a closed form, a Gaussian in the angle.
    fn sample(lobe: &Lobe, wo: Vec3, u: Vec2) -> Vec3 {
        let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
        let angle = lobe.shape * (-(1.0 - u.x * gaussian_share(lobe.shape)).ln()).max(0.0).sqrt();
        let (sine, cosine) = angle.sin_cos();
        reflect(Vec3::new(sine * cos_phi, sine * sin_phi, cosine), wo)
    }

    fn pdf(lobe: &Lobe, wo: Vec3, wi: Vec3) -> f32 {
        let h = half_vector(wo, wi);
        pdf_mirrored(h.z, wo.dot(h), |n_dot_h| {
            let angle = angle_from_cosine(n_dot_h);
            let m2 = lobe.shape * lobe.shape;
            // angle / sin(angle), 1 at the normal.
            let stretch = if angle > 1e-3 { angle / angle.sin() } else { 1.0 };
            (-angle * angle / m2).exp() * FRAC_1_PI * stretch / (m2 * gaussian_share(lobe.shape))
        })
    }

    fn light_lobe(lobe: &Lobe, wo: Vec3, light: &LightPatch) -> Vec3 {
        let slope = gaussian_masking_slope(lobe.shape);
        let masking = |n_dot_v, n_dot_l| v_smith_beckmann(n_dot_v, n_dot_l, slope);
        light_lobe(lobe, wo, light, masking, |patch| {
            let sigma = lobe.shape * FRAC_1_SQRT_2;
            patch.share(angle_from_cosine(patch.n_dot_h), sigma) / gaussian_norm(lobe.shape)
        })
    }

    fn equivalent_roughness(lobe: &Lobe) -> f32 {
        lobe.shape.sqrt()
    }
}
