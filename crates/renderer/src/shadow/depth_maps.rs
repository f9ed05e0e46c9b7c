//! Depth of the scene as lights see it.

use gnomon_shaders::layout;

use super::technique::FrameInputs;
use crate::bindings::{Binding, Groups, Shader, array_view};
use crate::geometry::placements_layout;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What a depth map holds. Maps of distant lights are orthographic: there both are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MapDepth {
    /// The share of the way from near to far plane.
    Linear,
    /// What a z-buffer stores, z / w: in a perspective map it resolves near depths finely and far ones coarsely.
    Projected,
}

/// Depth maps for a batch of lights, the layers of one texture array.
pub(crate) struct DepthMaps {
    pub array: wgpu::TextureView,
    depth: MapDepth,
    pub resolution: u32,
    /// Number of lights there is room for.
    pub capacity: u32,
    pub layers: Vec<wgpu::TextureView>,
}

impl DepthMaps {
    pub fn new(gpu: &Gpu, depth: MapDepth, capacity: u32, resolution: u32) -> Self {
        let texture = gpu.texture(
            "depth maps",
            [resolution, resolution, capacity.max(1)],
            1,
            DEPTH_FORMAT,
            wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        );
        let layers = (0..capacity)
            .map(|layer| {
                texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2),
                    base_array_layer: layer,
                    array_layer_count: Some(1),
                    ..Default::default()
                })
            })
            .collect();
        Self { array: array_view(&texture), depth, resolution, capacity, layers }
    }

    /// GPU memory of one light's map in bytes.
    pub fn bytes_per_light(resolution: u32) -> u64 {
        4 * u64::from(resolution).pow(2)
    }
}

/// Draws the scene's depth as every light sees it.
#[derive(Clone)]
pub(crate) struct ShadowMapPass {
    layout: wgpu::BindGroupLayout,
    /// The depth that the rasteriser makes.
    projected: wgpu::RenderPipeline,
    /// Linear depth under a perspective.
    linear: wgpu::RenderPipeline,
    /// The same of copies of meshes.
    placed_projected: wgpu::RenderPipeline,
    placed_linear: wgpu::RenderPipeline,
    /// The same of surfaces with holes.
    masked_projected: wgpu::RenderPipeline,
    masked_linear: wgpu::RenderPipeline,
}

