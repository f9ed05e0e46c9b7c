/// The error-weighted percentile: the error value `e` such that the pixels whose error is at most `e` carry `fraction`
/// of the total error. With `fraction = 0.5` it is the error-weighted median.
///
/// An ordinary percentile counts pixels, so a shadow missing on two pixels in a hundred never shows; here every pixel
/// counts as much as it is wrong. (Andersson et al. 2020, section 6.2, pool FLIP maps the same way.)
///
/// Between two errors the smallest that reaches the fraction is taken: the result is always one of the `errors`.
/// Errors must not be negative; those that are not positive carry nothing. 0 where all are 0 or there are none.
pub fn error_weighted_percentile(errors: &[f32], fraction: f64) -> f32 {
    let mut sorted: Vec<f32> = errors.iter().copied().filter(|&error| error > 0.0).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    error_weighted_percentile_of_sorted(&sorted, fraction)
}

/// The same for positive errors in ascending order.
pub(crate) fn error_weighted_percentile_of_sorted(sorted: &[f32], fraction: f64) -> f32 {
    let total: f64 = sorted.iter().map(|&error| f64::from(error)).sum();
    let mut carried = 0.0;
    for &error in sorted {
        carried += f64::from(error);
        if carried >= fraction * total {
            return error;
        }
    }
    sorted.last().copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Pins the definition: the pixels up to the median carry half of the error, not half of the pixels.
    #[test]
    fn weighted_median_splits_the_error_and_not_the_pixels() {
        // Ten pixels of 0.01 carry 0.1 in all, one of 0.3 and one of 0.6: total 1.
        let mut errors = vec![0.01_f32; 10];
        errors.extend([0.6, 0.3]);
        assert_eq!(error_weighted_percentile(&errors, 0.05), 0.01);
        assert_eq!(error_weighted_percentile(&errors, 0.25), 0.3);
        assert_eq!(error_weighted_percentile(&errors, 0.5), 0.6);
        assert_eq!(error_weighted_percentile(&errors, 1.0), 0.6);
        // The ordinary median of the same pixels sees nothing.
        errors.sort_by(f32::total_cmp);
        assert_eq!(errors[errors.len() / 2], 0.01);
    }

    #[test]
    fn a_missing_shadow_shows_and_faint_noise_does_not() {
        // Two pixels in a hundred are wrong by 0.7 where the rest carries noise of 0.002.
        let errors: Vec<f32> = (0..100).map(|i| if i < 2 { 0.7 } else { 0.002 }).collect();
        assert_eq!(error_weighted_percentile(&errors, 0.5), 0.7);
        assert_eq!(error_weighted_percentile(&vec![0.002; 100], 0.5), 0.002);
    }

    #[test]
    fn nothing_is_wrong_in_equal_or_empty_pictures() {
        assert_eq!(error_weighted_percentile(&[], 0.5), 0.0);
        assert_eq!(error_weighted_percentile(&[0.0, 0.0], 0.5), 0.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn pixels_below_carry_less_and_pixels_up_to_it_at_least_the_fraction(
            errors in proptest::collection::vec(0.001_f32..1.0, 1..50), fraction in 0.01_f64..0.99,
        ) {
            let value = error_weighted_percentile(&errors, fraction);
            let sum = |keep: &dyn Fn(f32) -> bool| -> f64 {
                errors.iter().filter(|&&e| keep(e)).map(|&e| f64::from(e)).sum()
            };
            let total = sum(&|_| true);
            prop_assert!(sum(&|e| e <= value) >= fraction * total - 1e-9);
            prop_assert!(sum(&|e| e < value) < fraction * total + 1e-9);
        }
    }
}
