use glam::{Vec2, Vec3, Vec4};

use crate::{LightPatch, Model, Tables};

/// The glossy part of a surface point as its model takes it, and as the G-buffer keeps it. `Lobe` of `brdf_lobe.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe<'a> {
    /// Whose it is.
    pub model: Model,
    /// What shapes it, in its range: see [`crate::ReflectanceModel::SHAPE`].
    pub shape: f32,
    /// What colours it: for models with Schlick's Fresnel the reflectance along the normal, and in w at grazing incidence; for others
    /// their own business. Nothing is reflected where all of it is 0.
    pub tint: Vec4,
    /// Of a model that is tabulated its tables; without them nothing is reflected.
    pub tables: Option<&'a Tables>,
}

impl Lobe<'_> {
    /// Whether there is a glossy part.
    pub fn is_present(&self) -> bool {
        self.tint.max_element() > 0.0
    }

    /// Its value [1/sr], without the cosine. Zero for a `wi` under the surface.
    pub fn value(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if wi.z <= 0.0 { Vec3::ZERO } else { self.model.lobe(self, wo, wi) }
    }

    /// A unit direction about in proportion to its value times the cosine, for `u` in `[0, 1)^2`. It may lie under the surface, where
    /// the sample is lost.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Vec3 {
        self.model.sample(self, wo, u)
    }

    /// Density of [`Lobe::sample`] [1/sr of `wi`]; its integral is 1 less the share of lost samples.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z <= 0.0 { 0.0 } else { self.model.pdf(self, wo, wi) }
    }

    /// Integral of [`Lobe::value`] times the cosine over an area light: radiance reflected per unit of the light's.
    pub fn over_light(&self, wo: Vec3, light: &LightPatch) -> Vec3 {
        self.model.light_lobe(self, wo, light)
    }

    /// Its value under Schlick's Fresnel, `bare` being the same without Fresnel's factor.
    pub(crate) fn schlick(&self, bare: f32, v_dot_h: f32) -> Vec3 {
        bare * crate::f_schlick(self.tint.truncate(), self.tint.w, v_dot_h)
    }
}
