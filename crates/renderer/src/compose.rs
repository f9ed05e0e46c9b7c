use crate::bindings::{Binding, D2, D2_ARRAY};
use crate::composite::Compositing;
use crate::lighting::Lighting;
use crate::radiance_cache::RadianceCache;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

pub(crate) const RADIANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Makes radiance of the sums of light, with one compositing rule.
pub(crate) struct ComposePass {
    environment_layout: wgpu::BindGroupLayout,
    output_layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl ComposePass {
    pub fn new(
        gpu: &Gpu,
        gbuffer_layout: &wgpu::BindGroupLayout,
        sums_layout: &wgpu::BindGroupLayout,
        compositing: &Compositing,
    ) -> Result<Self, RenderError> {
        let compute = wgpu::ShaderStages::COMPUTE;
        let mut environment = vec![(0, Binding::Uniform)];
        environment.extend((1..=5).map(|binding| (binding, Binding::LOADED)));
        let layers = Binding::Texture { dimension: D2_ARRAY, filterable: false };
        environment.extend([(6, Binding::Uniform), (7, layers), (8, layers)]);
        let environment_layout = gpu.layout("environment", compute, &environment);
        let written = Binding::StorageTexture { format: RADIANCE_FORMAT, dimension: D2 };
        let output_layout = gpu.layout("radiance", compute, &[(0, written)]);
        let module = gpu.shader("compose", &[("composite", compositing.module)])?;
        let groups =
            [Some(&environment_layout), Some(gbuffer_layout), Some(sums_layout), Some(&output_layout)];
        let pipeline = gpu.compute_pipeline(&module, "compose", &groups);
        Ok(Self { environment_layout, output_layout, pipeline })
    }

    /// Layout of bind group 3.
    pub fn output_layout(&self) -> &wgpu::BindGroupLayout {
        &self.output_layout
    }

    /// Bind group 0.
    pub fn environment_group(
        &self,
        gpu: &Gpu,
        view: &wgpu::Buffer,
        lighting: &Lighting,
        cache: &RadianceCache,
    ) -> wgpu::BindGroup {
        let maps = [
            &lighting.background,
            &lighting.irradiance_full,
            &lighting.prefiltered_full,
            &lighting.prefiltered_residual,
            &lighting.dfg_table,
        ];
        let mut resources = vec![(0, view.as_entire_binding())];
        resources.extend((1..).zip(maps).map(|(i, map)| (i, wgpu::BindingResource::TextureView(map))));
        resources.push((6, cache.parameters.as_entire_binding()));
        let layers = &cache.maps;
        resources.extend((7..).zip(layers).map(|(i, map)| (i, wgpu::BindingResource::TextureView(map))));
        gpu.bind_group("environment", &self.environment_layout, &resources)
    }

    /// Bind group 3.
    pub fn output_group(&self, gpu: &Gpu, radiance: &wgpu::TextureView) -> wgpu::BindGroup {
        let resources = [(0, wgpu::BindingResource::TextureView(radiance))];
        gpu.bind_group("radiance", &self.output_layout, &resources)
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
