//! LDR-FLIP: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild, "FLIP: A Difference Evaluator for
//! Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020. Section and equation numbers are theirs.

use std::f32::consts::{FRAC_1_SQRT_2, PI};

use glam::{Mat3, Vec2, Vec3};
use gnomon_picture::RgbImage;
use rayon::prelude::*;

use crate::{MetricsError, compare::check_pair, display::display_light};

/// Pixels per degree of visual angle of the default viewer: 0.7 m before a screen 0.7 m wide with 3840 pixels
/// (section 4.1).
pub const PIXELS_PER_DEGREE: f32 = 3840.0 * PI / 180.0;

/// FLIP error of every pixel, in `[0, 1]`, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` errors.
    pub errors: Vec<f32>,
}

/// FLIP between two equally large pictures of linear display light (what 8-bit sRGB pictures decode to), clamped to
/// `[0, 1]`.
///
/// # Errors
/// The sizes differ, a picture has no pixels or one that is not finite, or `pixels_per_degree` is not in `[1, 1000]`.
pub fn flip(image: &RgbImage, reference: &RgbImage, pixels_per_degree: f32) -> Result<FlipMap, MetricsError> {
    check_pair(image, reference)?;
    if !(1.0..=1000.0).contains(&pixels_per_degree) {
        return Err(MetricsError::PixelsPerDegree(pixels_per_degree));
    }
    let (width, height) = (reference.width(), reference.height());
    let errors =
        flip_errors(&display_light(image, 0.0), &display_light(reference, 0.0), width, pixels_per_degree);
    Ok(FlipMap { width, height, errors })
}

/// The same for checked pictures whose components all lie in `[0, 1]`.
pub(crate) fn flip_errors(
    image: &[Vec3],
    reference: &[Vec3],
    width: u32,
    pixels_per_degree: f32,
) -> Vec<f32> {
    let filters = Filters::new(pixels_per_degree);
    let [(image_colors, image_features), (reference_colors, reference_features)] =
        [image, reference].map(|pixels| {
            let opponent: Vec<Vec3> = pixels.iter().map(|&rgb| opponent_from_linear(rgb)).collect();
            (filters.perceived(&opponent, width as usize), filters.features(&opponent, width as usize))
        });
    let largest = largest_color_difference();
    image_colors
        .into_par_iter()
        .zip(reference_colors)
        .zip(image_features.into_par_iter().zip(reference_features))
        .map(|((a, b), (features_a, features_b))| {
            let color = compressed_color_difference(hyab(a, b), largest);
            color.powf(1.0 - feature_difference(features_a, features_b))
        })
        .collect()
}

/// One value for every window of `2 radius + 1` values along the rows, edge values repeated.
fn filter_rows<T: Copy + Sync, O: Send>(
    input: &[T],
    width: usize,
    radius: usize,
    window: impl Fn(&[T]) -> O + Sync,
) -> Vec<O> {
    input
        .par_chunks_exact(width)
        .flat_map_iter(|row| {
            let edge = |value| std::iter::repeat_n(value, radius);
            let padded: Vec<T> =
                edge(row[0]).chain(row.iter().copied()).chain(edge(row[width - 1])).collect();
            padded.windows(2 * radius + 1).map(&window).collect::<Vec<O>>()
        })
        .collect()
}

/// The same along the columns.
fn filter_columns<T: Copy + Sync, O: Copy + Send + Sync>(
    input: &[T],
    width: usize,
    radius: usize,
    window: impl Fn(&[T]) -> O + Sync,
) -> Vec<O> {
    let height = input.len() / width;
    transposed(&filter_rows(&transposed(input, width), height, radius, window), height)
}

fn transposed<T: Copy>(input: &[T], width: usize) -> Vec<T> {
    let height = input.len() / width;
    (0..width).flat_map(|x| (0..height).map(move |y| input[y * width + x])).collect()
}

/// Edge and point gradients of the luminance (section 4.2).
#[derive(Clone, Copy)]
struct Features {
    edge: Vec2,
    point: Vec2,
}

