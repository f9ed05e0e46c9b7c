use gnomon_shaders::layout;

use crate::bindings::{Binding, D2, Groups, Shader};
use crate::geometry::{DrawRange, Geometry, placements_layout};
use crate::materials::Materials;
use crate::recorder::Recorder;
use crate::shadow::depth_maps::DEPTH_FORMAT;
use crate::{Gpu, RenderError};

mod layers;

pub(crate) use layers::Layers;

/// Of both images, 32 bytes a sample together: WebGPU's default limit.
pub(crate) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

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

/// Textures of `gbuffer.wgsl`'s outputs, one texel a sample, and one surface. Layers of surfaces that light passes are in it in turn.
pub(crate) struct GBuffer {
    /// Parts a side that the samples are drawn in, see `sample_places.wgsl`.
    pub interleave: u32,
    pub size: [u32; 2],
    depth_texture: wgpu::Texture,
    pub depth: wgpu::TextureView,
    /// Geometry and reflectance, as `gbuffer_packing.wgsl` has them.
    images: [wgpu::TextureView; 2],
    /// As `relief_packing.wgsl` has it, where the scene has relief.
    pub relief: Option<[wgpu::TextureView; 2]>,
    /// Surface bind group of the passes over the screen.
    pub group: wgpu::BindGroup,
    pub layers: Layers,
}

/// What is in the G-buffer at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    /// What no light passes, but through holes.
    Opaque,
    /// One of the layers in front of it.
    Layer(u32),
    /// What lies behind all layers.
    Rest,
}

/// What is drawn.
#[derive(Clone, Copy)]
pub(crate) struct DrawnScene<'a> {
    pub view_group: &'a wgpu::BindGroup,
    pub geometry: &'a Geometry,
    pub materials: &'a Materials,
}

impl GBufferPass {
    /// Textures for a picture of `size` samples, `samples` x `samples` a pixel, and so many layers.
    pub fn target(
        &self,
        gpu: &Gpu,
        materials: &Materials,
        (size, samples): ([u32; 2], u32),
        (layers, has_relief): (u32, bool),
    ) -> GBuffer {
        let [width, height] = size;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let texture = |label, format, usage| gpu.texture(label, [width, height, 1], 1, format, usage);
        let target = |label| texture(label, FORMAT, usage).create_view(&Default::default());
        let depth_texture = texture("gbuffer depth", DEPTH_FORMAT, usage | wgpu::TextureUsages::COPY_SRC);
        let depth = depth_texture.create_view(&Default::default());
        let images = ["gbuffer geometry", "gbuffer reflectance"].map(target);
        let relief = has_relief.then(|| ["relief frame", "relief lit"].map(target));
        let group = self.read_group(gpu, materials, &depth, (&images, relief.as_ref()));
        let interleave = if samples.is_multiple_of(2) { 2 } else { 1 };
        let layers = Layers::new(gpu, &self.layers_layout, size, layers);
        GBuffer { interleave, size, depth_texture, depth, images, relief, group, layers }
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

    /// A pass that draws into some of its images, cleared, and into its depths or before them.
    pub fn begin_pass<'a>(
        &self,
        recorder: &'a mut Recorder<'_>,
        label: &str,
        images: &[wgpu::TextureView],
        depth: Option<wgpu::LoadOp<f32>>,
    ) -> wgpu::RenderPass<'a> {
        let ops = wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            store: wgpu::StoreOp::Store,
        };
        let image = |view| {
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        };
        recorder.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &images.iter().map(image).collect::<Vec<_>>(),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: depth.map(|load| wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }
}

