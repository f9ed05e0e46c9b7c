//! Mean and variance of values that come one by one.

use glam::DVec3;

/// Welford's recurrence. How many values there are is the caller's to know: pixels of one pass have the same.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Welford {
    /// Mean of the values so far.
    pub mean: DVec3,
    /// Sum of their squared differences from it.
    squares: DVec3,
}

impl Welford {
    /// Takes the value that makes it so many.
    pub fn add(&mut self, value: DVec3, count: u32) {
        let difference = value - self.mean;
        self.mean += difference / f64::from(count);
        self.squares += difference * (value - self.mean);
    }

    /// Unbiased variance of the mean of so many independent values; 0 of fewer than two, which tell nothing of it.
    pub fn variance_of_mean(&self, count: u32) -> DVec3 {
        match count {
            0 | 1 => DVec3::ZERO,
            _ => self.squares / (f64::from(count) * (f64::from(count) - 1.0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_of_the_mean_in_closed_form() {
        // 1, 2, 3, 4: mean 2.5, sample variance 5/3, of the mean 5/12.
        let mut sums = Welford::default();
        assert_eq!(sums.variance_of_mean(0), DVec3::ZERO);
        for count in 1..=4 {
            sums.add(DVec3::splat(f64::from(count)), count);
        }
        assert!((sums.mean.x - 2.5).abs() < 1e-12);
        assert!((sums.variance_of_mean(4).x - 5.0 / 12.0).abs() < 1e-12);
        assert_eq!(sums.variance_of_mean(1), DVec3::ZERO);
    }
}
