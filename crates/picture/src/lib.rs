//! Linear high-dynamic-range pictures and the files they come from.
//!
//! One picture type serves the whole project: [`RgbImage`], three `f32` a texel, linear Rec. 709 radiance,
//! row-major, top row first. [`ContactSheet`] makes one picture of several. Decoders are chosen by content, encoders by file name (see `CONVENTIONS.md`).

pub mod atomic;
mod contact_sheet;
mod error;
pub mod exr;
mod file;
mod font;
pub mod hdr;
pub mod ldr;
mod picture;
mod primaries;
pub mod tonemap;

pub use contact_sheet::{ContactSheet, Panel};
pub use error::{DecodeError, ImageError};
pub use file::{
    Decoded, Description, EnvironmentAttribute, Format, Mask, TexelSink, decode, decode_into, format_of,
    formats, read, read_bytes, read_mask, write,
};
pub use picture::{LUMINANCE, RgbImage, rec709_from_xyz};
pub use tonemap::ToneMapping;

/// Largest picture that is read, in texels: 16384 x 8192. It takes 1.5 GiB in memory whole.
pub const MAX_TEXELS: u64 = 1 << 27;
