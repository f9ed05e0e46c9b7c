use glam::{DVec2, Vec3};
use gnomon_brdf::{MetallicRoughness, Reflectance, local_from_world, world_from_local};
use gnomon_envmap::Equirect;

use crate::Ray;
use crate::illumination::Illumination;
use crate::sampler::{Decision, Sequence, to_vec2};
use crate::traced_scene::{HitPoint, TracedScene};

/// Scene and light, ready to be asked for radiance.
pub(crate) struct Tracer<'a> {
    pub(crate) scene: TracedScene<'a>,
    /// Light that the scene blocks.
    pub(crate) shadowed: Illumination<'a>,
    /// Light that reaches every surface it is above.
    pub(crate) unshadowed: Option<Illumination<'a>>,
    /// What the camera sees behind the scene.
    pub(crate) background: &'a Equirect,
}

/// The random numbers of one direct-light estimate.
struct Numbers {
    light: DVec2,
    light_choice: f64,
    reflection: DVec2,
    lobe: f64,
}

impl Numbers {
    fn new(sequence: &Sequence, index: u32, [light, choice, reflection]: [Decision; 3]) -> Self {
        let choice = sequence.pair(index, choice);
        Self {
            light: sequence.pair(index, light),
            light_choice: choice.x,
            reflection: sequence.pair(index, reflection),
            lobe: choice.y,
        }
    }
}

impl Tracer<'_> {
    /// One unbiased estimate of the radiance that arrives along a camera ray.
    pub(crate) fn radiance(&self, ray: &Ray, sequence: &Sequence, index: u32) -> Vec3 {
        let Some(hit) = self.scene.closest_hit(ray) else { return self.background.lookup(ray.direction) };
        let wo = -ray.direction;
        let point = self.scene.hit_point(&hit, wo);
        let decisions = [Decision::LightDirection, Decision::LightAndLobe, Decision::Reflection];
        let numbers = Numbers::new(sequence, index, decisions);
        let mut radiance = point.emissive + self.reflected(&point, wo, &self.shadowed, true, &numbers);
        if let Some(unshadowed) = &self.unshadowed {
            let decisions = [
                Decision::UnshadowedLightDirection,
                Decision::UnshadowedLightAndLobe,
                Decision::UnshadowedReflection,
            ];
            let numbers = Numbers::new(sequence, index, decisions);
            radiance += self.reflected(&point, wo, unshadowed, false, &numbers);
        }
        radiance
    }

    /// Direct light reflected towards `wo`: one sample of the light and one of the reflectance, each weighted by the power
    /// heuristic (Veach 1997, section 9.2.4).
    fn reflected(
        &self,
        point: &HitPoint,
        wo: Vec3,
        light: &Illumination,
        shadowed: bool,
        numbers: &Numbers,
    ) -> Vec3 {
        let n = point.shading_normal;
        let model = MetallicRoughness::new(point.surface);
        let wo_local = local_from_world(n, wo);
        let arrives = |wi: Vec3| {
            !shadowed
                || (wi.dot(point.geometric_normal) > 0.0
                    && !self.scene.is_occluded(&Ray { origin: point.lifted(), direction: wi }))
        };
        let mut sum = Vec3::ZERO;
        if let Some(sample) = light.sample(numbers.light, numbers.light_choice) {
            let wi_local = local_from_world(n, sample.wi);
            let value = model.evaluate(wo_local, wi_local) * wi_local.z * sample.radiance;
            if value != Vec3::ZERO && arrives(sample.wi) {
                let other = f64::from(model.pdf(wo_local, wi_local));
                sum += value * (power_heuristic(sample.pdf, other) / sample.pdf) as f32;
            }
        }
        if let Some(sample) = model.sample(wo_local, to_vec2(numbers.reflection), numbers.lobe as f32) {
            let wi = world_from_local(n, sample.wi).normalize();
            let (radiance, other) = light.evaluate(wi);
            let value = sample.f * sample.wi.z * radiance;
            if value != Vec3::ZERO && arrives(wi) {
                let pdf = f64::from(sample.pdf);
                sum += value * (power_heuristic(pdf, other) / pdf) as f32;
            }
        }
        sum
    }
}

/// Weight of a sample drawn with density `pdf` where another strategy draws it with density `other`: `p^2 / (p^2 + o^2)`.
fn power_heuristic(pdf: f64, other: f64) -> f64 {
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}
