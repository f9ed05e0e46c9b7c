//! Pictures of heights: PNG (8 and 16 bits), JPEG and WebP, whose codes count as they are, from 0 to 1; OpenEXR and Radiance, whose values
//! are heights in the material's unit. Of a picture in colour the mean of red, green and blue counts; alpha is left alone.

use std::io::Cursor;

use gnomon_scene::{HeightMap, Wrap};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use super::Budget;
use crate::error::Fault;

/// Largest side of a picture of heights.
const LARGEST_SIDE: u32 = 16_384;

/// Largest side of a map that is kept: what is larger is averaged, and says so.
const KEPT_SIDE: u32 = 4096;

/// What a decoder may take beside its texels [bytes].
const DECODER_BYTES: u64 = 1 << 24;

/// Decodes a picture of heights. `warn` is told of what was changed.
pub fn decode(
    bytes: &[u8],
    wrap: [Wrap; 2],
    budget: &mut Budget,
    mut warn: impl FnMut(String),
) -> Result<HeightMap, Fault> {
    let (width, height, values) = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => {
            codes(bytes, format, budget)?
        }
        _ => radiance(bytes, budget)?,
    };
    let map = HeightMap::new(width, height, values, wrap).map_err(Fault::Invalid)?;
    if width.max(height) <= KEPT_SIDE {
        return Ok(map);
    }
    let kept = map.at_most(KEPT_SIDE);
    let [w, h] = kept.size();
    warn(format!("heights of {width} x {height} texels are averaged to {w} x {h}"));
    Ok(kept)
}

type Values = (u32, u32, Vec<f32>);

/// Checks a size, and claims what its texels take while they are read.
fn claim(width: u32, height: u32, bytes_each: usize, budget: &mut Budget) -> Result<usize, Fault> {
    if width == 0 || height == 0 || width > LARGEST_SIDE || height > LARGEST_SIDE {
        let message = format!(
            "a picture of heights of {width} x {height} texels (1 to {LARGEST_SIDE} a side are allowed)"
        );
        return Err(Fault::Unsupported(message));
    }
    let count = width as usize * height as usize;
    budget.take(count, size_of::<f32>() + bytes_each)?;
    Ok(count)
}

fn codes(bytes: &[u8], format: ImageFormat, budget: &mut Budget) -> Result<Values, Fault> {
    let damaged = |error: image::ImageError| Fault::invalid(error.to_string());
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(damaged)?;
    let count = claim(width, height, 8, budget)?;
    let mut reader = reader();
    let mut limits = Limits::default();
    limits.max_alloc = Some(DECODER_BYTES + 16 * count as u64);
    reader.limits(limits);
    let decoded = reader.decode();
    budget.give_back(count, 8);
    let mean8 = |[r, g, b]: [u8; 3]| (f32::from(r) + f32::from(g) + f32::from(b)) / (3.0 * 255.0);
    let mean16 = |[r, g, b]: [u16; 3]| (f32::from(r) + f32::from(g) + f32::from(b)) / (3.0 * 65535.0);
    let values = match decoded.map_err(damaged)? {
        DynamicImage::ImageLuma8(picture) => picture.pixels().map(|p| f32::from(p.0[0]) / 255.0).collect(),
        DynamicImage::ImageLuma16(picture) => picture.pixels().map(|p| f32::from(p.0[0]) / 65535.0).collect(),
        picture @ (DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_)) => picture.into_rgb16().pixels().map(|p| mean16(p.0)).collect(),
        picture => picture.into_rgb8().pixels().map(|p| mean8(p.0)).collect(),
    };
    Ok((width, height, values))
}

fn radiance(bytes: &[u8], budget: &mut Budget) -> Result<Values, Fault> {
    if gnomon_picture::format_of(bytes).is_none() {
        return Err(Fault::unsupported(
            "heights are pictures: PNG, JPEG, WebP, OpenEXR or Radiance, told apart by content",
        ));
    }
    let picture = gnomon_picture::decode(bytes).map_err(|error| Fault::invalid(error.to_string()))?.image;
    let (width, height) = (picture.width(), picture.height());
    claim(width, height, 0, budget)?;
    Ok((width, height, picture.texels().iter().map(|texel| texel.element_sum() / 3.0).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(color: image::ExtendedColorType, size: [u32; 2], texels: &[u8]) -> Vec<u8> {
        use image::ImageEncoder;
        let mut bytes = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        encoder.write_image(texels, size[0], size[1], color).unwrap();
        bytes
    }

    fn read(bytes: &[u8]) -> Result<(HeightMap, Vec<String>), String> {
        let mut warnings = Vec::new();
        let map = decode(bytes, [Wrap::Repeat; 2], &mut Budget::new(1 << 30), |w| warnings.push(w));
        map.map(|map| (map, warnings)).map_err(|fault| fault.at(std::path::Path::new("h")).to_string())
    }

    #[test]
    fn codes_count_as_they_are_and_alpha_does_not() {
        let at = |bytes: &[u8], x: i64| read(bytes).unwrap().0.texel(x, 0);
        assert_eq!(at(&png(image::ExtendedColorType::L8, [2, 1], &[51, 255]), 0), 0.2);
        let sixteen: Vec<u8> = [13107u16, 1].iter().flat_map(|v| v.to_ne_bytes()).collect();
        let sixteen = png(image::ExtendedColorType::L16, [2, 1], &sixteen);
        assert_eq!((at(&sixteen, 0), at(&sixteen, 1)), (0.2, 1.0 / 65535.0));
        let color = png(image::ExtendedColorType::Rgba8, [1, 1], &[0, 51, 102, 0]);
        assert!((at(&color, 0) - 0.2).abs() < 1e-6);
        let grey = png(image::ExtendedColorType::La8, [1, 1], &[51, 7]);
        assert!((at(&grey, 0) - 0.2).abs() < 1e-6);
    }

    #[test]
    fn wide_pictures_are_averaged_and_wrong_kinds_refused() {
        let wide = png(image::ExtendedColorType::L8, [16_384, 2], &vec![102; 2 * 16_384]);
        let (map, warnings) = read(&wide).unwrap();
        assert_eq!((map.size(), map.texel(5, 1)), ([4096, 2], 0.4));
        assert_eq!(warnings, ["heights of 16384 x 2 texels are averaged to 4096 x 2"]);
        let wider = png(image::ExtendedColorType::L8, [16_385, 1], &vec![0; 16_385]);
        assert!(read(&wider).unwrap_err().contains("16385 x 1"));
        assert!(read(b"no picture").unwrap_err().contains("heights are pictures"));
    }
}
