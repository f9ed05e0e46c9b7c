//! Options that several commands share: first their text, then what they mean.

mod environment;
mod gpu;
mod inputs;
mod sequence;

pub use environment::load_environment;
pub use gpu::GpuArgs;
pub use inputs::{InputArgs, stage};
pub use sequence::SequenceArgs;

use std::str::FromStr;

use clap::Args;
use gnomon::envmap::Projection;
use gnomon::lights::fit::{Sampler, sampler_by_name};
use gnomon::picture::tonemap::ToneMapping;
use gnomon::studio::FitLook;

/// How many lights a fit makes.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct FitArgs {
    /// Number of lights [default: the fit's own choice]
    #[arg(long, value_name = "N", conflicts_with = "threshold")]
    light_count: Option<usize>,

    /// Where the fit stops, above 0 and below 1: disks at a light below this share of those before it (smaller makes more
    /// lights), squares and rectangles grow while a side adds more than this share (larger makes more)
    /// [default: the fit's own]
    #[arg(long, value_name = "T")]
    threshold: Option<f32>,

    /// Largest angular width and height of a light, in degrees [default: the fit's own]
    #[arg(long, value_name = "DEG", value_parser = finite)]
    max_extent: Option<f32>,

    /// Where samples are placed: median-cut, variance-cut, structured or stratified (see gnomon info) [default: median-cut]
    #[arg(long, value_name = "NAME", value_parser = sampler)]
    sampler: Option<Sampler>,

    /// Seed of random samplers (stratified): the same seed gives the same lights
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,
}

impl FitArgs {
    /// Changes what they mention.
    pub fn apply(&self, look: &mut FitLook) {
        // Count and threshold exclude each other: what is asked for here goes before the other in the scene file.
        if self.light_count.is_some() || self.threshold.is_some() {
            (look.light_count, look.threshold) = (self.light_count, self.threshold);
        }
        look.max_extent = self.max_extent.or(look.max_extent);
        if let Some(sampler) = self.sampler {
            look.sampler = Some(sampler.name.to_owned());
        }
        look.seed = self.seed.unwrap_or(look.seed);
    }
}

/// Width and height of a picture, as `WIDTHxHEIGHT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let sides = text.split_once(['x', 'X']).map(|(width, height)| (width.parse(), height.parse()));
        match sides {
            Some((Ok(width), Ok(height))) if width > 0 && height > 0 => Ok(Self { width, height }),
            _ => Err("a size is WIDTHxHEIGHT in pixels, as in 640x480".to_owned()),
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

/// A sampler by its name.
///
/// # Errors
/// Lists the names.
pub fn sampler(text: &str) -> Result<Sampler, String> {
    sampler_by_name(text).map_err(|error| error.to_string())
}

/// The name of a tone mapping.
///
/// # Errors
/// Lists the names.
pub fn tone_mapping(text: &str) -> Result<String, String> {
    ToneMapping::from_name(text)
        .map(|rule| rule.name().to_owned())
        .ok_or_else(|| format!("known are {}", ToneMapping::ALL.map(ToneMapping::name).join(", ")))
}

/// A projection by its name.
///
/// # Errors
/// Lists the names.
pub fn projection(text: &str) -> Result<Projection, String> {
    Projection::from_name(text).ok_or_else(|| {
        let names: Vec<_> = Projection::all().map(Projection::name).collect();
        format!("known projections are {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use gnomon::lights::fit::samplers;
    use gnomon::renderer::shadow;
    use gnomon::studio::Look;

    use super::*;

    #[test]
    fn help_tells_the_defaults_that_are_in_force() {
        let command = InputArgs::augment_args(clap::Command::new("all"));
        let command = SequenceArgs::augment_args(GpuArgs::augment_args(command));
        let help = |id: &str| {
            let option = command.get_arguments().find(|option| option.get_id() == id);
            let option = option.unwrap_or_else(|| unreachable!("there is no option for {id}"));
            option.get_help().map(ToString::to_string).unwrap_or_default()
        };
        let look = Look::default();
        let serde_json::Value::Object(render) = serde_json::to_value(&look.render).unwrap() else {
            unreachable!("a look is an object")
        };
        let text = |value: &serde_json::Value| value.as_str().map_or(value.to_string(), str::to_owned);
        let mut expected: Vec<(&str, String)> =
            render.iter().map(|(key, value)| (key.as_str(), text(value))).collect();
        let [width, height] = look.display.size;
        expected.extend([
            ("lights", look.fit.method.clone()),
            ("sampler", samplers()[0].name.to_owned()),
            ("size", format!("the scene file's, or {width}x{height}")),
            ("tone_mapping", format!("the scene file's, or {}", look.display.tone_mapping)),
            ("fps", sequence::FRAMES_PER_SECOND.to_string()),
        ]);
        for (id, default) in expected {
            let help = help(id);
            assert!(help.ends_with(&format!("[default: {default}]")), "{id}, not {default}: {help}");
        }
        for (name, _) in shadow::names() {
            assert!(help("shadows").contains(name), "{name}");
        }
    }

    #[test]
    fn sizes_are_two_positive_numbers() {
        assert_eq!("640x480".parse(), Ok(Size { width: 640, height: 480 }));
        for text in ["", "640", "x", "0x5", "5x0", "-1x5", "1e3x5", "99999999999x1", "1x2x3"] {
            assert!(text.parse::<Size>().is_err(), "{text}");
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
