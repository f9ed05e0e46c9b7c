use gnomon_shaders::layout;

use super::{DepthMapsOnly, ShadowResources, ShadowSettings, ShadowTechnique, in_range};
use crate::depth_maps::DepthMaps;
use crate::{Gpu, RenderError};

/// Projective shadow maps with a z-buffer test (Williams 1978; Heidrich 2001, section 2).
pub(super) struct Hard;

/// Parameters of hard shadow maps.
#[derive(Clone, Debug)]
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

impl ShadowTechnique for Hard {
    fn name(&self) -> &'static str {
        "hard"
    }

    fn summary(&self) -> &'static str {
        "one z-buffer test from each light's centre"
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        "shadow_hard"
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
        let parameters = layout::HardParameters {
            depth_bias: in_range("depth bias of hard shadows", settings.hard.depth_bias, 0.0..=1.0)?,
            padding_0: 0.0,
            padding_1: 0.0,
            padding_2: 0.0,
        };
        let parameters = bytemuck::bytes_of(&parameters);
        Ok(Box::new(DepthMapsOnly::with_parameters(gpu, "hard shadows", parameters, maps)))
    }
}
