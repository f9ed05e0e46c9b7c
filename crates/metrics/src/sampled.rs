//! The error of a picture from a few pixels of a noisy reference.

use std::fmt;

use glam::{DVec3, UVec2, Vec3};
use gnomon_picture::RgbImage;
use serde::Serialize;

use crate::compare::{MetricsError, check_finite};

/// Share of the pixels that are drawn without regard to contrast: it bounds how much any single pixel can weigh, and finds shadows that the picture
/// does not have.
const UNIFORM_SHARE: f64 = 0.5;

/// Pixels by which the error of a picture is estimated.
///
/// Errors are large along the edges of shadows and objects and small elsewhere. Pixels are therefore drawn in proportion to a mixture of a constant
/// and the root of the picture's own contrast, one from each of as many stretches of equal weight along a Z-order curve, which spreads them over the
/// picture. Weights of one over the probability keep the estimate unbiased whatever the contrast says.
#[derive(Clone, Debug)]
pub struct PixelSample {
    pixels: Vec<SampledPixel>,
    /// Mean over the picture's pixels and channels.
    mean: f64,
}

#[derive(Clone, Copy, Debug)]
struct SampledPixel {
    place: UVec2,
    value: DVec3,
    /// The mean over all pixels is the mean over drawn ones times this.
    weight: f64,
}

/// An estimate of [`crate::relative_rmse`] over a whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SampledError {
    /// The root of the mean squared difference over pixels and channels, relative to the reference's mean; 0 where noise makes the estimated
    /// square negative.
    pub relative_rmse: f64,
    /// One standard error of it.
    pub uncertainty: f64,
    /// How many pixels were drawn.
    pub pixels: usize,
}

impl PixelSample {
    /// Draws pixels; a pixel can be drawn twice. The same picture, count and seed give the same pixels.
    ///
    /// # Errors
    /// [`MetricsError::Empty`] for no pixels, [`MetricsError::NotFinite`].
    pub fn of(picture: &RgbImage, count: usize, seed: u64) -> Result<Self, MetricsError> {
        if picture.texels().is_empty() || count == 0 {
            return Err(MetricsError::Empty("no pixel is drawn"));
        }
        check_finite("picture", picture)?;
        let order = z_order(picture.width(), picture.height());
        let importance = importance(picture);
        let total: f64 = importance.iter().sum();
        let all = order.len() as f64;
        let mut pixels = Vec::with_capacity(count);
        let mut places = order.iter().copied();
        let (mut place, mut end) = (0, 0.0);
        for index in 0..count {
            let target = total * (index as f64 + uniform(seed, index as u64)) / count as f64;
            while end <= target {
                // Rounding may leave the end of the curve a little below the total.
                let Some(next) = places.next() else { break };
                (place, end) = (next, end + importance[next]);
            }
            pixels.push(SampledPixel {
                place: UVec2::new(place as u32 % picture.width(), place as u32 / picture.width()),
                value: picture.texels()[place].as_dvec3(),
                weight: total / (all * importance[place]),
            });
        }
        let mean = picture.texels().iter().map(|&value| channel_mean(value.as_dvec3())).sum::<f64>() / all;
        Ok(Self { pixels, mean })
    }

    /// Where they are, column and row.
    pub fn places(&self) -> Vec<UVec2> {
        self.pixels.iter().map(|pixel| pixel.place).collect()
    }

    /// The picture's error, given two estimates of the reference at each pixel that are independent and unbiased: the noise of neither counts as
    /// error, since `(x - r1) (x - r2)` has the mean of the squared difference.
    ///
    /// The standard error of squared difference over squared mean follows from the weighted pixels (delta method for the ratio): from how much each
    /// differs from the next one on the curve, as stretches leave only what varies inside them. What varies from stretch to stretch makes it a little
    /// too large. Of the root, half the longer side of the interval that two standard errors leave is told: that is the delta method where the error
    /// is well above its uncertainty, and stays finite where it is not. Where `traced` has fewer pairs than there are pixels, only those count.
    pub fn error(&self, traced: &[[DVec3; 2]]) -> SampledError {
        let pairs: Vec<_> = self.pixels.iter().zip(traced).collect();
        let count = pairs.len() as f64;
        // The picture's mean is known: only how far the reference's is from it has to be estimated.
        let terms = pairs.iter().map(|(pixel, [first, second])| {
            let (a, b) = (pixel.value - first, pixel.value - second);
            [pixel.weight * channel_mean(a * b), -0.5 * pixel.weight * channel_mean(a + b)]
        });
        let terms: Vec<[f64; 2]> = terms.collect();
        let [square, shift] = [0, 1].map(|k| terms.iter().map(|term| term[k]).sum::<f64>() / count);
        let mean = self.mean + shift;
        let pixels = pairs.len();
        if terms.iter().all(|&term| term == [0.0, 0.0]) {
            return SampledError { relative_rmse: 0.0, uncertainty: 0.0, pixels };
        }
        if pixels < 2 || mean <= 1e-9 * self.mean {
            // A single pixel has no spread, and nothing is relative to a black reference.
            return SampledError { relative_rmse: f64::INFINITY, uncertainty: f64::INFINITY, pixels };
        }
        let ratio = square / (mean * mean);
        let slope = |term: &[f64; 2]| ((term[0] - square) / mean - 2.0 * ratio * (term[1] - shift)) / mean;
        let steps = terms.windows(2).map(|pair| slope(&pair[1]) - slope(&pair[0]));
        let spread = steps.map(|step| 0.5 * step * step).sum::<f64>() / (count - 1.0);
        let two = 2.0 * (spread / count).sqrt();
        let ratio = ratio.max(0.0);
        let relative_rmse = ratio.sqrt();
        let (above, below) =
            ((ratio + two).sqrt() - relative_rmse, relative_rmse - (ratio - two).max(0.0).sqrt());
        SampledError { relative_rmse, uncertainty: 0.5 * above.max(below), pixels }
    }
}

