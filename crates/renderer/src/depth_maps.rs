use gnomon_shaders::layout;

use std::ops::Range;

use crate::bindings::{Binding, array_view};
use crate::geometry::Geometry;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Depth maps for a batch of lights, the layers of one texture array.
pub(crate) struct DepthMaps {
    pub array: wgpu::TextureView,
    pub resolution: u32,
    /// Number of lights there is room for.
    pub capacity: u32,
    pub layers: Vec<wgpu::TextureView>,
}

impl DepthMaps {
    pub fn new(gpu: &Gpu, capacity: u32, resolution: u32) -> Self {
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
        Self { array: array_view(&texture), resolution, capacity, layers }
    }

    /// GPU memory of one light's map in bytes.
    pub fn bytes_per_light(resolution: u32) -> u64 {
        4 * u64::from(resolution).pow(2)
    }
}

/// What a light's map shows.
#[derive(Clone, Debug)]
pub(crate) struct MapView {
    pub is_perspective: bool,
    /// Of the geometry's indices those that are drawn.
    pub indices: Vec<Range<u32>>,
}

/// Draws the scene's depth as every light sees it.
pub(crate) struct ShadowMapPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    perspective_pipeline: wgpu::RenderPipeline,
}

impl ShadowMapPass {
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let bindings = gpu.layout(
            "shadow map",
            wgpu::ShaderStages::VERTEX,
            &[(0, Binding::Storage { read_only: true })],
        );
        let shader = gpu.shader("shadow_map", &[])?;
        let pipeline = |vertex, fragment: Option<wgpu::FragmentState<'_>>| {
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("shadow map"),
                layout: Some(&gpu.pipeline_layout(&[(layout::GROUP_PASS, &bindings)])),
                vertex: wgpu::VertexState {
                    module: &shader.module,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers: &[Some(wgpu::VertexBufferLayout {
                        array_stride: 16,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &wgpu::vertex_attr_array![0 => Float32x4],
                    })],
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
                fragment,
                multiview_mask: None,
                cache: None,
            })
        };
        let linear_depth = wgpu::FragmentState {
            module: &shader.module,
            entry_point: Some("linear_depth"),
            compilation_options: Default::default(),
            targets: &[],
        };
        let perspective_pipeline = pipeline("perspective_shadow_map", Some(linear_depth));
        let pipeline = pipeline("shadow_map", None);
        Ok(Self { layout: bindings, pipeline, perspective_pipeline })
    }

    /// Bind group of the lights of one batch, a buffer of [`layout::Light`].
    pub fn lights_group(&self, gpu: &Gpu, lights: &wgpu::Buffer) -> wgpu::BindGroup {
        gpu.bind_group("shadow map", &self.layout, &[(0, lights.as_entire_binding())])
    }

    /// Draws the maps of a batch of lights.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        maps: &DepthMaps,
        lights_group: &wgpu::BindGroup,
        views: &[MapView],
    ) {
        for ((light, layer), view) in (0..).zip(&maps.layers).zip(views) {
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
            if geometry.index_count > 0 {
                pass.set_pipeline(if view.is_perspective {
                    &self.perspective_pipeline
                } else {
                    &self.pipeline
                });
                pass.set_bind_group(layout::GROUP_PASS, lights_group, &[]);
                pass.set_vertex_buffer(0, geometry.positions_world.slice(..));
                pass.set_index_buffer(geometry.indices.slice(..), wgpu::IndexFormat::Uint32);
                for indices in &view.indices {
                    pass.draw_indexed(indices.clone(), 0, light..light + 1);
                }
            }
        }
    }
}
