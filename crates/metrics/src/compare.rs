use glam::{DVec3, Vec3};
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::srgb_encode;
use serde::Serialize;

use crate::display::{DISPLAY_MAPPING, Exposure, display_light};
use crate::flip::{PIXELS_PER_DEGREE, flip_errors};
use crate::mask::Mask;
use crate::weighted::error_weighted_percentile_of_sorted;

/// Why two pictures cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MetricsError {
    /// The pictures, or the picture and the mask, are not equally large.
    #[error(
        "the {what} has {width} x {height} pixels but the reference has {reference_width} x {reference_height}; they must be equally large"
    )]
    SizeMismatch {
        /// `picture`, `mask` or what else is at fault.
        what: &'static str,
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// The reference's width.
        reference_width: u32,
        /// The reference's height.
        reference_height: u32,
    },
    /// A picture holds NaN or infinite values.
    #[error(
        "the {what} has {count} pixels that are NaN or infinite, the first at column {x}, row {y}; no error can be computed"
    )]
    NotFinite {
        /// `picture` or `reference`.
        what: &'static str,
        /// How many pixels.
        count: usize,
        /// Column of the first.
        x: u32,
        /// Row of the first.
        y: u32,
    },
    /// There is no pixel to compare.
    #[error("there is nothing to compare: {0}")]
    Empty(&'static str),
    /// The viewing condition of FLIP makes no sense.
    #[error("{0} pixels per degree is not a viewing condition; FLIP takes 1 to 1000 (a desk screen has 67)")]
    PixelsPerDegree(f32),
    /// The scale of a difference picture makes no sense.
    #[error("a difference picture cannot be scaled by {0}; the scale must be positive and finite")]
    DifferenceScale(f32),
}

/// How far a picture is from a reference, over the pixels of a mask.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Width of both pictures.
    pub width: u32,
    /// Height of both pictures.
    pub height: u32,
    /// Number of pixels compared: those inside the mask.
    pub pixels: usize,
    /// Mean radiance of the picture, channel by channel.
    pub mean: [f64; 3],
    /// Mean radiance of the reference, channel by channel.
    pub reference_mean: [f64; 3],
    /// Mean of picture minus reference over all pixels and channels, relative to the reference's mean: above 0 the
    /// picture is too bright.
    pub relative_bias: f64,
    /// Mean absolute difference over all pixels and channels, relative to the reference's mean.
    pub relative_mae: f64,
    /// Root of the mean squared difference over all pixels and channels, relative to the reference's mean.
    ///
    /// This and the other relative errors are 0 for equal pictures even if the reference is black; for another picture
    /// a black reference gives infinity (`null` in JSON).
    pub relative_rmse: f64,
    /// The pixel with the largest absolute difference in any channel.
    pub worst: WorstPixel,
    /// Exposure [stops] at which both pictures were displayed for the figures below.
    pub exposure: f32,
    /// How radiance became displayed values; always [`DISPLAY_MAPPING`].
    pub display: &'static str,
    /// Peak signal-to-noise ratio of the displayed sRGB values [dB]; infinity (`null` in JSON) for equal pictures.
    pub psnr: f64,
    /// FLIP of the displayed pictures.
    pub flip: FlipSummary,
}

/// Where a picture is most wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WorstPixel {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Largest absolute difference of its channels [radiance].
    pub difference: f32,
}

/// FLIP of the pixels inside the mask. Every value lies in `[0, 1]`, 0 being equal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FlipSummary {
    /// Pixels per degree of visual angle of the assumed viewer.
    pub pixels_per_degree: f32,
    /// Mean over pixels.
    pub mean: f64,
    /// Pixels up to this error carry a quarter of the whole error.
    pub weighted_first_quartile: f32,
    /// Pixels up to this error carry half of the whole error: the figure that tells a missing shadow from noise.
    pub weighted_median: f32,
    /// Pixels up to this error carry three quarters of the whole error.
    pub weighted_third_quartile: f32,
    /// Largest error.
    pub max: f32,
}

/// Compares two pictures of linear radiance over the pixels of `mask` (`None`: all of them), displayed at
/// [`Exposure::Auto`].
///
/// # Errors
/// See [`MetricsError`]: sizes differ, a pixel is not finite (inside the mask or not), no pixel is left.
pub fn compare(
    image: &RgbImage,
    reference: &RgbImage,
    mask: Option<&Mask>,
) -> Result<Comparison, MetricsError> {
    compare_displayed(image, reference, mask, Exposure::Auto)
}

