use glam::{Vec2, Vec3};

use crate::{Glossy, Lambert, MetallicRoughness, Surface};

/// Which reflectance a surface has. The numbers are those of `brdf_reflectance.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Model {
    /// glTF 2.0: Lambert under GGX, or metal.
    #[default]
    MetallicRoughness = 0,
    /// Ideally matte.
    Lambert = 1,
    /// Phong's lobe about the mirror direction.
    Phong = 2,
    /// Blinn's lobe of the half vector.
    BlinnPhong = 3,
    /// Torrance and Sparrow's microfacets with Beckmann's slopes.
    TorranceSparrowBeckmann = 4,
    /// The same with Gaussian angles.
    TorranceSparrowGaussian = 5,
}

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
    /// Which one it is.
    pub model: Model,
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
        model: Model::Lambert,
        name: "lambert",
        summary: "ideally matte: base color over pi",
        from_surface: |surface| Box::new(Lambert { albedo: surface.base_color }),
    },
    ReflectanceModel {
        model: Model::MetallicRoughness,
        name: "metallic-roughness",
        summary: "glTF 2.0: Lambert under GGX, or metal",
        from_surface: |surface| Box::new(MetallicRoughness::new(*surface)),
    },
    ReflectanceModel {
        model: Model::Phong,
        name: "phong",
        summary: "Lambert and a normalised power of the cosine to the mirror direction",
        from_surface: |surface| glossy(surface, Model::Phong),
    },
    ReflectanceModel {
        model: Model::BlinnPhong,
        name: "blinn-phong",
        summary: "Lambert and a normalised power of the half vector's cosine",
        from_surface: |surface| glossy(surface, Model::BlinnPhong),
    },
    ReflectanceModel {
        model: Model::TorranceSparrowBeckmann,
        name: "torrance-sparrow-beckmann",
        summary: "Lambert and microfacets of Gaussian slopes",
        from_surface: |surface| glossy(surface, Model::TorranceSparrowBeckmann),
    },
    ReflectanceModel {
        model: Model::TorranceSparrowGaussian,
        name: "torrance-sparrow-gaussian",
        summary: "Lambert and microfacets of Gaussian angles",
        from_surface: |surface| glossy(surface, Model::TorranceSparrowGaussian),
    },
];

fn glossy(surface: &Surface, model: Model) -> Box<dyn Reflectance> {
    Box::new(Glossy::new(&Surface { model, ..*surface }))
}

/// The model of that name.
pub fn model(name: &str) -> Option<&'static ReflectanceModel> {
    MODELS.iter().find(|model| model.name == name)
}

impl Model {
    /// Name for files and options.
    pub fn name(self) -> &'static str {
        MODELS.iter().find(|entry| entry.model == self).map_or("", |entry| entry.name)
    }
}
