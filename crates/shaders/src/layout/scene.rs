//! Triangles, and what they are made of.

use glam::{Mat4, Vec3, Vec4};

super::constants! {
    /// [`Instance::first_joint`] of an instance without a skin.
    pub const NO_SKIN: u32 = u32::MAX;
    /// Vertices a workgroup.
    pub const VERTEX_WORKGROUP: u32 = 64;
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

    /// Factors of a material; textures multiply them.
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
        /// Of GGX.
        pub roughness: f32,
        /// Index of refraction.
        pub ior: f32,
        /// Strength of the normal map.
        pub normal_scale: f32,
        /// Alpha below this is a hole; 0 for opaque materials.
        pub alpha_cutoff: f32,
        /// Reflectance model, a number of `gnomon_brdf::Model`.
        pub model: u32,
        /// Of all models but metallic-roughness what shapes its lobe.
        pub lobe_parameter: f32,
        /// Rows of uv_from_mesh (xyz) and the coordinate set (w), two vectors a texture, in the order of the bindings.
        pub uv_rows: [Vec4; 12],
    }
}
