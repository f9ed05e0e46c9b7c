use gnomon_envmap::Equirect;
use thiserror::Error;

/// Why lights could not be fitted.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FitError {
    /// No fit has that name.
    #[error("unknown light fit '{name}': choose one of {known}")]
    UnknownMethod {
        /// What was asked for.
        name: String,
        /// The names there are, separated by commas.
        known: String,
    },
    /// An option that cannot be what it is.
    #[error(transparent)]
    Option(#[from] gnomon_options::OptionError),
    /// Two options that exclude each other.
    #[error("a light count and a threshold exclude each other: give one of them")]
    CountAndThreshold,
    /// A count outside the allowed range.
    #[error("light count {0} is out of range: give 1 to {max}", max = crate::fit::MAX_LIGHTS)]
    LightCount(usize),
    /// Fewer lights than the fit can do with.
    #[error(
        "{given} lights are too few for '{method}', which covers the whole sphere: give at least {least}"
    )]
    TooFewLights {
        /// Fit that was asked.
        method: &'static str,
        /// What was asked for.
        given: usize,
        /// The fewest that work.
        least: usize,
    },
    /// A threshold outside (0, 1).
    #[error("threshold {0} is out of range: give a number above 0 and below 1")]
    Threshold(f32),
    /// A threshold for a fit that has none.
    #[error("fit '{0}' has no threshold: give a light count")]
    NoThreshold(&'static str),
    /// No sampler has that name.
    #[error("unknown sampler '{name}': choose one of {known}")]
    UnknownSampler {
        /// What was asked for.
        name: String,
        /// The names there are, separated by commas.
        known: String,
    },
    /// A sampler for a fit that places no points.
    #[error("fit '{0}' has no sampler: only 'samples' places points")]
    NoSampler(&'static str),
    /// A largest extent that the fit cannot honour.
    #[error(
        "largest light extent {} degrees is out of range for {method}: give {:.1} to 180",
        given.to_degrees(), (10.0 * least.to_degrees()).ceil() / 10.0
    )]
    MaxExtent {
        /// Fit that was asked.
        method: &'static str,
        /// What was asked for [rad].
        given: f32,
        /// The least that works [rad].
        least: f32,
    },
    /// A map without texels.
    #[error("the environment map is empty: it has {width} x {height} texels")]
    EmptyMap {
        /// Width in texels.
        width: u32,
        /// Height in texels.
        height: u32,
    },
    /// A texel that is no radiance.
    #[error(
        "environment map texel ({x}, {y}) is negative or not finite: clean the map before fitting lights"
    )]
    InvalidTexel {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
}

impl FitError {
    pub(super) fn unknown_method(name: &str) -> Self {
        let known = super::methods().iter().map(|method| method.name).collect::<Vec<_>>().join(", ");
        Self::UnknownMethod { name: name.to_owned(), known }
    }

    pub(super) fn unknown_sampler(name: &str) -> Self {
        let known = super::samplers().iter().map(|sampler| sampler.name).collect::<Vec<_>>().join(", ");
        Self::UnknownSampler { name: name.to_owned(), known }
    }
}

/// Checks what [`Equirect`] asks of its maker: some texels, all finite and none negative.
pub(super) fn check_map(map: &Equirect) -> Result<(), FitError> {
    let (width, height) = (map.width(), map.height());
    if width == 0 || height == 0 {
        return Err(FitError::EmptyMap { width, height });
    }
    let bad =
        map.radiance().texels().iter().position(|texel| !texel.is_finite() || texel.min_element() < 0.0);
    match bad {
        Some(index) => {
            let width = width as usize;
            Err(FitError::InvalidTexel { x: (index % width) as u32, y: (index / width) as u32 })
        }
        None => Ok(()),
    }
}
