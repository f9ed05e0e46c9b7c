//! Materials and how they use textures.

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::Int;

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct MaterialEntry {
    pub name: Option<String>,
    #[serde(default)]
    pub pbr_metallic_roughness: MetallicRoughness,
    pub normal_texture: Option<TextureInfo>,
    pub emissive_texture: Option<TextureInfo>,
    #[serde(default)]
    pub emissive_factor: [f32; 3],
    #[serde(default)]
    pub alpha_mode: AlphaModeEntry,
    pub alpha_cutoff: Option<f32>,
    #[serde(default)]
    pub double_sided: bool,
    #[serde(default)]
    pub extensions: MaterialExtensions,
    /// The application's own; anything may stand there.
    #[serde(default)]
    pub extras: serde_json::Value,
}

/// `extras.gnomon_height` of a material: there is no ratified extension for heights.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct HeightEntry {
    pub texture: TextureInfo,
    pub scale: f32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum AlphaModeEntry {
    #[default]
    Opaque,
    Mask,
    Blend,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct MetallicRoughness {
    pub base_color_factor: Option<[f32; 4]>,
    pub base_color_texture: Option<TextureInfo>,
    pub metallic_factor: Option<f32>,
    pub roughness_factor: Option<f32>,
    pub metallic_roughness_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
pub struct MaterialExtensions {
    #[serde(rename = "KHR_materials_anisotropy")]
    pub anisotropy: Option<Anisotropy>,
    #[serde(rename = "KHR_materials_clearcoat")]
    pub clearcoat: Option<Clearcoat>,
    #[serde(rename = "KHR_materials_sheen")]
    pub sheen: Option<Sheen>,
    #[serde(rename = "KHR_materials_specular")]
    pub specular: Option<Specular>,
    #[serde(rename = "KHR_materials_ior")]
    pub ior: Option<Ior>,
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_unlit")]
    pub unlit: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub specular_glossiness: Option<SpecularGlossiness>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SpecularGlossiness {
    pub diffuse_factor: Option<[f32; 4]>,
    pub diffuse_texture: Option<TextureInfo>,
    pub specular_factor: Option<[f32; 3]>,
    pub glossiness_factor: Option<f32>,
    pub specular_glossiness_texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Specular {
    pub specular_factor: Option<f32>,
    pub specular_texture: Option<TextureInfo>,
    pub specular_color_factor: Option<[f32; 3]>,
    pub specular_color_texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Anisotropy {
    pub anisotropy_strength: Option<f32>,
    pub anisotropy_rotation: Option<f32>,
    pub anisotropy_texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Clearcoat {
    pub clearcoat_factor: Option<f32>,
    pub clearcoat_texture: Option<TextureInfo>,
    pub clearcoat_roughness_factor: Option<f32>,
    pub clearcoat_roughness_texture: Option<TextureInfo>,
    pub clearcoat_normal_texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Sheen {
    pub sheen_color_factor: Option<[f32; 3]>,
    pub sheen_color_texture: Option<TextureInfo>,
    pub sheen_roughness_factor: Option<f32>,
    pub sheen_roughness_texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
pub struct Ior {
    pub ior: Option<f32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct EmissiveStrength {
    pub emissive_strength: Option<f32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureInfo {
    pub index: Int,
    #[serde(default)]
    pub tex_coord: Int,
    /// Of normal textures.
    pub scale: Option<f32>,
    #[serde(default)]
    pub extensions: TextureInfoExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub transform: Option<TextureTransform>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureTransform {
    #[serde(default)]
    pub offset: [f32; 2],
    #[serde(default)]
    pub rotation: f32,
    pub scale: Option<[f32; 2]>,
    pub tex_coord: Option<Int>,
}

impl TextureInfo {
    /// Which coordinates of the mesh it takes.
    pub fn set(&self) -> usize {
        let transform = self.extensions.transform.as_ref();
        transform.and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord).0
    }
}

impl MaterialEntry {
    /// The heights that its extras describe, or why they cannot be used.
    pub fn height(&self) -> Option<Result<HeightEntry, String>> {
        let entry = self.extras.get("gnomon_height")?;
        Some(HeightEntry::deserialize(entry).map_err(|error| error.to_string()))
    }

    /// Every use of a texture.
    pub fn texture_infos(&self) -> impl Iterator<Item = &TextureInfo> {
        let pbr = &self.pbr_metallic_roughness;
        let specular = self.extensions.specular.as_ref();
        let gloss = self.extensions.specular_glossiness.as_ref();
        let anisotropy = self.extensions.anisotropy.as_ref();
        let coat = self.extensions.clearcoat.as_ref();
        let sheen = self.extensions.sheen.as_ref();
        let infos = [
            pbr.base_color_texture.as_ref(),
            gloss.and_then(|gloss| gloss.diffuse_texture.as_ref()),
            pbr.metallic_roughness_texture.as_ref(),
            gloss.and_then(|gloss| gloss.specular_glossiness_texture.as_ref()),
            self.normal_texture.as_ref(),
            self.emissive_texture.as_ref(),
            specular.and_then(|specular| specular.specular_texture.as_ref()),
            specular.and_then(|specular| specular.specular_color_texture.as_ref()),
            anisotropy.and_then(|anisotropy| anisotropy.anisotropy_texture.as_ref()),
            coat.and_then(|coat| coat.clearcoat_texture.as_ref()),
            coat.and_then(|coat| coat.clearcoat_roughness_texture.as_ref()),
            coat.and_then(|coat| coat.clearcoat_normal_texture.as_ref()),
            sheen.and_then(|sheen| sheen.sheen_color_texture.as_ref()),
            sheen.and_then(|sheen| sheen.sheen_roughness_texture.as_ref()),
        ];
        infos.into_iter().flatten()
    }
}
