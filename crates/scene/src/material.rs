use std::sync::Arc;

use glam::{Affine2, Vec2, Vec3};
use gnomon_brdf::{Surface, Tables};

use crate::{GroundFade, Height};

/// Index into [`crate::Scene::textures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub usize);

/// Texture addressing outside `[0, 1]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Wrap {
    /// Repeat.
    #[default]
    Repeat,
    /// Repeat, every second copy mirrored.
    MirroredRepeat,
    /// The edge texel goes on.
    ClampToEdge,
}

/// Eight-bit texels as the file holds them, RGBA, top row first; the use decides whether they are sRGB or linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// `width * height` RGBA texels.
    pub rgba8: Vec<[u8; 4]>,
    /// Addressing along u and v.
    pub wrap: [Wrap; 2],
    /// Nearest texel instead of bilinear.
    pub nearest: bool,
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Which texture.
    pub texture: TextureId,
    /// `KHR_texture_transform`: texture coordinates from mesh coordinates.
    pub uv_from_mesh: Affine2,
    /// Which of the mesh's two coordinate sets (0 or 1).
    pub set: usize,
}

impl TextureRef {
    /// Texture coordinates for the mesh's coordinates.
    pub fn transform(&self, mesh_uv: Vec2) -> Vec2 {
        self.uv_from_mesh.transform_point2(mesh_uv)
    }
}

/// What alpha does.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum AlphaMode {
    /// Nothing.
    #[default]
    Opaque,
    /// Texels below the cutoff are holes.
    Mask {
        /// Cutoff, 0..1.
        cutoff: f32,
    },
    /// What lies behind shows through by as much as alpha is below 1: so many of the rays that meet the surface pass it.
    Blend,
}

impl AlphaMode {
    /// Share of the rays that a point of an alpha stops, 0..1.
    pub fn opacity(self, alpha: f32) -> f32 {
        match self {
            Self::Opaque => 1.0,
            Self::Mask { cutoff } => f32::from(u8::from(alpha >= cutoff)),
            Self::Blend => alpha.clamp(0.0, 1.0),
        }
    }
}

/// A surface and the textures that vary it: every texture multiplies its factor, as in glTF.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file, empty where it has none.
    pub name: String,
    /// Factors.
    pub surface: Surface,
    /// Tables of a file, for the model that has none of its own.
    pub tables: Option<Arc<Tables>>,
    /// sRGB: base colour; alpha in A.
    pub base_color_texture: Option<TextureRef>,
    /// Linear: roughness in G, metallic in B.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Linear: tangent-space normal.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the normal texture's x and y.
    pub normal_scale: f32,
    /// Heights: relief that shades, shadows and lights itself.
    pub height: Option<Height>,
    /// Linear: specular strength in A.
    pub specular_texture: Option<TextureRef>,
    /// sRGB: specular tint.
    pub specular_color_texture: Option<TextureRef>,
    /// Linear: direction along which an anisotropic lobe is wide, x and y in tangent space as R and G.
    pub anisotropy_texture: Option<TextureRef>,
    /// Linear: strength of the clear coat in R.
    pub clearcoat_texture: Option<TextureRef>,
    /// Linear: roughness of the clear coat in G.
    pub clearcoat_roughness_texture: Option<TextureRef>,
    /// Linear: tangent-space normal of the clear coat, which `normal_texture` does not bend.
    pub clearcoat_normal_texture: Option<TextureRef>,
    /// Scale of its x and y.
    pub clearcoat_normal_scale: f32,
    /// sRGB: sheen colour.
    pub sheen_color_texture: Option<TextureRef>,
    /// Linear: roughness of the sheen in A.
    pub sheen_roughness_texture: Option<TextureRef>,
    /// Emitted radiance, linear.
    pub emissive: Vec3,
    /// sRGB: multiplies `emissive`.
    pub emissive_texture: Option<TextureRef>,
    /// Whether vertex colours multiply `emissive`, instead of the base colour alone: a surface that emits its colour has them so.
    pub emissive_vertex_colors: bool,
    /// Base-colour alpha factor.
    pub alpha: f32,
    /// Use of alpha.
    pub alpha_mode: AlphaMode,
    /// What the file says of its back. Pictures do not depend on it: every surface is seen and lit from both sides.
    pub double_sided: bool,
    /// Shows what is seen behind the scene, by the share of the light that shadows leave on it, and blocks no light itself.
    pub catches: bool,
    /// How a catcher changes with the distance from the middle of its mesh: for the one of [`crate::Scene::ground`].
    pub fade: Option<GroundFade>,
}

impl Default for Material {
    /// Grey and matte (Lambert 0.5), opaque, single-sided, without textures.
    fn default() -> Self {
        Self {
            name: String::new(),
            surface: Surface::default(),
            tables: None,
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            height: None,
            specular_texture: None,
            specular_color_texture: None,
            anisotropy_texture: None,
            clearcoat_texture: None,
            clearcoat_roughness_texture: None,
            clearcoat_normal_texture: None,
            clearcoat_normal_scale: 1.0,
            sheen_color_texture: None,
            sheen_roughness_texture: None,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            emissive_vertex_colors: false,
            alpha: 1.0,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            catches: false,
            fade: None,
        }
    }
}

impl Material {
    /// Tables of the glossy part, where its model is tabulated: the file's, or those that the model makes of its parameters.
    pub fn reflectance_tables(&self) -> Option<Arc<Tables>> {
        if !self.surface.model.is_tabulated() {
            return None;
        }
        self.surface.tables().map(Arc::new).or_else(|| self.tables.clone())
    }

    /// The set of texture coordinates whose u its meshes' tangents follow, where it needs any: that of its normal map, else of its coat's, else of its lobe's direction.
    pub fn tangent_set(&self) -> Option<usize> {
        let needs_tangent = self.surface.model.needs_tangent();
        let normals = self.normal_texture.or(self.clearcoat_normal_texture).or(self.anisotropy_texture);
        normals.map(|texture| texture.set).or(needs_tangent.then_some(0))
    }

    /// Whether textures vary its sheen.
    pub fn has_sheen_textures(&self) -> bool {
        self.sheen_color_texture.or(self.sheen_roughness_texture).is_some()
    }

    /// Every place for a texture.
    pub(crate) fn textures_mut(&mut self) -> [&mut Option<TextureRef>; 12] {
        [
            &mut self.base_color_texture,
            &mut self.metallic_roughness_texture,
            &mut self.normal_texture,
            &mut self.specular_texture,
            &mut self.specular_color_texture,
            &mut self.anisotropy_texture,
            &mut self.clearcoat_texture,
            &mut self.clearcoat_roughness_texture,
            &mut self.clearcoat_normal_texture,
            &mut self.sheen_color_texture,
            &mut self.sheen_roughness_texture,
            &mut self.emissive_texture,
        ]
    }
}
