//! Pictures of low dynamic range: PNG and JPEG in, PNG out, through the `image` crate.

use std::io::Cursor;
use std::path::Path;

use glam::Vec3;
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageFormat, ImageReader, Limits};

use crate::error::{DecodeError, ImageError};
use crate::file::{Description, TexelSink};
use crate::tonemap::{srgb_decode, srgb_encode};
use crate::{MAX_TEXELS, RgbImage, atomic};

/// Memory that one decoder may take [bytes].
const MAX_DECODER_BYTES: u64 = 1 << 30;

/// Whether the bytes begin like a PNG picture.
pub fn sniff_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n")
}

/// Whether the bytes begin like a JPEG picture.
pub fn sniff_jpeg(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xff, 0xd8, 0xff])
}

/// Decodes a PNG picture of 8 or 16 bits from sRGB to linear; alpha is left out.
///
/// # Errors
/// [`DecodeError`] for a damaged or oversized file.
pub fn decode_png(bytes: &[u8], sink: &mut dyn TexelSink) -> Result<Description, DecodeError> {
    decode(bytes, ImageFormat::Png, "PNG", sink)
}

/// Decodes a JPEG picture from sRGB to linear.
///
/// # Errors
/// [`DecodeError`] for a damaged or oversized file.
pub fn decode_jpeg(bytes: &[u8], sink: &mut dyn TexelSink) -> Result<Description, DecodeError> {
    decode(bytes, ImageFormat::Jpeg, "JPEG", sink)
}

fn decode(
    bytes: &[u8],
    kind: ImageFormat,
    format: &'static str,
    sink: &mut dyn TexelSink,
) -> Result<Description, DecodeError> {
    let reader = || ImageReader::with_format(Cursor::new(bytes), kind);
    let (width, height) = reader().into_dimensions().map_err(|error| from_image(&error, format))?;
    if u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(DecodeError::too_large(
            format,
            format!("{width} x {height} texels (limit {MAX_TEXELS})"),
        ));
    }
    let mut reader = reader();
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| from_image(&error, format))?;
    if (picture.width(), picture.height()) != (width, height) {
        return Err(DecodeError::malformed(format, "its size changed while it was read"));
    }
    sink.begin(width, height, None);
    let mut row = Vec::with_capacity(width as usize);
    let mut hand_over = |y: u32, texels: &mut dyn Iterator<Item = Vec3>| {
        row.clear();
        row.extend(texels);
        sink.texels(0, y, &row);
    };
    match picture {
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            let decode = |code: u16| srgb_decode(f32::from(code) / 65535.0);
            for (y, pixels) in (0..).zip(picture.into_rgb16().rows()) {
                hand_over(y, &mut pixels.map(|pixel| Vec3::from_array(pixel.0.map(decode))));
            }
        }
        _ => {
            let table: [f32; 256] = std::array::from_fn(|code| srgb_decode(code as f32 / 255.0));
            let decode = |code: u8| table[usize::from(code)];
            for (y, pixels) in (0..).zip(picture.into_rgb8().rows()) {
                hand_over(y, &mut pixels.map(|pixel| Vec3::from_array(pixel.0.map(decode))));
            }
        }
    }
    Ok(Description { format, details: Vec::new(), warnings: Vec::new() })
}

fn from_image(error: &image::ImageError, format: &'static str) -> DecodeError {
    // Some of these messages span lines.
    let text = error.to_string().replace('\n', " ");
    match error {
        image::ImageError::Unsupported(_) => DecodeError::unsupported(format, text),
        image::ImageError::Limits(_) => DecodeError::too_large(format, text),
        _ => DecodeError::malformed(format, text),
    }
}

/// Display-linear values as 8-bit sRGB, three codes a texel: clipped to 0..1 and rounded to the nearest code; NaN becomes 0.
pub fn srgb8(image: &RgbImage) -> Vec<u8> {
    // A float converts to an integer by clipping, NaN to 0.
    let code = |linear: f32| (srgb_encode(linear.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
    image.texels().iter().flat_map(|texel| texel.to_array().map(code)).collect()
}

/// Encodes [`srgb8`] as PNG.
///
/// # Errors
/// The reason, for a picture without texels.
pub fn encode_png(image: &RgbImage) -> Result<Vec<u8>, String> {
    if image.texels().is_empty() {
        return Err("the picture is empty".to_owned());
    }
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&srgb8(image), image.width(), image.height(), ExtendedColorType::Rgb8)
        .map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// Encodes [`srgb8`] with an alpha channel as PNG, which has straight alpha: colours are not multiplied by it.
///
/// # Errors
/// The reason, for a picture without texels, and for another number of alphas.
pub fn encode_png_with_alpha(image: &RgbImage, alpha: &[f32]) -> Result<Vec<u8>, String> {
    if image.texels().is_empty() || image.texels().len() != alpha.len() {
        return Err(format!("the picture has {} texels and {} alphas", image.texels().len(), alpha.len()));
    }
    let colors = srgb8(image);
    let code = |alpha: f32| (alpha.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let texels = colors.chunks_exact(3).zip(alpha);
    let bytes: Vec<u8> = texels.flat_map(|(c, &alpha)| [c[0], c[1], c[2], code(alpha)]).collect();
    let mut file = Vec::new();
    image::codecs::png::PngEncoder::new(&mut file)
        .write_image(&bytes, image.width(), image.height(), ExtendedColorType::Rgba8)
        .map_err(|error| error.to_string())?;
    Ok(file)
}

/// Writes a picture as [`encode_png_with_alpha`] stores it, whole or not at all.
///
/// # Errors
/// [`ImageError::Write`] from the file system, [`ImageError::Encode`] as there.
pub fn write_png_with_alpha(path: &Path, image: &RgbImage, alpha: &[f32]) -> Result<(), ImageError> {
    let bytes = encode_png_with_alpha(image, alpha)
        .map_err(|reason| ImageError::Encode { path: path.to_owned(), reason })?;
    atomic::write(path, |writer| writer.write_all(&bytes))
        .map_err(|source| ImageError::Write { path: path.to_owned(), source })
}

/// Writes a picture as [`encode_png`] stores it, whole or not at all.
///
/// # Errors
/// [`ImageError::Write`] from the file system, [`ImageError::Encode`] for an empty picture.
pub fn write_png(path: &Path, image: &RgbImage) -> Result<(), ImageError> {
    let bytes = encode_png(image).map_err(|reason| ImageError::Encode { path: path.to_owned(), reason })?;
    atomic::write(path, |writer| writer.write_all(&bytes))
        .map_err(|source| ImageError::Write { path: path.to_owned(), source })
}
