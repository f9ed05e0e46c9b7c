use super::{DepthMapsOnly, ShadowResources, ShadowSettings, ShadowTechnique};
use crate::depth_maps::DepthMaps;
use crate::{Gpu, RenderError};

/// No shadows: ordinary image-based lighting.
pub(super) struct None;

impl ShadowTechnique for None {
    fn name(&self) -> &'static str {
        "none"
    }

    fn summary(&self) -> &'static str {
        "no shadows: ordinary image-based lighting"
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        "shadow_none"
    }

    fn needs_depth_maps(&self) -> bool {
        false
    }

    fn resources(
        &self,
        gpu: &Gpu,
        _: &ShadowSettings,
        _: &DepthMaps,
    ) -> Result<Box<dyn ShadowResources>, RenderError> {
        let layout = gpu.layout("no shadows", wgpu::ShaderStages::COMPUTE, &[]);
        let bind_group = gpu.bind_group("no shadows", &layout, &[]);
        Ok(Box::new(DepthMapsOnly { layout, bind_group }))
    }
}
