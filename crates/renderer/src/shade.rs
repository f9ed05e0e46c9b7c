use crate::bindings::{Binding, D2};
use crate::composite::Compositing;
use crate::gbuffer::GBuffer;
use crate::lighting::Lighting;
use crate::recorder::Recorder;
use crate::shadow_batches::Batch;
use crate::{Gpu, RenderError};

pub(crate) const RADIANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Layouts that every shading pipeline shares, whatever fills its slots.
pub(crate) struct ShadeLayouts {
    frame: wgpu::BindGroupLayout,
    gbuffer: wgpu::BindGroupLayout,
    output: wgpu::BindGroupLayout,
}

impl ShadeLayouts {
    pub fn new(gpu: &Gpu) -> Self {
        let compute = wgpu::ShaderStages::COMPUTE;
        let frame = [
            (0, Binding::Uniform),
            (1, Binding::Uniform),
            (2, Binding::LOADED),
            (3, Binding::LOADED),
            (4, Binding::LOADED),
            (5, Binding::LOADED),
            (6, Binding::LOADED),
            (7, Binding::Uniform),
        ];
        let gbuffer = [
            (0, Binding::Depth { dimension: D2 }),
            (1, Binding::LOADED),
            (2, Binding::LOADED),
            (3, Binding::LOADED),
            (4, Binding::LOADED),
        ];
        let output = [
            (0, Binding::StorageTexture { format: RADIANCE_FORMAT, dimension: D2 }),
            (1, Binding::Storage { read_only: false }),
        ];
        Self {
            frame: gpu.layout("frame", compute, &frame),
            gbuffer: gpu.layout("gbuffer", compute, &gbuffer),
            output: gpu.layout("radiance", compute, &output),
        }
    }

    pub fn frame_group(
        &self,
        gpu: &Gpu,
        view: &wgpu::Buffer,
        batch: &Batch,
        lighting: &Lighting,
    ) -> wgpu::BindGroup {
        let mut resources = vec![
            (0, view.as_entire_binding()),
            (1, batch.lights.as_entire_binding()),
            (7, batch.parameters.as_entire_binding()),
        ];
        let maps = [
            &lighting.background,
            &lighting.irradiance_full,
            &lighting.prefiltered_full,
            &lighting.prefiltered_residual,
            &lighting.dfg_table,
        ];
        resources.extend((2..).zip(maps).map(|(i, map)| (i, wgpu::BindingResource::TextureView(map))));
        gpu.bind_group("frame", &self.frame, &resources)
    }

    pub fn gbuffer_group(&self, gpu: &Gpu, gbuffer: &GBuffer) -> wgpu::BindGroup {
        let views = std::iter::once(&gbuffer.depth).chain(&gbuffer.colors);
        let resources: Vec<_> =
            (0..).zip(views).map(|(i, view)| (i, wgpu::BindingResource::TextureView(view))).collect();
        gpu.bind_group("gbuffer", &self.gbuffer, &resources)
    }

    /// `sums` carries the light of one batch to the next, [`layout::LightSums`] a sample where there are several.
    pub fn output_group(
        &self,
        gpu: &Gpu,
        radiance: &wgpu::TextureView,
        sums: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let resources = [(0, wgpu::BindingResource::TextureView(radiance)), (1, sums.as_entire_binding())];
        gpu.bind_group("radiance", &self.output, &resources)
    }
}

/// Lights every sample with one shadow technique and one compositing rule.
pub(crate) struct ShadePass {
    pipeline: wgpu::ComputePipeline,
}

impl ShadePass {
    pub fn new(
        gpu: &Gpu,
        layouts: &ShadeLayouts,
        shadow_module: &str,
        shadow_layout: Option<&wgpu::BindGroupLayout>,
        compositing: &Compositing,
    ) -> Result<Self, RenderError> {
        let module = gpu.shader("shade", &[("shadow", shadow_module), ("composite", compositing.module)])?;
        let groups = [Some(&layouts.frame), Some(&layouts.gbuffer), shadow_layout, Some(&layouts.output)];
        Ok(Self { pipeline: gpu.compute_pipeline(&module, "shade", &groups) })
    }

    /// `groups` are bind groups 0 to 3.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        groups: [&wgpu::BindGroup; 4],
        [width, height]: [u32; 2],
    ) {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        for (i, group) in (0..).zip(groups) {
            pass.set_bind_group(i, group, &[]);
        }
        pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
    }
}
