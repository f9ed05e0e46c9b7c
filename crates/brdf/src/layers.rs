use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3, Vec4};

use crate::fresnel::schlick_share;
use crate::sampling::half_vector;
use crate::{
    Finish, Lobe, MIN_N_DOT_V, SeenFinish, Tables, finish_pdf, finish_sample, finish_strength, finish_value,
    sample_cosine_hemisphere,
};

/// Reflectance of a surface point: a matte part and a glossy one, added, and what lies on both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers<'a> {
    /// Albedo of the matte part.
    pub diffuse: Vec3,
    /// Tint of the interface above the matte part, as [`Lobe::tint`] has it, for models that take from the matte part what their
    /// interface reflects.
    pub interface: Vec4,
    /// The glossy part.
    pub lobe: Lobe<'a>,
    /// What lies on both.
    pub finish: Finish,
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
pub(crate) const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Least chance of a part that reflects anything, so that no direction of it is starved of samples.
const MIN_PROBABILITY: f32 = 0.1;

impl<'a> Layers<'a> {
    /// The same with tables for the glossy part: what [`crate::Surface::tables`] makes, or a measurement's.
    #[must_use]
    pub fn with_tables(self, tables: Option<&'a Tables>) -> Self {
        Self { lobe: Lobe { tables, ..self.lobe }, ..self }
    }

    /// Whether anything but Lambert's law reflects.
    pub fn is_glossy(&self) -> bool {
        self.lobe.is_present() || self.finish.is_present()
    }

    /// Value [1/sr], without the cosine; zero for a `wi` under the surface.
    pub fn evaluate(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if wi.z <= 0.0 {
            return Vec3::ZERO;
        }
        let weight = self.matte_weight(wo.dot(half_vector(wo, wi)));
        let matte = weight * (self.diffuse * FRAC_1_PI);
        let base = if self.lobe.is_present() { matte + self.lobe.value(wo, wi) } else { matte };
        if !self.finish.is_present() {
            return base;
        }
        let finish = self.finish.seen_from(wo);
        finish.base * base + finish_value(&finish, wo, wi)
    }

    /// A direction distributed as [`Layers::pdf`] for uniform `u` in `[0, 1)^2` and `u_part` in `[0, 1)`; `None` where the sample is
    /// lost (it fell under the surface, or nothing is reflected).
    pub fn sample(&self, wo: Vec3, u: Vec2, u_part: f32) -> Option<Sample> {
        let (finish, of_finish) = self.finish_of(wo, self.base_luminance(wo.z));
        let wi = if u_part < of_finish {
            finish_sample(&finish, wo, u)
        } else if (u_part - of_finish) / (1.0 - of_finish) < self.lobe_probability(wo.z)? {
            self.lobe.sample(wo, u)
        } else {
            sample_cosine_hemisphere(u)
        };
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| Sample { wi, f: self.evaluate(wo, wi), pdf })
    }

    /// Density of [`Layers::sample`] [1/sr of `wi`]; its integral is 1 less the share of lost samples.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z <= 0.0 {
            return 0.0;
        }
        let base = self.lobe_probability(wo.z).map_or(0.0, |p| {
            let glossy = if p > 0.0 { p * self.lobe.pdf(wo, wi) } else { 0.0 };
            glossy + (1.0 - p) * wi.z * FRAC_1_PI
        });
        if !self.finish.is_present() {
            return base;
        }
        let (finish, of_finish) = self.finish_of(wo, self.base_luminance(wo.z));
        of_finish * finish_pdf(&finish, wo, wi) + (1.0 - of_finish) * base
    }

    /// [`Layers::evaluate`] without the matte part.
    pub fn gloss_value(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if !self.finish.is_present() {
            return self.lobe.value(wo, wi);
        }
        let finish = self.finish.seen_from(wo);
        finish.base * self.lobe.value(wo, wi) + finish_value(&finish, wo, wi)
    }

    /// A direction about in proportion to [`Layers::gloss_value`] times the cosine; it may lie under the surface.
    pub fn gloss_sample(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let (finish, of_finish) = self.finish_of(wo, self.lobe_luminance(wo.z));
        // One number both chooses and, stretched again, samples.
        if u.x < of_finish {
            finish_sample(&finish, wo, Vec2::new(u.x / of_finish, u.y))
        } else {
            self.lobe.sample(wo, Vec2::new((u.x - of_finish) / (1.0 - of_finish), u.y))
        }
    }

    /// Density of [`Layers::gloss_sample`] [1/sr of `wi`].
    pub fn gloss_pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if !self.finish.is_present() {
            return self.lobe.pdf(wo, wi);
        }
        let (finish, of_finish) = self.finish_of(wo, self.lobe_luminance(wo.z));
        let base = if of_finish < 1.0 { self.lobe.pdf(wo, wi) } else { 0.0 };
        of_finish * finish_pdf(&finish, wo, wi) + (1.0 - of_finish) * base
    }

    /// Most that is reflected of light from anywhere, about.
    pub fn strength(&self) -> Vec3 {
        self.lobe.model.strength(self)
    }

    /// Share of the light that reaches the matte part and returns.
    fn matte_weight(&self, v_dot_h: f32) -> f32 {
        self.lobe.model.matte_weight(self.interface, v_dot_h)
    }

    /// What lies on the base, seen from `wo`, and the chance of sampling it beside what reflects that luminance under it.
    fn finish_of(&self, wo: Vec3, under: f32) -> (SeenFinish, f32) {
        let finish = self.finish.seen_from(wo);
        let (own, under) = (finish_strength(&finish), finish.base * under);
        let chance = match (own > 0.0, under > 0.0) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => (own / (own + under)).clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY),
        };
        (finish, chance)
    }

    /// Luminance that the matte part reflects, estimated at the mirror direction.
    fn matte_luminance(&self, n_dot_v: f32) -> f32 {
        self.matte_weight(n_dot_v.max(MIN_N_DOT_V)).max(0.0) * self.diffuse.dot(LUMINANCE)
    }

    /// The same of the lobe.
    fn lobe_luminance(&self, n_dot_v: f32) -> f32 {
        if !self.lobe.is_present() {
            return 0.0;
        }
        let share = schlick_share(n_dot_v.max(MIN_N_DOT_V));
        let mirror_albedo = Vec2::new(1.0 - share, share);
        self.lobe.model.albedo(&self.lobe, n_dot_v.max(MIN_N_DOT_V), mirror_albedo).dot(LUMINANCE)
    }

    fn base_luminance(&self, n_dot_v: f32) -> f32 {
        if self.finish.is_present() {
            self.matte_luminance(n_dot_v) + self.lobe_luminance(n_dot_v)
        } else {
            0.0
        }
    }

    /// Chance of sampling the lobe: its share of the luminance that the base reflects. `None` where that reflects nothing.
    fn lobe_probability(&self, n_dot_v: f32) -> Option<f32> {
        let matte = self.matte_luminance(n_dot_v);
        match (self.lobe.is_present(), matte > 0.0) {
            (false, false) => None,
            (true, false) => Some(1.0),
            (false, true) => Some(0.0),
            (true, true) => {
                let lobe = self.lobe_luminance(n_dot_v);
                Some((lobe / (lobe + matte)).clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY))
            }
        }
    }
}
