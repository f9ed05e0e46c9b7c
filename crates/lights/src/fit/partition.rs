use gnomon_envmap::Equirect;
use serde_json::{Map, Value, json};

use super::cells::{FACE_SIZE, cells};
use super::faces::luminance;
use super::{FitError, FitOptions, LightFit};
use crate::LightSet;

pub(super) const SUMMARY: &str =
    "rectangles that divide the whole map, each with the centre and spread of its part's light";

/// Number of lights unless told otherwise.
const LIGHT_COUNT: usize = 60;

/// Uniform rectangles on cube faces that hold all of the map's flux, strongest first: the residual is black. See [`cells`].
///
/// With exact shadows and ratio compositing, three boxes and a bunny under eight captured maps are off by 0.013 of their mean
/// with 30 lights, 0.005 with 60 and 0.004 with 80 (relative root mean square; the worst of the 16 pictures by 0.022, 0.010
/// and 0.007); rectangles that grow ([`super::Rectangles`]) by 0.039, 0.027 and 0.023.
#[derive(Clone, Debug)]
pub struct Partition {
    light_count: usize,
    max_extent: Option<f32>,
}

pub(super) fn build(options: &FitOptions) -> Result<Box<dyn LightFit>, FitError> {
    Ok(Box::new(Partition::new(options)?))
}

impl Partition {
    /// `light_count` and `max_extent` as for [`cells`]; there is no threshold.
    pub fn new(options: &FitOptions) -> Result<Self, FitError> {
        options.validate()?;
        options.validate_tiling("partition")?;
        options.refuse_threshold("partition")?;
        options.refuse_sampler("partition")?;
        Ok(Self { light_count: options.light_count.unwrap_or(LIGHT_COUNT), max_extent: options.max_extent })
    }
}

impl LightFit for Partition {
    fn name(&self) -> &'static str {
        "partition"
    }

    fn parameters(&self) -> Map<String, Value> {
        let mut parameters = Map::new();
        parameters.insert("light_count".into(), json!(self.light_count));
        parameters.insert("face_size".into(), json!(FACE_SIZE));
        parameters.insert("max_extent".into(), json!(self.max_extent));
        parameters
    }

    fn fit(&self, map: &Equirect) -> Result<LightSet, FitError> {
        let mut lights = cells(map, self.light_count, self.max_extent)?;
        lights.sort_by(|a, b| luminance(b.flux()).total_cmp(&luminance(a.flux())));
        Ok(LightSet::without_residual(self.name(), self.parameters(), lights, map))
    }
}
