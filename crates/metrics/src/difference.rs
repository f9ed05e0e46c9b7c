use glam::Vec3;
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::srgb_decode;

use crate::color_map::magma;
use crate::compare::{MetricsError, check_pair};
use crate::display::{Exposure, display_light};
use crate::flip::{PIXELS_PER_DEGREE, flip_errors};
use crate::mask::Mask;

/// A picture of where two pictures differ visibly: FLIP through the [`magma`] colour map, black where equal. Linear
/// display light, to be written as PNG without tone mapping.
///
/// # Errors
/// As [`crate::compare`].
pub fn flip_difference(
    image: &RgbImage,
    reference: &RgbImage,
    exposure: Exposure,
) -> Result<RgbImage, MetricsError> {
    check_pair(image, reference)?;
    let (width, height) = (reference.width(), reference.height());
    let stops = exposure.stops(reference, &Mask::everything(width, height));
    let errors =
        flip_errors(&display_light(image, stops), &display_light(reference, stops), width, PIXELS_PER_DEGREE);
    Ok(RgbImage::from_fn(width, height, |x, y| magma(errors[y as usize * width as usize + x as usize])))
}

/// A picture of which way two pictures differ: sRGB mid grey where equal, lighter where `image` is brighter, channel
/// by channel; a difference of `scale` [radiance] reaches white or black. Linear display light.
///
/// # Errors
/// As [`crate::compare`], and a `scale` that is not positive and finite.
pub fn signed_difference(
    image: &RgbImage,
    reference: &RgbImage,
    scale: f32,
) -> Result<RgbImage, MetricsError> {
    check_pair(image, reference)?;
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(MetricsError::DifferenceScale(scale));
    }
    Ok(RgbImage::from_fn(reference.width(), reference.height(), |x, y| {
        let difference = (image.get(x, y) - reference.get(x, y)) / scale;
        let encoded = (0.5 + 0.5 * difference).clamp(Vec3::ZERO, Vec3::ONE);
        Vec3::from(encoded.to_array().map(srgb_decode))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signed_difference_tells_the_direction() {
        let reference = RgbImage::filled(3, 1, Vec3::splat(2.0));
        let image = RgbImage::from_fn(3, 1, |x, _| Vec3::new([1.5, 2.0, 2.5][x as usize], 2.0, 2.0));
        let difference = signed_difference(&image, &reference, 0.5).unwrap();
        let middle = srgb_decode(0.5);
        assert_eq!(difference.get(0, 0), Vec3::new(0.0, middle, middle));
        assert_eq!(difference.get(1, 0), Vec3::splat(middle));
        assert_eq!(difference.get(2, 0).x, 1.0);
        assert!(signed_difference(&image, &reference, 0.0).is_err());
        assert!(signed_difference(&image, &reference, f32::NAN).is_err());
    }

    #[test]
    fn flip_difference_is_dark_where_equal_and_light_where_not() {
        let reference = RgbImage::filled(64, 16, Vec3::splat(0.2));
        let mut image = reference.clone();
        *image.get_mut(50, 8) = Vec3::splat(0.9);
        let difference = flip_difference(&image, &reference, Exposure::Stops(0.0)).unwrap();
        assert!(difference.get(5, 8).max_element() < 0.002, "{}", difference.get(5, 8));
        assert!(difference.get(50, 8).max_element() > 0.05);
    }
}
