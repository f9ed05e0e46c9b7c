use gnomon_shaders::layout;

use crate::bindings::{Binding, D2};
use crate::geometry::{DrawRange, Geometry};
use crate::materials::Materials;
use crate::recorder::Recorder;
use crate::shadow::depth_maps::DEPTH_FORMAT;
use crate::{Gpu, RenderError};

mod layers;

pub(crate) use layers::Layers;

/// Of both images, 32 bytes a sample together: WebGPU's default limit.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// Textures of `gbuffer.wgsl`'s outputs, one texel a sample, and one surface. Layers of surfaces that light passes are in it in turn.
pub(crate) struct GBuffer {
    /// Parts a side that the samples are drawn in, see `sample_places.wgsl`.
    pub interleave: u32,
    size: [u32; 2],
    depth_texture: wgpu::Texture,
    depth: wgpu::TextureView,
    /// Geometry and reflectance, as `gbuffer_packing.wgsl` has them.
    images: [wgpu::TextureView; 2],
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

impl GBufferPass {
    /// Textures for a picture of `size` samples, `samples` x `samples` a pixel, and so many layers.
    pub fn target(
        &self,
        gpu: &Gpu,
        materials: &Materials,
        size: [u32; 2],
        (samples, layers): (u32, u32),
    ) -> GBuffer {
        let [width, height] = size;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let target = |label, format, usage| gpu.texture(label, [width, height, 1], 1, format, usage);
        let depth_texture = target("gbuffer depth", DEPTH_FORMAT, usage | wgpu::TextureUsages::COPY_SRC);
        let depth = depth_texture.create_view(&Default::default());
        let images = ["gbuffer geometry", "gbuffer reflectance"]
            .map(|label| target(label, FORMAT, usage).create_view(&Default::default()));
        let group = self.read_group(gpu, materials, &depth, &images);
        let interleave = if samples.is_multiple_of(2) { 2 } else { 1 };
        let layers = Layers::new(gpu, &self.layers_layout, size, layers);
        GBuffer { interleave, size, depth_texture, depth, images, group, layers }
    }

    /// Surface bind group of the passes over the screen with other materials.
    pub fn group_with(&self, gpu: &Gpu, target: &GBuffer, materials: &Materials) -> wgpu::BindGroup {
        self.read_group(gpu, materials, &target.depth, &target.images)
    }

