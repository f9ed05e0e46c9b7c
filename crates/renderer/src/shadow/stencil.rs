//! Shadow volumes, drawn into a stencil light by light.

use std::sync::{Mutex, PoisonError};

use gnomon_shaders::layout;

use super::ShadowSettings;
use super::buffered::VisibilityBuffer;
use super::depth_maps::MapDepth;
use super::silhouettes::Silhouettes;
use super::technique::{FrameInputs, ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::bindings::{Binding, D2, Groups, set_groups};
use crate::gbuffer::GBuffer;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32FloatStencil8;

/// Ends that lie on what is seen count as behind it: it bounds its volume and is not in it.
const BEHIND: wgpu::DepthBiasState = wgpu::DepthBiasState { constant: -16, slope_scale: -1.0, clamp: 0.0 };

/// Shadow volumes by depth fail (Crow 1977; Heidmann 1991; Carmack 2000).
pub(super) struct Stencil;

impl ShadowTechnique for Stencil {
    fn name(&self) -> &'static str {
        "stencil"
    }

    fn summary(&self) -> &'static str {
        "shadow volumes counted in a stencil: hard shadows from geometry; surfaces with masks cast none"
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        "shadow_buffered"
    }

    fn needed_features(&self) -> wgpu::Features {
        wgpu::Features::DEPTH32FLOAT_STENCIL8
    }

    fn depth_maps(&self) -> Option<MapDepth> {
        None
    }

    fn has_sharp_maps(&self) -> bool {
        false
    }

    fn traces_rays(&self) -> bool {
        true
    }

    fn needs_edges(&self) -> bool {
        true
    }

    fn fills_buffer(&self) -> bool {
        true
    }

    fn memory(&self, _: &ShadowSettings, _resolution: u32) -> ShadowMemory {
        ShadowMemory { per_light: 0, per_pair: 1 }
    }

    fn layers_per_light(&self, _: &ShadowSettings) -> u32 {
        0
    }

    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError> {
        Ok(Box::new(Resources::new(context)?))
    }
}

struct Resources {
    gpu: Gpu,
    silhouettes: Silhouettes,
    buffer: VisibilityBuffer,
    passes: Passes,
    /// A [`layout::VolumeParameters`].
    parameters: wgpu::Buffer,
    volumes: wgpu::BindGroup,
    /// The number of each light of the batch.
    numbers: Vec<wgpu::Buffer>,
    edges: u32,
    triangles: u32,
    /// For the size of picture that was drawn last.
    target: Mutex<Option<Target>>,
}

/// What volumes are drawn into.
struct Target {
    size: [u32; 2],
    both: wgpu::TextureView,
    stencil: wgpu::TextureView,
}

struct Passes {
    depth_layout: wgpu::BindGroupLayout,
    depth: wgpu::RenderPipeline,
    sides: wgpu::RenderPipeline,
    ends: wgpu::RenderPipeline,
    take_layout: wgpu::BindGroupLayout,
    take: wgpu::ComputePipeline,
}

