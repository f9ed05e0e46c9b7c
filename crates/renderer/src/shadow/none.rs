use super::ShadowSettings;
use super::depth_maps::MapDepth;
use super::technique::{FrameInputs, ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::RenderError;
use crate::recorder::Recorder;

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

    fn memory(&self, _: &ShadowSettings, _resolution: u32) -> ShadowMemory {
        ShadowMemory::default()
    }

    fn layers_per_light(&self, _: &ShadowSettings) -> u32 {
        0
    }

    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError> {
        let layout = context.gpu.layout("no shadows", wgpu::ShaderStages::COMPUTE, &[]);
        let bind_group = context.gpu.bind_group("no shadows", &layout, &[]);
        Ok(Box::new(Nothing { layout, bind_group }))
    }
}

/// An empty bind group.
struct Nothing {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
}

impl ShadowResources for Nothing {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn prepare(&self, _: &mut Recorder<'_>, _: &FrameInputs<'_>) -> Result<(), RenderError> {
        Ok(())
    }
}
