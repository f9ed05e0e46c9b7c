//! Closed-form errors, defined results for awkward pictures, clear errors, and planted faults of soft shadows.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use glam::Vec3;
use gnomon_metrics::{Exposure, Mask, Region, compare, compare_displayed, penumbra};
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::srgb_decode;
use gnomon_testing::tolerances::{PENUMBRA_WIDTH, SHADOW_FLIP_WEIGHTED_MEDIAN};
use proptest::prelude::*;

#[test]
fn relative_errors_have_their_closed_form() {
    // Reference mean 2; the picture is 1 too bright in one channel of one pixel of two: six values in all.
    let reference = RgbImage::filled(2, 1, Vec3::splat(2.0));
    let image = RgbImage::from_fn(2, 1, |x, _| Vec3::new(2.0 + x as f32, 2.0, 2.0));
    let comparison = compare(&image, &reference, None).unwrap();
    assert!((comparison.relative_mae - 1.0 / 6.0 / 2.0).abs() < 1e-12);
    assert!((comparison.relative_bias - 1.0 / 6.0 / 2.0).abs() < 1e-12);
    assert!((comparison.relative_rmse - (1.0_f64 / 6.0).sqrt() / 2.0).abs() < 1e-12);
    assert_eq!((comparison.worst.x, comparison.worst.y, comparison.worst.difference), (1, 0, 1.0));
    assert_eq!(comparison.mean, [2.5, 2.0, 2.0]);
    assert_eq!(comparison.pixels, 2);
}

#[test]
fn psnr_has_its_closed_form() {
    // All code values differ by 0.1: 20 dB.
    let [image, reference] = [0.6, 0.5].map(|v| RgbImage::filled(4, 4, Vec3::splat(srgb_decode(v))));
    let comparison = compare_displayed(&image, &reference, None, Exposure::Stops(0.0)).unwrap();
    assert!((comparison.psnr - 20.0).abs() < 1e-4, "{}", comparison.psnr);
}

#[test]
fn equal_pictures_have_no_error_even_if_black() {
    for value in [0.0, 3.0] {
        let picture = RgbImage::filled(5, 3, Vec3::splat(value));
        let comparison = compare(&picture, &picture, None).unwrap();
        assert_eq!(comparison.relative_rmse, 0.0);
        assert_eq!(comparison.relative_mae, 0.0);
        assert_eq!(comparison.psnr, f64::INFINITY);
        assert_eq!(comparison.flip.max, 0.0);
        assert_eq!(comparison.flip.weighted_median, 0.0);
    }
}

#[test]
fn a_black_reference_is_infinitely_far() {
    let black = RgbImage::filled(5, 3, Vec3::ZERO);
    let grey = RgbImage::filled(5, 3, Vec3::splat(0.5));
    let comparison = compare(&grey, &black, None).unwrap();
    assert_eq!(comparison.relative_rmse, f64::INFINITY);
    assert_eq!(comparison.relative_bias, f64::INFINITY);
    assert!(comparison.flip.mean > 0.5);
}

#[test]
fn incomparable_pictures_are_named() {
    let picture = RgbImage::filled(4, 3, Vec3::ONE);
    let message =
        |image: &RgbImage, mask: Option<&Mask>| compare(image, &picture, mask).unwrap_err().to_string();
    assert_eq!(
        message(&RgbImage::filled(3, 4, Vec3::ONE), None),
        "the picture has 3 x 4 pixels but the reference has 4 x 3; they must be equally large"
    );
    let mut broken = picture.clone();
    broken.get_mut(2, 1).y = f32::NAN;
    broken.get_mut(3, 2).x = f32::NEG_INFINITY;
    assert_eq!(
        message(&broken, None),
        "the picture has 2 pixels that are NaN or infinite, the first at column 2, row 1; no error can be computed"
    );
    assert!(
        compare(&picture, &broken, None).unwrap_err().to_string().starts_with("the reference has 2 pixels")
    );
    assert!(message(&picture, Some(&Mask::everything(2, 2))).contains("mask has 2 x 2"));
    assert!(message(&picture, Some(&Mask::from_fn(4, 3, |_, _| false))).contains("no pixel lies inside"));
    let empty = RgbImage::filled(0, 0, Vec3::ZERO);
    assert!(compare(&empty, &empty, None).unwrap_err().to_string().contains("no pixels"));
}

#[test]
fn huge_and_negative_values_are_measured() {
    let reference = RgbImage::filled(8, 8, Vec3::splat(1e30));
    let image = RgbImage::filled(8, 8, Vec3::splat(-1e30));
    let comparison = compare(&image, &reference, None).unwrap();
    assert!((comparison.relative_rmse - 2.0).abs() < 1e-6, "{comparison:?}");
    assert!(comparison.flip.max.is_finite() && comparison.exposure.is_finite());
}

/// A grey floor of 256 x 256 with a round soft shadow on 1.9 % of it.
struct Floor {
    penumbra: f32,
    darkness: f32,
    noise: f32,
}

const UMBRA_CENTER: f32 = 128.0;
const SHADOW_RADIUS: f32 = 19.9;
const PENUMBRA: f32 = 16.0;