    fn read_group(
        &self,
        gpu: &Gpu,
        materials: &Materials,
        depth: &wgpu::TextureView,
        [geometry, reflectance]: &[wgpu::TextureView; 2],
    ) -> wgpu::BindGroup {
        let images = [depth, geometry, reflectance].map(wgpu::BindingResource::TextureView);
        let mut resources = vec![(0, materials.records.as_entire_binding())];
        resources.extend((1..).zip(images));
        gpu.bind_group("gbuffer", &self.read_layout, &resources)
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
        let read = [
            (0, Binding::Storage { read_only: true }),
            (1, Binding::Depth { dimension: D2 }),
            (2, Binding::UintTexture),
            (3, Binding::UintTexture),
        ];
        let read_layout = gpu.layout("gbuffer", wgpu::ShaderStages::COMPUTE, &read);
        let layers_layout = Layers::layout(gpu);
        let shader = gpu.shader("gbuffer", &[])?;
        let attribute = |array_stride, attributes| {
            Some(wgpu::VertexBufferLayout {
                array_stride,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes,
            })
        };
        let one = wgpu::vertex_attr_array![0 => Float32x4];
        let two = wgpu::vertex_attr_array![1 => Float32x4];
        let three = wgpu::vertex_attr_array![2 => Float32x4];
        let last = wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4];
        let buffers = [attribute(16, &one), attribute(16, &two), attribute(16, &three), attribute(32, &last)];
        let surfaces = [(layout::GROUP_FRAME, &view_layout), (layout::GROUP_SURFACE, &material_layout)];
        let of_layers = [&surfaces[..], &[(layout::GROUP_PASS, &layers_layout)]].concat();
        let pipeline = |fragment, groups, format: &[_], compare| {
            let targets: Vec<_> =
                format.iter().map(|&format: &wgpu::TextureFormat| Some(format.into())).collect();
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("gbuffer"),
                layout: Some(&gpu.pipeline_layout(groups)),
                vertex: wgpu::VertexState {
                    module: &shader.module,
                    entry_point: Some("gbuffer_vertex"),
                    compilation_options: Default::default(),
                    buffers: &buffers,
                },
                // No culling: every surface is two-sided, as in the reference.
                primitive: Default::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH_FORMAT,
                    depth_write_enabled: Some(compare != wgpu::CompareFunction::Equal),
                    depth_compare: Some(compare),
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
        };
        let (nearest, known) = (wgpu::CompareFunction::Greater, wgpu::CompareFunction::Equal);
        Ok(Self {
            opaque: pipeline("gbuffer_fragment", &surfaces, &[FORMAT; 2], nearest),
            layer_opacity: pipeline("layer_opacity", &of_layers, &[layers::OPACITY_FORMAT], nearest),
            layer: pipeline("layer_fragment", &surfaces, &[FORMAT; 2], known),
            rest: pipeline("rest_fragment", &of_layers, &[FORMAT; 2], nearest),
            material_layout,
            view_layout,
            read_layout,
            layers_layout,
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
        let (is_opaque, is_blended) = (|range: &DrawRange| !range.is_blended(), DrawRange::is_blended);
        let mut depth = wgpu::LoadOp::Clear(0.0);
        if let Shown::Layer(layer) = shown {
            let mut pass = begin(recorder, target, &target.layers.opacities[layer as usize..][..1], depth);
            self.draw_ranges(&mut pass, target, scene, &self.layer_opacity, is_blended);
            depth = wgpu::LoadOp::Load;
        }
        let mut pass = begin(recorder, target, &target.images, depth);
        match shown {
            Shown::Layer(_) => self.draw_ranges(&mut pass, target, scene, &self.layer, is_blended),
            Shown::Opaque => self.draw_ranges(&mut pass, target, scene, &self.opaque, is_opaque),
            Shown::Rest => {
                self.draw_ranges(&mut pass, target, scene, &self.opaque, is_opaque);
                // Without layers, as in a debug view, the nearest surface is shown.
                let behind = if target.layers.count > 0 { &self.rest } else { &self.opaque };
                self.draw_ranges(&mut pass, target, scene, behind, is_blended);
            }
        }
    }

    fn draw_ranges(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        target: &GBuffer,
        scene: DrawnScene<'_>,
        pipeline: &wgpu::RenderPipeline,
        wanted: impl Fn(&DrawRange) -> bool,
    ) {
        let DrawnScene { view_group, geometry, materials } = scene;
        let ranges: Vec<&DrawRange> = geometry.ranges.iter().filter(|range| wanted(range)).collect();
        if geometry.index_count == 0 || ranges.is_empty() {
            return;
        }
        pass.set_pipeline(pipeline);
        pass.set_bind_group(layout::GROUP_FRAME, view_group, &[]);
        pass.set_bind_group(layout::GROUP_PASS, &target.layers.group, &[]);
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
            for range in &ranges {
                let material = materials.number(range.material);
                pass.set_bind_group(layout::GROUP_SURFACE, materials.bind_group(material), &[]);
                let instance = material as u32 * parts + part;
                pass.draw_indexed(range.indices.clone(), 0, instance..instance + 1);
            }
        }
    }
}

/// What is drawn.
#[derive(Clone, Copy)]
pub(crate) struct DrawnScene<'a> {
    pub view_group: &'a wgpu::BindGroup,
    pub geometry: &'a Geometry,
    pub materials: &'a Materials,
}

fn begin<'a>(
    recorder: &'a mut Recorder<'_>,
    target: &GBuffer,
    images: &[wgpu::TextureView],
    depth: wgpu::LoadOp<f32>,
) -> wgpu::RenderPass<'a> {
    let image = |view| {
        let load = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        })
    };
    recorder.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("gbuffer"),
        color_attachments: &images.iter().map(image).collect::<Vec<_>>(),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &target.depth,
            depth_ops: Some(wgpu::Operations { load: depth, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}
