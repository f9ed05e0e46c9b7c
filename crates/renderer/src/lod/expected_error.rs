use super::LevelOfDetail;

/// Error of the light fit with [`FIT_LIGHTS`] lights and exact shadows, and the power with which it falls: 0.013 with 30 lights of
/// `partition`, 0.005 with 60, 0.004 with 80.
const FIT: f64 = 0.013;
const FIT_LIGHTS: f64 = 30.0;
const FIT_POWER: f64 = 1.3;
/// Error of maps of 256 x 256 texels, in proportion to the side of a texel.
const MAP: f64 = 0.010;
/// Error of a shadow buffer of all samples, in proportion to the side of its samples: a sixteenth of the samples adds a tenth at most
/// to the whole.
const SAMPLING: f64 = 0.0025;

/// Relative RMSE that the settings add to a picture, as independent errors, beside the shadow technique's own (about 0.03). It only
/// ranks settings, so that the knobs are turned in the order in which they hurt least.
pub(super) fn expected_error(level: LevelOfDetail) -> f64 {
    let fit = FIT * (FIT_LIGHTS / f64::from(level.lights.max(1))).powf(FIT_POWER);
    let map = MAP * 256.0 / f64::from(level.shadow_resolution.max(1));
    let sampling = SAMPLING * f64::from(level.shadow_sampling);
    [fit, map, sampling].iter().map(|error| error * error).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_knob_hurts_when_turned_down() {
        let level = LevelOfDetail { lights: 60, shadow_resolution: 256, shadow_sampling: 2 };
        let base = expected_error(level);
        assert!((0.01..0.02).contains(&base), "{base}");
        assert!(expected_error(LevelOfDetail { lights: 30, ..level }) > base);
        assert!(expected_error(LevelOfDetail { shadow_resolution: 128, ..level }) > base);
        assert!(expected_error(LevelOfDetail { shadow_sampling: 4, ..level }) > base);
        assert!(expected_error(LevelOfDetail { lights: 0, ..level }).is_finite());
    }
}