impl Passes {
    fn new(context: &ShadowContext<'_>, volumes: &wgpu::BindGroupLayout) -> Result<Self, RenderError> {
        let (gpu, shared) = (context.gpu, context.shared);
        let depth_layout = gpu.layout(
            "stencil depth",
            wgpu::ShaderStages::FRAGMENT,
            &[(0, Binding::Depth { dimension: D2 })],
        );
        let read = Binding::Storage { read_only: true };
        let take_layout = gpu.layout(
            "stencil visibility",
            wgpu::ShaderStages::COMPUTE,
            &[
                (0, read),
                (1, read),
                (2, Binding::Uniform),
                (3, Binding::Storage { read_only: false }),
                (4, Binding::Uniform),
                (5, Binding::UintTexture),
                (6, Binding::Uniform),
            ],
        );
        let groups = [
            (layout::GROUP_FRAME, &shared.frame),
            (layout::GROUP_SURFACE, &shared.gbuffer),
            (layout::GROUP_PASS, &take_layout),
        ];
        let take = gpu.compute_pipeline(&gpu.shader("stencil_visibility", &[])?, "take_stencil", &groups);
        let depth = render_pipeline(
            gpu,
            ("stencil_depth", "whole_picture", Some("seen_depth")),
            &[(layout::GROUP_PASS, &depth_layout)],
            wgpu::DepthStencilState {
                format: FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: Default::default(),
                bias: Default::default(),
            },
        )?;
        let count = |depth_fail_op| wgpu::StencilFaceState {
            compare: wgpu::CompareFunction::Always,
            fail_op: wgpu::StencilOperation::Keep,
            depth_fail_op,
            pass_op: wgpu::StencilOperation::Keep,
        };
        let stencil = wgpu::StencilState {
            front: count(wgpu::StencilOperation::DecrementWrap),
            back: count(wgpu::StencilOperation::IncrementWrap),
            read_mask: 0xff,
            write_mask: 0xff,
        };
        let groups = [
            (layout::GROUP_FRAME, &shared.view),
            (layout::GROUP_SHADOW, volumes),
            (layout::GROUP_PASS, shared.shadow_map.lights_layout()),
        ];
        let volume = |entry, bias| {
            let state = wgpu::DepthStencilState {
                format: FORMAT,
                depth_write_enabled: Some(false),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: stencil.clone(),
                bias,
            };
            render_pipeline(gpu, ("shadow_volumes", entry, None), &groups, state)
        };
        Ok(Self {
            sides: volume("volume_sides", Default::default())?,
            ends: volume("volume_ends", BEHIND)?,
            depth,
            depth_layout,
            take,
            take_layout,
        })
    }
}