impl ShadowMapPass {
    /// Surfaces with holes take the bind groups of `materials`.
    pub fn new(gpu: &Gpu, materials: &wgpu::BindGroupLayout) -> Result<Self, RenderError> {
        let bindings = gpu.layout(
            "shadow map",
            wgpu::ShaderStages::VERTEX,
            &[(0, Binding::Storage { read_only: true })],
        );
        let lights = (layout::GROUP_PASS, &bindings);
        let placements = placements_layout(gpu);
        let placements = (layout::GROUP_PLACEMENTS, &placements);
        let whole = gpu.shader("shadow_map", &[])?;
        let masked = gpu.shader("shadow_map_masked", &[])?;
        let pipeline =
            |shader: &Shader, vertex, fragment: Option<&str>, groups: Groups<'_>, buffers: &[_]| {
                gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some("shadow map"),
                    layout: Some(&gpu.pipeline_layout(groups)),
                    vertex: wgpu::VertexState {
                        module: &shader.module,
                        entry_point: Some(vertex),
                        compilation_options: Default::default(),
                        buffers,
                    },
                    // No culling: open meshes cast shadows from both sides.
                    primitive: Default::default(),
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format: DEPTH_FORMAT,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(wgpu::CompareFunction::Less),
                        stencil: Default::default(),
                        bias: Default::default(),
                    }),
                    multisample: Default::default(),
                    fragment: fragment.map(|entry_point| wgpu::FragmentState {
                        module: &shader.module,
                        entry_point: Some(entry_point),
                        compilation_options: Default::default(),
                        targets: &[],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            };
        let buffer = |array_stride, attributes| {
            let step_mode = wgpu::VertexStepMode::Vertex;
            Some(wgpu::VertexBufferLayout { array_stride, step_mode, attributes })
        };
        let position = wgpu::vertex_attr_array![0 => Float32x4];
        let uvs_and_color = wgpu::vertex_attr_array![1 => Float32x4, 2 => Float32x4];
        let (positions, attributes) = (buffer(16, &position), buffer(32, &uvs_and_color));
        let of_whole = |vertex, fragment| {
            pipeline(&whole, vertex, fragment, &[lights, placements], std::slice::from_ref(&positions))
        };
        let of_masked = |fragment| {
            let groups = [(layout::GROUP_SURFACE, materials), lights, placements];
            let buffers = [positions.clone(), attributes.clone()];
            pipeline(&masked, "masked_shadow_map", Some(fragment), &groups, &buffers)
        };
        Ok(Self {
            projected: of_whole("shadow_map", None),
            linear: of_whole("linear_shadow_map", Some("linear_depth")),
            placed_projected: of_whole("placed_shadow_map", None),
            placed_linear: of_whole("placed_linear_shadow_map", Some("linear_depth")),
            masked_projected: of_masked("masked_depth"),
            masked_linear: of_masked("masked_linear_depth"),
            layout: bindings,
        })
    }

    /// Layout of that bind group.
    pub fn lights_layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Bind group of the lights of one batch, a buffer of [`layout::Light`].
    pub fn lights_group(&self, gpu: &Gpu, lights: &wgpu::Buffer) -> wgpu::BindGroup {
        gpu.bind_group("shadow map", &self.layout, &[(0, lights.as_entire_binding())])
    }

    /// Draws the maps of a batch of lights.
    pub fn encode(&self, recorder: &mut Recorder<'_>, maps: &DepthMaps, frame: &FrameInputs<'_>) {
        let (geometry, lights) = (frame.geometry, frame.lights);
        let drawn = maps.layers.iter().zip(lights.uniforms).zip(lights.casters);
        for (number, ((layer, light), casters)) in (0..).zip(drawn) {
            let mut pass = recorder.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow map"),
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: layer,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(1.0),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            if geometry.index_count == 0 {
                continue;
            }
            let is_orthographic = light.kind == layout::KIND_DISTANT;
            let (whole_pipeline, placed_pipeline, masked_pipeline) = match maps.depth {
                MapDepth::Linear if !is_orthographic => {
                    (&self.linear, &self.placed_linear, &self.masked_linear)
                }
                _ => (&self.projected, &self.placed_projected, &self.masked_projected),
            };
            let (masked, whole) = geometry.split_masked(&casters.draws);
            let (copies, whole): (Vec<_>, Vec<_>) =
                whole.into_iter().partition(|draw| draw.placements.start > 0);
            let [positions_world, _, _, attributes] = geometry.vertex_buffers();
            pass.set_pipeline(whole_pipeline);
            pass.set_bind_group(layout::GROUP_PASS, lights.group, &[]);
            pass.set_bind_group(layout::GROUP_PLACEMENTS, geometry.placements_group(), &[]);
            pass.set_vertex_buffer(0, positions_world.slice(..));
            pass.set_index_buffer(geometry.indices.slice(..), wgpu::IndexFormat::Uint32);
            for draw in whole {
                pass.draw_indexed(draw.indices, 0, number..number + 1);
            }
            if !copies.is_empty() {
                pass.set_pipeline(placed_pipeline);
            }
            for draw in copies {
                pass.draw_indexed(draw.indices, 0, geometry.instances_of(number, &draw.placements));
            }
            if masked.is_empty() {
                continue;
            }
            pass.set_pipeline(masked_pipeline);
            pass.set_vertex_buffer(1, attributes.slice(..));
            for range in masked {
                let material = frame.materials.number(range.material);
                pass.set_bind_group(layout::GROUP_SURFACE, frame.materials.bind_group(material), &[]);
                let draw = material as u32 * layout::MAX_BATCH_LIGHTS + number;
                pass.draw_indexed(range.indices, 0, geometry.instances_of(draw, &range.placements));
            }
        }
    }
}