/// One line for people.
impl fmt::Display for SampledError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [error, uncertainty] = [self.relative_rmse, self.uncertainty].map(|share| 100.0 * share);
        write!(f, "{error:.1} % off ray-traced truth, +- {uncertainty:.1} % ({} pixels)", self.pixels)
    }
}

fn channel_mean(value: DVec3) -> f64 {
    value.element_sum() / 3.0
}

/// What pixels are drawn in proportion to; the mean is about 1. Of the contrast the root counts, so that a sun in the picture does not get all of them.
fn importance(picture: &RgbImage) -> Vec<f64> {
    let (width, height) = (picture.width(), picture.height());
    let mut contrasts = Vec::with_capacity(picture.texels().len());
    for y in 0..height {
        for x in 0..width {
            let here = picture.get(x, y);
            let columns = [x.saturating_sub(1), (x + 1).min(width - 1)].map(|x| picture.get(x, y));
            let rows = [y.saturating_sub(1), (y + 1).min(height - 1)].map(|y| picture.get(x, y));
            let steps = columns.into_iter().chain(rows).map(|there: Vec3| (there - here).abs().element_sum());
            contrasts.push(f64::from(steps.fold(0.0, f32::max)).sqrt());
        }
    }
    let mean = contrasts.iter().sum::<f64>() / contrasts.len() as f64;
    let scale = if mean > 0.0 { (1.0 - UNIFORM_SHARE) / mean } else { 0.0 };
    contrasts.iter().map(|contrast| UNIFORM_SHARE + scale * contrast).collect()
}

/// Indices of all pixels along a curve whose stretches are compact.
fn z_order(width: u32, height: u32) -> Vec<usize> {
    let spread =
        |value: u32| (0..32).fold(0_u64, |code, bit| code | (u64::from(value) >> bit & 1) << (2 * bit));
    let columns: Vec<u64> = (0..width).map(spread).collect();
    let mut codes = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        let row = spread(y) << 1;
        codes.extend(
            columns.iter().enumerate().map(|(x, &column)| (row | column, y as usize * width as usize + x)),
        );
    }
    codes.sort_unstable();
    codes.into_iter().map(|(_, index)| index).collect()
}

