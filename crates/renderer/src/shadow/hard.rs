use gnomon_shaders::layout;

use super::depth_map::DepthMapTechnique;
use super::depth_maps::MapDepth;
use super::{ShadowSettings, in_range};
use crate::RenderError;

/// Parameters of hard shadow maps.
#[derive(Clone, Debug, PartialEq)]
pub struct HardSettings {
    /// Distance towards the light by which a receiver is moved, as a share of the *stored* depth's range, 0 to 1: under a
    /// perspective map the same bias is more metres the farther the receiver. Surfaces tilted against the light are covered by
    /// the offset along the normal; this bias only has to cover rounding.
    pub depth_bias: f32,
}

impl Default for HardSettings {
    fn default() -> Self {
        Self { depth_bias: 0.002 }
    }
}

/// Projective shadow maps with a z-buffer test (Williams 1978; Heidrich 2001, section 2).
pub(super) static HARD: DepthMapTechnique = DepthMapTechnique {
    name: "hard",
    summary: "one z-buffer test from each light's centre",
    module: "shadow_hard",
    depth: MapDepth::Projected,
    parameters,
};

fn parameters(settings: &ShadowSettings, _: u32) -> Result<Vec<u8>, RenderError> {
    let parameters = layout::HardParameters {
        depth_bias: in_range("depth bias of hard shadows", settings.hard.depth_bias, 0.0..=1.0)?,
    };
    Ok(layout::bytes(&parameters))
}
