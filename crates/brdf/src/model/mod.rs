//! The list of reflectance models, and what each of them is.
//!
//! A new model is a file here with a type that implements [`ReflectanceModel`], its line in [`Model`]'s list, and
//! `brdf_NAME.wgsl` with functions of the same names. Nothing else names a model. One that is tabulated says how its tables are made, and
//! has nothing in WGSL.

use glam::{Vec2, Vec3, Vec4};

use crate::{FINISH, Layers, LightPatch, Lobe, Parameter, Surface, Tables};

pub mod anisotropic_ggx;
pub mod blinn_phong;
pub mod cosine_lobe;
pub mod lambert;
pub mod measured;
pub mod metallic_roughness;
pub mod microfacet_beckmann;
pub mod microfacet_gaussian;
pub mod phong;
mod power_lobe;
mod tabulated;
pub mod threads;
pub mod torrance_sparrow_beckmann;
pub mod torrance_sparrow_gaussian;
pub mod ward;

/// One reflectance model whole. Directions are unit length in the tangent frame, `wi.z > 0`.
///
/// In WGSL the model called `some-name` is `brdf_some_name.wgsl` with `some_name_lobe` and so on; functions that have a default here
/// may be left out there, too.
pub trait ReflectanceModel {
    /// Name for files and options, kebab-case.
    const NAME: &'static str;
    /// One line for people.
    const SUMMARY: &'static str;
    /// Parameters that must be given.
    const REQUIRED: &'static [&'static Parameter];
    /// The other parameters that concern it.
    const OPTIONAL: &'static [&'static Parameter];
    /// The parameter that shapes the lobe, a number: [`Lobe::shape`].
    const SHAPE: Option<&'static Parameter>;
    /// Whether the glossy part is a sum of products of tables. Such a model has defaults of the lobe's functions.
    const IS_TABULATED: bool = false;
    /// Whether lobe and albedo need the mesh's tangents.
    const NEEDS_TANGENT: bool = false;
    /// Whether the GGX-prefiltered environment is as right for it as its own radiance cache.
    const IS_PREFILTERED: bool = false;

    /// The surface with parameters that do not concern the model at values without effect.
    fn concerning(surface: Surface) -> Surface {
        surface
    }

    /// Tables of the glossy part, of a tabulated model that makes them of a surface's parameters.
    fn tables(_surface: &Surface) -> Option<Tables> {
        None
    }

    /// Value of the glossy part [1/sr], without the cosine, Fresnel's factor in it.
    fn lobe(lobe: &Lobe, wo: Vec3, wi: Vec3) -> Vec3 {
        lobe.tables.map_or(Vec3::ZERO, |tables| tables.value(lobe.tint, wo, wi))
    }

    /// A direction about in proportion to the lobe times the cosine for `u` in `[0, 1)^2`; it may lie under the surface.
    fn sample(lobe: &Lobe, wo: Vec3, u: Vec2) -> Vec3 {
        lobe.tables.map_or(Vec3::NEG_Z, |tables| tables.sample(wo, u))
    }

    /// Density of `sample` [1/sr of `wi`].
    fn pdf(lobe: &Lobe, wo: Vec3, wi: Vec3) -> f32 {
        lobe.tables.map_or(0.0, |tables| tables.pdf(wo, wi))
    }

    /// Integral of the lobe times the cosine over an area light. Tends to the lobe times the solid angle as the light shrinks.
    fn light_lobe(lobe: &Lobe, wo: Vec3, light: &LightPatch) -> Vec3 {
        lobe.tables.map_or(Vec3::ZERO, |tables| tables.light_lobe(lobe.tint, wo, light))
    }

    /// Roughness of a GGX lobe about as wide (Walter et al. 2007, section 5.3).
    fn equivalent_roughness(lobe: &Lobe) -> f32 {
        lobe.tables.map_or(lobe.shape, Tables::roughness)
    }

    /// Share of uniform light that the lobe reflects, given scale and bias of [`crate::dfg`] for the equivalent roughness.
    fn albedo(lobe: &Lobe, n_dot_v: f32, ggx: Vec2) -> Vec3 {
        match lobe.tables {
            Some(tables) => tables.albedo(lobe.tint, n_dot_v),
            None => lobe.tint.truncate() * ggx.x + lobe.tint.w * ggx.y,
        }
    }

    /// Radiance that the lobe reflects, of what the radiance cache holds: the same for the tints (1, 1, 1, 0) and (0, 0, 0, 1). `cosines`
    /// is the cosine to the viewer over that in the cache.
    fn cached(lobe: &Lobe, [f0, f90]: [Vec3; 2], _cosines: f32) -> Vec3 {
        lobe.tint.truncate() * f0 + lobe.tint.w * f90
    }

    /// Share of the light that comes back from the matte part through the interface above it; 1 where the parts are just added.
    fn matte_weight(_interface: Vec4, _v_dot_h: f32) -> f32 {
        1.0
    }

    /// Most that both parts reflect together: above 1 a surface gives back more light than it gets.
    fn strength(layers: &Layers) -> Vec3 {
        layers.diffuse + layers.lobe.tint.truncate().max(Vec3::splat(layers.lobe.tint.w))
    }
}

