//! glTF 2.0 (appendix B.3.5) with `KHR_materials_specular`: a dielectric is `(1 - max F) diffuse + F specular`, its `F` running from
//! `min(f0(ior) * specular_color, 1) * specular` to `specular`; a metal is `F specular` with `f0 = base_color`, `f90 = 1`. The lobe is
//! GGX.

use std::f32::consts::PI;

use glam::{Vec2, Vec3, Vec4};

use super::ReflectanceModel;
use crate::sampling::{half_vector, reflect};
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

/// GGX with an alpha of its own for the microfacets' distribution.
fn ggx_lobe(lobe: &Lobe, wo: Vec3, wi: Vec3, alpha_of_d: f32) -> Vec3 {
    let h = half_vector(wo, wi);
    let masking = v_smith_ggx_correlated(wo.z.max(MIN_N_DOT_V), wi.z, alpha_from_roughness(lobe.shape));
    lobe.schlick(d_ggx(h.z, alpha_of_d) * masking, wo.dot(h))
}

impl ReflectanceModel for MetallicRoughness {
    const NAME: &'static str = "metallic-roughness";
    const SUMMARY: &'static str = "glTF 2.0: Lambert under GGX, or metal";
    const REQUIRED: &'static [&'static Parameter] = &[];
    const OPTIONAL: &'static [&'static Parameter] =
        &[&BASE_COLOR, &METALLIC, &ROUGHNESS, &SPECULAR, &SPECULAR_COLOR, &IOR];
    const SHAPE: Option<&'static Parameter> = Some(&ROUGHNESS);
    const IS_PREFILTERED: bool = true;

    fn lobe(lobe: &Lobe, wo: Vec3, wi: Vec3) -> Vec3 {
        ggx_lobe(lobe, wo, wi, alpha_from_roughness(lobe.shape))
    }

    fn sample(lobe: &Lobe, wo: Vec3, u: Vec2) -> Vec3 {
        let wo = lifted(wo);
        reflect(sample_ggx_vndf(wo, alpha_from_roughness(lobe.shape), u), wo)
    }

    fn pdf(lobe: &Lobe, wo: Vec3, wi: Vec3) -> f32 {
        pdf_ggx_vndf(lifted(wo), wi, alpha_from_roughness(lobe.shape))
    }

    /// No integral: the light's extent widens the lobe, `alpha' = alpha + half the light's radius`. Of a light in the scene the point
    /// nearest to the mirrored view stands for all of it, and its lobe keeps the energy of the widened one (Karis 2013, area lights).
    fn light_lobe(lobe: &Lobe, wo: Vec3, light: &LightPatch) -> Vec3 {
        let wi = light.nearest;
        if wi.z <= 0.0 {
            return Vec3::ZERO;
        }
        let alpha = alpha_from_roughness(lobe.shape);
        let wide = (alpha + 0.5 * (light.solid_angle / PI).sqrt()).min(1.0);
        let weight = wi.z * light.solid_angle;
        if light.is_distant {
            return ggx_lobe(lobe, wo, wi, wide) * weight;
        }
        let narrowing = alpha / wide;
        ggx_lobe(lobe, wo, wi, alpha) * (narrowing * narrowing * weight)
    }

    fn matte_weight(interface: Vec4, v_dot_h: f32) -> f32 {
        1.0 - f_schlick(interface.truncate(), interface.w, v_dot_h).max_element()
    }

    /// The matte part lies under the interface, which takes its share.
    fn strength(layers: &Layers) -> Vec3 {
        layers.diffuse.max(layers.lobe.tint.truncate())
    }
}
