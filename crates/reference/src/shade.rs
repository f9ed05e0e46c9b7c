use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use glam::{DVec2, DVec3, Vec3};
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
    pub(crate) background: Option<(&'a Equirect, Vec3)>,
    /// Whether glossy lobes reflect the scene as well as the light.
    pub(crate) reflections: bool,
    /// Unshadowed irradiance of catchers, by the bits of their normal: level ones have one or two.
    pub(crate) unshadowed_irradiance: Mutex<HashMap<[u32; 3], Vec3>>,
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
        let opacity = sequence.pair(index, Decision::Opacity);
        let Some(hit) = self.scene.closest_hit(ray, opacity.x) else {
            return self.behind(ray);
        };
        let wo = -ray.direction;
        let point = self.scene.hit_point(&hit, wo);
        let numbers = |decisions: [Decision; 4]| decisions.map(|decision| sequence.pair(index, decision));
        let of_direct = numbers([
            Decision::Direction,
            Decision::Choice,
            Decision::UnshadowedDirection,
            Decision::UnshadowedChoice,
        ]);
        let direct = self.direct(&point, wo, of_direct, 1.0);
        let direct = direct + self.scattered(&point, sequence, index);
        if point.catches {
            let lit = |own: f32| self.direct(&point, wo, of_direct, own);
            return self.caught(&point, ray, direct, lit);
        }
        if !(self.reflections && point.layers().is_glossy()) {
            return direct;
        }
        let mirrored = sequence.pair(index, Decision::Mirrored);
        let beyond = numbers([
            Decision::MirroredDirection,
            Decision::MirroredChoice,
            Decision::MirroredUnshadowedDirection,
            Decision::MirroredUnshadowedChoice,
        ]);
        direct + self.mirrored(&point, wo, (mirrored, opacity.y), beyond)
    }

    /// What a surface sends towards `wo` of direct light, and of its own, with a factor of the light of the scene's own lights.
    fn direct(&self, point: &HitPoint, wo: Vec3, [a, b, c, d]: [DVec2; 4], own: f32) -> Vec3 {
        let shadowed = self.reflected(point, wo, (&self.shadowed, own), true, [a, b]);
        let unshadowed = self.unshadowed.as_ref();
        let unshadowed =
            unshadowed.map_or(Vec3::ZERO, |light| self.reflected(point, wo, (light, own), false, [c, d]));
        self.emitted(point, wo) + shadowed + unshadowed
    }

    /// What a surface sends towards `wo` of its own.
    fn emitted(&self, point: &HitPoint, wo: Vec3) -> Vec3 {
        let finish = point.layers().finish;
        match (point.catches, finish.is_present()) {
            (true, _) => Vec3::ZERO,
            (false, false) => point.emissive,
            (false, true) => point.emissive * finish.emission_weight(point.frame.local_from_world(wo)),
        }
    }

    /// What the glossy parts reflect towards `wo` of the scene in direct light: one sample of them.
    fn mirrored(
        &self,
        point: &HitPoint,
        wo: Vec3,
        (direction, chance): (DVec2, f64),
        beyond: [DVec2; 4],
    ) -> Vec3 {
        let (frame, layers) = (&point.frame, point.layers());
        let wo_local = frame.local_from_world(wo);
        let wi_local = layers.gloss_sample(wo_local, to_vec2(direction));
        let pdf = layers.gloss_pdf(wo_local, wi_local);
        if pdf <= 0.0 {
            return Vec3::ZERO;
        }
        let wi = frame.world_from_local(wi_local).normalize();
        let reflectance = layers.gloss_value(wo_local, wi_local) * (wi_local.z / pdf);
        if reflectance == Vec3::ZERO || wi.dot(point.geometric_normal) <= 0.0 {
            return Vec3::ZERO;
        }
        let ray = Ray { origin: point.lifted(), direction: wi };
        let Some(hit) = self.scene.closest_caster(&ray, chance) else {
            return Vec3::ZERO;
        };
        let mut seen = self.scene.hit_point(&hit, -wi);
        if seen.shines {
            // The lobe reflects its lights.
            seen.emissive = Vec3::ZERO;
        }
        reflectance * self.direct(&seen, -wi, beyond, 1.0)
    }

    /// What is seen of a catcher that reflects `direct`: what is behind it by the share of light that is left there, and a share of a matte
    /// surface of its own. What the scene's own lights add to what is behind ends with a ground that fades: `lit` is what it reflects with a
    /// factor of their light.
    fn caught(&self, point: &HitPoint, ray: &Ray, direct: Vec3, lit: impl Fn(f32) -> Vec3) -> Vec3 {
        let Some((ground, color)) = point.fades else {
            return self.behind(ray) * self.share_left(point, direct);
        };
        let share = ground.share(point.position);
        let direction = ground.direction(point.position, ray.direction);
        let behind = self.behind(&Ray { direction, ..*ray }) * self.share_left(point, lit(share));
        let share = if ground.camera_height > 0.0 { 0.0 } else { share };
        behind.lerp(direct * color / point.surface.base_color, share)
    }

    /// What the camera sees along a ray that meets nothing.
    fn behind(&self, ray: &Ray) -> Vec3 {
        self.background.map_or(Vec3::ZERO, |(map, factor)| map.seen(ray.direction) * factor)
    }

    /// Share of the unshadowed light of a catcher that an estimate of what it reflects stands for.
    fn share_left(&self, point: &HitPoint, reflected: Vec3) -> Vec3 {
        let n = point.frame.n;
        let full = || {
            let unshadowed = self.unshadowed.as_ref().map_or(DVec3::ZERO, |light| light.irradiance(n));
            (self.shadowed.irradiance(n) + unshadowed).as_vec3()
        };
        let mut known = self.unshadowed_irradiance.lock().unwrap_or_else(PoisonError::into_inner);
        let full = *known.entry(n.to_array().map(f32::to_bits)).or_insert_with(full);
        drop(known);
        let irradiance = reflected * std::f32::consts::PI / point.surface.base_color;
        Vec3::select(full.cmpgt(Vec3::splat(1e-20)), irradiance / full, Vec3::ONE)
    }

    /// Direct light reflected towards `wo`: one sample of either the light or the reflectance, weighted by the balance
    /// heuristic (one-sample model, Veach 1997, section 9.2.4), which divides by the density of both together.
    fn reflected(
        &self,
        point: &HitPoint,
        wo: Vec3,
        (light, own): (&Illumination, f32),
        shadowed: bool,
        [direction, choice]: [DVec2; 2],
    ) -> Vec3 {
        let frame = &point.frame;
        let layers = point.layers();
        let wo_local = frame.local_from_world(wo);
        let lifted = point.lifted();
        let light = light.aim(lifted, frame.n).with_own(own);
        let share = if layers.is_glossy() { GLOSSY_REFLECTION_SHARE } else { MATTE_REFLECTION_SHARE };
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
        let arrives = |distance: f32| match shadowed {
            false => 1.0,
            true if wi.dot(point.geometric_normal) <= 0.0 => 0.0,
            true if point.relief.is_some_and(|(relief, uv)| relief.hit(uv, wi).is_some()) => 0.0,
            true => self.scene.transmittance(&Ray { origin: lifted, direction: wi }, distance),
        };
        let (radiance, light_pdf) = light.evaluate(wi, arrives);
        let pdf = share * f64::from(layers.pdf(wo_local, wi_local)) + (1.0 - share) * light_pdf;
        if pdf > 0.0 { ((reflectance * radiance).as_dvec3() / pdf).as_vec3() } else { Vec3::ZERO }
    }
}
