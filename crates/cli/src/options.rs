//! Options that several commands share: first their text, then what they mean.

mod environment;
mod gpu;
mod inputs;
mod layers;
mod look;
mod sequence;

pub use environment::{GivenEnvironment, environment_help, load_environment};
pub use gpu::GpuArgs;
pub use inputs::{InputArgs, stage};
pub use layers::LayerArgs;
pub use look::{Fitted, LookArgs};
pub use sequence::SequenceArgs;

use std::ops::RangeInclusive;
use std::str::FromStr;

/// The first and the last of some numbers, both included, as `FIRST..LAST`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbers<T>(pub RangeInclusive<T>);

impl<T: FromStr + PartialOrd> FromStr for Numbers<T> {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let ends = text.split_once("..").map(|(first, last)| (first.trim().parse(), last.trim().parse()));
        match ends {
            Some((Ok(first), Ok(last))) if first <= last => Ok(Self(first..=last)),
            Some((Ok(_), Ok(_))) => Err("the last comes before the first: expected FIRST..LAST, as in 0..99"),
            _ => Err("expected FIRST..LAST, both included, as in 0..99"),
        }
    }
}

/// A finite number.
///
/// # Errors
/// Says what was expected.
pub fn finite(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("expected a finite number".to_owned()),
    }
}

/// A finite number above 0.
///
/// # Errors
/// Says what was expected.
pub fn positive(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|number| *number > 0.0).ok_or("expected a number above 0".to_owned())
}

/// An exposure in stops within any camera's reach.
///
/// # Errors
/// Says what was expected.
pub fn stops(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|stops| stops.abs() <= 60.0).ok_or("expected stops from -60 to 60".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_two_numbers_in_order() {
        assert_eq!("3..12".parse(), Ok(Numbers(3_u32..=12)));
        for text in ["", "3", "..", "3..", "5..3", "-1..3", "0..4294967296", "0..=3"] {
            assert!(text.parse::<Numbers<u32>>().is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_are_finite() {
        assert_eq!(finite("-1.5"), Ok(-1.5));
        assert!(
            finite("nan").is_err()
                && finite("inf").is_err()
                && finite("1e99").is_err()
                && finite("").is_err()
        );
        assert!(positive("0").is_err() && positive("-1").is_err() && positive("1e-3") == Ok(1e-3));
        assert!(stops("61").is_err() && stops("-3") == Ok(-3.0));
    }
}
