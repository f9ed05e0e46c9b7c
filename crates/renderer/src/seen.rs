//! What is seen through the middle of every pixel, and the geometry layers that it becomes.

use glam::Mat4;
use gnomon_scene::{Camera, Projection};
use gnomon_shaders::layout;

use crate::bindings::{Binding, D2, set_groups};
use crate::gbuffer::{GBufferPass, VERTEX_BUFFERS, vertex_buffer};
use crate::geometry::{Geometry, placements_layout};
use crate::materials::Materials;
use crate::recorder::Recorder;
use crate::shadow::depth_maps::DEPTH_FORMAT;
use crate::{Gpu, RenderError};

/// Of what is drawn, twice 16 bytes a pixel, and of a layer.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// Where vertices were drawn in another frame.
pub(crate) struct DrawnVertices {
    pub positions: wgpu::Buffer,
    pub placements: wgpu::Buffer,
}

/// Draws what is seen and makes layers of it.
pub(crate) struct SeenPass {
    frame_layout: wgpu::BindGroupLayout,
    layer_layout: wgpu::BindGroupLayout,
    draw: wgpu::RenderPipeline,
    write: wgpu::ComputePipeline,
    /// Of the frame.
    view: wgpu::Buffer,
    seen_frame: wgpu::Buffer,
}

/// Textures for a picture of one size.
pub(crate) struct SeenTarget {
    size: [u32; 2],
    depth: wgpu::TextureView,
    images: [wgpu::TextureView; 2],
    /// A layer.
    pub words: wgpu::Texture,
    words_view: wgpu::TextureView,
}

