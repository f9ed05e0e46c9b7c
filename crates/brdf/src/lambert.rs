use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use crate::{Reflectance, Sample, sample_cosine_hemisphere};

/// Lambert's reflectance for albedo 1: `1 / pi` [1/sr].
pub fn fd_lambert() -> f32 {
    FRAC_1_PI
}

/// An ideally matte surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Share of the irradiance that leaves again, 0..1.
    pub albedo: Vec3,
}

impl Reflectance for Lambert {
    fn evaluate(&self, _wo: Vec3, wi: Vec3) -> Vec3 {
        if wi.z > 0.0 { self.albedo * fd_lambert() } else { Vec3::ZERO }
    }

    fn sample(&self, wo: Vec3, u: Vec2, _u_lobe: f32) -> Option<Sample> {
        let wi = sample_cosine_hemisphere(u);
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| Sample { wi, f: self.evaluate(wo, wi), pdf })
    }

    fn pdf(&self, _wo: Vec3, wi: Vec3) -> f32 {
        wi.z.max(0.0) * FRAC_1_PI
    }
}
