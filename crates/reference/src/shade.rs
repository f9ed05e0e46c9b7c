use glam::{DVec2, Vec3};
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
    /// What the camera sees behind the scene, black where there is none.
    pub(crate) background: Option<&'a Equirect>,
}

/// Share of the samples that follow the reflectance of a matte surface; the others follow the light, which is aimed by the
/// cosine as well. These few are for surfaces in the shade of what gets most light samples: they bound the noise there
/// and cost a tenth more elsewhere (measured: a quarter costs 40 %).
const MATTE_REFLECTION_SHARE: f64 = 0.1;
/// The same for a surface with a glossy lobe, which the light does not know.
const GLOSSY_REFLECTION_SHARE: f64 = 0.5;

impl Tracer<'_> {
    /// One unbiased estimate of the radiance that arrives along a camera ray.
    pub(crate) fn radiance(&self, ray: &Ray, sequence: &Sequence, index: u32) -> Vec3 {
        let Some(hit) = self.scene.closest_hit(ray) else {
            return self.background.map_or(Vec3::ZERO, |map| map.seen(ray.direction));
        };
        let wo = -ray.direction;
        let point = self.scene.hit_point(&hit, wo);
        let mut numbers =
            [Decision::Direction, Decision::Choice].map(|decision| sequence.pair(index, decision));
        let mut radiance = point.emissive + self.reflected(&point, wo, &self.shadowed, true, numbers);
        if let Some(unshadowed) = &self.unshadowed {
            numbers = [Decision::UnshadowedDirection, Decision::UnshadowedChoice]
                .map(|decision| sequence.pair(index, decision));
            radiance += self.reflected(&point, wo, unshadowed, false, numbers);
        }
        radiance
    }

    /// Direct light reflected towards `wo`: one sample of either the light or the reflectance, weighted by the balance
    /// heuristic (one-sample model, Veach 1997, section 9.2.4), which divides by the density of both together.
    fn reflected(
        &self,
        point: &HitPoint,
        wo: Vec3,
        light: &Illumination,
        shadowed: bool,
        [direction, choice]: [DVec2; 2],
    ) -> Vec3 {
        let frame = &point.frame;
        let layers = point.layers();
        let wo_local = frame.local_from_world(wo);
        let lifted = point.lifted();
        let light = light.aim(lifted, frame.n);
        let share = if layers.lobe.is_present() { GLOSSY_REFLECTION_SHARE } else { MATTE_REFLECTION_SHARE };
        let wi = if choice.x < share {
            let sample = layers.sample(wo_local, to_vec2(direction), choice.y as f32);
            sample.map(|sample| frame.world_from_local(sample.wi).normalize())
        } else {
            light.sample(direction, choice.y)
        };
        let Some(wi) = wi else { return Vec3::ZERO };
        let wi_local = frame.local_from_world(wi);
        let reflectance = layers.evaluate(wo_local, wi_local) * wi_local.z;
        if reflectance == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let arrives = |distance: f32| {
            !shadowed
                || (wi.dot(point.geometric_normal) > 0.0
                    && !self.scene.is_occluded(&Ray { origin: lifted, direction: wi }, distance))
        };
        let (radiance, light_pdf) = light.evaluate(wi, arrives);
        let pdf = share * f64::from(layers.pdf(wo_local, wi_local)) + (1.0 - share) * light_pdf;
        if pdf > 0.0 { ((reflectance * radiance).as_dvec3() / pdf).as_vec3() } else { Vec3::ZERO }
    }
}
