use crate::bindings::Binding;
use crate::recorder::Recorder;
use crate::shading_points::ShadingPoints;
use crate::shadow_batches::Batch;
use crate::{Gpu, RenderError};

/// Layout of bind group 0 of the pass that sums light.
pub(crate) fn frame_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let uniforms = [(0, Binding::Uniform), (1, Binding::Uniform), (2, Binding::Uniform)];
    gpu.layout("frame", wgpu::ShaderStages::COMPUTE, &uniforms)
}

/// Bind group 0 of a batch.
pub(crate) fn frame_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    view: &wgpu::Buffer,
    batch: &Batch,
) -> wgpu::BindGroup {
    let buffers = [
        (0, view.as_entire_binding()),
        (1, batch.lights.as_entire_binding()),
        (2, batch.parameters.as_entire_binding()),
    ];
    gpu.bind_group("frame", layout, &buffers)
}

/// Sums the light of a batch at every shading point, with one shadow technique.
pub(crate) struct LightPass {
    pipeline: wgpu::ComputePipeline,
}

impl LightPass {
    /// `groups` are the layouts of the bind groups 0 to 3; the third is the technique's.
    pub fn new(
        gpu: &Gpu,
        shadow_module: &str,
        groups: [Option<&wgpu::BindGroupLayout>; 4],
    ) -> Result<Self, RenderError> {
        let module = gpu.shader("light", &[("shadow", shadow_module)])?;
        Ok(Self { pipeline: gpu.compute_pipeline(&module, "light", &groups) })
    }

    /// `groups` are bind groups 0 to 2.
    pub fn encode(&self, recorder: &mut Recorder<'_>, groups: [&wgpu::BindGroup; 3], points: &ShadingPoints) {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        for (i, group) in (0..).zip(groups.into_iter().chain([&points.light_group])) {
            pass.set_bind_group(i, group, &[]);
        }
        pass.dispatch_workgroups_indirect(&points.dispatch, 0);
    }
}
