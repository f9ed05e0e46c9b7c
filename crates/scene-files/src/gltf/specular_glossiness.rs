//! `KHR_materials_pbrSpecularGlossiness` in the parameters that there are.
//!
//! The conversion in the extension's appendix solves for a metallic share and loses tinted dielectrics. `KHR_materials_specular` with the
//! full reflection of `KHR_materials_ior` holds the same model instead: a matte part and a reflectance at normal incidence, each a colour.
//! glTF-Transform converts so, too. The extension lowers the matte part by the strongest reflectance, which `KHR_materials_specular` does
//! by its Fresnel term.

use glam::Vec3;
use gnomon_scene::{Material, Scene, TextureRef};

use super::materials::{CoordinateSets, not_negative, unit};
use super::schema::SpecularGlossiness;
use super::textures::Textures;
use super::{Budget, Fault};

/// Reflectance at grazing incidence for one at normal incidence: 1, but for what is too dark for any dielectric (2 % is water's) and so
/// meant to reflect nothing (Lagarde and de Rousiers, "Moving Frostbite to Physically Based Rendering", 2014, section 3.1.3).
fn strength(color: [f32; 3]) -> f32 {
    (50.0 * Vec3::from_array(color).max_element()).min(1.0)
}

/// Sets what the extension says.
pub fn convert(
    entry: &SpecularGlossiness,
    material: &mut Material,
    textures: &mut Textures,
    place: (CoordinateSets, &str),
    budget: &mut Budget,
    scene: &mut Scene,
) -> Result<(), Fault> {
    let [r, g, b, alpha] = entry.diffuse_factor.unwrap_or([1.0; 4]).map(unit);
    material.surface.base_color = Vec3::new(r, g, b);
    material.alpha = alpha;
    material.base_color_texture = textures.reference(entry.diffuse_texture.as_ref(), place, budget, scene)?;
    let specular = entry.specular_factor.unwrap_or([1.0; 3]).map(not_negative);
    let glossiness = entry.glossiness_factor.map_or(1.0, unit);
    material.surface.metallic = 0.0;
    material.surface.ior = 0.0;
    material.surface.specular_color = Vec3::from_array(specular);
    material.surface.specular = strength(specular);
    material.surface.roughness = 1.0 - glossiness;
    material.metallic_roughness_texture = None;
    let texture = textures.reference(entry.specular_glossiness_texture.as_ref(), place, budget, scene)?;
    if let Some(texture) = texture {
        let factors = (specular, glossiness);
        let made = textures.roughness_and_strength(texture.texture, factors, strength, budget, scene)?;
        let made = Some(TextureRef { texture: made, ..texture });
        (material.surface.specular, material.surface.roughness) = (1.0, 1.0);
        material.specular_color_texture = Some(texture);
        (material.specular_texture, material.metallic_roughness_texture) = (made, made);
    }
    Ok(())
}
