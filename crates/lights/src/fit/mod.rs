//! Fits: an environment map in, uniform area lights and a residual map out.
//!
//! A new fit is one file here that implements [`LightFit`], and one line in [`methods`].

mod arrival;
mod cells;
mod disks;
mod edge_error;
mod error;
mod faces;
mod growth;
mod optimized;
mod options;
mod partition;
mod quality;
mod rectangles;
mod samples;
mod settings;
mod sphere_grid;

use gnomon_envmap::Equirect;
use serde_json::{Map, Value};

pub use arrival::Arrival;
pub use cells::cells;
pub use disks::Disks;
pub use error::FitError;
pub use options::{FitOptions, MAX_LIGHTS};
pub use partition::Partition;
pub use quality::error_behind_edges;
pub use rectangles::{Outline, Rectangles};
pub use samples::{Sampler, Samples, sampler_by_name, samplers};
pub use settings::FitSettings;

use crate::LightSet;

/// One way to turn an environment map into lights and a residual.
pub trait LightFit: Send + Sync {
    /// Name on the command line and in JSON.
    fn name(&self) -> &'static str;

    /// The settings in force, by name; numbers in the units that their names or documentation give.
    fn parameters(&self) -> Map<String, Value>;

    /// Whether the lights are others for a scene that stands on a ground, as this fit's options have it.
    fn heeds_ground(&self) -> bool {
        false
    }

    /// Whether they are others for an interior ([`FitOptions::arrival`]).
    fn heeds_arrival(&self) -> bool {
        false
    }

    /// Fits lights to a map. Deterministic; flux of lights and residual equals the map's, channel by channel; a black
    /// map has no lights.
    fn fit(&self, map: &Equirect) -> Result<LightSet, FitError>;
}

/// One registered fit.
#[derive(Clone, Copy)]
pub struct Method {
    /// Name on the command line and in JSON.
    pub name: &'static str,
    /// One line for a list of methods.
    pub summary: &'static str,
    build: fn(&FitOptions) -> Result<Box<dyn LightFit>, FitError>,
}

impl Method {
    /// The fit with the given options.
    pub fn build(&self, options: &FitOptions) -> Result<Box<dyn LightFit>, FitError> {
        options.validate()?;
        (self.build)(options)
    }
}

/// Every fit there is.
pub fn methods() -> &'static [Method] {
    &[
        Method { name: "disks", summary: disks::SUMMARY, build: disks::build },
        Method { name: "squares", summary: rectangles::SUMMARY_SQUARES, build: rectangles::build_squares },
        Method { name: "rectangles", summary: rectangles::SUMMARY, build: rectangles::build_rectangles },
        Method { name: "partition", summary: partition::SUMMARY, build: partition::build },
        Method {
            name: "optimized",
            summary: partition::SUMMARY_OPTIMIZED,
            build: partition::build_optimized,
        },
        Method { name: "samples", summary: samples::SUMMARY, build: samples::build },
    ]
}

/// The fit called `name`, with the given options.
pub fn by_name(name: &str, options: &FitOptions) -> Result<Box<dyn LightFit>, FitError> {
    let method = methods().iter().find(|method| method.name == name);
    method.ok_or_else(|| FitError::unknown_method(name))?.build(options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_registered_name_builds_a_fit_of_that_name() {
        for method in methods() {
            let fit = by_name(method.name, &FitOptions::default()).unwrap();
            assert_eq!(fit.name(), method.name);
        }
    }

    #[test]
    fn an_unknown_name_lists_the_known_ones() {
        let message = by_name("cubes", &FitOptions::default()).err().unwrap().to_string();
        assert!(
            message.contains("cubes") && message.contains("disks") && message.contains("squares"),
            "{message}"
        );
    }
}
