mod median_cut;

use glam::{DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_image::RgbImage;
use serde_json::{Map, Value, json};

use super::error::check_map;
use super::{FitError, FitOptions, LightFit};
use crate::{DistantLight, LightSet};

pub(super) const SUMMARY: &str =
    "points of equal luminous flux, for many hard shadow maps (median cut, Debevec 2005)";

/// Number of samples unless told otherwise: as many hard shadow maps as the paper's comparison has (Annen et al. 2008,
/// figure 11).
const LIGHT_COUNT: usize = 500;
/// A point is a disk of this angular radius [rad]: a fifth of the sun's, and wide enough for single precision.
const ANGULAR_RADIUS: f64 = 1e-3;

/// A point of the environment and what it stands for.
struct Sample {
    /// Unit.
    direction: DVec3,
    /// Flux [radiance x sr].
    flux: DVec3,
}

/// Point samples of the map that hold all of its flux, as disks of a milliradian: the residual is black. A sampler is one
/// file beside this one that turns a map and a number into samples, each with the flux of its own part of the map.
#[derive(Clone, Debug)]
pub struct Samples {
    light_count: usize,
}

pub(super) fn build(options: &FitOptions) -> Result<Box<dyn LightFit>, FitError> {
    Ok(Box::new(Samples::new(options)?))
}

impl Samples {
    /// `light_count` (500) is met exactly. There is no threshold, and `max_extent` is met by any value that a point fits in.
    pub fn new(options: &FitOptions) -> Result<Self, FitError> {
        options.validate()?;
        if options.threshold.is_some() {
            return Err(FitError::NoThreshold("samples"));
        }
        let least = 2.0 * ANGULAR_RADIUS as f32;
        match options.max_extent {
            Some(given) if !(least..=std::f32::consts::PI).contains(&given) => {
                Err(FitError::MaxExtent { method: "samples", given, least })
            }
            _ => Ok(Self { light_count: options.light_count.unwrap_or(LIGHT_COUNT) }),
        }
    }
}

impl LightFit for Samples {
    fn name(&self) -> &'static str {
        "samples"
    }

    fn parameters(&self) -> Map<String, Value> {
        let mut parameters = Map::new();
        parameters.insert("light_count".into(), json!(self.light_count));
        parameters.insert("sampler".into(), json!("median-cut"));
        parameters.insert("angular_radius".into(), json!(ANGULAR_RADIUS));
        parameters
    }

    fn fit(&self, map: &Equirect) -> Result<LightSet, FitError> {
        check_map(map)?;
        let samples = median_cut::sample(map, self.light_count);
        let lights = samples
            .iter()
            .map(|sample| DistantLight::disk(sample.direction, ANGULAR_RADIUS, sample.flux))
            .collect();
        let residual = Equirect::new(RgbImage::filled(map.width(), map.height(), Vec3::ZERO));
        Ok(LightSet { method: self.name(), parameters: self.parameters(), lights, residual })
    }
}