/// The `index`-th number of a seed, in `[0, 1)` (SplitMix64).
fn uniform(seed: u64, index: u64) -> f64 {
    let mix = |z: u64| {
        let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    };
    let z = mix(mix(seed).wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    (z >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relative_rmse;

    /// A dark square with soft edges, and the same a little moved: errors at its edges only, beside a faint one everywhere.
    fn pictures() -> (RgbImage, RgbImage) {
        let square = |shift: f32| {
            RgbImage::from_fn(96, 64, |x, y| {
                let edge = |t: f32| (0.4 * t).clamp(0.0, 1.0);
                let (x, y) = (x as f32 - shift, y as f32);
                let inside = edge(x - 20.0) * edge(60.0 - x) * edge(y - 10.0) * edge(40.0 - y);
                Vec3::new(1.0, 0.8, 0.5) * (1.0 - 0.9 * inside)
            })
        };
        let mut picture = square(0.4);
        picture.texels_mut().iter_mut().for_each(|texel| *texel *= 1.005);
        (picture, square(0.0))
    }

    /// Two noisy views of a picture at the places of a sample, 3 % of noise in each.
    fn noisy(truth: &RgbImage, sample: &PixelSample, seed: u64) -> Vec<[DVec3; 2]> {
        let views = sample.places().into_iter().enumerate().map(|(index, place)| {
            [0, 1].map(|view| {
                let noise = uniform(seed, 2 * index as u64 + view) - 0.5;
                truth.get(place.x, place.y).as_dvec3() * (1.0 + 0.1 * noise)
            })
        });
        views.collect()
    }

    #[test]
    fn the_estimate_is_unbiased_and_knows_its_uncertainty() {
        let (picture, truth) = pictures();
        let expected = relative_rmse(&picture, &truth).unwrap();
        let errors: Vec<SampledError> = (0..400)
            .map(|seed| {
                let sample = PixelSample::of(&picture, 512, seed).unwrap();
                sample.error(&noisy(&truth, &sample, 1_000_000 + seed))
            })
            .collect();
        let count = errors.len() as f64;
        // Squares are unbiased; a root is not.
        let square = errors.iter().map(|error| error.relative_rmse.powi(2)).sum::<f64>() / count;
        let spread = errors.iter().map(|error| (error.relative_rmse.powi(2) - square).powi(2)).sum::<f64>();
        let tolerance = 4.0 * (spread / count / count).sqrt();
        assert!(
            (square - expected * expected).abs() < tolerance,
            "{square} {} {tolerance}",
            expected.powi(2)
        );
        let inside = errors
            .iter()
            .filter(|error| (error.relative_rmse - expected).abs() <= 2.0 * error.uncertainty)
            .count();
        assert!(inside >= 360, "{inside} of {count}");
        let uncertainty = errors.iter().map(|error| error.uncertainty).sum::<f64>() / count;
        assert!(uncertainty < 0.25 * expected, "it says little: {uncertainty} of {expected}");
    }

    #[test]
    fn noise_alone_is_no_error_and_its_uncertainty_is_told() {
        let (_, truth) = pictures();
        let errors: Vec<SampledError> = (0..200)
            .map(|seed| {
                let sample = PixelSample::of(&truth, 256, seed).unwrap();
                sample.error(&noisy(&truth, &sample, 5_000_000 + seed))
            })
            .collect();
        let is_none = |error: &&SampledError| error.relative_rmse <= 2.0 * error.uncertainty;
        assert!(errors.iter().filter(is_none).count() >= 180, "{errors:?}");
        assert!(errors.iter().all(|error| error.uncertainty > 0.0 && error.uncertainty < 0.02), "{errors:?}");
        assert!(errors.iter().any(|error| error.relative_rmse == 0.0), "half of the squares are negative");
        let sample = PixelSample::of(&truth, 256, 0).unwrap();
        let exact: Vec<_> = sample.places().iter().map(|at| [truth.get(at.x, at.y).as_dvec3(); 2]).collect();
        let none = SampledError { relative_rmse: 0.0, uncertainty: 0.0, pixels: 256 };
        assert_eq!(sample.error(&exact), none);
    }

    #[test]
    fn pixels_follow_contrast_and_cover_the_picture() {
        let picture = RgbImage::from_fn(64, 64, |x, _| Vec3::splat(if x < 40 { 1.0 } else { 0.1 }));
        let sample = PixelSample::of(&picture, 256, 3).unwrap();
        let places = sample.places();
        let at_edge = places.iter().filter(|place| (39..=40).contains(&place.x)).count();
        assert!((128..240).contains(&at_edge), "{at_edge}");
        for corner in [UVec2::ZERO, UVec2::new(32, 0), UVec2::new(0, 32), UVec2::new(32, 32)] {
            let inside = |place: &&UVec2| (**place / 32) * 32 == corner && !(39..=40).contains(&place.x);
            assert!(places.iter().filter(inside).count() >= 12, "{corner}");
        }
        assert_eq!(places, PixelSample::of(&picture, 256, 3).unwrap().places());
        assert_ne!(places, PixelSample::of(&picture, 256, 4).unwrap().places());
        // The weights sum to the number of pixels, up to the luck of the draw.
        let total: f64 = sample.pixels.iter().map(|pixel| pixel.weight).sum();
        assert!((total / 256.0 - 1.0).abs() < 0.1, "{total}");
    }

    #[test]
    fn what_cannot_be_measured_is_said() {
        let black = RgbImage::filled(4, 4, Vec3::ZERO);
        let sample = PixelSample::of(&black, 20, 0).unwrap();
        assert_eq!(sample.error(&[[DVec3::ZERO; 2]; 20]).relative_rmse, 0.0);
        let light = RgbImage::filled(4, 4, Vec3::ONE);
        let sample = PixelSample::of(&light, 20, 0).unwrap();
        assert_eq!(sample.error(&[[DVec3::ZERO; 2]; 20]).relative_rmse, f64::INFINITY);
        let mut broken = light.clone();
        *broken.get_mut(1, 2) = Vec3::NAN;
        let error = PixelSample::of(&broken, 20, 0).unwrap_err();
        assert!(matches!(error, MetricsError::NotFinite { x: 1, y: 2, .. }), "{error}");
        assert!(PixelSample::of(&light, 0, 0).is_err());
    }
}
