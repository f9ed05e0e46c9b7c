use glam::Vec3;

use crate::{
    CLEARCOAT, CLEARCOAT_ROUGHNESS, Finish, Layers, Lobe, Model, SHEEN_ROUGHNESS, Tables, f0_from_ior,
};

/// What reflectance models need to know of a surface point: glTF's metallic-roughness parameters with `KHR_materials_specular`, and
/// those of the models that glTF does not have. Every model takes those that concern it ([`Model::parameters`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Linear base colour, 0..1.
    pub base_color: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness, 0..1; GGX alpha is its square.
    pub roughness: f32,
    /// `specularFactor`: strength of the dielectric reflection; 0 is exactly Lambert.
    pub specular: f32,
    /// `specularColorFactor`: tint of the dielectric reflection at normal incidence; may exceed 1.
    pub specular_color: Vec3,
    /// Index of refraction of the dielectric (1.5 unless the file says otherwise); 0 is `KHR_materials_ior`'s full reflection.
    pub ior: f32,
    /// Which model reflects.
    pub model: Model,
    /// Exponent of the Phong models.
    pub shininess: f32,
    /// m of Torrance and Sparrow's models; along the tangent where they are anisotropic.
    pub slope: f32,
    /// Width of the lobe across the tangent over that along it.
    pub aspect: f32,
    /// Real part of the index of refraction, of models with Fresnel's exact reflectance.
    pub index: Vec3,
    /// Its imaginary part, 0 for dielectrics.
    pub extinction: Vec3,
    /// `anisotropyStrength` of `KHR_materials_anisotropy`, 0..1.
    pub anisotropy: f32,
    /// `anisotropyRotation`: counter-clockwise from the tangent [rad].
    pub anisotropy_rotation: f32,
    /// What a cosine lobe weighs the products of both directions' components with (Lafortune et al. 1997).
    pub axes: Vec3,
    /// `clearcoatFactor` of `KHR_materials_clearcoat`, 0..1: a clear coat over any model.
    pub clearcoat: f32,
    /// `clearcoatRoughnessFactor`, 0..1.
    pub clearcoat_roughness: f32,
    /// `sheenColorFactor` of `KHR_materials_sheen`: sheen of cloth between coat and model, black for none.
    pub sheen_color: Vec3,
    /// `sheenRoughnessFactor`, 0..1.
    pub sheen_roughness: f32,
}

impl Surface {
    /// The same with parameters that do not concern the model at values without effect: what G-buffer and [`Surface::layers`] read.
    #[must_use]
    pub fn of_its_model(&self) -> Self {
        self.model.concerning(*self)
    }

    /// What shapes the glossy lobe, within its range (the lower end for NaN); 0 where the model has none.
    pub fn shape(&self) -> f32 {
        self.model.shape().map_or(0.0, |parameter| parameter.clamped(self))
    }

    /// Tables of the glossy part, of a model that makes them of its parameters. Takes milliseconds.
    pub fn tables(&self) -> Option<Tables> {
        self.model.tables(&self.tabulated())
    }

    /// The same with parameters that tables do not depend on at their defaults: surfaces that are alike in it have the same tables.
    #[must_use]
    pub fn tabulated(&self) -> Self {
        let Self { base_color, metallic, specular, specular_color, ior, .. } = Self::default();
        Self { base_color, metallic, specular, specular_color, ior, ..*self }.without_finish()
    }

    /// The same without what lies on its base.
    #[must_use]
    pub fn without_finish(&self) -> Self {
        let Self { clearcoat, clearcoat_roughness, sheen_color, sheen_roughness, .. } = Self::default();
        Self { clearcoat, clearcoat_roughness, sheen_color, sheen_roughness, ..*self }
    }

    /// What lies on its base, the coat along the normal of the base.
    pub fn finish(&self) -> Finish {
        Finish {
            clearcoat: CLEARCOAT.clamped(self),
            clearcoat_roughness: CLEARCOAT_ROUGHNESS.clamped(self),
            clearcoat_normal: Vec3::Z,
            sheen_color: self.sheen_color.max(Vec3::ZERO).min(Vec3::ONE),
            sheen_roughness: SHEEN_ROUGHNESS.clamped(self),
        }
    }

    /// Matte and glossy part, and what lies on them. That of a tabulated model reflects nothing until [`Layers::with_tables`] gives it tables.
    pub fn layers(&self) -> Layers<'static> {
        let s = self.of_its_model();
        // `KHR_materials_specular`, section "Implementation".
        let dielectric_f0 = (f0_from_ior(s.ior) * s.specular_color).min(Vec3::ONE) * s.specular;
        let interface = dielectric_f0.extend(s.specular);
        Layers {
            diffuse: s.base_color * (1.0 - s.metallic),
            interface,
            lobe: Lobe {
                model: s.model,
                shape: s.shape(),
                tint: interface.lerp(s.base_color.extend(1.0), s.metallic),
                tables: None,
            },
            finish: self.finish(),
        }
    }

    /// Whether the surface reflects nothing but Lambert's law.
    pub fn is_matte(&self) -> bool {
        !self.layers().is_glossy()
    }
}

impl Default for Surface {
    /// A grey matte surface: Lambert 0.5. Shininess is that of DeCoro and Rusinkiewicz 2008, Fig. 3.
    fn default() -> Self {
        Self {
            base_color: Vec3::splat(0.5),
            metallic: 0.0,
            roughness: 1.0,
            specular: 0.0,
            specular_color: Vec3::ONE,
            ior: 1.5,
            model: Model::MetallicRoughness,
            shininess: 40.0,
            slope: 0.3,
            aspect: 1.0,
            index: Vec3::splat(1.5),
            extinction: Vec3::ZERO,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            axes: Vec3::new(-1.0, -1.0, 1.0),
            clearcoat: 0.0,
            clearcoat_roughness: 0.0,
            sheen_color: Vec3::ZERO,
            sheen_roughness: 0.0,
        }
    }
}
