use super::{ShadowResources, ShadowSettings, ShadowTechnique};
use crate::depth_maps::DepthMaps;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// No shadows: ordinary image-based lighting.
pub(super) struct None;

struct Resources {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
}

impl ShadowTechnique for None {
    fn name(&self) -> &'static str {
        "none"
    }

    fn summary(&self) -> &'static str {
        "no shadows: ordinary image-based lighting"
    }

    fn module(&self) -> &'static str {
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
        Ok(Box::new(Resources { layout, bind_group }))
    }
}

impl ShadowResources for Resources {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn encode(&self, _: &mut Recorder<'_>) {}

    fn bytes(&self) -> u64 {
        0
    }
}
