//! Light that bumps scatter to each other: paths through the height field under a hit.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use gnomon_brdf::{Frame, sample_cosine_hemisphere};

use crate::Ray;
use crate::illumination::Illumination;
use crate::relief::Relief;
use crate::sampler::{Sequence, to_vec2};
use crate::shade::Tracer;
use crate::traced_scene::HitPoint;

/// Most bounces: of a cavity that is half closed and white they leave out a hundredth.
const BOUNCES: u32 = 6;

impl Tracer<'_> {
    /// One estimate of the radiance that the matte part of a hit reflects of light that its bumps scatter. All of them count as of its albedo,
    /// and as seen by the scene from its own place.
    pub(crate) fn scattered(&self, point: &HitPoint, sequence: &Sequence, index: u32) -> Vec3 {
        let Some((relief, mut uv)) = point.relief else { return Vec3::ZERO };
        let albedo = point.layers().diffuse;
        let mut n = point.frame.n;
        let mut throughput = albedo;
        let mut radiance = Vec3::ZERO;
        for bounce in 0..BOUNCES {
            let number = |decision: u32| to_vec2(sequence.bounce(index, 3 * bounce + decision));
            let direction = about(n, sample_cosine_hemisphere(number(0)));
            let Some(next) = relief.hit(uv, direction) else { break };
            (uv, n) = (next, relief.normal(next));
            if n.dot(direction) >= 0.0 {
                // A back side that interpolated normals make up.
                break;
            }
            let irradiance = self.irradiance(point, (&relief, uv, n), &self.shadowed, [number(1), number(2)]);
            radiance += throughput * albedo / PI * irradiance;
            throughput *= albedo;
        }
        radiance
    }

    /// One estimate of the direct irradiance of a place on the bumps.
    fn irradiance(
        &self,
        point: &HitPoint,
        (relief, uv, n): (&Relief<'_>, Vec2, Vec3),
        light: &Illumination<'_>,
        [direction, choice]: [Vec2; 2],
    ) -> Vec3 {
        let lifted = point.lifted();
        let light = light.aim(lifted, n);
        let Some(wi) = light.sample(direction.as_dvec2(), f64::from(choice.y)) else { return Vec3::ZERO };
        let cosine = wi.dot(n);
        if cosine <= 0.0 {
            return Vec3::ZERO;
        }
        if wi.dot(point.geometric_normal) <= 0.0 || relief.hit(uv, wi).is_some() {
            return Vec3::ZERO;
        }
        let arrives =
            |distance: f32| self.scene.transmittance(&Ray { origin: lifted, direction: wi }, distance);
        let (radiance, pdf) = light.evaluate(wi, arrives);
        if pdf > 0.0 { radiance * cosine / pdf as f32 } else { Vec3::ZERO }
    }
}

fn about(n: Vec3, local: Vec3) -> Vec3 {
    Frame::from_normal(n).world_from_local(local).normalize()
}
