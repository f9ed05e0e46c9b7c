use gnomon_shaders::layout;

use super::depth_map::DepthMapTechnique;
use super::depth_maps::MapDepth;
use super::{ShadowSettings, in_range};
use crate::RenderError;

/// Parameters of hard shadow maps of linear depth.
#[derive(Clone, Debug, PartialEq)]
pub struct HardLinearSettings {
    /// Difference of linear depth up to which a receiver counts as its own blocker's surface, as a share of the depth range,
    /// 0 to 1: the same number of metres everywhere.
    pub depth_bias: f32,
}

impl Default for HardLinearSettings {
    fn default() -> Self {
        Self { depth_bias: 0.002 }
    }
}

/// Shadow maps of linear depth, compared by subtraction (Heidrich 2001, section 2.1).
pub(super) static HARD_LINEAR: DepthMapTechnique = DepthMapTechnique {
    name: "hard-linear",
    summary: "one subtraction of linear depths from each light's centre (Heidrich 2001)",
    module: "shadow_hard_linear",
    depth: MapDepth::Linear,
    parameters,
};

fn parameters(settings: &ShadowSettings, _: u32) -> Result<Vec<u8>, RenderError> {
    let bias = settings.hard_linear.depth_bias;
    let parameters = layout::HardParameters {
        depth_bias: in_range("depth bias of hard linear shadows", bias, 0.0..=1.0)?,
    };
    Ok(layout::bytes(&parameters))
}
