//! PNG, JPEG and WebP textures.

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

/// What a decoder may take beside its texels [bytes]: tables, and the notes and colour profiles in a file.
const DECODER_BYTES: u64 = 1 << 24;

/// Whether a file is a WebP.
pub fn is_webp(bytes: &[u8]) -> bool {
    matches!(image::guess_format(bytes), Ok(ImageFormat::WebP))
}

/// Decodes a PNG, JPEG or WebP, told apart by content. Notes of how to turn a picture are left alone (glTF 2.0, section 3.8.3).
pub fn decode(bytes: &[u8], budget: &mut Budget) -> Result<Texels, Fault> {
    if bytes.is_empty() {
        return Err(Fault::invalid("the picture has no bytes"));
    }
    let format = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => format,
        _ => return Err(Fault::unsupported("the picture is neither PNG nor JPEG nor WebP")),
    };
    let damaged = |error: image::ImageError| Fault::invalid(error.to_string());
    let (width, height) =
        ImageReader::with_format(Cursor::new(bytes), format).into_dimensions().map_err(damaged)?;
    if width == 0 || height == 0 || width > LARGEST_SIDE || height > LARGEST_SIDE {
        let message =
            format!("a texture of {width} x {height} texels (1 to {LARGEST_SIDE} a side are allowed)");
        return Err(Fault::Unsupported(message));
    }
    let count = width as usize * height as usize;
    // The decoder's own texels, up to 8 bytes each, live beside ours for a moment.
    budget.take(count, 4 + 8)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(DECODER_BYTES + 16 * count as u64);
    reader.limits(limits);
    let decoded = reader.decode().map(image::DynamicImage::into_rgba8);
    let texels = decoded.inspect_err(|_| budget.give_back(count, 4)).map(|texels| {
        let rgba8 = texels.pixels().map(|pixel| pixel.0).collect();
        Texels { width, height, rgba8 }
    });
    budget.give_back(count, 8);
    texels.map_err(damaged)
}
