use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3, Vec4};

use crate::fresnel::schlick_share;
use crate::sampling::half_vector;
use crate::{Lobe, MIN_N_DOT_V, Tables, sample_cosine_hemisphere};

/// Reflectance of a surface point: a matte part and a glossy one, added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers<'a> {
    /// Albedo of the matte part.
    pub diffuse: Vec3,
    /// Tint of the interface above the matte part, as [`Lobe::tint`] has it, for models that take from the matte part what their
    /// interface reflects.
    pub interface: Vec4,
    /// The glossy part.
    pub lobe: Lobe<'a>,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Direction to the light; unit length, tangent frame, `z > 0`.
    pub wi: Vec3,
    /// Value towards it [1/sr], without the cosine.
    pub f: Vec3,
    /// Density of `wi` over both parts [1/sr], positive.
    pub pdf: f32,
}

/// Rec. 709 luminance weights, to choose between parts.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Least chance of a part that reflects anything, so that no direction of it is starved of samples.
const MIN_PROBABILITY: f32 = 0.1;

impl<'a> Layers<'a> {
    /// The same with tables for the glossy part: what [`crate::Surface::tables`] makes, or a measurement's.
    #[must_use]
    pub fn with_tables(self, tables: Option<&'a Tables>) -> Self {
        Self { lobe: Lobe { tables, ..self.lobe }, ..self }
    }

    /// Value [1/sr], without the cosine; zero for a `wi` under the surface.
    pub fn evaluate(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if wi.z <= 0.0 {
            return Vec3::ZERO;
        }
        let weight = self.matte_weight(wo.dot(half_vector(wo, wi)));
        let matte = weight * (self.diffuse * FRAC_1_PI);
        if self.lobe.is_present() { matte + self.lobe.value(wo, wi) } else { matte }
    }

    /// A direction distributed as [`Layers::pdf`] for uniform `u` in `[0, 1)^2` and `u_part` in `[0, 1)`; `None` where the sample is
    /// lost (it fell under the surface, or nothing is reflected).
    pub fn sample(&self, wo: Vec3, u: Vec2, u_part: f32) -> Option<Sample> {
        let is_glossy = u_part < self.lobe_probability(wo.z)?;
        let wi = if is_glossy { self.lobe.sample(wo, u) } else { sample_cosine_hemisphere(u) };
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| Sample { wi, f: self.evaluate(wo, wi), pdf })
    }

    /// Density of [`Layers::sample`] [1/sr of `wi`]; its integral is 1 less the share of lost samples.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z <= 0.0 {
            return 0.0;
        }
        let Some(p) = self.lobe_probability(wo.z) else { return 0.0 };
        let glossy = if p > 0.0 { p * self.lobe.pdf(wo, wi) } else { 0.0 };
        glossy + (1.0 - p) * wi.z * FRAC_1_PI
    }

    /// Most that is reflected of light from anywhere, about.
    pub fn strength(&self) -> Vec3 {
        self.lobe.model.strength(self)
    }

    /// Share of the light that reaches the matte part and returns.
    fn matte_weight(&self, v_dot_h: f32) -> f32 {
        self.lobe.model.matte_weight(self.interface, v_dot_h)
    }

    /// Chance of sampling the lobe: its share of the reflected luminance, estimated at the mirror direction. `None` where nothing is
    /// reflected.
    fn lobe_probability(&self, n_dot_v: f32) -> Option<f32> {
        let n_dot_v = n_dot_v.max(MIN_N_DOT_V);
        let matte = self.matte_weight(n_dot_v).max(0.0) * self.diffuse.dot(LUMINANCE);
        match (self.lobe.is_present(), matte > 0.0) {
            (false, false) => None,
            (true, false) => Some(1.0),
            (false, true) => Some(0.0),
            (true, true) => {
                let share = schlick_share(n_dot_v);
                let mirror_albedo = Vec2::new(1.0 - share, share);
                let lobe = self.lobe.model.albedo(&self.lobe, n_dot_v, mirror_albedo).dot(LUMINANCE);
                Some((lobe / (lobe + matte)).clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY))
            }
        }
    }
}
