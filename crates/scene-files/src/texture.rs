//! PNG and JPEG textures.

use std::io::Cursor;

use image::{ImageFormat, ImageReader, Limits};

use super::Budget;
use crate::error::Fault;

/// Texels of a texture file: width, height, RGBA, top row first.
pub struct Texels {
    pub width: u32,
    pub height: u32,
    pub rgba8: Vec<[u8; 4]>,
}

/// Largest side of a texture; GPUs end at 16,384 too.
const LARGEST_SIDE: u32 = 16_384;

/// Decodes a PNG or JPEG, told apart by content.
pub fn decode(bytes: &[u8], budget: &mut Budget) -> Result<Texels, Fault> {
    let format = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => format,
        _ => return Err(Fault::unsupported("the picture is neither PNG nor JPEG")),
    };
    let damaged = |error: image::ImageError| Fault::invalid(error.to_string());
    let (width, height) =
        ImageReader::with_format(Cursor::new(bytes), format).into_dimensions().map_err(damaged)?;
    if width == 0 || height == 0 || width > LARGEST_SIDE || height > LARGEST_SIDE {
        let message =
            format!("a texture of {width} x {height} texels (1 to {LARGEST_SIDE} a side are allowed)");
        return Err(Fault::Unsupported(message));
    }
    // Twice: the decoder's own texels, up to 8 bytes each, live beside ours for a moment.
    budget.take(width as usize * height as usize, 4 + 8)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(64 + 16 * u64::from(width) * u64::from(height));
    reader.limits(limits);
    let texels = reader.decode().map_err(damaged)?.into_rgba8();
    let rgba8 = texels.pixels().map(|pixel| pixel.0).collect();
    Ok(Texels { width, height, rgba8 })
}