/// Makes the enum of all models and its dispatch: the only `match` over models.
macro_rules! models {
    ($($(#[$attribute:meta])* $module:ident::$model:ident),* $(,)?) => {
        /// Which reflectance a surface has. The numbers are the shaders', too.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
        #[repr(u32)]
        #[allow(missing_docs, reason = "each model's file says what it is")]
        pub enum Model {
            $($(#[$attribute])* $model),*
        }

        /// The items of [`ReflectanceModel`], which says what they are.
        #[allow(missing_docs, reason = "the trait says it")]
        impl Model {
            /// Every model, in the order of their numbers.
            pub const ALL: &'static [Self] = &[$(Self::$model),*];

            pub fn name(self) -> &'static str {
                match self { $(Self::$model => $module::$model::NAME),* }
            }
            pub fn summary(self) -> &'static str {
                match self { $(Self::$model => $module::$model::SUMMARY),* }
            }
            pub fn required(self) -> &'static [&'static Parameter] {
                match self { $(Self::$model => $module::$model::REQUIRED),* }
            }
            pub fn optional(self) -> &'static [&'static Parameter] {
                match self { $(Self::$model => $module::$model::OPTIONAL),* }
            }
            pub fn shape(self) -> Option<&'static Parameter> {
                match self { $(Self::$model => $module::$model::SHAPE),* }
            }
            pub fn needs_tangent(self) -> bool {
                match self { $(Self::$model => $module::$model::NEEDS_TANGENT),* }
            }
            pub fn is_tabulated(self) -> bool {
                match self { $(Self::$model => $module::$model::IS_TABULATED),* }
            }
            pub(crate) fn tables(self, surface: &Surface) -> Option<Tables> {
                match self { $(Self::$model => $module::$model::tables(surface)),* }
            }
            pub fn is_prefiltered(self) -> bool {
                match self { $(Self::$model => $module::$model::IS_PREFILTERED),* }
            }
            pub(crate) fn concerning(self, surface: Surface) -> Surface {
                match self { $(Self::$model => $module::$model::concerning(surface)),* }
            }
            pub(crate) fn lobe(self, lobe: &Lobe, wo: Vec3, wi: Vec3) -> Vec3 {
                match self { $(Self::$model => $module::$model::lobe(lobe, wo, wi)),* }
            }
            pub(crate) fn sample(self, lobe: &Lobe, wo: Vec3, u: Vec2) -> Vec3 {
                match self { $(Self::$model => $module::$model::sample(lobe, wo, u)),* }
            }
            pub(crate) fn pdf(self, lobe: &Lobe, wo: Vec3, wi: Vec3) -> f32 {
                match self { $(Self::$model => $module::$model::pdf(lobe, wo, wi)),* }
            }
            pub(crate) fn light_lobe(self, lobe: &Lobe, wo: Vec3, light: &LightPatch) -> Vec3 {
                match self { $(Self::$model => $module::$model::light_lobe(lobe, wo, light)),* }
            }
            pub fn equivalent_roughness(self, lobe: &Lobe) -> f32 {
                match self { $(Self::$model => $module::$model::equivalent_roughness(lobe)),* }
            }
            pub fn albedo(self, lobe: &Lobe, n_dot_v: f32, ggx: Vec2) -> Vec3 {
                match self { $(Self::$model => $module::$model::albedo(lobe, n_dot_v, ggx)),* }
            }
            pub fn cached(self, lobe: &Lobe, radiance: [Vec3; 2], cosines: f32) -> Vec3 {
                match self { $(Self::$model => $module::$model::cached(lobe, radiance, cosines)),* }
            }
            pub fn matte_weight(self, interface: Vec4, v_dot_h: f32) -> f32 {
                match self { $(Self::$model => $module::$model::matte_weight(interface, v_dot_h)),* }
            }
            pub fn strength(self, layers: &Layers) -> Vec3 {
                match self { $(Self::$model => $module::$model::strength(layers)),* }
            }
        }
    };
}

models! {
    #[default]
    metallic_roughness::MetallicRoughness,
    lambert::Lambert,
    phong::Phong,
    blinn_phong::BlinnPhong,
    torrance_sparrow_beckmann::TorranceSparrowBeckmann,
    torrance_sparrow_gaussian::TorranceSparrowGaussian,
    microfacet_beckmann::MicrofacetBeckmann,
    microfacet_gaussian::MicrofacetGaussian,
    anisotropic_ggx::AnisotropicGgx,
    ward::Ward,
    threads::Threads,
    cosine_lobe::CosineLobe,
    measured::Measured,
}

impl Model {
    /// Every parameter that concerns it, those that must be given first, and last those of what lies on any model.
    pub fn parameters(self) -> impl Iterator<Item = &'static Parameter> {
        self.required().iter().chain(self.optional()).chain(FINISH).copied()
    }

    /// The model of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|model| model.name() == name)
    }
}
