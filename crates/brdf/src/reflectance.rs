use glam::{Vec2, Vec3};

use crate::{Lambert, MetallicRoughness, Surface};

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Direction to the light; unit length, local frame, `z > 0`.
    pub wi: Vec3,
    /// Value towards it [1/sr], without the cosine.
    pub f: Vec3,
    /// Density of `wi` over all lobes [1/sr], positive.
    pub pdf: f32,
}

/// A reflectance model with its parameters set. Directions are unit length in the local frame, `z` the shading normal.
pub trait Reflectance: Send + Sync {
    /// Value [1/sr], without the cosine; zero for a `wi` under the surface.
    fn evaluate(&self, wo: Vec3, wi: Vec3) -> Vec3;

    /// A direction distributed as [`Reflectance::pdf`] for uniform `u` in `[0, 1)^2` and `u_lobe` in `[0, 1)`; `None` where
    /// the sample is lost (it fell under the surface, or nothing is reflected).
    fn sample(&self, wo: Vec3, u: Vec2, u_lobe: f32) -> Option<Sample>;

    /// Density of [`Reflectance::sample`] [1/sr of `wi`]; its integral is 1 less the share of lost samples.
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32;
}

/// A registered reflectance model.
#[derive(Clone, Copy, Debug)]
pub struct ReflectanceModel {
    /// Name for files and options, kebab-case.
    pub name: &'static str,
    /// One line for people.
    pub summary: &'static str,
    /// The model with the parameters that it takes of a surface.
    pub from_surface: fn(&Surface) -> Box<dyn Reflectance>,
}

/// Every reflectance model: a new one is a file and a line here.
pub const MODELS: &[ReflectanceModel] = &[
    ReflectanceModel {
        name: "lambert",
        summary: "ideally matte: base color over pi",
        from_surface: |surface| Box::new(Lambert { albedo: surface.base_color }),
    },
    ReflectanceModel {
        name: "metallic-roughness",
        summary: "glTF 2.0: Lambert under GGX, or metal",
        from_surface: |surface| Box::new(MetallicRoughness::new(*surface)),
    },
];

/// The model of that name.
pub fn model(name: &str) -> Option<&'static ReflectanceModel> {
    MODELS.iter().find(|model| model.name == name)
}
