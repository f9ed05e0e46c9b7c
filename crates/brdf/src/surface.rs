use glam::Vec3;

use crate::metallic_roughness::dielectric_f0;
use crate::{MAX_SLOPE, MIN_SLOPE, Model, Reflectance};

/// Largest Phong exponent: the lobe is 0.8 degrees wide, and normals are stored that finely.
pub const MAX_SHININESS: f32 = 10_000.0;

/// What a reflectance model needs to know of a surface point: glTF's metallic-roughness parameters with
/// `KHR_materials_specular`, and those of the models that glTF does not have. Every model takes those that concern it:
///
/// | model | matte part | glossy part |
/// |---|---|---|
/// | metallic-roughness | as glTF has it | as glTF has it |
/// | lambert | `base_color` | none |
/// | phong, blinn-phong | `base_color` | colour `specular * specular_color`, `shininess` |
/// | torrance-sparrow-* | `base_color (1 - metallic)` | glTF's f0 and f90 (`specular`, `specular_color`, `ior`, `metallic`), `slope` |
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
    /// Index of refraction of the dielectric (1.5 unless the file says otherwise).
    pub ior: f32,
    /// Which model reflects.
    pub model: Model,
    /// Exponent of the Phong models, 0 to [`MAX_SHININESS`].
    pub shininess: f32,
    /// m of Torrance and Sparrow's models, [`MIN_SLOPE`] to [`MAX_SLOPE`].
    pub slope: f32,
}

/// Reflectance of a surface, separated from the shape of its glossy lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers {
    /// Albedo of the matte part.
    pub diffuse: Vec3,
    /// Reflectance of the glossy part along the normal, or its colour.
    pub f0: Vec3,
    /// Reflectance at grazing incidence; 0 where there is no glossy part.
    pub f90: f32,
}

impl Surface {
    /// The surface's model with its parameters.
    pub fn reflectance(&self) -> Box<dyn Reflectance> {
        let entry = crate::MODELS.iter().find(|entry| entry.model == self.model);
        match entry {
            Some(entry) => (entry.from_surface)(self),
            None => Box::new(crate::MetallicRoughness::new(*self)),
        }
    }

    /// What shapes the glossy lobe: roughness, shininess or slope, within its range (its lower end for NaN).
    #[allow(clippy::manual_clamp, reason = "clamp keeps NaN")]
    pub fn lobe_parameter(&self) -> f32 {
        match self.model {
            Model::MetallicRoughness | Model::Lambert => self.roughness,
            Model::Phong | Model::BlinnPhong => self.shininess.max(0.0).min(MAX_SHININESS),
            Model::TorranceSparrowBeckmann | Model::TorranceSparrowGaussian => {
                self.slope.max(MIN_SLOPE).min(MAX_SLOPE)
            }
        }
    }

    /// Colours of the matte and the glossy part. (Of metallic-roughness, whose matte part lies under the interface, without what
    /// the interface keeps from it.)
    pub fn layers(&self) -> Layers {
        match self.model {
            Model::Lambert => Layers { diffuse: self.base_color, f0: Vec3::ZERO, f90: 0.0 },
            Model::Phong | Model::BlinnPhong => Layers {
                diffuse: self.base_color,
                f0: self.specular_color.min(Vec3::ONE) * self.specular,
                f90: self.specular,
            },
            Model::MetallicRoughness | Model::TorranceSparrowBeckmann | Model::TorranceSparrowGaussian => {
                Layers {
                    diffuse: self.base_color * (1.0 - self.metallic),
                    f0: dielectric_f0(self).lerp(self.base_color, self.metallic),
                    f90: self.specular + (1.0 - self.specular) * self.metallic,
                }
            }
        }
    }

    /// Whether the surface reflects nothing but Lambert's law.
    pub fn is_matte(&self) -> bool {
        self.layers().f90 == 0.0
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
        }
    }
}
