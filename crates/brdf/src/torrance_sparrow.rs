//! Torrance and Sparrow's microfacets (1967) with Smith's shadowing, as Heidrich 2001, section 1.1, has them: Beckmann's
//! distribution of slopes, or a Gaussian one of angles.
//!
//! `slope` is m: the root mean square slope of Beckmann's surface; of the Gaussian one, the angle [rad] at which the density has
//! fallen to 1/e.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, TAU};

use glam::{Vec2, Vec3};

use crate::MIN_N_DOT_V;
use crate::sampling::{reflect, world_from_local};

/// Smallest slope: `n . h` rounds by 6e-8, which moves the density of so narrow a lobe by 0.1 %.
pub const MIN_SLOPE: f32 = 0.01;

/// Largest slope, up to which [`gaussian_norm`] is fitted.
pub const MAX_SLOPE: f32 = 1.0;

/// How the normals of microfacets are spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlopeDistribution {
    /// Gaussian slopes (Beckmann and Spizzichino 1963).
    Beckmann,
    /// Gaussian angles (Torrance and Sparrow 1967).
    Gaussian,
}

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

/// Angle of a cosine in `[0, 1]` [rad].
pub(crate) fn angle_from_cosine(cosine: f32) -> f32 {
    ((1.0 - cosine).max(0.0) * (1.0 + cosine)).sqrt().atan2(cosine)
}

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
/// 23). Both cosines are positive.
pub fn v_smith_beckmann(n_dot_v: f32, n_dot_l: f32, slope: f32) -> f32 {
    g1_smith_beckmann(n_dot_v, slope) * g1_smith_beckmann(n_dot_l, slope) / (4.0 * n_dot_v * n_dot_l)
}

impl SlopeDistribution {
    /// The slope whose masking by [`g1_smith_beckmann`] is that of the distribution: its own, or for Gaussian angles, which have more
    /// steep facets, the one that fits their masking by brute force within 1 % up to a slope of 0.5 and 3 % up to 1.
    pub fn masking_slope(self, slope: f32) -> f32 {
        match self {
            Self::Beckmann => slope,
            Self::Gaussian => slope * (1.0 + 0.1 * slope),
        }
    }

    /// Density of microfacet normals [1/sr].
    pub fn density(self, n_dot_h: f32, slope: f32) -> f32 {
        match self {
            Self::Beckmann => d_beckmann(n_dot_h, slope),
            Self::Gaussian => d_gaussian(n_dot_h, slope),
        }
    }

    /// Density of [`SlopeDistribution::sample_normal`] [1/sr]: `D (n . h)` for Beckmann, for the other what can be drawn in closed
    /// form, a Gaussian in the angle.
    fn pdf_normal(self, n_dot_h: f32, slope: f32) -> f32 {
        match self {
            Self::Beckmann => d_beckmann(n_dot_h, slope) * n_dot_h,
            Self::Gaussian => {
                let angle = angle_from_cosine(n_dot_h);
                let m2 = slope * slope;
                // angle / sin(angle), 1 at the normal.
                let stretch = if angle > 1e-3 { angle / angle.sin() } else { 1.0 };
                (-angle * angle / m2).exp() * FRAC_1_PI * stretch / (m2 * gaussian_share(slope))
            }
        }
    }

    /// Microfacet normal about +z.
    fn sample_normal(self, slope: f32, u: Vec2) -> Vec3 {
        let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
        let (sine, cosine) = match self {
            // Walter et al. 2007, eq. 28.
            Self::Beckmann => {
                let tangent = slope * (-(1.0 - u.x).ln()).max(0.0).sqrt();
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                (tangent * cosine, cosine)
            }
            Self::Gaussian => (slope * (-(1.0 - u.x * gaussian_share(slope)).ln()).max(0.0).sqrt()).sin_cos(),
        };
        Vec3::new(sine * cos_phi, sine * sin_phi, cosine)
    }
}

/// Share of a Gaussian in the plane that lies within pi/2.
fn gaussian_share(slope: f32) -> f32 {
    let t = FRAC_PI_2 / slope;
    1.0 - (-t * t).exp()
}

/// Torrance and Sparrow's lobe without Fresnel's factor [1/sr]: `D G / (4 (n . l) (n . v))` (the 4 is today's; their pi belongs to
/// another measure of D). Both cosines are positive; the viewer's is taken at least [`MIN_N_DOT_V`].
pub fn torrance_sparrow_lobe(
    distribution: SlopeDistribution,
    slope: f32,
    n: Vec3,
    wo: Vec3,
    wi: Vec3,
) -> f32 {
    let h = (wo + wi).normalize_or_zero();
    let n_dot_l = n.dot(wi);
    if n_dot_l <= 0.0 {
        return 0.0;
    }
    let masking = v_smith_beckmann(n.dot(wo).max(MIN_N_DOT_V), n_dot_l, distribution.masking_slope(slope));
    distribution.density(n.dot(h), slope) * masking
}

/// `wo` mirrored about a microfacet, distributed as [`torrance_sparrow_pdf`] for `u` in `[0, 1)^2`. It may lie under the surface.
pub fn torrance_sparrow_sample(
    distribution: SlopeDistribution,
    slope: f32,
    n: Vec3,
    wo: Vec3,
    u: Vec2,
) -> Vec3 {
    reflect(world_from_local(n, distribution.sample_normal(slope, u)), wo)
}

/// Density of [`torrance_sparrow_sample`] [1/sr] (Walter et al. 2007, eqs. 24 and 14).
pub fn torrance_sparrow_pdf(distribution: SlopeDistribution, slope: f32, n: Vec3, wo: Vec3, wi: Vec3) -> f32 {
    let h = (wo + wi).normalize_or_zero();
    let (n_dot_h, v_dot_h) = (n.dot(h), wo.dot(h));
    if n_dot_h <= 0.0 || v_dot_h <= 0.0 {
        return 0.0;
    }
    distribution.pdf_normal(n_dot_h, slope) / (4.0 * v_dot_h)
}
