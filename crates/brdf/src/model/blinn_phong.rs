//! Blinn's form of Phong's lobe (Blinn 1977): a power of the cosine between normal and half vector.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::{ReflectanceModel, power_lobe};
use crate::area::{HalfVectorPatch, power_distance};
use crate::sampling::{cosine_power, half_vector, reflect, sample_cosine_power};
use crate::{Layers, LightPatch, Lobe, Parameter, SHININESS, Surface};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct BlinnPhong;

/// Factor with which `(n . h)^s` reflects everything that arrives along the normal [1/sr]:
/// `(s + 2) (s + 4) / (8 pi (2^(-s/2) + s))`.
///
/// It is the inverse of the integral of `cos(theta / 2)^s cos(theta)` over the hemisphere. (The often seen `(s + 8) / (8 pi)` is
/// its approximation; Akenine-Moeller et al., "Real-Time Rendering", 3rd edition, section 7.6.)
pub fn blinn_phong_norm(shininess: f32) -> f32 {
    let s = shininess;
    (s + 2.0) * (s + 4.0) / (8.0 * PI * ((-0.5 * s).exp2() + s))
}

impl ReflectanceModel for BlinnPhong {
    const NAME: &'static str = "blinn-phong";
    const SUMMARY: &'static str = "Lambert and a normalised power of the half vector's cosine";
    const REQUIRED: &'static [&'static Parameter] = power_lobe::REQUIRED;
    const OPTIONAL: &'static [&'static Parameter] = power_lobe::OPTIONAL;
    const SHAPE: Option<&'static Parameter> = Some(&SHININESS);

    fn concerning(surface: Surface) -> Surface {
        power_lobe::concerning(surface)
    }

    /// Reciprocal, and seen along the normal it reflects exactly the specular colour, elsewhere less.
    fn lobe(lobe: &Lobe, wo: Vec3, wi: Vec3) -> Vec3 {
        let power = cosine_power(half_vector(wo, wi).z, lobe.shape);
        lobe.tint.truncate() * (blinn_phong_norm(lobe.shape) * power)
    }

    /// `wo` mirrored about a half vector drawn about the normal.
    fn sample(lobe: &Lobe, wo: Vec3, u: Vec2) -> Vec3 {
        reflect(sample_cosine_power(lobe.shape, u), wo)
    }

    /// `(s + 1) / (2 pi) (n . h)^s / (4 wo . h)`.
    fn pdf(lobe: &Lobe, wo: Vec3, wi: Vec3) -> f32 {
        let h = half_vector(wo, wi);
        let v_dot_h = wo.dot(h);
        if h.z <= 0.0 || v_dot_h <= 0.0 {
            return 0.0;
        }
        (lobe.shape + 1.0) / TAU * cosine_power(h.z, lobe.shape) / (4.0 * v_dot_h)
    }

    /// Of the half vector; the cosine at the light's middle.
    fn light_lobe(lobe: &Lobe, wo: Vec3, light: &LightPatch) -> Vec3 {
        let s = lobe.shape;
        let Some(patch) = HalfVectorPatch::new(wo, light) else { return Vec3::ZERO };
        let share = patch.share(power_distance(patch.n_dot_h, s), 1.0 / (s + 1.0).sqrt());
        let norm = blinn_phong_norm(s) * TAU / (s + 1.0);
        lobe.tint.truncate() * (norm * 4.0 * patch.v_dot_h * share * light.direction.z)
    }

    /// Walter et al. 2007, section 5.3.
    fn equivalent_roughness(lobe: &Lobe) -> f32 {
        (2.0 / (lobe.shape + 2.0)).sqrt().sqrt()
    }

    /// That of a narrow lobe falls with the cosine's square.
    fn albedo(lobe: &Lobe, n_dot_v: f32, _: Vec2) -> Vec3 {
        lobe.tint.truncate() * (n_dot_v * n_dot_v)
    }

    fn cached(lobe: &Lobe, [white, _]: [Vec3; 2], cosines: f32) -> Vec3 {
        power_lobe::cached(lobe, white, cosines)
    }

    fn strength(layers: &Layers) -> Vec3 {
        power_lobe::strength(layers)
    }
}
