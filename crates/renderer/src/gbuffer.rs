use gnomon_shaders::layout;

use crate::bindings::{Binding, D2, Groups, Shader};
use crate::geometry::Geometry;
use crate::materials::Materials;
use crate::recorder::Recorder;
use crate::shadow::depth_maps::DEPTH_FORMAT;
use crate::{Gpu, RenderError};

/// Of both images, 32 bytes a sample together: WebGPU's default limit.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// Of [`Geometry::vertex_buffers`], as `gbuffer.wgsl` names their attributes.
pub(crate) const VERTEX_BUFFERS: [Option<wgpu::VertexBufferLayout<'static>>; 4] = [
    vertex_buffer(16, &wgpu::vertex_attr_array![0 => Float32x4]),
    vertex_buffer(16, &wgpu::vertex_attr_array![1 => Float32x4]),
    vertex_buffer(16, &wgpu::vertex_attr_array![2 => Float32x4]),
    vertex_buffer(32, &wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4]),
];

/// A vertex buffer.
pub(crate) const fn vertex_buffer(
    array_stride: u64,
    attributes: &'static [wgpu::VertexAttribute],
) -> Option<wgpu::VertexBufferLayout<'static>> {
    Some(wgpu::VertexBufferLayout { array_stride, step_mode: wgpu::VertexStepMode::Vertex, attributes })
}

/// Textures of `gbuffer.wgsl`'s outputs, one texel a sample, and one surface: a further layer would be another of these.
pub(crate) struct GBuffer {
    /// Parts a side that the samples are drawn in, see `sample_places.wgsl`.
    pub interleave: u32,
    pub size: [u32; 2],
    pub depth: wgpu::TextureView,
    /// Geometry and reflectance, as `gbuffer_packing.wgsl` has them.
    images: [wgpu::TextureView; 2],
    /// As `relief_packing.wgsl` has it, where the scene has relief.
    pub relief: Option<[wgpu::TextureView; 2]>,
    /// Surface bind group of the passes over the screen.
    pub group: wgpu::BindGroup,
}

impl GBufferPass {
    /// Textures for a picture of `size` samples, `samples` x `samples` a pixel.
    pub fn target(
        &self,
        gpu: &Gpu,
        materials: &Materials,
        (size, samples): ([u32; 2], u32),
        has_relief: bool,
    ) -> GBuffer {
        let [width, height] = size;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let target = |label, format| {
            gpu.texture(label, [width, height, 1], 1, format, usage).create_view(&Default::default())
        };
        let depth = target("gbuffer depth", DEPTH_FORMAT);
        let images = ["gbuffer geometry", "gbuffer reflectance"].map(|label| target(label, FORMAT));
        let relief = has_relief.then(|| ["relief frame", "relief lit"].map(|label| target(label, FORMAT)));
        let group = self.read_group(gpu, materials, &depth, (&images, relief.as_ref()));
        let interleave = if samples.is_multiple_of(2) { 2 } else { 1 };
        GBuffer { interleave, size, depth, images, relief, group }
    }

    /// Surface bind group of the passes over the screen with other materials.
    pub fn group_with(&self, gpu: &Gpu, target: &GBuffer, materials: &Materials) -> wgpu::BindGroup {
        self.read_group(gpu, materials, &target.depth, (&target.images, target.relief.as_ref()))
    }

    fn read_group(
        &self,
        gpu: &Gpu,
        materials: &Materials,
        depth: &wgpu::TextureView,
        ([geometry, reflectance], relief): (&[wgpu::TextureView; 2], Option<&[wgpu::TextureView; 2]>),
    ) -> wgpu::BindGroup {
        let [frame, lit] = relief.unwrap_or(&self.no_relief);
        let images = [(1, depth), (2, geometry), (3, reflectance), (7, frame), (8, lit)];
        let mut resources = vec![(0, materials.records.as_entire_binding())];
        resources.extend(images.map(|(number, image)| (number, wgpu::BindingResource::TextureView(image))));
        resources.extend(materials.tables.resources());
        gpu.bind_group("gbuffer", &self.read_layout, &resources)
    }
}

impl GBuffer {
    /// Left and upper edge, width and height of every part.
    pub fn parts(&self) -> impl Iterator<Item = [u32; 4]> + use<> {
        let (side, [width, height]) = (self.interleave, self.size.map(|side| side / self.interleave));
        (0..side * side).map(move |part| [part % side * width, part / side * height, width, height])
    }
}

/// Draws what the camera sees.
pub(crate) struct GBufferPass {
    pub material_layout: wgpu::BindGroupLayout,
    /// Of the frame's view alone.
    pub view_layout: wgpu::BindGroupLayout,
    /// Of what it draws, for the passes over the screen.
    pub read_layout: wgpu::BindGroupLayout,
    /// In place of a scene's relief that has none.
    no_relief: [wgpu::TextureView; 2],
    pipeline: wgpu::RenderPipeline,
}