impl Floor {
    fn picture(&self) -> RgbImage {
        let mut state = 7_u32;
        RgbImage::from_fn(256, 256, |x, y| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = self.noise * ((state >> 8) as f32 / 8_388_608.0 - 1.0);
            let distance = (x as f32 + 0.5 - UMBRA_CENTER).hypot(y as f32 + 0.5 - UMBRA_CENTER);
            let position = (distance - SHADOW_RADIUS) / self.penumbra + 0.5;
            let visible = 1.0 - self.darkness * (1.0 - penumbra::disk_visibility(position));
            Vec3::splat(0.5 * visible * (1.0 + noise))
        })
    }
}

const TRUTH: Floor = Floor { penumbra: PENUMBRA, darkness: 0.9, noise: 0.0 };

/// Visibility along the row through the shadow's centre, from there to the right edge.
fn profile(picture: &RgbImage) -> Vec<f32> {
    let lit = picture.get(250, 128).x;
    let umbra = picture.get(128, 128).x;
    (128..256).map(|x| (picture.get(x, 128).x - umbra) / (lit - umbra)).collect()
}

fn weighted_median(floor: &Floor) -> f32 {
    let comparison = compare(&floor.picture(), &TRUTH.picture(), None).unwrap();
    comparison.flip.weighted_median
}

#[test]
fn harmless_noise_passes_the_shadow_gate() {
    let median = weighted_median(&Floor { noise: 0.02, ..TRUTH });
    assert!(median < SHADOW_FLIP_WEIGHTED_MEDIAN, "{median}");
}

#[test]
fn missing_shadow_is_caught() {
    let missing = Floor { darkness: 0.0, ..TRUTH };
    let median = weighted_median(&missing);
    assert!(median > 10.0 * SHADOW_FLIP_WEIGHTED_MEDIAN, "{median}");

    let region: Region = "umbra=118,118,20x20".parse().unwrap();
    let mask = Mask::everything(256, 256).within(&region);
    let umbra = compare(&missing.picture(), &TRUTH.picture(), Some(&mask)).unwrap();
    assert!(umbra.relative_rmse > 5.0 && umbra.pixels == 400, "{umbra:?}");
    // What the error-weighted figures are for: the mean says next to nothing.
    let whole = compare(&missing.picture(), &TRUTH.picture(), None).unwrap();
    assert!(whole.flip.mean < 0.03, "{}", whole.flip.mean);
}

#[test]
fn penumbra_twice_as_wide_is_caught() {
    let median = weighted_median(&Floor { penumbra: 2.0 * PENUMBRA, ..TRUTH });
    assert!(median > 2.0 * SHADOW_FLIP_WEIGHTED_MEDIAN, "{median}");
    let width =
        penumbra::disk_penumbra_width(&profile(&Floor { penumbra: 2.0 * PENUMBRA, ..TRUTH }.picture()));
    assert!((width.unwrap() / PENUMBRA - 1.0).abs() > PENUMBRA_WIDTH, "{width:?}");
}

#[test]
fn hard_edge_is_caught() {
    let hard = Floor { penumbra: 0.01, ..TRUTH };
    let median = weighted_median(&hard);
    assert!(median > 2.0 * SHADOW_FLIP_WEIGHTED_MEDIAN, "{median}");
    let width = penumbra::disk_penumbra_width(&profile(&hard.picture())).unwrap();
    assert!(width < 0.2 * PENUMBRA, "{width}");
}

#[test]
fn penumbra_width_of_the_truth_passes() {
    let width = penumbra::disk_penumbra_width(&profile(&TRUTH.picture())).unwrap();
    assert!((width / PENUMBRA - 1.0).abs() < PENUMBRA_WIDTH, "{width}");
    let wider = Floor { penumbra: 1.2 * PENUMBRA, ..TRUTH };
    let width = penumbra::disk_penumbra_width(&profile(&wider.picture())).unwrap();
    assert!((width / PENUMBRA - 1.0).abs() > PENUMBRA_WIDTH, "{width}");
}

fn small_picture() -> impl Strategy<Value = RgbImage> {
    proptest::collection::vec(proptest::array::uniform3(0.0_f32..10.0), 20)
        .prop_map(|values| RgbImage::from_fn(5, 4, |x, y| Vec3::from(values[(y * 5 + x) as usize])))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn mae_never_exceeds_rmse_and_scale_does_not_matter(a in small_picture(), b in small_picture()) {
        let comparison = compare(&a, &b, None).unwrap();
        prop_assert!(comparison.relative_mae <= comparison.relative_rmse + 1e-12);
        prop_assert!(comparison.relative_bias.abs() <= comparison.relative_mae + 1e-12);
        let doubled = |p: &RgbImage| RgbImage::from_fn(5, 4, |x, y| p.get(x, y) * 4.0);
        let scaled = compare(&doubled(&a), &doubled(&b), None).unwrap();
        prop_assert!((scaled.relative_rmse - comparison.relative_rmse).abs() < 1e-9);
        // Auto exposure undoes the scale.
        prop_assert!((scaled.flip.mean - comparison.flip.mean).abs() < 1e-3);
    }

    #[test]
    fn flip_stays_in_its_range(a in small_picture(), b in small_picture()) {
        let flip = compare(&a, &b, None).unwrap().flip;
        prop_assert!(flip.mean >= 0.0 && flip.max <= 1.0);
        prop_assert!(flip.weighted_first_quartile <= flip.weighted_median);
        prop_assert!(flip.weighted_median <= flip.weighted_third_quartile);
        prop_assert!(flip.weighted_third_quartile <= flip.max);
    }
}
