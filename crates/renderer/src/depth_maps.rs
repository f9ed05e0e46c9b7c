use gnomon_shaders::layout;

use crate::bindings::{Binding, array_view};
use crate::geometry::Geometry;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// One linear depth map a light, the layers of one texture array.
pub(crate) struct DepthMaps {
    pub array: wgpu::TextureView,
    pub resolution: u32,
    pub light_count: u32,
    layers: Vec<wgpu::TextureView>,
    /// Whether each light's map is perspective.
    perspective: Vec<bool>,
    bind_group: wgpu::BindGroup,
}

impl DepthMaps {
    /// Maps for all of `lights`, a buffer of [`layout::Light`]; `perspective` tells which of them see in perspective.
    pub fn new(
        gpu: &Gpu,
        pass: &ShadowMapPass,
        lights: &wgpu::Buffer,
        perspective: Vec<bool>,
        resolution: u32,
    ) -> Result<Self, RenderError> {
        let light_count = perspective.len() as u32;
        let limit = gpu.max_layers();
        if light_count > limit {
            return Err(RenderError::OverLimit {
                what: "lights with a shadow map",
                wanted: u64::from(light_count),
                limit: u64::from(limit),
                adapter: gpu.adapter().name.clone(),
            });
        }
        let texture = gpu.texture(
            "depth maps",
            [resolution, resolution, light_count.max(1)],
            1,
            DEPTH_FORMAT,
            wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        );
        let layers = (0..light_count)
            .map(|layer| {
                texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2),
                    base_array_layer: layer,
                    array_layer_count: Some(1),
                    ..Default::default()
                })
            })
            .collect();
        let bind_group = gpu.bind_group("shadow map", &pass.layout, &[(0, lights.as_entire_binding())]);
        Ok(Self { array: array_view(&texture), resolution, light_count, layers, perspective, bind_group })
    }

    /// GPU memory of the maps in bytes.
    pub fn bytes(&self) -> u64 {
        4 * u64::from(self.resolution).pow(2) * u64::from(self.light_count)
    }
}

/// Draws the scene's depth as every light sees it.
pub(crate) struct ShadowMapPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    perspective_pipeline: wgpu::RenderPipeline,
}

impl ShadowMapPass {
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let layout = gpu.layout(
            "shadow map",
            wgpu::ShaderStages::VERTEX,
            &[(0, Binding::Storage { read_only: true })],
        );
        let module = gpu.shader("shadow_map", &[])?;
        let pipeline = |vertex, fragment: Option<wgpu::FragmentState<'_>>| {
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("shadow map"),
                layout: Some(&gpu.pipeline_layout(&[Some(&layout)])),
                vertex: wgpu::VertexState {
                    module: &module,
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
            module: &module,
            entry_point: Some("linear_depth"),
            compilation_options: Default::default(),
            targets: &[],
        };
        let perspective_pipeline = pipeline("perspective_shadow_map", Some(linear_depth));
        let pipeline = pipeline("shadow_map", None);
        debug_assert_eq!(size_of::<layout::Light>() % 16, 0);
        Ok(Self { layout, pipeline, perspective_pipeline })
    }

    pub fn encode(&self, recorder: &mut Recorder<'_>, geometry: &Geometry, maps: &DepthMaps) {
        for ((light, layer), &perspective) in (0..).zip(&maps.layers).zip(&maps.perspective) {
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
                pass.set_pipeline(if perspective { &self.perspective_pipeline } else { &self.pipeline });
                pass.set_bind_group(0, &maps.bind_group, &[]);
                pass.set_vertex_buffer(0, geometry.positions_world.slice(..));
                pass.set_index_buffer(geometry.indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..geometry.index_count, 0, light..light + 1);
            }
        }
    }
}
