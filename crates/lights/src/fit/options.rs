use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::rectangles::LEAST_EXTENT;
use super::{Arrival, FitError, Sampler};

/// Fewest lights that can cover the sphere: one a cube face.
const LEAST_COUNT: usize = 6;

/// Most lights that a fit can be asked for.
pub const MAX_LIGHTS: usize = 4096;

/// What can be asked of any fit. Each has its own defaults; `light_count` and `threshold` exclude each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FitOptions {
    /// Number of lights, 1 to [`MAX_LIGHTS`].
    pub light_count: Option<usize>,
    /// Where the fit stops, in (0, 1); its meaning is the fit's own, and not every fit has one.
    pub threshold: Option<f32>,
    /// Largest diameter of a disk or side of a rectangle [rad].
    pub max_extent: Option<f32>,
    /// How point samples are placed; only for the fit that makes them.
    pub sampler: Option<Sampler>,
    /// Seed of what is random: a stratified sampler. The same seed gives the same lights.
    pub seed: u64,
    /// The scene stands on a ground, so that little light arrives from below the horizon (-y). Partitions, optimized or
    /// not, then start with few lights there if they have fewer than 48; other fits take lights where there is light.
    pub ground: bool,
    /// What arrives of the light of every direction, for an interior: partitions, optimized or not, refine it and merge the rest.
    pub arrival: Option<Arc<Arrival>>,
}

/// Where a fit stops that has a threshold.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stop {
    Threshold(f32),
    Count(usize),
}

impl Stop {
    /// Adds itself to the settings of a fit.
    pub(super) fn insert_into(self, parameters: &mut Map<String, Value>) {
        match self {
            Self::Threshold(threshold) => parameters.insert("threshold".into(), json!(threshold)),
            Self::Count(count) => parameters.insert("light_count".into(), json!(count)),
        };
    }
}

impl FitOptions {
    /// Checks what does not depend on the fit.
    pub fn validate(&self) -> Result<(), FitError> {
        match *self {
            Self { light_count: Some(_), threshold: Some(_), .. } => Err(FitError::CountAndThreshold),
            Self { light_count: Some(count), .. } if count == 0 || count > MAX_LIGHTS => {
                Err(FitError::LightCount(count))
            }
            // Not `t <= 0 || t >= 1`: that would let NaN through.
            Self { threshold: Some(t), .. } if !(t > 0.0 && t < 1.0) => Err(FitError::Threshold(t)),
            _ => Ok(()),
        }
    }

    /// For fits that only go by a count.
    pub(super) fn refuse_threshold(&self, method: &'static str) -> Result<(), FitError> {
        if self.threshold.is_some() { Err(FitError::NoThreshold(method)) } else { Ok(()) }
    }

    /// For fits that place no points.
    pub(super) fn refuse_sampler(&self, method: &'static str) -> Result<(), FitError> {
        if self.sampler.is_some() { Err(FitError::NoSampler(method)) } else { Ok(()) }
    }

    /// Checks what every fit asks that covers the whole sphere: a light a face, and no light too narrow to do so.
    pub(super) fn validate_tiling(&self, method: &'static str) -> Result<(), FitError> {
        match *self {
            Self { light_count: Some(given), .. } if given < LEAST_COUNT => {
                Err(FitError::TooFewLights { method, given, least: LEAST_COUNT })
            }
            Self { max_extent: Some(given), .. }
                if !(LEAST_EXTENT..=std::f32::consts::PI).contains(&given) =>
            {
                Err(FitError::MaxExtent { method, given, least: LEAST_EXTENT })
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_makes_no_sense_is_refused() {
        let refused = |options: FitOptions| options.validate().is_err();
        let none = FitOptions::default();
        assert!(!refused(none.clone()));
        assert!(refused(FitOptions { light_count: Some(3), threshold: Some(0.5), ..none.clone() }));
        assert!(refused(FitOptions { light_count: Some(0), ..none.clone() }));
        assert!(refused(FitOptions { light_count: Some(MAX_LIGHTS + 1), ..none.clone() }));
        for t in [0.0, 1.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(refused(FitOptions { threshold: Some(t), ..none.clone() }), "{t}");
        }
    }
}