impl SeenPass {
    pub fn new(gpu: &Gpu, gbuffer: &GBufferPass) -> Result<Self, RenderError> {
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let read = Binding::Storage { read_only: true };
        let frame = [(0, Binding::Uniform), (1, Binding::Uniform), (2, read), (3, read)];
        let frame_layout = gpu.layout("seen frame", stages, &frame);
        let shader = gpu.shader("seen", &[])?;
        // Positions of the frame before follow those of this one.
        let mut buffers = VERTEX_BUFFERS.to_vec();
        buffers.push(vertex_buffer(16, &wgpu::vertex_attr_array![5 => Float32x4]));
        let placements = placements_layout(gpu);
        let groups = [
            (layout::GROUP_FRAME, &frame_layout),
            (layout::GROUP_SURFACE, &gbuffer.material_layout),
            (layout::GROUP_PLACEMENTS, &placements),
        ];
        let draw = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("seen"),
            layout: Some(&gpu.pipeline_layout(&groups)),
            vertex: wgpu::VertexState {
                module: &shader.module,
                entry_point: Some("seen_vertex"),
                compilation_options: Default::default(),
                buffers: &buffers,
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader.module,
                entry_point: Some("seen_fragment"),
                compilation_options: Default::default(),
                targets: &[Some(FORMAT.into()), Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let written = Binding::StorageTexture { format: FORMAT, dimension: D2 };
        let layer =
            [(0, Binding::UintTexture), (1, Binding::UintTexture), (2, Binding::Uniform), (3, written)];
        let layer_layout = gpu.layout("layer", wgpu::ShaderStages::COMPUTE, &layer);
        let groups = [(layout::GROUP_FRAME, &frame_layout), (layout::GROUP_PASS, &layer_layout)];
        let write = gpu.compute_pipeline(&gpu.shader("layers", &[])?, "write_layer", &groups);
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        Ok(Self {
            frame_layout,
            layer_layout,
            draw,
            write,
            view: gpu.empty_buffer("seen view", layout::size::<layout::View>(), usage),
            seen_frame: gpu.empty_buffer("seen frame", layout::size::<layout::SeenFrame>(), usage),
        })
    }

    /// Textures for a picture of so many pixels.
    pub fn target(&self, gpu: &Gpu, size: [u32; 2]) -> SeenTarget {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let texture = |label, format, usage| gpu.texture(label, [size[0], size[1], 1], 1, format, usage);
        let words =
            texture("layer", FORMAT, wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC);
        let view = |label, format| texture(label, format, usage).create_view(&Default::default());
        SeenTarget {
            size,
            depth: view("seen depth", DEPTH_FORMAT),
            images: ["seen identities", "seen places"].map(|label| view(label, FORMAT)),
            words_view: words.create_view(&Default::default()),
            words,
        }
    }

    /// Draws what is seen in `view`, with one sample a pixel, and gives the frame's bind group for [`SeenPass::write`].
    pub fn draw(
        &self,
        recorder: &mut Recorder<'_>,
        target: &SeenTarget,
        (view, frame): (&layout::View, &layout::SeenFrame),
        (geometry, before): (&Geometry, Option<&DrawnVertices>),
        materials: &Materials,
    ) -> wgpu::BindGroup {
        let gpu = recorder.gpu;
        gpu.write(&self.view, view);
        gpu.write(&self.seen_frame, frame);
        let seen_draw = |(node, material): (gnomon_scene::NodeId, _)| layout::SeenDraw {
            object: node.0 as u32 + 1,
            material: materials.number(material) as u32,
        };
        // They are counted from 1.
        let draws: Vec<_> =
            std::iter::once(Default::default()).chain(geometry.instances().map(seen_draw)).collect();
        let draws = gpu.shared_buffer("seen draws", draws.as_slice(), wgpu::BufferUsages::STORAGE);
        let resources = [
            (0, self.view.as_entire_binding()),
            (1, self.seen_frame.as_entire_binding()),
            (2, draws.as_entire_binding()),
            (3, before.map_or(geometry.placements(), |before| &before.placements).as_entire_binding()),
        ];
        let group = gpu.bind_group("seen frame", &self.frame_layout, &resources);
        let attachments = target.images.each_ref().map(|view| {
            let ops = wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            };
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        });
        let mut pass = recorder.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("seen"),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        if geometry.index_count > 0 {
            pass.set_pipeline(&self.draw);
            pass.set_bind_group(layout::GROUP_FRAME, &group, &[]);
            pass.set_bind_group(layout::GROUP_PLACEMENTS, geometry.placements_group(), &[]);
            let buffers = geometry.vertex_buffers();
            let before = before.map_or(buffers[0], |before| &before.positions);
            for (slot, buffer) in (0..).zip(buffers.into_iter().chain([before])) {
                pass.set_vertex_buffer(slot, buffer.slice(..));
            }
            pass.set_index_buffer(geometry.indices.slice(..), wgpu::IndexFormat::Uint32);
            for (number, material, draw) in geometry.bodies() {
                let material = materials.number(material);
                pass.set_bind_group(layout::GROUP_SURFACE, materials.bind_group(material), &[]);
                pass.draw_indexed(draw.indices, 0, geometry.instances_of(number, &draw.placements));
            }
        }
        drop(pass);
        group
    }

    /// Writes a layer, a LAYER constant, to the target's words.
    pub fn write(
        &self,
        recorder: &mut Recorder<'_>,
        target: &SeenTarget,
        frame_group: &wgpu::BindGroup,
        layer: u32,
    ) {
        let gpu = recorder.gpu;
        let layer = gpu.buffer_with("layer", &layer.to_le_bytes(), wgpu::BufferUsages::UNIFORM);
        let [identities, places] = target.images.each_ref().map(wgpu::BindingResource::TextureView);
        let resources = [
            (0, identities),
            (1, places),
            (2, layer.as_entire_binding()),
            (3, wgpu::BindingResource::TextureView(&target.words_view)),
        ];
        let group = gpu.bind_group("layer", &self.layer_layout, &resources);
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.write);
        set_groups(&mut pass, &[(layout::GROUP_FRAME, frame_group), (layout::GROUP_PASS, &group)]);
        let [width, height] = target.size;
        pass.dispatch_workgroups(width.div_ceil(layout::TILE), height.div_ceil(layout::TILE), 1);
    }
}

/// The camera of some rows of a picture of `size` pixels, top row first.
pub(crate) fn seen_frame(
    camera: &Camera,
    [width, height]: [u32; 2],
    rows: &std::ops::Range<u32>,
    clip_before_from_world: Mat4,
) -> layout::SeenFrame {
    let (extent, is_parallel) = match camera.projection {
        Projection::Perspective { fov_x } => ((0.5 * fov_x).tan(), false),
        Projection::Orthographic { half_width } => (half_width, true),
    };
    // From the rows' own coordinates, upwards from -1 to 1, to those of the picture, in half widths.
    let half_height = height as f32 / width as f32;
    let share = rows.len() as f32 / height as f32;
    let middle = 1.0 - 2.0 * (rows.start as f32 / height as f32) - share;
    let place = |ndc_y: f32| glam::Vec2::new(0.0, half_height * ndc_y);
    let offset = camera.film.plane_from_picture(place(middle));
    let unit = camera.film.plane_from_picture(place(middle) + glam::Vec2::new(1.0, half_height * share));
    layout::SeenFrame {
        clip_before_from_world,
        world_from_camera: camera.world_from_camera,
        plane_scale: extent * (unit - offset),
        plane_offset: extent * offset,
        is_parallel: is_parallel.into(),
    }
}
