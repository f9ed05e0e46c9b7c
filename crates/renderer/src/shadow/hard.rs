use gnomon_shaders::layout;

use super::{DepthMapsOnly, ShadowResources, ShadowSettings, ShadowTechnique};
use crate::bindings::{Binding, D2_ARRAY};
use crate::depth_maps::DepthMaps;
use crate::{Gpu, RenderError};

/// Projective shadow maps with a z-buffer test (Williams 1978; Heidrich 2001, section 2).
pub(super) struct Hard;

/// Parameters of hard shadow maps.
#[derive(Clone, Debug)]
pub struct HardSettings {
    /// Distance towards the light by which a receiver is moved, as a share of the depth range. Surfaces tilted against the
    /// light are covered by the offset along the normal; this bias only has to cover rounding.
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

    fn module(&self) -> &'static str {
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
            depth_bias: settings.hard.depth_bias,
            padding_0: 0.0,
            padding_1: 0.0,
            padding_2: 0.0,
        };
        let parameters =
            gpu.buffer_with("hard shadows", bytemuck::bytes_of(&parameters), wgpu::BufferUsages::UNIFORM);
        let layout = gpu.layout(
            "hard shadows",
            wgpu::ShaderStages::COMPUTE,
            &[(0, Binding::Uniform), (1, Binding::Depth { dimension: D2_ARRAY })],
        );
        let bind_group = gpu.bind_group(
            "hard shadows",
            &layout,
            &[(0, parameters.as_entire_binding()), (1, wgpu::BindingResource::TextureView(&maps.array))],
        );
        Ok(Box::new(DepthMapsOnly { layout, bind_group }))
    }
}