/// Draws what the camera sees.
pub(crate) struct GBufferPass {
    pub material_layout: wgpu::BindGroupLayout,
    /// Of the frame's view alone.
    pub view_layout: wgpu::BindGroupLayout,
    /// Of what it draws, for the passes over the screen.
    pub read_layout: wgpu::BindGroupLayout,
    layers_layout: wgpu::BindGroupLayout,
    /// In place of a scene's relief that has none.
    no_relief: [wgpu::TextureView; 2],
    /// Of what no light passes.
    opaque: wgpu::RenderPipeline,
    /// Opacity of a layer, then the rest of it.
    layer_opacity: wgpu::RenderPipeline,
    layer: wgpu::RenderPipeline,
    /// Of what is behind all layers and light passes in part.
    rest: wgpu::RenderPipeline,
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
        let layers_layout = Layers::layout(gpu);
        let (shader, of_layers) = (gpu.shader("gbuffer", &[])?, gpu.shader("gbuffer_layers", &[])?);
        let surfaces = [(layout::GROUP_FRAME, &view_layout), (layout::GROUP_SURFACE, &material_layout)];
        let with_layers = [&surfaces[..], &[(layout::GROUP_PASS, &layers_layout)]].concat();
        let (nearest, known) = (wgpu::CompareFunction::Greater, wgpu::CompareFunction::Equal);
        let both = &[FORMAT; 2];
        let no_relief = ["no relief frame", "no relief lit"].map(|label| {
            let usage = wgpu::TextureUsages::TEXTURE_BINDING;
            gpu.texture(label, [1, 1, 1], 1, FORMAT, usage).create_view(&Default::default())
        });
        Ok(Self {
            opaque: pipeline(gpu, &shader, "gbuffer_fragment", &surfaces, (both, nearest)),
            layer_opacity: pipeline(
                gpu,
                &of_layers,
                "layer_opacity",
                &with_layers,
                (&[layers::OPACITY_FORMAT], nearest),
            ),
            layer: pipeline(gpu, &of_layers, "layer_fragment", &surfaces, (both, known)),
            rest: pipeline(gpu, &of_layers, "rest_fragment", &with_layers, (both, nearest)),
            material_layout,
            view_layout,
            read_layout,
            layers_layout,
            no_relief,
        })
    }

    /// Bind group of the frame over the frame's view uniform.
    pub fn view_group(&self, gpu: &Gpu, view: &wgpu::Buffer) -> wgpu::BindGroup {
        gpu.bind_group("view", &self.view_layout, &[(0, view.as_entire_binding())])
    }

    /// Draws what is lit in turn: layer after layer, the last time what lies behind all of them. `drawn` is called in between.
    ///
    /// # Errors
    /// Those of `drawn`.
    pub fn encode<'a>(
        &self,
        recorder: &mut Recorder<'a>,
        target: &GBuffer,
        scene: DrawnScene<'_>,
        mut drawn: impl FnMut(&mut Recorder<'a>, u32) -> Result<(), RenderError>,
    ) -> Result<(), RenderError> {
        let layers = &target.layers;
        if layers.count > 0 {
            self.draw(recorder, target, scene, Shown::Opaque);
            layers.begin(recorder, &target.depth_texture);
        }
        for layer in 0..layers.count {
            self.draw(recorder, target, scene, Shown::Layer(layer));
            layers.peel(recorder, &target.depth_texture);
            drawn(recorder, layer)?;
        }
        self.draw(recorder, target, scene, Shown::Rest);
        drawn(recorder, layers.count)
    }

    fn draw(&self, recorder: &mut Recorder<'_>, target: &GBuffer, scene: DrawnScene<'_>, shown: Shown) {
        let draw_some = |pass: &mut wgpu::RenderPass<'_>, pipeline, is_blended| {
            pass.set_bind_group(layout::GROUP_PASS, &target.layers.group, &[]);
            draw(pass, pipeline, target, scene, |_, range| range.is_blended() == is_blended);
        };
        let mut depth = wgpu::LoadOp::Clear(0.0);
        if let Shown::Layer(layer) = shown {
            let opacities = &target.layers.opacities[layer as usize..][..1];
            let mut pass = target.begin_pass(recorder, "opacities", opacities, Some(depth));
            draw_some(&mut pass, &self.layer_opacity, true);
            depth = wgpu::LoadOp::Load;
        }
        let mut pass = target.begin_pass(recorder, "gbuffer", &target.images, Some(depth));
        match shown {
            Shown::Layer(_) => draw_some(&mut pass, &self.layer, true),
            Shown::Opaque => draw_some(&mut pass, &self.opaque, false),
            Shown::Rest => {
                draw_some(&mut pass, &self.opaque, false);
                // Without layers, as in a debug view, the nearest surface is shown.
                let behind = if target.layers.count > 0 { &self.rest } else { &self.opaque };
                draw_some(&mut pass, behind, true);
            }
        }
    }
}

/// A pipeline over the scene's triangles. Of the depth it draws what is so; it keeps that, unless it is known.
pub(crate) fn pipeline(
    gpu: &Gpu,
    shader: &Shader,
    fragment: &str,
    groups: Groups<'_>,
    (formats, depth): (&[wgpu::TextureFormat], wgpu::CompareFunction),
) -> wgpu::RenderPipeline {
    let placements = placements_layout(gpu);
    let groups = [groups, &[(layout::GROUP_PLACEMENTS, &placements)]].concat();
    let targets: Vec<_> = formats.iter().map(|&format| Some(format.into())).collect();
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(&gpu.pipeline_layout(&groups)),
        vertex: wgpu::VertexState {
            module: &shader.module,
            entry_point: Some("gbuffer_vertex"),
            compilation_options: Default::default(),
            buffers: &VERTEX_BUFFERS,
        },
        // No culling: every surface is two-sided, as in the reference.
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(depth != wgpu::CompareFunction::Equal),
            depth_compare: Some(depth),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &shader.module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Draws the scene into every part of a target; `binds` says which ranges, and may bind what those need.
pub(crate) fn draw<'a>(
    pass: &mut wgpu::RenderPass<'a>,
    pipeline: &wgpu::RenderPipeline,
    target: &GBuffer,
    DrawnScene { view_group, geometry, materials }: DrawnScene<'_>,
    binds: impl Fn(&mut wgpu::RenderPass<'a>, &DrawRange) -> bool,
) {
    if geometry.index_count == 0 {
        return;
    }
    pass.set_pipeline(pipeline);
    pass.set_bind_group(layout::GROUP_FRAME, view_group, &[]);
    pass.set_bind_group(layout::GROUP_PLACEMENTS, geometry.placements_group(), &[]);
    for (slot, buffer) in (0..).zip(geometry.vertex_buffers()) {
        pass.set_vertex_buffer(slot, buffer.slice(..));
    }
    pass.set_index_buffer(geometry.indices.slice(..), wgpu::IndexFormat::Uint32);
    let parts = target.interleave * target.interleave;
    for (part, [x, y, width, height]) in (0..).zip(target.parts()) {
        pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(x, y, width, height);
        for range in &geometry.ranges {
            if !binds(pass, range) {
                continue;
            }
            let material = materials.number(range.material);
            pass.set_bind_group(layout::GROUP_SURFACE, materials.bind_group(material), &[]);
            let instances = geometry.instances_of(material as u32 * parts + part, &range.placements);
            pass.draw_indexed(range.indices.clone(), 0, instances);
        }
    }
}
