//! glTF 2.0's metallic-roughness with `KHR_materials_anisotropy`, in tables: `D(delta, phi)`, Smith's masking of either direction and
//! Schlick's Fresnel. Masking and shadowing are taken as independent: both heights at once do not factor into tables of one direction.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec3, Vec4};

use super::ReflectanceModel;
use super::metallic_roughness::MetallicRoughness;
use super::tabulated::{FRESNEL_ROWS, cosine_of, elliptical, masking};
use crate::fresnel::schlick_share;
use crate::tables::{Coordinates, Factor, Term, Tint};
use crate::{
    ANISOTROPY, ANISOTROPY_ROTATION, BASE_COLOR, IOR, Layers, METALLIC, Parameter, ROUGHNESS, SPECULAR,
    SPECULAR_COLOR, Surface, Tables, alpha_from_roughness, g1_smith_ggx,
};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct AnisotropicGgx;

/// Alpha along the direction of anisotropy and across it (`KHR_materials_anisotropy`, section "Individual lights").
pub fn alphas(surface: &Surface) -> [f32; 2] {
    let alpha = alpha_from_roughness(ROUGHNESS.clamped(surface)).max(MIN_ALPHA);
    let strength = ANISOTROPY.clamped(surface);
    [alpha + (1.0 - alpha) * strength * strength, alpha]
}

/// Narrower lobes would fall between the columns of tables.
const MIN_ALPHA: f32 = 0.01;

impl ReflectanceModel for AnisotropicGgx {
    const NAME: &'static str = "anisotropic-metallic-roughness";
    const SUMMARY: &'static str = "tables: glTF 2.0 with anisotropy: Lambert under elliptical GGX, or metal";
    const REQUIRED: &'static [&'static Parameter] = &[&ANISOTROPY];
    const OPTIONAL: &'static [&'static Parameter] =
        &[&ANISOTROPY_ROTATION, &BASE_COLOR, &METALLIC, &ROUGHNESS, &SPECULAR, &SPECULAR_COLOR, &IOR];
    const SHAPE: Option<&'static Parameter> = None;
    const IS_TABULATED: bool = true;
    const NEEDS_TANGENT: bool = true;

    fn tables(surface: &Surface) -> Option<Tables> {
        let alphas = alphas(surface);
        let [along, across] = alphas;
        // Walter et al. 2007, eq. 33, with an ellipse for the circle (Burley 2012, eq. 13).
        let facets = elliptical(alphas, |cosine, sin, cos| {
            let sine2 = (1.0 - cosine) * (1.0 + cosine);
            let spread = sine2 * ((cos / along).powi(2) + (sin / across).powi(2)) + cosine * cosine;
            FRAC_1_PI / (along * across * spread * spread)
        });
        let g1 = |coordinates| masking(coordinates, alphas, |alpha| 2.0 / alpha, g1_smith_ggx);
        let [light, view] = [g1(Coordinates::Light), g1(Coordinates::View)];
        let term = |tint, share: fn(f32) -> f32| {
            let fresnel = Factor::new(Coordinates::Difference, 0.0, [FRESNEL_ROWS, 1], |theta, _| {
                Vec3::splat(share(schlick_share(cosine_of(theta))))
            });
            Term { tint, factors: vec![facets.clone(), fresnel, light.clone(), view.clone()] }
        };
        let terms = vec![term(Tint::Color, |share| 1.0 - share), term(Tint::Grazing, |share| share)];
        Some(Tables::new(terms, surface.anisotropy_rotation))
    }

    fn matte_weight(interface: Vec4, v_dot_h: f32) -> f32 {
        MetallicRoughness::matte_weight(interface, v_dot_h)
    }

    fn strength(layers: &Layers) -> Vec3 {
        MetallicRoughness::strength(layers)
    }
}
