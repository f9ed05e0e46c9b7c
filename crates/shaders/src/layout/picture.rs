//! What becomes of the samples.

use glam::Vec3;

super::constants! {
    /// [`ResolveParameters::tone_mapping`]: radiance clipped to what can be shown.
    pub const TONE_LINEAR: u32 = 0;
    /// [`ResolveParameters::tone_mapping`]: Khronos PBR Neutral.
    pub const TONE_NEUTRAL: u32 = 1;

    /// [`DebugParameters::view`]: shading normals.
    pub const VIEW_NORMALS: u32 = 1;
    /// [`DebugParameters::view`]: distance along the view.
    pub const VIEW_DEPTH: u32 = 2;
    /// [`DebugParameters::view`]: base colour.
    pub const VIEW_BASE_COLOR: u32 = 3;
    /// [`DebugParameters::view`]: share of the lights' irradiance that arrives.
    pub const VIEW_SHADOW_BUFFER: u32 = 4;
    /// [`DebugParameters::view`]: share of one light that is seen.
    pub const VIEW_VISIBILITY: u32 = 5;
    /// [`DebugParameters::view`]: one light's depth map.
    pub const VIEW_SHADOW_MAP: u32 = 6;
    /// [`DebugParameters::view`]: the lights on the environment.
    pub const VIEW_LIGHTS: u32 = 7;
    /// [`DebugParameters::view`]: where lights are summed.
    pub const VIEW_POINTS: u32 = 8;
    /// [`DebugParameters::view`]: share of the hemisphere that bumps leave open.
    pub const VIEW_BUMPS: u32 = 9;
    /// [`DebugParameters::view`]: light that bumps scatter to each other.
    pub const VIEW_SCATTERED: u32 = 10;
}

super::structs! {
    /// How samples become pixels.
    pub struct ResolveParameters {
        /// Samples along a pixel's side.
        pub samples: u32,
        /// 2^EV.
        pub exposure: f32,
        /// TONE constant.
        pub tone_mapping: u32,
    }

    /// What a debug view shows, and how.
    pub struct DebugParameters {
        /// VIEW constant.
        pub view: u32,
        /// The light shown, within its batch.
        pub light: u32,
        /// Whether it is of this batch.
        pub has_light: u32,
        /// Whether depth maps are drawn at all.
        pub has_maps: u32,
        /// Direction to the viewer, along which depth is measured.
        pub to_viewer: Vec3,
        /// Lights of the batches before.
        pub lights_before: u32,
        /// Of what is seen [m].
        pub least_depth: f32,
        /// From there to the farthest [m].
        pub depth_range: f32,
        /// Factor of the exposure in force.
        pub exposure: f32,
        /// Of this batch.
        pub light_count: u32,
    }
}
