use gnomon_picture::RgbImage;

use crate::compare::{MetricsError, check_finite, check_pair, check_size};

/// Outcome of a per-pixel z-test between two noisy pictures of the same thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZTest {
    /// Share of pixels, 0..1, whose three channels all differ by less than the limit.
    pub passing: f64,
    /// Mean of z squared over pixels and channels: 1 where the difference is exactly the noise that the variances
    /// claim, larger where there is bias or a variance is too small.
    pub mean_square: f64,
}

/// Tests whether two pictures differ by no more than their noise: `z = (a - b) / sqrt(var_a + var_b)` for every channel,
/// where the variances are those of the pixel *means*. A pixel passes if `|z| < limit` in all three channels.
///
/// A channel where both variances are 0 passes only where the difference is below `1e-6` of the value (rounding).
///
/// # Errors
/// Sizes differ, values are not finite, there are no pixels.
pub fn z_test(
    (image, image_variance): (&RgbImage, &RgbImage),
    (reference, reference_variance): (&RgbImage, &RgbImage),
    limit: f32,
) -> Result<ZTest, MetricsError> {
    check_pair(image, reference)?;
    for (what, picture) in
        [("picture's variance", image_variance), ("reference's variance", reference_variance)]
    {
        check_size(what, (picture.width(), picture.height()), reference)?;
        check_finite(what, picture)?;
    }
    let (mut passing, mut square_sum) = (0_usize, 0.0);
    let means = image.texels().iter().zip(reference.texels());
    for ((a, b), (var_a, var_b)) in means.zip(image_variance.texels().iter().zip(reference_variance.texels()))
    {
        let (difference, variance) = ((*a - *b).as_dvec3(), (*var_a + *var_b).as_dvec3());
        let rounding = 1e-6 * a.abs().max(b.abs()).as_dvec3();
        let z = difference / (variance + rounding * rounding).max(glam::DVec3::splat(1e-60)).map(f64::sqrt);
        passing += usize::from(z.abs().max_element() < f64::from(limit));
        square_sum += z.length_squared() / 3.0;
    }
    let count = reference.texels().len() as f64;
    Ok(ZTest { passing: passing as f64 / count, mean_square: square_sum / count })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// Sums of twelve uniform numbers from a small generator: near enough to a normal distribution.
    fn noisy(mean: f32, sigma: f32, seed: u32) -> RgbImage {
        let mut state = seed;
        let mut uniform = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        let mut normal = move || (0..12).map(|_| uniform()).sum::<f32>() - 6.0;
        RgbImage::from_fn(64, 64, |_, _| Vec3::splat(mean) + sigma * Vec3::new(normal(), normal(), normal()))
    }

    #[test]
    fn equal_means_pass_and_a_bias_of_three_sigma_fails() {
        let variance = |sigma: f32| RgbImage::filled(64, 64, Vec3::splat(sigma * sigma));
        let (a, b) = (noisy(1.0, 0.02, 1), noisy(1.0, 0.03, 99));
        let test = z_test((&a, &variance(0.02)), (&b, &variance(0.03)), 4.0).unwrap();
        assert!(test.passing > 0.995, "{test:?}");
        assert!((test.mean_square - 1.0).abs() < 0.1, "{test:?}");

        let biased = noisy(1.1, 0.02, 1);
        let test = z_test((&biased, &variance(0.02)), (&b, &variance(0.03)), 4.0).unwrap();
        assert!(test.passing < 0.9 && test.mean_square > 5.0, "{test:?}");

        // A variance that claims too little noise is caught as well.
        let test = z_test((&a, &variance(0.005)), (&b, &variance(0.01)), 4.0).unwrap();
        assert!(test.passing < 0.9, "{test:?}");
    }

    #[test]
    fn noise_free_pixels_must_be_equal() {
        let zero = RgbImage::filled(2, 2, Vec3::ZERO);
        let one = RgbImage::filled(2, 2, Vec3::ONE);
        assert_eq!(z_test((&one, &zero), (&one, &zero), 4.0).unwrap().passing, 1.0);
        assert_eq!(z_test((&zero, &zero), (&zero, &zero), 4.0).unwrap().passing, 1.0);
        assert_eq!(z_test((&one, &zero), (&zero, &zero), 4.0).unwrap().passing, 0.0);
    }

    #[test]
    fn a_variance_of_another_size_is_named() {
        let picture = RgbImage::filled(2, 2, Vec3::ONE);
        let other = RgbImage::filled(3, 2, Vec3::ONE);
        let error = z_test((&picture, &other), (&picture, &picture), 4.0).unwrap_err();
        assert!(error.to_string().contains("picture's variance has 3 x 2"), "{error}");
    }
}
