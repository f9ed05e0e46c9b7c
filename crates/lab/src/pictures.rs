//! Small things done to pictures.

use gnomon_metrics::{Comparison, Mask, Region, compare, signed_difference};
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::{ToneMapping, tone_mapped};

use crate::LabError;

/// Mean over pixels and channels.
pub(crate) fn channel_mean(picture: &RgbImage) -> f64 {
    let sum: f64 = picture.texels().iter().map(|texel| texel.as_dvec3().element_sum()).sum();
    sum / (3.0 * picture.texels().len().max(1) as f64)
}

/// The box-filtered picture, where its size is a whole multiple of the one wanted.
pub(crate) fn shrunk_to(picture: &RgbImage, width: u32, height: u32) -> Option<RgbImage> {
    let factor = picture.width() / width.max(1);
    if factor == 0 || (picture.width(), picture.height()) != (factor * width, factor * height) {
        return None;
    }
    let texel = |x: u32, y: u32| {
        let inside = (0..factor).flat_map(|j| (0..factor).map(move |i| (factor * x + i, factor * y + j)));
        inside.map(|(x, y)| picture.get(x, y)).sum::<glam::Vec3>() / (factor * factor) as f32
    };
    Some(RgbImage::from_fn(width, height, texel))
}

/// The part of a picture inside a region; what reaches past the edge is cut.
pub(crate) fn cropped(picture: &RgbImage, region: &Region) -> RgbImage {
    let x = region.x.min(picture.width());
    let y = region.y.min(picture.height());
    let (width, height) = (region.width.min(picture.width() - x), region.height.min(picture.height() - y));
    RgbImage::from_fn(width, height, |i, j| picture.get(x + i, y + j))
}

/// Radiance as a display shows it, one stop above `stops`: metrics put the median at 0.18, which is dim for the eye.
pub(crate) fn shown(radiance: &RgbImage, stops: f32) -> RgbImage {
    tone_mapped(radiance, ToneMapping::default(), stops + 1.0)
}

/// Picture minus truth on mid grey; half the truth's mean reaches white or black.
pub(crate) fn difference(picture: &RgbImage, truth: &RgbImage) -> Result<RgbImage, LabError> {
    let scale = (0.5 * channel_mean(truth)) as f32;
    Ok(signed_difference(picture, truth, scale.max(f32::MIN_POSITIVE))?)
}

/// How far the picture is from the truth inside a region.
pub(crate) fn compare_within(
    picture: &RgbImage,
    truth: &RgbImage,
    region: &Region,
) -> Result<Comparison, LabError> {
    let mask = Mask::everything(truth.width(), truth.height()).within(region);
    Ok(compare(picture, truth, Some(&mask))?)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn only_whole_multiples_shrink() {
        let picture = RgbImage::from_fn(4, 2, |x, y| Vec3::splat((x + 4 * y) as f32));
        let half = shrunk_to(&picture, 2, 1).unwrap();
        assert_eq!((half.get(0, 0).x, half.get(1, 0).x), (2.5, 4.5));
        assert_eq!(shrunk_to(&picture, 4, 2).unwrap(), picture);
        for (width, height) in [(3, 2), (2, 2), (8, 4), (0, 0)] {
            assert!(shrunk_to(&picture, width, height).is_none(), "{width} x {height}");
        }
    }

    #[test]
    fn crops_are_cut_at_the_edge() {
        let picture = RgbImage::from_fn(4, 4, |x, y| Vec3::splat((x + 4 * y) as f32));
        let region = |x, y| Region { name: String::new(), x, y, width: 2, height: 9 };
        let part = cropped(&picture, &region(3, 2));
        assert_eq!((part.width(), part.height(), part.get(0, 1).x), (1, 2, 15.0));
        assert_eq!(cropped(&picture, &region(9, 9)).texels().len(), 0);
    }
}
