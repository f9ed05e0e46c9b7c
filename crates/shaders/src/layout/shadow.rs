//! Parameters of shadow techniques.

use glam::{Vec3, Vec4};

super::constants! {
    /// Most points that percentage-closer soft shadows look at, of all their sets.
    pub const PCSS_POINTS: u32 = 3 * PCSS_SAMPLES;
    /// Most points of one of them.
    pub const PCSS_SAMPLES: u32 = 1024;
    /// Rows or columns of a summed-area table a workgroup.
    pub const LINE_WORKGROUP: u32 = 32;
    /// Nodes that are refitted by a workgroup.
    pub const RAY_WORKGROUP: u32 = 64;
    /// What [`RayNode::members`] counts in.
    pub const RAY_LEAF: u32 = 8;
    /// Instead of a number of triangles: the node's one member is an instance.
    pub const RAY_INSTANCE: u32 = 7;
    /// The same, where what leads to it is the place of its transforms among the triangles.
    pub const RAY_COPY: u32 = 6;
    /// Points of a light that rays go to.
    pub const LIGHT_POINTS: u32 = 64;
    /// Directions that stand for the sky where a ray meets the scene.
    pub const SKY_SAMPLES: u32 = 1024;
    /// So many of them that follow one another are spread over the whole sky.
    pub const SKY_BLOCK: u32 = 32;
    /// Triangles in a row of the texture of what rays meet, two texels each.
    pub const HIT_TRIANGLES_A_ROW: u32 = 1024;
    /// Beside the number of a triangle's material: lights of the scene stand for its emission.
    pub const HIT_SHINES: u32 = 1 << 31;
    /// Texels of a material as reflections see it.
    pub const FAR_MATERIAL_TEXELS: u32 = 5;
    /// Materials in a row of their texture.
    pub const FAR_MATERIALS_A_ROW: u32 = 256;
    /// Instead of the second triangle of an edge: there is none.
    pub const NO_WING: u32 = u32::MAX;
    /// Where the SIDE constants of a triangle begin in the word beside its third corner.
    pub const SIDE_SHIFT: u32 = 28;
    /// A triangle has to be turned to agree with those around it.
    pub const SIDE_TURNED: u32 = 1;
    /// Both sides of a triangle's surface block light by themselves.
    pub const SIDE_SHEET: u32 = 2;
}

super::structs! {
    /// Parameters of hard shadow maps, stored or linear.
    pub struct HardParameters {
        /// Receiver depth is moved towards the light by this much, in the depth that is compared.
        pub depth_bias: f32,
    }

    /// Parameters of percentage-closer filtering.
    pub struct PcfParameters {
        /// Of the kernel.
        pub samples: u32,
        /// Radius of the kernel as a share of the map's side.
        pub radius_uv: f32,
        /// Receiver depth is moved towards the light by this much, in linear depth.
        pub depth_bias: f32,
        /// Factor on the lights' offset along the normal.
        pub normal_offset_scale: f32,
    }

    /// Parameters of percentage-closer soft shadows.
    pub struct PcssParameters {
        /// Of the blocker search.
        pub search_samples: u32,
        /// Of the kernel.
        pub filter_samples: u32,
        /// Receiver depth is moved towards the light by this much, in linear depth.
        pub depth_bias: f32,
        /// Factor on the lights' offset along the normal.
        pub normal_offset_scale: f32,
    }

    /// A node of the hierarchies of boxes that rays are traced through.
    pub struct RayNode {
        /// Least coordinates.
        pub low: Vec3,
        /// The node after all that lie below this one.
        pub skip: u32,
        /// Greatest coordinates.
        pub high: Vec3,
        /// Of a leaf [`RAY_LEAF`] times its first triangle, the first node of its instance or the place of its copy, plus the number of
        /// triangles, [`RAY_INSTANCE`] or [`RAY_COPY`]; 0 of any other node.
        pub members: u32,
    }

    /// What is marked for every light: triangles, then edges, then nodes around edges, each a word for every 32 lights.
    pub struct SilhouetteCounts {
        /// Triangles that rays meet.
        pub triangles: u32,
        /// Edges between them.
        pub edges: u32,
        /// The first node around edges, of the level around instances.
        pub first_node: u32,
        /// The first that is marked: of the levels around edges.
        pub first_marked: u32,
        /// Words of a mark.
        pub words: u32,
    }

    /// Parameters of penumbra wedges.
    pub struct WedgeParameters {
        /// Factor on the lights' size.
        pub light_size: f32,
    }

    /// Parameters of shadow volumes.
    pub struct VolumeParameters {
        /// How far they reach in a parallel view [m].
        pub length: f32,
    }

    /// Parameters of techniques that look at all texels of a depth map that may block.
    pub struct WindowParameters {
        /// Of a window, along a side.
        pub texels: u32,
        /// Factor on the lights' offset along the normal.
        pub normal_offset_scale: f32,
        /// Receiver depth is moved towards the light by this much, in linear depth.
        pub depth_bias: f32,
    }

    /// Parameters of moment soft shadow maps.
    pub struct MomentParameters {
        /// Edge length of the shadow map in texels.
        pub resolution: f32,
        /// Coarsest mip level.
        pub max_level: f32,
        /// Share of a wide distribution mixed into every lookup.
        pub moment_bias: f32,
        /// Receiver depth is moved towards the light by this much, in linear depth.
        pub depth_bias: f32,
        /// Factor on every kernel's width.
        pub footprint_scale: f32,
        /// Factor on the shadow, whose reconstruction is a lower bound.
        pub intensity_scale: f32,
        /// Factor on the lights' offset along the normal.
        pub normal_offset_scale: f32,
    }

    /// Parameters of convolution shadows (Annen et al. 2008).
    pub struct ConvolutionParameters {
        /// Terms of the series, M.
        pub order: u32,
        /// RGBA layers a light needs for M terms.
        pub groups: u32,
        /// Edge length of the shadow map in texels.
        pub resolution: f32,
        /// Coarsest mip level.
        pub max_level: f32,
        /// Ringing suppression: value of the series that becomes 0.
        pub black_point: f32,
        /// Value of the series that becomes 1.
        pub white_point: f32,
        /// A of the sharpening p = 1 + A exp(-B (d - z_avg)).
        pub sharpening_a: f32,
        /// B of the sharpening.
        pub sharpening_b: f32,
        /// Receiver depth is moved towards the light by this much, in scaled light depth: in the final lookup.
        pub depth_bias: f32,
        /// The same where blocker depth is averaged.
        pub average_bias: f32,
        /// Widens kernels by what ringing suppression narrows penumbrae.
        pub footprint_scale: f32,
        /// Times the shadow map's plane is put at the average blocker depth.
        pub plane_iterations: u32,
        /// Places of the depth map looked at for blockers near the receiver, 0 for none.
        pub contact_samples: u32,
        /// How near those are, in linear depth.
        pub contact_reach: f32,
        /// Sines of the basis at the far plane, group by group: of texels that nothing blocks.
        pub far_sin: [Vec4; 4],
        /// Cosines of the same.
        pub far_cos: [Vec4; 4],
    }
}