impl GBufferPass {
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let material_layout = crate::materials::material_layout(gpu);
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let view_layout = gpu.layout("view", stages, &[(0, Binding::Uniform)]);
        let mut read = vec![
            (0, Binding::Storage { read_only: true }),
            (1, Binding::Depth { dimension: D2 }),
            (2, Binding::UintTexture),
            (3, Binding::UintTexture),
            (7, Binding::UintTexture),
            (8, Binding::UintTexture),
        ];
        read.extend(crate::materials::tables::bindings());
        let read_layout = gpu.layout("gbuffer", wgpu::ShaderStages::COMPUTE, &read);
        let shader = gpu.shader("gbuffer", &[])?;
        let groups = [(layout::GROUP_FRAME, &view_layout), (layout::GROUP_SURFACE, &material_layout)];
        let pipeline = pipeline(
            gpu,
            &shader,
            "gbuffer_fragment",
            &groups,
            wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            },
        );
        let no_relief = ["no relief frame", "no relief lit"].map(|label| {
            let usage = wgpu::TextureUsages::TEXTURE_BINDING;
            gpu.texture(label, [1, 1, 1], 1, FORMAT, usage).create_view(&Default::default())
        });
        Ok(Self { material_layout, view_layout, read_layout, no_relief, pipeline })
    }

    /// Bind group of the frame over the frame's view uniform.
    pub fn view_group(&self, gpu: &Gpu, view: &wgpu::Buffer) -> wgpu::BindGroup {
        gpu.bind_group("view", &self.view_layout, &[(0, view.as_entire_binding())])
    }

    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        target: &GBuffer,
        view_group: &wgpu::BindGroup,
        geometry: &Geometry,
        materials: &Materials,
    ) {
        let depth = wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store };
        let mut pass = target.begin_pass(recorder, "gbuffer", &target.images, Some(depth));
        draw(&mut pass, &self.pipeline, target, view_group, (geometry, materials), |_, _| true);
    }
}

impl GBuffer {
    /// A pass that draws into some of its images, cleared, and into its depths or before them.
    pub fn begin_pass<'a>(
        &self,
        recorder: &'a mut Recorder<'_>,
        label: &str,
        images: &[wgpu::TextureView; 2],
        depth_ops: Option<wgpu::Operations<f32>>,
    ) -> wgpu::RenderPass<'a> {
        let ops = wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            store: wgpu::StoreOp::Store,
        };
        let attachments = images.each_ref().map(|view| {
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        });
        recorder.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops,
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }
}

/// A pipeline over the scene's triangles with two images of [`FORMAT`].
pub(crate) fn pipeline(
    gpu: &Gpu,
    shader: &Shader,
    fragment: &str,
    groups: Groups<'_>,
    depth_stencil: wgpu::DepthStencilState,
) -> wgpu::RenderPipeline {
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(&gpu.pipeline_layout(groups)),
        vertex: wgpu::VertexState {
            module: &shader.module,
            entry_point: Some("gbuffer_vertex"),
            compilation_options: Default::default(),
            buffers: &VERTEX_BUFFERS,
        },
        // No culling: every surface is two-sided, as in the reference.
        primitive: Default::default(),
        depth_stencil: Some(depth_stencil),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &shader.module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &[Some(FORMAT.into()), Some(FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Draws the scene into every part of a target; `binds` takes the number of a material and says whether its meshes are drawn.
pub(crate) fn draw<'a>(
    pass: &mut wgpu::RenderPass<'a>,
    pipeline: &wgpu::RenderPipeline,
    target: &GBuffer,
    view_group: &wgpu::BindGroup,
    (geometry, materials): (&Geometry, &Materials),
    binds: impl Fn(&mut wgpu::RenderPass<'a>, usize) -> bool,
) {
    if geometry.index_count == 0 {
        return;
    }
    pass.set_pipeline(pipeline);
    pass.set_bind_group(layout::GROUP_FRAME, view_group, &[]);
    for (slot, buffer) in (0..).zip(geometry.vertex_buffers()) {
        pass.set_vertex_buffer(slot, buffer.slice(..));
    }
    pass.set_index_buffer(geometry.indices.slice(..), wgpu::IndexFormat::Uint32);
    let [width, height] = target.size.map(|side| side / target.interleave);
    let parts = target.interleave * target.interleave;
    for part in 0..parts {
        let (x, y) = (part % target.interleave * width, part / target.interleave * height);
        pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(x, y, width, height);
        for range in &geometry.ranges {
            let material = materials.number(range.material);
            if !binds(pass, material) {
                continue;
            }
            pass.set_bind_group(layout::GROUP_SURFACE, materials.bind_group(material), &[]);
            let instance = material as u32 * parts + part;
            pass.draw_indexed(range.indices.clone(), 0, instance..instance + 1);
        }
    }
}
