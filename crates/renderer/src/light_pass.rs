use gnomon_shaders::layout;

use crate::bindings::{Binding, Groups, set_groups};
use crate::recorder::Recorder;
use crate::shading_points::{PointStage, ShadingPoints};
use crate::{Gpu, RenderError};

/// Layout of the frame as the pass that sums light has it.
pub(crate) fn frame_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let uniforms = [(0, Binding::Uniform), (1, Binding::Uniform), (2, Binding::Uniform)];
    gpu.layout("frame", wgpu::ShaderStages::COMPUTE, &uniforms)
}

/// Bind group of the frame for a batch.
pub(crate) fn frame_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    view: &wgpu::Buffer,
    [lights, batch]: [&wgpu::Buffer; 2],
) -> wgpu::BindGroup {
    let buffers =
        [(0, view.as_entire_binding()), (1, lights.as_entire_binding()), (2, batch.as_entire_binding())];
    gpu.bind_group("frame", layout, &buffers)
}

/// Sums the light of a batch at every shading point, with one shadow technique.
pub(crate) struct LightPass {
    pipeline: wgpu::ComputePipeline,
}

impl LightPass {
    /// With the modules of a shadow technique and of bumps.
    pub fn new(gpu: &Gpu, [shadow, bumps]: [&str; 2], groups: Groups<'_>) -> Result<Self, RenderError> {
        let module = gpu.shader("light", &[("shadow", shadow), ("bumps", bumps)])?;
        Ok(Self { pipeline: gpu.compute_pipeline(&module, "light", groups) })
    }

    /// `groups` are those of frame, surface and shadow.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        [frame, surface, shadow]: [&wgpu::BindGroup; 3],
        points: &ShadingPoints,
        stage: &PointStage,
    ) {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        let groups = [
            (layout::GROUP_FRAME, frame),
            (layout::GROUP_SURFACE, surface),
            (layout::GROUP_SHADOW, shadow),
            (layout::GROUP_PASS, &stage.light_group),
        ];
        set_groups(&mut pass, &groups);
        pass.dispatch_workgroups_indirect(&points.work, stage.dispatch_offset);
    }
}
