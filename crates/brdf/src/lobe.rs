use glam::{Vec2, Vec3};

use crate::sampling::{local_from_world, reflect, world_from_local};
use crate::{
    MIN_N_DOT_V, Model, SlopeDistribution, alpha_from_roughness, blinn_phong_lobe, blinn_phong_pdf,
    blinn_phong_sample, d_ggx, pdf_ggx_vndf, phong_lobe, phong_pdf, phong_sample, sample_ggx_vndf,
    torrance_sparrow_lobe, torrance_sparrow_pdf, torrance_sparrow_sample, v_smith_ggx_correlated,
};

impl Model {
    /// The microfacets' distribution, where the model is Torrance and Sparrow's.
    pub(crate) fn distribution(self) -> Option<SlopeDistribution> {
        match self {
            Self::TorranceSparrowBeckmann => Some(SlopeDistribution::Beckmann),
            Self::TorranceSparrowGaussian => Some(SlopeDistribution::Gaussian),
            _ => None,
        }
    }
}

/// Schlick's share of `f90` in `f0 (1 - share) + f90 share`.
pub(crate) fn schlick_share(v_dot_h: f32) -> f32 {
    let m = (1.0 - v_dot_h).clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// A model's glossy part for world-space directions about the unit normal `n`, without the cosine [1/sr]: `x f0 + y f90` is its
/// value, so that Fresnel's and the specular colour stay outside. Zero for a `wi` under the surface.
///
/// `parameter` is [`crate::Surface::lobe_parameter`]. Of the Phong models `f0` is the specular colour and `y` 0; Lambert has no
/// glossy part.
pub fn reflectance_lobe(model: Model, parameter: f32, n: Vec3, wo: Vec3, wi: Vec3) -> Vec2 {
    let n_dot_l = n.dot(wi);
    if n_dot_l <= 0.0 {
        return Vec2::ZERO;
    }
    let lobe = match model {
        Model::Lambert => return Vec2::ZERO,
        Model::Phong => return Vec2::new(phong_lobe(parameter, n, wo, wi), 0.0),
        Model::BlinnPhong => return Vec2::new(blinn_phong_lobe(parameter, n, wo, wi), 0.0),
        Model::MetallicRoughness => {
            let alpha = alpha_from_roughness(parameter);
            let h = (wo + wi).normalize_or_zero();
            d_ggx(n.dot(h), alpha) * v_smith_ggx_correlated(n.dot(wo).max(MIN_N_DOT_V), n_dot_l, alpha)
        }
        Model::TorranceSparrowBeckmann => {
            torrance_sparrow_lobe(SlopeDistribution::Beckmann, parameter, n, wo, wi)
        }
        Model::TorranceSparrowGaussian => {
            torrance_sparrow_lobe(SlopeDistribution::Gaussian, parameter, n, wo, wi)
        }
    };
    let share = schlick_share(wo.dot((wo + wi).normalize_or_zero()));
    lobe * Vec2::new(1.0 - share, share)
}

/// Draws a direction of [`reflectance_lobe`] for `u` in `[0, 1)^2`: a unit vector and [`reflectance_pdf`] of it, which is 0 where the
/// sample is lost under the surface.
pub fn reflectance_sample(model: Model, parameter: f32, n: Vec3, wo: Vec3, u: Vec2) -> (Vec3, f32) {
    let wi = match model {
        Model::Lambert => return (n, 0.0),
        Model::Phong => phong_sample(parameter, n, wo, u),
        Model::BlinnPhong => blinn_phong_sample(parameter, n, wo, u),
        Model::MetallicRoughness => {
            let wo = lifted(n, wo);
            let h = sample_ggx_vndf(local_from_world(n, wo), alpha_from_roughness(parameter), u);
            reflect(world_from_local(n, h), wo)
        }
        Model::TorranceSparrowBeckmann => {
            torrance_sparrow_sample(SlopeDistribution::Beckmann, parameter, n, wo, u)
        }
        Model::TorranceSparrowGaussian => {
            torrance_sparrow_sample(SlopeDistribution::Gaussian, parameter, n, wo, u)
        }
    };
    (wi, reflectance_pdf(model, parameter, n, wo, wi))
}

/// Density of [`reflectance_sample`] [1/sr of `wi`]; its integral is 1 less the share of lost samples.
pub fn reflectance_pdf(model: Model, parameter: f32, n: Vec3, wo: Vec3, wi: Vec3) -> f32 {
    if n.dot(wi) <= 0.0 {
        return 0.0;
    }
    match model {
        Model::Lambert => 0.0,
        Model::Phong => phong_pdf(parameter, n, wo, wi),
        Model::BlinnPhong => blinn_phong_pdf(parameter, n, wo, wi),
        Model::MetallicRoughness => {
            let alpha = alpha_from_roughness(parameter);
            pdf_ggx_vndf(local_from_world(n, lifted(n, wo)), local_from_world(n, wi), alpha)
        }
        Model::TorranceSparrowBeckmann => {
            torrance_sparrow_pdf(SlopeDistribution::Beckmann, parameter, n, wo, wi)
        }
        Model::TorranceSparrowGaussian => {
            torrance_sparrow_pdf(SlopeDistribution::Gaussian, parameter, n, wo, wi)
        }
    }
}

/// `wo` lifted to at least [`MIN_N_DOT_V`] above the surface.
pub(crate) fn lifted(n: Vec3, wo: Vec3) -> Vec3 {
    let n_dot_v = n.dot(wo);
    if n_dot_v >= MIN_N_DOT_V { wo } else { (wo + n * (MIN_N_DOT_V - n_dot_v)).normalize() }
}