/// The same with the displayed pictures exposed as given.
///
/// # Errors
/// As [`compare`].
pub fn compare_displayed(
    image: &RgbImage,
    reference: &RgbImage,
    mask: Option<&Mask>,
    exposure: Exposure,
) -> Result<Comparison, MetricsError> {
    check_pair(image, reference)?;
    let (width, height) = (reference.width(), reference.height());
    let everything;
    let mask = match mask {
        Some(mask) => mask,
        None => {
            everything = Mask::everything(width, height);
            &everything
        }
    };
    check_size("mask", (mask.width(), mask.height()), reference)?;
    let pixels = mask.indices().count();
    if pixels == 0 {
        return Err(MetricsError::Empty("no pixel lies inside the mask or region"));
    }

    let mut sum = Sums::default();
    let mut worst = (0, 0.0_f32);
    for index in mask.indices() {
        let (a, b) = (image.texels()[index], reference.texels()[index]);
        sum.add(a, b);
        let difference = (a - b).abs().max_element();
        if difference > worst.1 {
            worst = (index, difference);
        }
    }
    let count = pixels as f64;
    let exposure = exposure.stops(reference, mask);
    let (shown, reference_shown) = (display_light(image, exposure), display_light(reference, exposure));
    let errors = flip_errors(&shown, &reference_shown, width, PIXELS_PER_DEGREE);
    Ok(Comparison {
        width,
        height,
        pixels,
        mean: (sum.image / count).into(),
        reference_mean: (sum.reference / count).into(),
        relative_bias: sum.relative((sum.image - sum.reference).element_sum(), count),
        relative_mae: sum.relative(sum.absolute.element_sum(), count),
        relative_rmse: sum.relative((sum.squared.element_sum() * 3.0 * count).sqrt(), count),
        worst: WorstPixel { x: worst.0 as u32 % width, y: worst.0 as u32 / width, difference: worst.1 },
        exposure,
        display: DISPLAY_MAPPING,
        psnr: psnr(&shown, &reference_shown, mask),
        flip: summary(mask.indices().map(|index| errors[index]).collect()),
    })
}

/// The relative root mean square error alone, as [`compare`] has it: for a number in every frame.
///
/// # Errors
/// As [`compare`].
pub fn relative_rmse(image: &RgbImage, reference: &RgbImage) -> Result<f64, MetricsError> {
    check_pair(image, reference)?;
    let mut sum = Sums::default();
    for (a, b) in image.texels().iter().zip(reference.texels()) {
        sum.add(*a, *b);
    }
    let count = reference.texels().len() as f64;
    Ok(sum.relative((sum.squared.element_sum() * 3.0 * count).sqrt(), count))
}

/// Sums over pixels, in `f64` because a sun is 10^5 times the mean.
#[derive(Default)]
struct Sums {
    image: DVec3,
    reference: DVec3,
    absolute: DVec3,
    squared: DVec3,
}

impl Sums {
    fn add(&mut self, image: Vec3, reference: Vec3) {
        let (image, reference) = (image.as_dvec3(), reference.as_dvec3());
        self.image += image;
        self.reference += reference;
        self.absolute += (image - reference).abs();
        self.squared += (image - reference) * (image - reference);
    }

    /// A sum over `count` pixels and their channels relative to the same sum of the reference.
    fn relative(&self, error: f64, count: f64) -> f64 {
        // Through the means: both sums could be huge, and a mean of denormals is a black reference too.
        let (error, mean) = (error / (3.0 * count), self.reference.element_sum() / (3.0 * count));
        if error == 0.0 {
            0.0
        } else if mean > f64::from(f32::MIN_POSITIVE) {
            error / mean
        } else {
            f64::INFINITY.copysign(error)
        }
    }
}

fn psnr(image: &[Vec3], reference: &[Vec3], mask: &Mask) -> f64 {
    let encode = |light: Vec3| Vec3::from(light.to_array().map(srgb_encode)).as_dvec3();
    let (mut squared, mut count) = (0.0, 0.0);
    for index in mask.indices() {
        squared += (encode(image[index]) - encode(reference[index])).length_squared();
        count += 3.0;
    }
    // The peak of displayed values is 1.
    if squared == 0.0 { f64::INFINITY } else { -10.0 * (squared / count).log10() }
}

fn summary(mut errors: Vec<f32>) -> FlipSummary {
    errors.sort_unstable_by(f32::total_cmp);
    let percentile = |fraction| error_weighted_percentile_of_sorted(&errors, fraction);
    FlipSummary {
        pixels_per_degree: PIXELS_PER_DEGREE,
        mean: errors.iter().map(|&error| f64::from(error)).sum::<f64>() / errors.len() as f64,
        weighted_first_quartile: percentile(0.25),
        weighted_median: percentile(0.5),
        weighted_third_quartile: percentile(0.75),
        max: errors.last().copied().unwrap_or(0.0),
    }
}

/// Equally large, not empty, all finite.
pub(crate) fn check_pair(image: &RgbImage, reference: &RgbImage) -> Result<(), MetricsError> {
    check_size("picture", (image.width(), image.height()), reference)?;
    if reference.texels().is_empty() {
        return Err(MetricsError::Empty("the pictures have no pixels"));
    }
    check_finite("picture", image)?;
    check_finite("reference", reference)
}

pub(crate) fn check_size(
    what: &'static str,
    (width, height): (u32, u32),
    reference: &RgbImage,
) -> Result<(), MetricsError> {
    let (reference_width, reference_height) = (reference.width(), reference.height());
    if (width, height) == (reference_width, reference_height) {
        Ok(())
    } else {
        Err(MetricsError::SizeMismatch { what, width, height, reference_width, reference_height })
    }
}

pub(crate) fn check_finite(what: &'static str, picture: &RgbImage) -> Result<(), MetricsError> {
    let mut bad = picture.texels().iter().enumerate().filter(|(_, value)| !value.is_finite());
    match bad.next() {
        None => Ok(()),
        Some((first, _)) => Err(MetricsError::NotFinite {
            what,
            count: 1 + bad.count(),
            x: first as u32 % picture.width(),
            y: first as u32 / picture.width(),
        }),
    }
}
