//! Linear high-dynamic-range pictures and the files they come from.
//!
//! One picture type serves the whole project: [`RgbImage`], three `f32` a texel, linear Rec. 709 radiance,
//! row-major, top row first. Decoders are chosen by content, encoders by file name (see `CONVENTIONS.md`).

mod picture;

pub use picture::{LUMINANCE, RgbImage};
