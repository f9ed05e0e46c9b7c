//! Rust mirrors of `types.wgsl`, field for field. `tests/layout.rs` compares names, offsets and sizes with naga's.
//!
//! WGSL aligns `vec3f` to 16 bytes; here every `[f32; 3]` is followed by a scalar that fills the gap.
#![allow(missing_docs, reason = "types.wgsl documents every field once")]

use bytemuck::{Pod, Zeroable};

pub type Mat4 = [[f32; 4]; 4];

/// [`Light::shape`] of a disk.
pub const SHAPE_DISK: u32 = 0;
/// [`Light::shape`] of a quadrilateral.
pub const SHAPE_RECTANGLE: u32 = 1;
/// [`Light::kind`] of a distant light.
pub const KIND_DISTANT: u32 = 0;
/// [`Light::kind`] of a flat light in the scene.
pub const KIND_FLAT: u32 = 1;
/// [`Light::kind`] of a sphere in the scene.
pub const KIND_SPHERE: u32 = 2;
/// [`Light::role`] of a light that lights.
pub const ROLE_LIGHT: u32 = 0;
/// [`Light::role`] of a light of which only the visibility is asked for.
pub const ROLE_PROBE: u32 = 1;
/// Most lights of a batch: what fits into the 64 KiB that every adapter allows a uniform buffer.
pub const MAX_BATCH_LIGHTS: u32 = 160;
/// [`Batch::flags`]: nothing has been summed before.
pub const FLAG_FIRST: u32 = 1;
/// [`View::flags`]: draw the environment behind the scene.
pub const FLAG_BACKGROUND: u32 = 1;
/// [`View::flags`]: matte surfaces take irradiance from spherical harmonics.
pub const FLAG_SPHERICAL_HARMONICS: u32 = 2;
/// Most lobes of the radiance cache.
pub const MAX_CACHED_LOBES: usize = 16;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct View {
    pub clip_from_world: Mat4,
    pub world_from_clip: Mat4,
    pub eye_world: [f32; 4],
    pub size: [u32; 2],
    pub flags: u32,
    pub shadow_sampling: u32,
    pub sample_extent: f32,
    pub interleave: u32,
    pub padding_0: f32,
    pub padding_1: f32,
    pub residual_sh: [[f32; 4]; 9],
    pub full_sh: [[f32; 4]; 9],
    pub environment_from_world: Mat4,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Light {
    pub direction: [f32; 3],
    pub shape: u32,
    pub tangent: [f32; 3],
    pub angular_radius: f32,
    pub bitangent: [f32; 3],
    pub solid_angle: f32,
    pub radiance: [f32; 3],
    pub padding_2: f32,
    pub corners: [[f32; 4]; 4],
    pub light_from_world: Mat4,
    pub map_width_world: f32,
    pub depth_range_world: f32,
    pub normal_offset_world: f32,
    pub near_world: f32,
    pub position: [f32; 3],
    pub kind: u32,
    pub half_extent: [f32; 2],
    pub role: u32,
    pub caster_deviation_world: f32,
    pub vector_irradiance: [f32; 3],
    pub padding_1: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Batch {
    pub first_light: u32,
    pub end_light: u32,
    pub flags: u32,
    pub padding_0: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ShadingPoint {
    pub position_world: [f32; 3],
    pub sample: u32,
    pub normal: [f32; 3],
    pub padding: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LightSums {
    pub diffuse_unshadowed: [f32; 3],
    pub probed: f32,
    pub diffuse_shadowed: [f32; 3],
    pub probed_open: f32,
    pub specular_unshadowed: [f32; 3],
    pub padding_0: f32,
    pub specular_shadowed: [f32; 3],
    pub padding_1: f32,
    pub diffuse_near: [f32; 3],
    pub padding_2: f32,
    pub specular_near: [f32; 3],
    pub padding_3: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CachedLobe {
    pub model: u32,
    pub parameter: f32,
    pub padding_0: u32,
    pub padding_1: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct RadianceCache {
    pub right: [f32; 3],
    pub count: u32,
    pub up: [f32; 3],
    pub samples: u32,
    pub to_viewer: [f32; 3],
    pub padding: u32,
    pub environment_from_world: Mat4,
    pub lobes: [CachedLobe; MAX_CACHED_LOBES],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct MeshVertex {
    pub position: [f32; 3],
    pub instance: u32,
    pub normal: [f32; 3],
    pub tangent_sign: f32,
    pub tangent: [f32; 3],
    pub record: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Instance {
    pub world_from_mesh: Mat4,
    pub normal_from_mesh: Mat4,
    pub first_joint: u32,
    pub first_weight: u32,
    pub padding: [u32; 2],
}

/// [`Instance::first_joint`] of an instance without a skin.
pub const NO_SKIN: u32 = u32::MAX;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Material {
    pub base_color: [f32; 4],
    pub emissive: [f32; 3],
    pub metallic: f32,
    pub specular_color: [f32; 3],
    pub specular: f32,
    pub roughness: f32,
    pub ior: f32,
    pub normal_scale: f32,
    pub alpha_cutoff: f32,
    pub model: u32,
    pub lobe_parameter: f32,
    pub padding_0: u32,
    pub padding_1: u32,
    pub uv_rows: [[f32; 4]; 12],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct HardParameters {
    pub depth_bias: f32,
    pub padding_0: f32,
    pub padding_1: f32,
    pub padding_2: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct PcfParameters {
    pub samples: u32,
    pub radius_uv: f32,
    pub depth_bias: f32,
    pub normal_offset_scale: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct PcssParameters {
    pub search_samples: u32,
    pub filter_samples: u32,
    pub depth_bias: f32,
    pub normal_offset_scale: f32,
    pub rotate_per_pixel: u32,
    pub padding_0: u32,
    pub padding_1: u32,
    pub padding_2: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct MomentParameters {
    pub resolution: f32,
    pub max_level: f32,
    pub moment_bias: f32,
    pub depth_bias: f32,
    pub slope_bias: f32,
    pub footprint_scale: f32,
    pub intensity_scale: f32,
    pub normal_offset_scale: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ConvolutionParameters {
    pub order: u32,
    pub groups: u32,
    pub resolution: f32,
    pub max_level: f32,
    pub black_point: f32,
    pub white_point: f32,
    pub sharpening_a: f32,
    pub sharpening_b: f32,
    pub depth_bias: f32,
    pub average_bias: f32,
    pub footprint_scale: f32,
    pub plane_iterations: u32,
    pub contact_samples: u32,
    pub contact_reach: f32,
    pub padding_0: u32,
    pub padding_1: u32,
    pub far_sin: [[f32; 4]; 4],
    pub far_cos: [[f32; 4]; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ResolveParameters {
    pub samples: u32,
    pub exposure: f32,
    pub tone_mapping: u32,
    pub padding: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct DebugParameters {
    pub view: u32,
    pub light: u32,
    pub has_light: u32,
    pub has_maps: u32,
    pub to_viewer: [f32; 3],
    pub lights_before: u32,
    pub least_depth: f32,
    pub depth_range: f32,
    pub exposure: f32,
    pub light_count: u32,
}