fn render_pipeline(
    gpu: &Gpu,
    (module, vertex, fragment): (&str, &str, Option<&str>),
    groups: Groups<'_>,
    depth_stencil: wgpu::DepthStencilState,
) -> Result<wgpu::RenderPipeline, RenderError> {
    let shader = gpu.shader(module, &[])?;
    Ok(gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(vertex),
        layout: Some(&gpu.pipeline_layout(groups)),
        vertex: wgpu::VertexState {
            module: &shader.module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(depth_stencil),
        multisample: Default::default(),
        fragment: fragment.map(|entry_point| wgpu::FragmentState {
            module: &shader.module,
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    }))
}

impl Resources {
    fn new(context: &ShadowContext<'_>) -> Result<Self, RenderError> {
        let gpu = context.gpu;
        let (silhouettes, edges) = Silhouettes::new(context)?;
        let read = Binding::Storage { read_only: true };
        let bindings = [(0, Binding::Uniform), (1, read), (2, read), (3, read), (4, Binding::Uniform)];
        let layout = gpu.layout("shadow volumes", wgpu::ShaderStages::VERTEX, &bindings);
        let uniform = wgpu::BufferUsages::UNIFORM;
        let parameters = gpu.shared_buffer("shadow volumes", &layout::VolumeParameters::default(), uniform);
        let buffers =
            [&parameters, edges.triangles, &edges.scene.edges, &silhouettes.marks, &silhouettes.counts];
        let resources: Vec<_> =
            (0..).zip(buffers).map(|(number, buffer)| (number, buffer.as_entire_binding())).collect();
        let volumes = gpu.bind_group("shadow volumes", &layout, &resources);
        let number = |light: u32| gpu.buffer_with("light", bytemuck::bytes_of(&[light, 0, 0, 0]), uniform);
        Ok(Self {
            buffer: VisibilityBuffer::new(context),
            passes: Passes::new(context, &layout)?,
            numbers: (0..context.size.lights).map(number).collect(),
            edges: edges.scene.counts.edges,
            triangles: edges.scene.counts.triangles,
            target: Mutex::default(),
            gpu: gpu.clone(),
            silhouettes,
            parameters,
            volumes,
        })
    }

    fn new_target(&self, size: [u32; 2]) -> Target {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let texture = self.gpu.texture("stencil", [size[0], size[1], 1], 1, FORMAT, usage);
        let stencil =
            wgpu::TextureViewDescriptor { aspect: wgpu::TextureAspect::StencilOnly, ..Default::default() };
        Target {
            size,
            both: texture.create_view(&Default::default()),
            stencil: texture.create_view(&stencil),
        }
    }

    /// Begins a pass over all of the target.
    fn begin<'e>(
        encoder: &'e mut wgpu::CommandEncoder,
        target: &Target,
        depth: wgpu::LoadOp<f32>,
    ) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow volumes"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target.both,
                depth_ops: Some(wgpu::Operations { load: depth, store: wgpu::StoreOp::Store }),
                stencil_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0),
                    store: wgpu::StoreOp::Store,
                }),
            }),
            ..Default::default()
        })
    }

    fn copy_depth(&self, recorder: &mut Recorder<'_>, target: &Target, seen: &GBuffer) {
        let view = wgpu::BindingResource::TextureView(&seen.depth);
        let group = self.gpu.bind_group("stencil depth", &self.passes.depth_layout, &[(0, view)]);
        let mut pass = Self::begin(recorder.encoder, target, wgpu::LoadOp::Clear(0.0));
        pass.set_pipeline(&self.passes.depth);
        pass.set_bind_group(layout::GROUP_PASS, &group, &[]);
        pass.draw(0..3, 0..1);
    }

    fn draw_volumes(
        &self,
        recorder: &mut Recorder<'_>,
        target: &Target,
        frame: &FrameInputs<'_>,
        light: u32,
    ) {
        let mut pass = Self::begin(recorder.encoder, target, wgpu::LoadOp::Load);
        pass.set_bind_group(layout::GROUP_FRAME, frame.view, &[]);
        pass.set_bind_group(layout::GROUP_SHADOW, &self.volumes, &[]);
        pass.set_bind_group(layout::GROUP_PASS, frame.lights.group, &[]);
        for (pipeline, vertices) in
            [(&self.passes.sides, 6 * self.edges), (&self.passes.ends, 3 * self.triangles)]
        {
            pass.set_pipeline(pipeline);
            for (part, [x, y, width, height]) in (0..).zip(frame.seen.parts()) {
                pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
                pass.set_scissor_rect(x, y, width, height);
                let parts = frame.seen.interleave * frame.seen.interleave;
                for copy in 0..2 {
                    let instance = (2 * light + copy) * parts + part;
                    pass.draw(0..vertices, instance..instance + 1);
                }
            }
        }
    }

    fn take_stencil(
        &self,
        recorder: &mut Recorder<'_>,
        target: &Target,
        frame: &FrameInputs<'_>,
        number: &wgpu::Buffer,
    ) {
        let (points, stage) = (frame.points, frame.stage);
        let group = self.gpu.bind_group(
            "stencil visibility",
            &self.passes.take_layout,
            &[
                (0, points.list.as_entire_binding()),
                (1, points.work.as_entire_binding()),
                (2, self.buffer.point_count.as_entire_binding()),
                (3, self.buffer.entries.as_entire_binding()),
                (4, stage.uniform.as_entire_binding()),
                (5, wgpu::BindingResource::TextureView(&target.stencil)),
                (6, number.as_entire_binding()),
            ],
        );
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.passes.take);
        let groups = [
            (layout::GROUP_FRAME, frame.frame),
            (layout::GROUP_SURFACE, frame.gbuffer),
            (layout::GROUP_PASS, &group),
        ];
        set_groups(&mut pass, &groups);
        pass.dispatch_workgroups_indirect(&points.work, stage.dispatch_offset);
    }
}

impl ShadowResources for Resources {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.buffer.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.buffer.bind_group
    }

    fn prepare(&self, recorder: &mut Recorder<'_>, frame: &FrameInputs<'_>) -> Result<(), RenderError> {
        self.silhouettes.encode(recorder, frame)?;
        let length = frame.geometry.bounds().map_or(1.0, |around| 2.0 * around.radius());
        self.gpu.write(&self.parameters, &layout::VolumeParameters { length });
        let mut target = self.target.lock().unwrap_or_else(PoisonError::into_inner);
        let size = frame.seen.size;
        let target = match &mut *target {
            Some(target) if target.size == size => target,
            target => target.insert(self.new_target(size)),
        };
        self.copy_depth(recorder, target, frame.seen);
        for (light, number) in (0..frame.lights.uniforms.len() as u32).zip(&self.numbers) {
            self.draw_volumes(recorder, target, frame, light);
            self.take_stencil(recorder, target, frame, number);
        }
        recorder.end_pass("shadow volumes")
    }
}
