use gnomon_shaders::layout;

use super::{DepthMapsOnly, ShadowResources, ShadowSettings, ShadowTechnique, in_range};
use crate::depth_maps::DepthMaps;
use crate::{Gpu, RenderError};

/// Shadow maps of linear depth, compared by subtraction (Heidrich 2001, section 2.1).
pub(super) struct HardLinear;

/// Parameters of hard shadow maps of linear depth.
#[derive(Clone, Debug)]
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

impl ShadowTechnique for HardLinear {
    fn name(&self) -> &'static str {
        "hard-linear"
    }

    fn summary(&self) -> &'static str {
        "one subtraction of linear depths from each light's centre (Heidrich 2001)"
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        "shadow_hard_linear"
    }

    fn needs_depth_maps(&self) -> bool {
        true
    }

    fn resources(
        &self,
        gpu: &Gpu,
        settings: &ShadowSettings,
        maps: &DepthMaps,
    ) -> Result<Box<dyn ShadowResources>, RenderError> {
        let bias = settings.hard_linear.depth_bias;
        let parameters = layout::HardParameters {
            depth_bias: in_range("depth bias of hard linear shadows", bias, 0.0..=1.0)?,
            padding_0: 0.0,
            padding_1: 0.0,
            padding_2: 0.0,
        };
        let parameters = bytemuck::bytes_of(&parameters);
        Ok(Box::new(DepthMapsOnly::with_parameters(gpu, "hard linear shadows", parameters, maps)))
    }
}
