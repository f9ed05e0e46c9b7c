//! How long the fits take.

use std::time::Instant;

use gnomon_envmap::Equirect;

use crate::fit::{FitError, FitOptions, methods};

/// Time of one fit on one map.
#[derive(Clone, Debug, PartialEq)]
pub struct FitTiming {
    /// Name of the fit.
    pub method: &'static str,
    /// How many lights it found.
    pub lights: usize,
    /// Median wall time over the repeats [ms].
    pub median_ms: f64,
}

/// Runs every registered fit `repeats` times (at least once) with its default options, after one run to warm up.
pub fn time_fits(map: &Equirect, repeats: usize) -> Result<Vec<FitTiming>, FitError> {
    let time = |method: &crate::fit::Method| {
        let fit = method.build(&FitOptions::default())?;
        let lights = fit.fit(map)?.lights.len();
        let mut times = Vec::new();
        for _ in 0..repeats.max(1) {
            let start = Instant::now();
            fit.fit(map)?;
            times.push(1000.0 * start.elapsed().as_secs_f64());
        }
        times.sort_by(f64::total_cmp);
        Ok(FitTiming { method: method.name, lights, median_ms: times[times.len() / 2] })
    };
    methods().iter().map(time).collect()
}
