//! Layers of a picture.

use glam::{Mat4, Vec2};

super::constants! {
    /// Geometry layer: depth.
    pub const LAYER_DEPTH: u32 = 1;
    /// Geometry layer: shading normal.
    pub const LAYER_NORMAL: u32 = 2;
    /// Geometry layer: position in the world.
    pub const LAYER_POSITION: u32 = 3;
    /// Geometry layer: texture coordinates.
    pub const LAYER_UV: u32 = 4;
    /// Geometry layer: way since the frame before.
    pub const LAYER_MOTION: u32 = 5;
    /// Geometry layer: number of the object.
    pub const LAYER_OBJECT: u32 = 6;
    /// Geometry layer: number of the material.
    pub const LAYER_MATERIAL: u32 = 7;
    /// Bits of an infinite 32-bit float.
    pub const INFINITY_BITS: u32 = 0x7f80_0000;

    /// [`Composition::part`]: the picture.
    pub const PART_PICTURE: u32 = 0;
    /// [`Composition::part`]: base colour.
    pub const PART_ALBEDO: u32 = 1;
    /// [`Composition::part`]: light that matte surfaces reflect.
    pub const PART_DIFFUSE: u32 = 2;
    /// [`Composition::part`]: light that glossy surfaces reflect.
    pub const PART_SPECULAR: u32 = 3;
    /// [`Composition::part`]: light that surfaces emit.
    pub const PART_EMISSION: u32 = 4;
    /// [`Composition::part`]: the environment behind the scene.
    pub const PART_BACKGROUND: u32 = 5;
    /// [`Composition::part`]: share of the light on matte surfaces that shadows leave.
    pub const PART_SHADOW: u32 = 6;
    /// [`Composition::part`]: [`PART_DIFFUSE`] without what stays ambient.
    pub const PART_LIGHTS: u32 = 7;
    /// [`Composition::part`]: 1 where the scene is seen.
    pub const PART_ALPHA: u32 = 8;
}

super::structs! {
    /// What passes that compose are told.
    pub struct Composition {
        /// Whether over edge pixels alone, not over the whole picture.
        pub over_edges: u32,
        /// PART constant.
        pub part: u32,
        /// Of surfaces that light passes, counted from the nearest; [`Composition::layer_count`] for what lies behind them.
        pub layer: u32,
        /// Number of layers.
        pub layer_count: u32,
    }

    /// The camera of geometry layers.
    pub struct SeenFrame {
        /// Of the frame before.
        pub clip_before_from_world: Mat4,
        /// Rigid.
        pub world_from_camera: Mat4,
        /// Of a place in normalised device coordinates on the plane at a depth of 1 m, or of the parallel view [m]: scale,
        pub plane_scale: Vec2,
        /// and what is added.
        pub plane_offset: Vec2,
        /// Whether the view is parallel.
        pub is_parallel: u32,
    }

    /// What is drawn at once.
    pub struct SeenDraw {
        /// Label of the object, above 0.
        pub object: u32,
        /// Number of the material.
        pub material: u32,
    }
}
