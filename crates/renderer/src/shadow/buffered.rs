//! Visibility through a buffer: any technique's function, evaluated light by light.

use gnomon_shaders::layout;

use super::ShadowSettings;
use super::depth_maps::{DepthMaps, MapDepth};
use super::technique::{FrameInputs, ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::bindings::{Binding, set_groups};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Another technique, whose visibility a pass of its own writes to a buffer.
#[derive(Clone, Copy)]
pub(super) struct Buffered(&'static dyn ShadowTechnique);

impl Buffered {
    /// A technique that has no other way.
    pub const fn new(technique: &'static dyn ShadowTechnique) -> Self {
        Self(technique)
    }

    /// All of `techniques`.
    pub const fn all<const N: usize>(techniques: [&'static dyn ShadowTechnique; N]) -> [Self; N] {
        let mut buffered = [Self(techniques[0]); N];
        let mut i = 1;
        while i < N {
            buffered[i] = Self(techniques[i]);
            i += 1;
        }
        buffered
    }
}

impl ShadowTechnique for Buffered {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn summary(&self) -> &'static str {
        self.0.summary()
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        "shadow_buffered"
    }

    fn needed_features(&self) -> wgpu::Features {
        self.0.needed_features()
    }

    fn depth_maps(&self) -> Option<MapDepth> {
        self.0.depth_maps()
    }

    fn has_sharp_maps(&self) -> bool {
        self.0.has_sharp_maps()
    }

    fn casts_shadows(&self) -> bool {
        self.0.casts_shadows()
    }

    fn traces_rays(&self) -> bool {
        self.0.traces_rays()
    }

    fn is_grainy(&self) -> bool {
        self.0.is_grainy()
    }

    fn needs_edges(&self) -> bool {
        self.0.needs_edges()
    }

    fn fills_buffer(&self) -> bool {
        true
    }

    fn draws_grounds(&self) -> bool {
        self.0.draws_grounds()
    }

    fn memory(&self, settings: &ShadowSettings, resolution: u32) -> ShadowMemory {
        let inline = self.0.memory(settings, resolution);
        ShadowMemory { per_pair: inline.per_pair + 1, ..inline }
    }

    fn layers_per_light(&self, settings: &ShadowSettings) -> u32 {
        self.0.layers_per_light(settings)
    }

    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError> {
        let inline = self.0.resources(context)?;
        let buffer = VisibilityBuffer::new(context);
        let gpu = context.gpu;
        let read = Binding::Storage { read_only: true };
        let pass_layout = gpu.layout(
            "visibility",
            wgpu::ShaderStages::COMPUTE,
            &[
                (0, read),
                (1, read),
                (2, Binding::Uniform),
                (3, Binding::Storage { read_only: false }),
                (4, Binding::Uniform),
            ],
        );
        let module = gpu
            .shader("visibility", &[("shadow", self.0.module(context.settings)), ("bumps", context.bumps)])?;
        let shared = context.shared;
        let groups = [
            (layout::GROUP_FRAME, &shared.frame),
            (layout::GROUP_SURFACE, &shared.gbuffer),
            (layout::GROUP_SHADOW, inline.layout()),
            (layout::GROUP_PASS, &pass_layout),
        ];
        let pipeline = gpu.compute_pipeline(&module, "write_visibility", &groups);
        Ok(Box::new(Resources { inline, buffer, pass_layout, pipeline, gpu: gpu.clone() }))
    }
}

/// One byte for every pair of a light of a batch and a shading point, as `shadow_buffered.wgsl` reads them.
pub(super) struct VisibilityBuffer {
    pub point_count: wgpu::Buffer,
    pub entries: wgpu::Buffer,
    /// Layout of the bind group, and the bind group, for `shadow_buffered`.
    pub layout: wgpu::BindGroupLayout,
    pub bind_group: wgpu::BindGroup,
}

impl VisibilityBuffer {
    pub fn new(context: &ShadowContext<'_>) -> Self {
        let (gpu, size) = (context.gpu, context.size);
        let bytes = u64::from(size.lights.next_multiple_of(4)) * size.points;
        let point_count = [size.points as u32, 0, 0, 0];
        let usage = wgpu::BufferUsages::UNIFORM;
        let point_count = gpu.buffer_with("point count", bytemuck::bytes_of(&point_count), usage);
        let entries = gpu.empty_buffer("visibility", bytes, wgpu::BufferUsages::STORAGE);
        let layout = gpu.layout(
            "buffered shadows",
            wgpu::ShaderStages::COMPUTE,
            &[(0, Binding::Uniform), (1, Binding::Storage { read_only: true })],
        );
        let resources = [(0, point_count.as_entire_binding()), (1, entries.as_entire_binding())];
        let bind_group = gpu.bind_group("buffered shadows", &layout, &resources);
        Self { point_count, entries, layout, bind_group }
    }
}

struct Resources {
    inline: Box<dyn ShadowResources>,
    buffer: VisibilityBuffer,
    pass_layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    gpu: Gpu,
}

impl ShadowResources for Resources {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.buffer.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.buffer.bind_group
    }

    fn prepare(&self, recorder: &mut Recorder<'_>, frame: &FrameInputs<'_>) -> Result<(), RenderError> {
        self.inline.prepare(recorder, frame)?;
        let (points, stage) = (frame.points, frame.stage);
        let pass_group = self.gpu.bind_group(
            "visibility",
            &self.pass_layout,
            &[
                (0, points.list.as_entire_binding()),
                (1, points.work.as_entire_binding()),
                (2, self.buffer.point_count.as_entire_binding()),
                (3, self.buffer.entries.as_entire_binding()),
                (4, stage.uniform.as_entire_binding()),
            ],
        );
        {
            let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pipeline);
            let groups = [
                (layout::GROUP_FRAME, frame.frame),
                (layout::GROUP_SURFACE, frame.gbuffer),
                (layout::GROUP_SHADOW, self.inline.bind_group()),
                (layout::GROUP_PASS, &pass_group),
            ];
            set_groups(&mut pass, &groups);
            pass.dispatch_workgroups_indirect(&points.work, stage.dispatch_offset);
        }
        recorder.end_pass("visibility")
    }

    fn depth_maps(&self) -> Option<&DepthMaps> {
        self.inline.depth_maps()
    }
}
