//! The pass that moves vertices.

use gnomon_shaders::layout;

use super::Geometry;
use crate::bindings::Binding;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Brings every vertex to world space, every frame.
pub(crate) struct TransformPass {
    pub(super) layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl TransformPass {
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let read = Binding::Storage { read_only: true };
        let write = Binding::Storage { read_only: false };
        let bindings = gpu.layout(
            "transform",
            wgpu::ShaderStages::COMPUTE,
            &[(0, read), (1, read), (2, write), (3, write), (4, write), (5, read), (6, read), (7, read)],
        );
        let pipeline = gpu.compute_pipeline(
            &gpu.shader("transform", &[])?,
            "transform",
            &[(layout::GROUP_PASS, &bindings)],
        );
        Ok(Self { layout: bindings, pipeline })
    }

    pub fn encode(&self, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        for (group, count) in &geometry.windows {
            let groups = count.div_ceil(layout::VERTEX_WORKGROUP);
            let x = groups.min(1024);
            pass.set_bind_group(layout::GROUP_PASS, group, &[]);
            pass.dispatch_workgroups(x, groups.div_ceil(x), 1);
        }
    }
}
