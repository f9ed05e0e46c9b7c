use glam::Vec3;
use gnomon_picture::{LUMINANCE, RgbImage};

use crate::Mask;

/// How the metrics of displayed values (PSNR, FLIP) turn radiance into what a display shows. It is deliberately not a
/// film curve: every tone mapper that compresses highlights also hides errors there.
pub const DISPLAY_MAPPING: &str = "sRGB of clamp(radiance * 2^exposure, 0, 1)";

/// Luminance at which [`Exposure::Auto`] shows the reference's median: photographic mid grey.
const MID_GREY: f32 = 0.18;

/// How bright radiance is shown before it is clamped to the display's range.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Exposure {
    /// The median of the reference's positive luminances inside the mask is shown as mid grey, 0.18. For radiance
    /// without a natural scale; a reference that is black everywhere is shown at 0 stops.
    #[default]
    Auto,
    /// Radiance times `2^stops`. Pictures that are already display-referred (8-bit PNG) want 0.
    Stops(f32),
}

impl Exposure {
    /// The exposure in stops that this means for a reference picture.
    pub(crate) fn stops(self, reference: &RgbImage, mask: &Mask) -> f32 {
        match self {
            Self::Stops(stops) => stops,
            Self::Auto => {
                let mut luminances: Vec<f32> = mask
                    .indices()
                    .map(|index| reference.texels()[index].dot(LUMINANCE))
                    .filter(|&luminance| luminance > 0.0)
                    .collect();
                let middle = luminances.len() / 2;
                if luminances.is_empty() {
                    return 0.0;
                }
                let (_, median, _) = luminances.select_nth_unstable_by(middle, f32::total_cmp);
                (MID_GREY / *median).log2()
            }
        }
    }
}

/// Linear display light in `[0, 1]`: radiance times `2^stops`, clamped.
pub(crate) fn display_light(picture: &RgbImage, stops: f32) -> Vec<Vec3> {
    let scale = stops.exp2();
    picture.texels().iter().map(|&radiance| (radiance * scale).clamp(Vec3::ZERO, Vec3::ONE)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auto_exposure_shows_the_median_as_mid_grey() {
        let picture = RgbImage::from_fn(3, 1, |x, _| Vec3::splat([0.0, 8.0, 1000.0][x as usize]));
        let stops = Exposure::Auto.stops(&picture, &Mask::everything(3, 1));
        // The upper of the two positive values is their median here.
        assert!((1000.0 * stops.exp2() - 0.18).abs() < 1e-4, "{stops}");
        let black = RgbImage::filled(3, 1, Vec3::ZERO);
        assert_eq!(Exposure::Auto.stops(&black, &Mask::everything(3, 1)), 0.0);
        assert_eq!(Exposure::Stops(-1.5).stops(&picture, &Mask::everything(3, 1)), -1.5);
    }
}
