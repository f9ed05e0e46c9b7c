//! Techniques that look at the lights' depth maps: at the maps themselves, or at images made of them.

use super::ShadowSettings;
use super::depth_maps::{DepthMaps, MapDepth, ShadowMapPass};
use super::technique::{FrameInputs, ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::bindings::{Binding, D2_ARRAY};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Depth maps, and what a technique makes of them.
pub(super) struct MapShadows<F> {
    maps: DepthMaps,
    pass: ShadowMapPass,
    filter: F,
}

/// What a technique makes of depth maps.
pub(super) trait MapFilter: Send {
    /// Layout of bind group 2.
    fn layout(&self) -> &wgpu::BindGroupLayout;
    /// Bind group 2.
    fn bind_group(&self) -> &wgpu::BindGroup;
    /// Makes images of the maps of the first `light_count` lights, at least one.
    fn encode(&self, recorder: &mut Recorder<'_>, light_count: u32);
}

impl<F: MapFilter + 'static> MapShadows<F> {
    /// Maps for a batch, and what `filter` makes of them.
    pub fn boxed(
        context: &ShadowContext<'_>,
        depth: MapDepth,
        filter: impl FnOnce(&DepthMaps) -> Result<F, RenderError>,
    ) -> Result<Box<dyn ShadowResources>, RenderError> {
        let maps = DepthMaps::new(context.gpu, depth, context.size.lights, context.size.resolution);
        let filter = filter(&maps)?;
        Ok(Box::new(Self { maps, pass: context.shared.shadow_map.clone(), filter }))
    }
}

impl<F: MapFilter> ShadowResources for MapShadows<F> {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        self.filter.layout()
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        self.filter.bind_group()
    }

    fn prepare(&self, recorder: &mut Recorder<'_>, frame: &FrameInputs<'_>) -> Result<(), RenderError> {
        if !frame.same_lights {
            self.pass.encode(recorder, &self.maps, frame);
        }
        recorder.end_pass("shadow maps")?;
        let lights = frame.lights.uniforms.len() as u32;
        if !frame.same_lights && lights > 0 {
            self.filter.encode(recorder, lights);
        }
        recorder.end_pass("shadow filter")
    }

    fn depth_maps(&self) -> Option<&DepthMaps> {
        Some(&self.maps)
    }
}

/// A technique that looks only at the depth maps themselves.
pub(super) struct DepthMapTechnique {
    pub name: &'static str,
    pub summary: &'static str,
    pub module: &'static str,
    pub depth: MapDepth,
    /// Bytes of the module's uniform for maps of a resolution.
    pub parameters: fn(&ShadowSettings, u32) -> Vec<u8>,
}

impl ShadowTechnique for DepthMapTechnique {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        self.module
    }

    fn depth_maps(&self) -> Option<MapDepth> {
        Some(self.depth)
    }

    fn memory(&self, _: &ShadowSettings, resolution: u32) -> ShadowMemory {
        ShadowMemory { per_light: DepthMaps::bytes_per_light(resolution), per_pair: 0 }
    }

    fn layers_per_light(&self, _: &ShadowSettings) -> u32 {
        1
    }

    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError> {
        let parameters = (self.parameters)(context.settings, context.size.resolution);
        MapShadows::boxed(context, self.depth, |maps| {
            Ok(Unfiltered::new(context.gpu, self.name, &parameters, maps))
        })
    }
}

/// Bindings of a technique that makes no images of its own.
struct Unfiltered {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
}

impl Unfiltered {
    /// `parameters` at binding 0, the depth maps at 1 and at 2 a bilinear sampler that gives 1 where the reference depth is no
    /// deeper than what is stored.
    fn new(gpu: &Gpu, label: &'static str, parameters: &[u8], maps: &DepthMaps) -> Self {
        let layout = gpu.layout(
            label,
            wgpu::ShaderStages::COMPUTE,
            &[
                (0, Binding::Uniform),
                (1, Binding::Depth { dimension: D2_ARRAY }),
                (2, Binding::ComparisonSampler),
            ],
        );
        let parameters = gpu.buffer_with(label, parameters, wgpu::BufferUsages::UNIFORM);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("lit if nearer"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(wgpu::CompareFunction::LessEqual),
            ..Default::default()
        });
        let bind_group = gpu.bind_group(
            label,
            &layout,
            &[
                (0, parameters.as_entire_binding()),
                (1, wgpu::BindingResource::TextureView(&maps.array)),
                (2, wgpu::BindingResource::Sampler(&sampler)),
            ],
        );
        Self { layout, bind_group }
    }
}

impl MapFilter for Unfiltered {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn encode(&self, _: &mut Recorder<'_>, _light_count: u32) {}
}