struct Filters {
    /// Contrast sensitivity: first Gaussian of the three opponent channels, one dimension of it (the second is alike).
    sensitivity: Vec<Vec3>,
    /// Second Gaussian of the blue-yellow channel, the only one that has two.
    sensitivity_second: Vec<f32>,
    /// Reciprocal sum of the two-dimensional kernels.
    sensitivity_scale: Vec3,
    /// Gaussian, its first and its second derivative.
    feature: Vec<Vec3>,
}

impl Filters {
    fn new(pixels_per_degree: f32) -> Self {
        // Table 1: a1, b1 of the three channels; a2, b2 of the third.
        let a = Vec3::new(1.0, 1.0, 34.1);
        let b = Vec3::new(0.0047, 0.0053, 0.04);
        let (a_second, b_second) = (13.5_f32, 0.025_f32);
        let radius = (3.0 * (b.z / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        // Equation 5. The root of the weight goes to each dimension, so that their product carries it whole.
        let gaussian = |a: f32, b: f32, degrees: f32| {
            (a * (PI / b).sqrt()).sqrt() * (-PI * PI * degrees * degrees / b).exp()
        };
        let degrees = |tap: i32| tap as f32 / pixels_per_degree;
        let sensitivity: Vec<Vec3> = (-radius..=radius)
            .map(|tap| {
                let degrees = degrees(tap);
                Vec3::new(
                    gaussian(a.x, b.x, degrees),
                    gaussian(a.y, b.y, degrees),
                    gaussian(a.z, b.z, degrees),
                )
            })
            .collect();
        let sensitivity_second: Vec<f32> =
            (-radius..=radius).map(|tap| gaussian(a_second, b_second, degrees(tap))).collect();
        let sum: Vec3 = sensitivity.iter().sum();
        let sum_second: f32 = sensitivity_second.iter().sum();
        let sensitivity_scale = (sum * sum + Vec3::Z * sum_second * sum_second).recip();

        // Section 4.2: the feature detector is 0.082 degrees wide.
        let sigma = 0.5 * 0.082 * pixels_per_degree;
        let radius = (3.0 * sigma).ceil() as i32;
        let mut feature: Vec<Vec3> = (-radius..=radius)
            .map(|tap| {
                let x = tap as f32;
                let g = (-x * x / (2.0 * sigma * sigma)).exp();
                Vec3::new(g, -x * g, (x * x / (sigma * sigma) - 1.0) * g)
            })
            .collect();
        // Positive weights sum to 1, negative ones to -1.
        let positive: Vec3 = feature.iter().map(|weight| weight.max(Vec3::ZERO)).sum();
        let negative: Vec3 = feature.iter().map(|weight| (-*weight).max(Vec3::ZERO)).sum();
        for weight in &mut feature {
            let sum = Vec3::select(weight.cmplt(Vec3::ZERO), negative, positive);
            *weight /= sum;
        }
        Self { sensitivity, sensitivity_second, sensitivity_scale, feature }
    }

    /// What the viewer sees of a picture: contrast-sensitivity filter (section 4.1.1), then the perceptually uniform
    /// colour space with Hunt adjustment (section 4.1.2).
    fn perceived(&self, opponent: &[Vec3], width: usize) -> Vec<Vec3> {
        let radius = self.sensitivity.len() / 2;
        let weights = || self.sensitivity.iter().zip(&self.sensitivity_second);
        let across = filter_rows(opponent, width, radius, |window| {
            window.iter().zip(weights()).fold(
                (Vec3::ZERO, 0.0),
                |(first, second), (value, (weight, weight_second))| {
                    (first + *weight * *value, second + weight_second * value.z)
                },
            )
        });
        let linear_from_xyz = XYZ_FROM_LINEAR.inverse();
        filter_columns(&across, width, radius, |window| {
            let filtered = window.iter().zip(weights()).fold(
                Vec3::ZERO,
                |sum, (&(first, second), (weight, weight_second))| {
                    sum + *weight * first + Vec3::Z * (weight_second * second)
                },
            );
            let linear = linear_from_xyz * xyz_from_opponent(filtered * self.sensitivity_scale);
            hunt_lab_from_linear(linear.clamp(Vec3::ZERO, Vec3::ONE))
        })
    }

    fn features(&self, opponent: &[Vec3], width: usize) -> Vec<Features> {
        let radius = self.feature.len() / 2;
        // The achromatic channel, back in 0..1.
        let luminance: Vec<f32> = opponent.iter().map(|value| (value.x + 16.0) / 116.0).collect();
        let across = filter_rows(&luminance, width, radius, |window| {
            window.iter().zip(&self.feature).map(|(&value, &weight)| weight * value).sum::<Vec3>()
        });
        filter_columns(&across, width, radius, |window| {
            let mut features = Features { edge: Vec2::ZERO, point: Vec2::ZERO };
            for (across, weight) in window.iter().zip(&self.feature) {
                features.edge += Vec2::new(weight.x * across.y, weight.y * across.x);
                features.point += Vec2::new(weight.x * across.z, weight.z * across.x);
            }
            features
        })
    }
}

/// Equation 11: the stronger of the edge and point differences, sharpened.
fn feature_difference(a: Features, b: Features) -> f32 {
    let edge = (a.edge.length() - b.edge.length()).abs();
    let point = (a.point.length() - b.point.length()).abs();
    (FRAC_1_SQRT_2 * edge.max(point)).sqrt()
}

/// Equation 8: distance that stays meaningful for large colour differences.
fn hyab(a: Vec3, b: Vec3) -> f32 {
    let difference = a - b;
    difference.x.abs() + Vec2::new(difference.y, difference.z).length()
}

/// Exponent of section 4.1.3.
const COLOR_EXPONENT: f32 = 0.7;

/// The largest colour difference of the sRGB gamut, green to blue, after the exponent.
fn largest_color_difference() -> f32 {
    hyab(hunt_lab_from_linear(Vec3::Y), hunt_lab_from_linear(Vec3::Z)).powf(COLOR_EXPONENT)
}

/// Section 4.1.3: differences up to 0.4 of the largest take 0.95 of the range, the rest is compressed.
fn compressed_color_difference(hyab: f32, largest: f32) -> f32 {
    const KNEE: f32 = 0.4;
    const KNEE_VALUE: f32 = 0.95;
    let difference = hyab.powf(COLOR_EXPONENT);
    let knee = KNEE * largest;
    if difference < knee {
        KNEE_VALUE / knee * difference
    } else {
        // Rounding can carry the sum an ulp past 1.
        (KNEE_VALUE + (1.0 - KNEE_VALUE) * (difference - knee) / (largest - knee)).min(1.0)
    }
}

/// sRGB primaries under D65, as the exact ratios that the reference implementation uses.
const XYZ_FROM_LINEAR: Mat3 = Mat3::from_cols(
    Vec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
    Vec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
    Vec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
);

/// XYZ relative to the white of the display.
fn relative_xyz(linear: Vec3) -> Vec3 {
    XYZ_FROM_LINEAR * linear / (XYZ_FROM_LINEAR * Vec3::ONE)
}

/// YCxCz, the linear cousin of L*a*b* (equation 2).
fn opponent_from_linear(linear: Vec3) -> Vec3 {
    let xyz = relative_xyz(linear);
    Vec3::new(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z))
}

fn xyz_from_opponent(opponent: Vec3) -> Vec3 {
    let y = (opponent.x + 16.0) / 116.0;
    Vec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0) * (XYZ_FROM_LINEAR * Vec3::ONE)
}

/// CIE L*a*b* with the Hunt effect: colours of dark pixels count less (equation 7).
fn hunt_lab_from_linear(linear: Vec3) -> Vec3 {
    const DELTA: f32 = 6.0 / 29.0;
    let f = |t: f32| {
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let xyz = relative_xyz(linear);
    let (x, y, z) = (f(xyz.x), f(xyz.y), f(xyz.z));
    let lightness = 116.0 * y - 16.0;
    Vec3::new(lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z))
}
