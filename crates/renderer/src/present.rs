use gnomon_shaders::layout;

use crate::bindings::Binding;
use crate::{Gpu, RenderError, Renderer};

/// Draws finished pictures over whole windows: into surface textures of one format.
pub struct Presenter {
    gpu: Gpu,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
}

impl Presenter {
    /// For targets of `format`. An sRGB format encodes what is drawn into it, and the picture is decoded for it first; any other
    /// format takes the picture's encoded values as they are. So it looks the same in both.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the format cannot be drawn into.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Result<Self, RenderError> {
        let scopes = gpu.catch_errors();
        let bindings = [(0, Binding::SAMPLED), (1, Binding::Sampler)];
        let picture = gpu.layout("present", wgpu::ShaderStages::FRAGMENT, &bindings);
        let shader = gpu.shader("present", &[])?;
        let fragment = if format.is_srgb() { "present_decoded" } else { "present_encoded" };
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("present"),
            layout: Some(&gpu.pipeline_layout(&[(layout::GROUP_PASS, &picture)])),
            vertex: wgpu::VertexState {
                module: &shader.module,
                entry_point: Some("present_vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader.module,
                entry_point: Some(fragment),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        scopes.finish()?;
        Ok(Self { gpu: gpu.clone(), layout: picture, pipeline, sampler })
    }

    /// Draws the picture that `renderer` has drawn last over all of `target`, black where there is none yet.
    ///
    /// # Errors
    /// The device failed or was lost.
    pub fn draw(&self, renderer: &Renderer, target: &wgpu::TextureView) -> Result<(), RenderError> {
        let scopes = self.gpu.catch_errors();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.record(&mut encoder, renderer, target)?;
        self.gpu.queue.submit([encoder.finish()]);
        scopes.finish()
    }

    /// The same into an encoder of the embedding program, which submits it.
    ///
    /// # Errors
    /// As [`Presenter::draw`].
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        renderer: &Renderer,
        target: &wgpu::TextureView,
    ) -> Result<(), RenderError> {
        let scopes = self.gpu.catch_errors();
        let group = renderer.display_view().map(|picture| {
            self.gpu.bind_group(
                "present",
                &self.layout,
                &[
                    (0, wgpu::BindingResource::TextureView(&picture)),
                    (1, wgpu::BindingResource::Sampler(&self.sampler)),
                ],
            )
        });
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("present"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            if let Some(group) = &group {
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(layout::GROUP_PASS, group, &[]);
                pass.draw(0..3, 0..1);
            }
        }
        scopes.finish()
    }
}
