//! Reflectance as tables: `gnomon_brdf::tables`.

use glam::Vec3;
use gnomon_brdf::tables::{Coordinates, Tint};

super::constants! {
    /// Most reflectances of a scene that are tables.
    pub const MAX_TABLE_SETS: u32 = 128;
    /// Most tables that these are made of, beside albedos and proposals.
    pub const MAX_TABLE_FACTORS: u32 = 768;
    /// [`TableFactor::coordinates`], see `Coordinates`.
    pub const TABLE_HALF: u32 = Coordinates::Half.number();
    /// [`TableFactor::coordinates`].
    pub const TABLE_HALF_QUADRANT: u32 = Coordinates::HalfQuadrant(1.0).number();
    /// [`TableFactor::coordinates`].
    pub const TABLE_HALF_AND_DIFFERENCE: u32 = Coordinates::HalfAndDifference.number();
    /// [`TableFactor::coordinates`].
    pub const TABLE_COSINES: u32 = Coordinates::Cosines.number();
    /// [`TableFactor::coordinates`].
    pub const TABLE_DIFFERENCE: u32 = Coordinates::Difference.number();
    /// [`TableFactor::coordinates`].
    pub const TABLE_LIGHT: u32 = Coordinates::Light.number();
    /// [`TableFactor::coordinates`].
    pub const TABLE_VIEW: u32 = Coordinates::View.number();
    /// [`TableFactor::coordinates`].
    pub const TABLE_TANGENT: u32 = Coordinates::Tangent.number();
    /// [`TableFactor::coordinates`].
    pub const TABLE_COSINE_LOBE: u32 = Coordinates::CosineLobe(Vec3::ZERO).number();
    /// [`TableFactor::tint`]: multiplies the factors before it.
    pub const TABLE_MULTIPLIES: u32 = 0;
    /// [`TableFactor::tint`]: the first of a term, which the tint's colour tints.
    pub const TABLE_COLOR: u32 = Tint::Color as u32;
    /// [`TableFactor::tint`]: the first of a term, which the tint's w scales.
    pub const TABLE_GRAZING: u32 = Tint::Grazing as u32;
    /// Chance of a sample about a half vector.
    pub const TABLE_PROPOSAL_SHARE: f32 = gnomon_brdf::tables::PROPOSAL_SHARE;
    /// Where the columns of albedos lie.
    pub const TABLE_ALBEDO_SCALE: f32 = gnomon_brdf::Tables::ALBEDO_SCALE;
    /// Points on a light, and of the lobe, that its highlight is summed over.
    pub const TABLE_LIGHT_POINTS: u32 = gnomon_brdf::tables::LIGHT_POINTS;
    /// Half the width of the border over which a light fades out, in its half sides.
    pub const TABLE_LIGHT_BORDER: f32 = gnomon_brdf::tables::LIGHT_BORDER;
}

super::structs! {
    /// One table of a sum of products.
    pub struct TableFactor {
        /// What it is looked up with, a TABLE constant.
        pub coordinates: u32,
        /// TABLE_MULTIPLIES, or what tints the term that it begins.
        pub tint: u32,
        /// Where it lies: layer of the texture array.
        pub layer: u32,
        /// And the first row there.
        pub first_row: u32,
        /// Texels a row.
        pub columns: u32,
        /// Rows.
        pub rows: u32,
        /// 1 where the first row follows after the last one, else 0.
        pub periodic: u32,
        /// Where columns lie.
        pub scale: f32,
        /// Numbers of the coordinates.
        pub parameters: Vec3,
    }

    /// A reflectance.
    pub struct TableSet {
        /// Its first [`TableFactor`].
        pub first_factor: u32,
        /// One after its last.
        pub end_factor: u32,
        /// Layer of the albedos.
        pub albedo_layer: u32,
        /// First of their two rows.
        pub albedo_row: u32,
        /// Texels a row.
        pub albedo_columns: u32,
        /// Layer of the cells that samples are drawn from.
        pub proposal_layer: u32,
        /// First row of them.
        pub proposal_row: u32,
        /// Cells a row.
        pub proposal_columns: u32,
        /// Rows of cells, around the normal.
        pub proposal_rows: u32,
        /// Where their columns lie.
        pub proposal_scale: f32,
        /// From the surface's tangent to the tables' x axis, counter-clockwise [rad].
        pub turn: f32,
        /// Roughness of a GGX lobe about as wide.
        pub roughness: f32,
    }
}
