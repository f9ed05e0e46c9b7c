use gnomon_envmap::Equirect;
use serde_json::{Map, Value, json};

use super::cells::{FACE_SIZE, LIGHT_COUNT, cells, check, heeds_ground};
use super::faces::luminance;
use super::{FitError, FitOptions, LightFit};
use crate::LightSet;

pub(super) const SUMMARY: &str =
    "rectangles that divide the whole map, each with the centre and spread of its part's light";

/// Uniform rectangles on cube faces that hold all of the map's flux, strongest first: the residual is black. See [`cells`].
///
/// Three boxes and a bunny on a ground, under seven maps, drawn with percentage-closer shadows and ratio compositing, are off by
/// 0.041 of their mean with 15 lights, 0.027 with 30 and 0.018 with 60 (relative root mean square, geometric mean of 14 pictures,
/// the noise of the truth included). With [`FitOptions::ground`] 15 lights are off by 0.035 and 30 by 0.024.
#[derive(Clone, Debug)]
pub struct Partition {
    options: FitOptions,
}

pub(super) fn build(options: &FitOptions) -> Result<Box<dyn LightFit>, FitError> {
    Ok(Box::new(Partition::new(options)?))
}

impl Partition {
    /// The options of [`cells`]; there is no threshold.
    pub fn new(options: &FitOptions) -> Result<Self, FitError> {
        check("partition", options)?;
        let light_count = options.light_count.or(Some(LIGHT_COUNT));
        Ok(Self { options: FitOptions { light_count, ground: heeds_ground(options), ..*options } })
    }
}

impl LightFit for Partition {
    fn name(&self) -> &'static str {
        "partition"
    }

    fn parameters(&self) -> Map<String, Value> {
        let mut parameters = Map::new();
        parameters.insert("light_count".into(), json!(self.options.light_count));
        parameters.insert("face_size".into(), json!(FACE_SIZE));
        parameters.insert("max_extent".into(), json!(self.options.max_extent));
        parameters.insert("ground".into(), json!(self.options.ground));
        parameters
    }

    fn heeds_ground(&self) -> bool {
        self.options.ground
    }

    fn fit(&self, map: &Equirect) -> Result<LightSet, FitError> {
        let mut lights = cells(map, &self.options)?;
        lights.sort_by(|a, b| luminance(b.flux()).total_cmp(&luminance(a.flux())));
        Ok(LightSet::without_residual(self.name(), self.parameters(), lights, map))
    }
}
