use super::ShadowSettings;
use super::depth_maps::MapDepth;
use super::technique::{Bound, ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::RenderError;

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

    fn depth_maps(&self) -> Option<MapDepth> {
        Option::None
    }

    fn casts_shadows(&self) -> bool {
        false
    }

    fn memory(&self, _: &ShadowSettings, _resolution: u32) -> ShadowMemory {
        ShadowMemory::default()
    }

    fn layers_per_light(&self, _: &ShadowSettings) -> u32 {
        0
    }

    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError> {
        let layout = context.gpu.layout("no shadows", wgpu::ShaderStages::COMPUTE, &[]);
        let bind_group = context.gpu.bind_group("no shadows", &layout, &[]);
        Ok(Box::new(Bound { layout, bind_group }))
    }
}
