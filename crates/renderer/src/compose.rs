use gnomon_shaders::layout;

use crate::bindings::{Binding, D2_ARRAY, set_groups};
use crate::composite::Compositing;
use crate::lighting::Lighting;
use crate::radiance_cache::RadianceCache;
use crate::recorder::Recorder;
use crate::shading_points::ShadingPoints;
use crate::{Gpu, RenderError};

pub(crate) const RADIANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// What is composed, before it is resolved.
pub(crate) struct Composed {
    /// Values along a pixel's side: 1, or the samples of a debug view.
    pub side: u32,
    pub texture: wgpu::Texture,
    pub values: wgpu::TextureView,
    texture_in_front: wgpu::Texture,
    /// Of the layers in front of the one that is composed.
    pub in_front: wgpu::TextureView,
}

impl Composed {
    /// Of a picture of `size` pixels, with layers or without.
    pub fn new(gpu: &Gpu, size: [u32; 2], side: u32, has_layers: bool) -> Self {
        let read = wgpu::TextureUsages::TEXTURE_BINDING;
        let [width, height] = size.map(|pixels| pixels * side);
        let usage = read | wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let texture = gpu.texture("composed", [width, height, 1], 1, RADIANCE_FORMAT, usage);
        let [width, height] = if has_layers { [width, height] } else { [1, 1] };
        let usage = read | wgpu::TextureUsages::COPY_DST;
        let in_front = gpu.texture("composed in front", [width, height, 1], 1, RADIANCE_FORMAT, usage);
        Self {
            side,
            values: texture.create_view(&Default::default()),
            texture,
            in_front: in_front.create_view(&Default::default()),
            texture_in_front: in_front,
        }
    }

    /// Ends a layer: what is composed so far lies in front of the next one.
    fn end_layer(&self, recorder: &mut Recorder<'_>) {
        recorder.encoder.copy_texture_to_texture(
            self.texture.as_image_copy(),
            self.texture_in_front.as_image_copy(),
            self.texture_in_front.size(),
        );
    }
}

/// Makes radiance of the sums of light, with one compositing rule.
pub(crate) struct ComposePass {
    environment_layout: wgpu::BindGroupLayout,
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
        environment.extend([
            (6, Binding::Uniform),
            (7, layers),
            (8, layers),
            (9, Binding::Uniform),
            (10, Binding::LOADED),
        ]);
        let environment_layout = gpu.layout("environment", compute, &environment);
        let module = gpu.shader("compose", &[("composite", compositing.module)])?;
        let groups = [
            (layout::GROUP_FRAME, &environment_layout),
            (layout::GROUP_SURFACE, gbuffer_layout),
            (layout::GROUP_PASS, sums_layout),
        ];
        let pipeline = gpu.compute_pipeline(&module, "compose", &groups);
        Ok(Self { environment_layout, pipeline })
    }

    /// Bind group of the frame.
    pub fn environment_group(
        &self,
        gpu: &Gpu,
        view: &wgpu::Buffer,
        lighting: &Lighting,
        cache: &RadianceCache,
    ) -> wgpu::BindGroup {
        let maps = [
            &lighting.seen,
            &lighting.irradiance_rest,
            &lighting.prefiltered_full,
            &lighting.prefiltered_residual,
            &lighting.dfg_table,
        ];
        let mut resources = vec![(0, view.as_entire_binding())];
        resources.extend((1..).zip(maps).map(|(i, map)| (i, wgpu::BindingResource::TextureView(map))));
        resources.push((6, cache.parameters.as_entire_binding()));
        let layers = &cache.maps;
        resources.extend((7..).zip(layers).map(|(i, map)| (i, wgpu::BindingResource::TextureView(map))));
        resources.push((9, lighting.emitters.as_entire_binding()));
        resources.push((10, wgpu::BindingResource::TextureView(&lighting.background)));
        gpu.bind_group("environment", &self.environment_layout, &resources)
    }

    /// Adds a layer of surfaces that light passes, or what lies behind all, to a picture of `width` x `height` pixels; `groups` are those of frame and surface.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        [frame, surface]: [&wgpu::BindGroup; 2],
        [width, height]: [u32; 2],
        (points, composed): (&ShadingPoints, &Composed),
        layer: u32,
    ) {
        let Some([smooth, edges]) = points.compose_groups.get(layer as usize) else { return };
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        let groups =
            [(layout::GROUP_FRAME, frame), (layout::GROUP_SURFACE, surface), (layout::GROUP_PASS, smooth)];
        set_groups(&mut pass, &groups);
        pass.dispatch_workgroups(width.div_ceil(layout::TILE), height.div_ceil(layout::TILE), 1);
        pass.set_bind_group(layout::GROUP_PASS, edges, &[]);
        pass.dispatch_workgroups_indirect(&points.work, 4 * u64::from(layout::WORK_EDGE_DISPATCH));
        drop(pass);
        if layer as usize + 1 < points.compose_groups.len() {
            composed.end_layer(recorder);
        }
    }
}
