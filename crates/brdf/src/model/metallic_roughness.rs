//! glTF 2.0 (appendix B.3.5) with `KHR_materials_specular`: a dielectric is `(1 - max F) diffuse + F specular`, its `F` running from
//! `min(f0(ior) * specular_color, 1) * specular` to `specular`; a metal is `F specular` with `f0 = base_color`, `f90 = 1`. The lobe is
//! GGX.

use glam::{Vec2, Vec3, Vec4};

use super::ReflectanceModel;
use crate::area::HalfVectorPatch;
use crate::sampling::{half_vector, reflect};
use crate::torrance_sparrow::{gaussian_slopes_on, light_lobe};
use crate::{
    BASE_COLOR, IOR, Layers, LightPatch, Lobe, METALLIC, MIN_N_DOT_V, Parameter, ROUGHNESS, SPECULAR,
    SPECULAR_COLOR, alpha_from_roughness, d_ggx, f_schlick, pdf_ggx_vndf, sample_ggx_vndf,
    v_smith_ggx_correlated,
};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct MetallicRoughness;

/// `wo` lifted to at least [`MIN_N_DOT_V`] above the surface.
fn lifted(wo: Vec3) -> Vec3 {
    if wo.z >= MIN_N_DOT_V { wo } else { wo.with_z(MIN_N_DOT_V).normalize() }
}

/// GGX's slopes, `1 / (1 + x)^2` of squares x in alphas, as a sum of Gaussian ones: their root mean squares in alphas, and shares. Fitted
/// by least squares of the relative error, which is at most 1.6 % up to slopes of ten alphas.
const GAUSSIANS: [(f32, f32); 5] =
    [(0.6023, 0.1929), (1.0445, 0.4113), (1.8306, 0.2523), (3.2827, 0.1041), (6.7452, 0.0392)];

impl ReflectanceModel for MetallicRoughness {
    const NAME: &'static str = "metallic-roughness";
    const SUMMARY: &'static str = "glTF 2.0: Lambert under GGX, or metal";
    const REQUIRED: &'static [&'static Parameter] = &[];
    const OPTIONAL: &'static [&'static Parameter] =
        &[&BASE_COLOR, &METALLIC, &ROUGHNESS, &SPECULAR, &SPECULAR_COLOR, &IOR];
    const SHAPE: Option<&'static Parameter> = Some(&ROUGHNESS);
    const IS_PREFILTERED: bool = true;

    fn lobe(lobe: &Lobe, wo: Vec3, wi: Vec3) -> Vec3 {
        let h = half_vector(wo, wi);
        let alpha = alpha_from_roughness(lobe.shape);
        let masking = v_smith_ggx_correlated(wo.z.max(MIN_N_DOT_V), wi.z, alpha);
        lobe.schlick(d_ggx(h.z, alpha) * masking, wo.dot(h))
    }

    fn sample(lobe: &Lobe, wo: Vec3, u: Vec2) -> Vec3 {
        let wo = lifted(wo);
        reflect(sample_ggx_vndf(wo, alpha_from_roughness(lobe.shape), u), wo)
    }

    fn pdf(lobe: &Lobe, wo: Vec3, wi: Vec3) -> f32 {
        pdf_ggx_vndf(lifted(wo), wi, alpha_from_roughness(lobe.shape))
    }

    fn light_lobe(lobe: &Lobe, wo: Vec3, light: &LightPatch) -> Vec3 {
        let alpha = alpha_from_roughness(lobe.shape);
        let masking = |n_dot_v, n_dot_l| v_smith_ggx_correlated(n_dot_v, n_dot_l, alpha);
        let on_light = |patch: &HalfVectorPatch| {
            GAUSSIANS.iter().map(|(width, share)| share * gaussian_slopes_on(patch, width * alpha)).sum()
        };
        light_lobe(lobe, wo, light, masking, on_light)
    }

    fn matte_weight(interface: Vec4, v_dot_h: f32) -> f32 {
        1.0 - f_schlick(interface.truncate(), interface.w, v_dot_h).max_element()
    }

    /// The matte part lies under the interface, which takes its share.
    fn strength(layers: &Layers) -> Vec3 {
        layers.diffuse.max(layers.lobe.tint.truncate())
    }
}
