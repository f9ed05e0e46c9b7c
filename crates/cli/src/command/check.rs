use clap::Args;
use gnomon::metrics::SampledError;
use gnomon::options::Given;
use gnomon::picture::RgbImage;
use gnomon::reference::MOST_UNASKED_TRIANGLES;
use gnomon::studio::{CHECKED_PIXELS, ErrorBound, Look, Stage};
use gnomon_terminal::Terminal;
use serde_json::{Value, json};

use crate::error::CliError;

/// How far a picture is from the truth, and how far it may be. Neither is part of a look: the one says something about a picture, the other chooses
/// options of the look.
#[derive(Args, Clone, Copy, Debug)]
pub struct CheckArgs {
    /// Ray-trace so many pixels of the picture and tell by them how far it is off: relative RMSE and its standard error; 0 for none [default: 256, 0
    /// for a sequence and for more than four million triangles]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = pixels, conflicts_with = "debug")]
    check: Option<usize>,

    /// Draw with the cheapest lights, shadow maps and samples whose checked error, its uncertainty included, is at most this share (0.02 or 2%);
    /// options that are given stay
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = share,
        conflicts_with_all = ["target_fps", "budget_ms", "frames", "duration", "debug"])]
    max_error: Option<f64>,
}

/// Fewest pixels that say anything of the spread of errors, and most.
const PIXELS: std::ops::RangeInclusive<usize> = 16..=1 << 20;

fn pixels(text: &str) -> Result<usize, String> {
    let number = text.trim().parse().ok().filter(|number| *number == 0 || PIXELS.contains(number));
    number.ok_or(format!("expected 0 or a number of pixels from {} to {}", PIXELS.start(), PIXELS.end()))
}

/// A share of 1, as itself or in per cent.
fn share(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    let share = number.trim().parse::<f64>().ok().map(|number| unit * number);
    share
        .filter(|share| *share > 0.0 && *share < 1.0)
        .ok_or("expected a share above 0 and below 1, as 0.02 or 2%".to_owned())
}

impl CheckArgs {
    /// Refuses a bound that nothing is checked against.
    ///
    /// # Errors
    /// [`CliError::Usage`].
    pub fn validate(&self) -> Result<(), CliError> {
        match (self.check, self.max_error) {
            (Some(0), Some(_)) => {
                Err(CliError::usage("--max-error checks pictures: it does not go with --check 0"))
            }
            _ => Ok(()),
        }
    }

    /// What the error may be, where that is given.
    pub fn bound(&self, given: &Given) -> Option<ErrorBound> {
        let pixels = self.check.unwrap_or(CHECKED_PIXELS);
        self.max_error.map(|most| ErrorBound { most, pixels, given: given.clone() })
    }

    /// Checks a single picture, unless nobody wants to know, or nobody asked and the scene is too large to be traced by the way.
    ///
    /// # Errors
    /// As [`Stage::check`].
    pub fn single(&self, stage: &Stage, radiance: &RgbImage) -> Result<Option<SampledError>, CliError> {
        let is_large = stage.scene().triangle_count() > MOST_UNASKED_TRIANGLES;
        let usual = if is_large { 0 } else { CHECKED_PIXELS };
        checked(stage, radiance, self.check.unwrap_or(usual))
    }

    /// Checks a frame of a sequence, where that is asked for.
    ///
    /// # Errors
    /// As [`Stage::check`].
    pub fn frame(&self, stage: &Stage, radiance: &RgbImage) -> Result<Option<SampledError>, CliError> {
        checked(stage, radiance, self.check.unwrap_or(0))
    }
}

fn checked(stage: &Stage, radiance: &RgbImage, pixels: usize) -> Result<Option<SampledError>, CliError> {
    match pixels {
        0 => Ok(None),
        _ => Ok(Some(stage.check(radiance, pixels)?)),
    }
}

/// Says what a bound came to: the settings, and whether they keep it.
pub fn tell_bound(bound: &ErrorBound, look: &Look, lights: usize, error: &SampledError, terminal: Terminal) {
    let techniques = &look.techniques;
    let samples = techniques.supersample;
    terminal.note(&format!(
        "max-error: {lights} lights, shadow maps of {} and {}, shadow sampling {} and {}, {samples} x {samples} samples a pixel",
        techniques.shadow_resolution,
        techniques.sharp_shadow_resolution,
        techniques.shadow_sampling,
        techniques.sharp_shadow_sampling,
    ));
    if !bound.is_met(error) {
        terminal.warn(&format!(
            "no setting that --max-error tries keeps {} %: the dearest is {error}",
            100.0 * bound.most
        ));
    }
}

/// The same for the statistics.
pub fn bound_document(bound: &ErrorBound, look: &Look, error: &SampledError) -> Value {
    let techniques = &look.techniques;
    json!({
        "bound": bound.most,
        "met": bound.is_met(error),
        "shadow_resolution": techniques.shadow_resolution,
        "sharp_shadow_resolution": techniques.sharp_shadow_resolution,
        "shadow_sampling": techniques.shadow_sampling,
        "sharp_shadow_sampling": techniques.sharp_shadow_sampling,
        "supersample": techniques.supersample,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_pixels_are_in_range() {
        assert_eq!((share("2%"), share(" 0.02 "), share("2.5 %")), (Ok(0.02), Ok(0.02), Ok(0.025)));
        for text in ["", "%", "0", "2", "-1%", "100%", "nan", "2%%", "two"] {
            assert!(share(text).is_err(), "{text}");
        }
        assert_eq!((pixels("0"), pixels("256"), pixels("1048576")), (Ok(0), Ok(256), Ok(1 << 20)));
        for text in ["", "1", "15", "-1", "1048577", "2.5", "all"] {
            assert!(pixels(text).is_err(), "{text}");
        }
    }
}
