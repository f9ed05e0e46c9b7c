//! Triangles, and what they are made of.

use glam::{Mat4, UVec2, Vec2, Vec3, Vec4};

super::constants! {
    /// [`Instance::first_joint`] of an instance without a skin.
    pub const NO_SKIN: u32 = u32::MAX;
    /// Vertices a workgroup.
    pub const VERTEX_WORKGROUP: u32 = 64;

    /// Texture arrays, each with its sampler, that a draw can read.
    pub const TEXTURE_SLOTS: u32 = 8;
    /// [`MaterialTexture::kind`]: RGBA, multiplies the base colour.
    pub const TEXTURE_BASE_COLOR: u32 = 0;
    /// [`MaterialTexture::kind`]: G multiplies the roughness, B the metallic share.
    pub const TEXTURE_METALLIC_ROUGHNESS: u32 = 1;
    /// [`MaterialTexture::kind`]: B, multiplies the metallic share.
    pub const TEXTURE_METALLIC: u32 = 2;
    /// [`MaterialTexture::kind`]: RGB, the normal in tangent space.
    pub const TEXTURE_NORMAL: u32 = 3;
    /// [`MaterialTexture::kind`]: A, multiplies the dielectric's reflection.
    pub const TEXTURE_SPECULAR: u32 = 4;
    /// [`MaterialTexture::kind`]: RGB, multiplies the dielectric's tint.
    pub const TEXTURE_SPECULAR_COLOR: u32 = 5;
    /// [`MaterialTexture::kind`]: RGB, multiplies the emission.
    pub const TEXTURE_EMISSIVE: u32 = 6;
    /// [`MaterialTexture::kind`]: slopes of heights along u and v, and the means of their squares.
    pub const TEXTURE_HEIGHT: u32 = 7;
    /// [`MaterialTexture::kind`]: R, multiplies the strength of the clear coat.
    pub const TEXTURE_CLEARCOAT: u32 = 8;
    /// [`MaterialTexture::kind`]: G, multiplies the roughness of the clear coat.
    pub const TEXTURE_CLEARCOAT_ROUGHNESS: u32 = 9;
    /// [`MaterialTexture::kind`]: RGB, the normal of the clear coat in tangent space.
    pub const TEXTURE_CLEARCOAT_NORMAL: u32 = 10;
    /// [`MaterialTexture::kind`]: RGB, multiplies the colour of the sheen.
    pub const TEXTURE_SHEEN_COLOR: u32 = 11;
    /// [`MaterialTexture::kind`]: A, multiplies the roughness of the sheen.
    pub const TEXTURE_SHEEN_ROUGHNESS: u32 = 12;
    /// [`MaterialTexture::kind`]: RG, the direction along which an anisotropic lobe is wide in tangent space.
    pub const TEXTURE_ANISOTROPY: u32 = 13;
    /// [`Material::catches`]: it is a surface as any other.
    pub const CATCHES_NOT: u32 = 0;
    /// [`Material::catches`]: it shows what is behind the scene everywhere.
    pub const CATCHES: u32 = 1;
    /// [`Material::catches`]: it is the ground that fades.
    pub const CATCHES_FADING: u32 = 2;
    /// [`ReliefMap::shape`]: ellipses.
    pub const RELIEF_ELLIPSES: u32 = 0;
    /// [`ReliefMap::shape`]: horizons in eight azimuths.
    pub const RELIEF_HORIZONS: u32 = 1;
    /// [`Material::alpha_cutoff`] where alpha is a share of the rays.
    pub const ALPHA_BLENDS: f32 = -1.0;
    /// [`MaterialTexture::wrap`]: repeat.
    pub const WRAP_REPEAT: u32 = 0;
    /// [`MaterialTexture::wrap`]: the edge goes on.
    pub const WRAP_CLAMP: u32 = 1;
    /// [`MaterialTexture::wrap`]: every second copy is mirrored.
    pub const WRAP_MIRROR: u32 = 2;
}

super::structs! {
    /// One vertex as it lies in its mesh.
    pub struct MeshVertex {
        /// In the mesh.
        pub position: Vec3,
        /// Index into the instance transforms.
        pub instance: u32,
        /// In the mesh.
        pub normal: Vec3,
        /// Of the bitangent; 0 without a tangent.
        pub tangent_sign: f32,
        /// Along increasing u.
        pub tangent: Vec3,
        /// Where its record of joints and morph targets begins; 0 for a vertex that only follows its instance.
        pub record: u32,
    }

    /// Rigid or affine placement of a mesh.
    pub struct Instance {
        /// Of positions.
        pub world_from_mesh: Mat4,
        /// Cofactors: for normals, and for the tangents of normal maps, as the reference does it.
        pub normal_from_mesh: Mat4,
        /// Of its skin, among all joints; [`NO_SKIN`] without.
        pub first_joint: u32,
        /// Of its morph targets, among all weights.
        pub first_weight: u32,
    }

    /// Factors of a material; what its textures hold multiplies them.
    pub struct Material {
        /// Colour and alpha.
        pub base_color: Vec4,
        /// Emitted radiance.
        pub emissive: Vec3,
        /// Metallic share.
        pub metallic: f32,
        /// Tint of the dielectric's reflection.
        pub specular_color: Vec3,
        /// Strength of the dielectric's reflection.
        pub specular: f32,
        /// Index of refraction.
        pub ior: f32,
        /// Strength of the normal map.
        pub normal_scale: f32,
        /// Alpha below this is a hole; 0 for opaque materials, [`ALPHA_BLENDS`] for those that light passes in part.
        pub alpha_cutoff: f32,
        /// Reflectance model, a number of `gnomon_brdf::Model`.
        pub model: u32,
        /// `Lobe::shape`: roughness, shininess or slope.
        pub shape: f32,
        /// Its first [`MaterialTexture`].
        pub first_texture: u32,
        /// One after its last.
        pub end_texture: u32,
        /// 1 where vertex colours multiply the emission, else 0.
        pub emissive_vertex_colors: u32,
        /// Whether it shows what is behind the scene, darkened by shadows: a CATCHES constant.
        pub catches: u32,
        /// Of its heights: metres over the map's width and height for a slope of 1 in the texture.
        pub height_slope: Vec2,
        /// Factor of the roughness that textures multiply, where [`Material::shape`] leaves it to them: bumps may make a surface rougher than
        /// its own.
        pub roughness: f32,
        /// Strength of the clear coat; 0 is none.
        pub clearcoat: f32,
        /// Its roughness.
        pub clearcoat_roughness: f32,
        /// Strength of its normal map.
        pub clearcoat_normal_scale: f32,
        /// Colour of the sheen, black for none.
        pub sheen_color: Vec3,
        /// Its roughness.
        pub sheen_roughness: f32,
        /// 1 where the G-buffer keeps what textures say of the sheen, and nothing of the coat.
        pub has_sheen_textures: u32,
    }

    /// What is prepared of a material's heights.
    pub struct ReliefMap {
        /// Along width and height of the map, where the field was prepared [m].
        pub extent: Vec2,
        /// RELIEF constant.
        pub shape: u32,
    }

    /// A texture as a material uses it.
    pub struct MaterialTexture {
        /// Rows of uv_from_mesh (xyz).
        pub uv_rows: [Vec4; 2],
        /// Addressing along u and v, WRAP constants.
        pub wrap: UVec2,
        /// Which of the mesh's coordinates.
        pub uv_set: u32,
        /// What it is, a TEXTURE constant.
        pub kind: u32,
        /// Which of the arrays that its material's draws bind.
        pub slot: u32,
        /// Layer of the array.
        pub layer: u32,
    }
}
