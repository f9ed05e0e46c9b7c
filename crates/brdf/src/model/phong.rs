//! Phong's lobe about the mirrored view direction (Phong 1975), reciprocal and normalised as by Lafortune and Willems 1994.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::{ReflectanceModel, power_lobe};
use crate::area::{away, gaussian_patch, power_distance};
use crate::sampling::{cosine_power, mirrored, sample_cosine_power};
use crate::{Frame, Layers, LightPatch, Lobe, Parameter, SHININESS, Surface};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Phong;

impl ReflectanceModel for Phong {
    const NAME: &'static str = "phong";
    const SUMMARY: &'static str = "Lambert and a normalised power of the cosine to the mirror direction";
    const REQUIRED: &'static [&'static Parameter] = power_lobe::REQUIRED;
    const OPTIONAL: &'static [&'static Parameter] = power_lobe::OPTIONAL;
    const SHAPE: Option<&'static Parameter> = Some(&SHININESS);

    fn concerning(surface: Surface) -> Surface {
        power_lobe::concerning(surface)
    }

    /// `(s + 2) / (2 pi) cos^s`, the cosine being that between `wi` and the mirrored `wo`.
    ///
    /// In this form, without a division by the cosine at the surface, the model is reciprocal; seen along the normal it reflects
    /// exactly the specular colour, elsewhere less (Lafortune and Willems 1994, "Using the modified Phong reflectance model for
    /// physically based rendering", eqs. 1 and 8).
    fn lobe(lobe: &Lobe, wo: Vec3, wi: Vec3) -> Vec3 {
        let s = lobe.shape;
        lobe.tint.truncate() * ((s + 2.0) / TAU * cosine_power(mirrored(wo).dot(wi), s))
    }

    fn sample(lobe: &Lobe, wo: Vec3, u: Vec2) -> Vec3 {
        Frame::from_normal(mirrored(wo)).world_from_local(sample_cosine_power(lobe.shape, u))
    }

    /// `(s + 1) / (2 pi) cos^s`.
    fn pdf(lobe: &Lobe, wo: Vec3, wi: Vec3) -> f32 {
        let (s, cosine) = (lobe.shape, mirrored(wo).dot(wi));
        if cosine > 0.0 { (s + 1.0) / TAU * cosine_power(cosine, s) } else { 0.0 }
    }

    /// About the mirrored view; the cosine at the light's middle.
    fn light_lobe(lobe: &Lobe, wo: Vec3, light: &LightPatch) -> Vec3 {
        let (s, wi) = (lobe.shape, light.direction);
        if wi.z <= 0.0 {
            return Vec3::ZERO;
        }
        let peak = mirrored(wo);
        let at = away(wi, peak, power_distance(peak.dot(wi), s));
        let sigma = 1.0 / (s + 1.0).sqrt();
        let share = gaussian_patch(at, light.half_width, light.half_height, sigma, light.is_disk);
        lobe.tint.truncate() * ((s + 2.0) / (s + 1.0) * share * wi.z)
    }

    /// The exponent is a quarter of Blinn's.
    fn equivalent_roughness(lobe: &Lobe) -> f32 {
        (2.0 / (4.0 * lobe.shape + 2.0)).sqrt().sqrt()
    }

    /// That of a narrow lobe falls with the cosine.
    fn albedo(lobe: &Lobe, n_dot_v: f32, _: Vec2) -> Vec3 {
        lobe.tint.truncate() * n_dot_v
    }

    fn cached(lobe: &Lobe, [white, _]: [Vec3; 2], cosines: f32) -> Vec3 {
        power_lobe::cached(lobe, white, cosines)
    }

    fn strength(layers: &Layers) -> Vec3 {
        power_lobe::strength(layers)
    }
}
