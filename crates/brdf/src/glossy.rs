use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use crate::metallic_roughness::{LUMINANCE, MIN_LOBE_PROBABILITY};
use crate::{
    Model, Reflectance, Sample, Surface, f_schlick, reflectance_lobe, reflectance_pdf, reflectance_sample,
    sample_cosine_hemisphere,
};

/// A glossy lobe and a matte part, added: the Phong models and Torrance and Sparrow's.
///
/// Energy is kept where the matte and the specular colour (`f90` of Torrance and Sparrow's) add up to at most 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glossy {
    model: Model,
    parameter: f32,
    diffuse: Vec3,
    f0: Vec3,
    f90: f32,
}

impl Glossy {
    /// The model that `surface` names.
    pub fn new(surface: &Surface) -> Self {
        let layers = surface.layers();
        Self {
            model: surface.model,
            parameter: surface.lobe_parameter(),
            diffuse: layers.diffuse,
            f0: layers.f0,
            f90: layers.f90,
        }
    }

    /// Chance of sampling the lobe: its share of the reflected luminance, estimated at the mirror direction.
    fn lobe_probability(&self, n_dot_v: f32) -> Option<f32> {
        let lobe = match self.model.distribution() {
            Some(_) => f_schlick(self.f0, self.f90, n_dot_v).dot(LUMINANCE),
            None => self.f0.dot(LUMINANCE),
        };
        let diffuse = self.diffuse.dot(LUMINANCE);
        let has_lobe = self.f90 > 0.0 && self.model != Model::Lambert;
        match (has_lobe, diffuse > 0.0) {
            (false, false) => None,
            (true, false) => Some(1.0),
            (false, true) => Some(0.0),
            (true, true) => {
                Some((lobe / (lobe + diffuse)).clamp(MIN_LOBE_PROBABILITY, 1.0 - MIN_LOBE_PROBABILITY))
            }
        }
    }
}

impl Reflectance for Glossy {
    fn evaluate(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if wi.z <= 0.0 {
            return Vec3::ZERO;
        }
        let lobe = reflectance_lobe(self.model, self.parameter, Vec3::Z, wo, wi);
        self.diffuse * FRAC_1_PI + self.f0 * lobe.x + self.f90 * lobe.y
    }

    fn sample(&self, wo: Vec3, u: Vec2, u_lobe: f32) -> Option<Sample> {
        let wi = if u_lobe < self.lobe_probability(wo.z)? {
            reflectance_sample(self.model, self.parameter, Vec3::Z, wo, u).0
        } else {
            sample_cosine_hemisphere(u)
        };
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| Sample { wi, f: self.evaluate(wo, wi), pdf })
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z <= 0.0 {
            return 0.0;
        }
        let Some(p) = self.lobe_probability(wo.z) else { return 0.0 };
        let lobe = reflectance_pdf(self.model, self.parameter, Vec3::Z, wo, wi);
        p * lobe + (1.0 - p) * wi.z * FRAC_1_PI
    }
}
