use gnomon_picture::tonemap::ToneMapping;
use gnomon_shaders::layout;

use crate::bindings::{Binding, D2};
use crate::compose::RADIANCE_FORMAT;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

const DISPLAY_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The finished picture on the GPU.
pub(crate) struct Output {
    pub radiance: wgpu::Texture,
    pub display: wgpu::Texture,
    bind_group: wgpu::BindGroup,
    parameters: wgpu::Buffer,
    size: [u32; 2],
}

/// Filters samples to pixels and tone-maps them.
pub(crate) struct ResolvePass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl ResolvePass {
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let written = |format| Binding::StorageTexture { format, dimension: D2 };
        let own = gpu.layout(
            "resolve",
            wgpu::ShaderStages::COMPUTE,
            &[
                (0, Binding::Uniform),
                (1, Binding::LOADED),
                (2, written(RADIANCE_FORMAT)),
                (3, written(DISPLAY_FORMAT)),
            ],
        );
        let pipeline =
            gpu.compute_pipeline(&gpu.shader("resolve", &[])?, "resolve", &[(layout::GROUP_PASS, &own)]);
        Ok(Self { layout: own, pipeline })
    }

    /// Textures for pictures of `size` pixels, made from `samples`.
    pub fn output(&self, gpu: &Gpu, samples: &wgpu::TextureView, size: [u32; 2]) -> Output {
        let usage = wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::TEXTURE_BINDING;
        let [width, height] = size;
        let radiance = gpu.texture("radiance", [width, height, 1], 1, RADIANCE_FORMAT, usage);
        let display = gpu.texture("display", [width, height, 1], 1, DISPLAY_FORMAT, usage);
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let parameters = gpu.empty_buffer("resolve", layout::size::<layout::ResolveParameters>(), uniform);
        let (radiance_view, display_view) =
            (radiance.create_view(&Default::default()), display.create_view(&Default::default()));
        let bind_group = gpu.bind_group(
            "resolve",
            &self.layout,
            &[
                (0, parameters.as_entire_binding()),
                (1, wgpu::BindingResource::TextureView(samples)),
                (2, wgpu::BindingResource::TextureView(&radiance_view)),
                (3, wgpu::BindingResource::TextureView(&display_view)),
            ],
        );
        Output { radiance, display, bind_group, parameters, size }
    }

    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        output: &Output,
        samples: u32,
        exposure_ev: f32,
        tone_mapping: ToneMapping,
    ) {
        let parameters = layout::ResolveParameters {
            samples,
            exposure: gnomon_picture::tonemap::exposure_scale(exposure_ev),
            tone_mapping: match tone_mapping {
                ToneMapping::Linear => layout::TONE_LINEAR,
                ToneMapping::Neutral => layout::TONE_NEUTRAL,
            },
        };
        recorder.gpu.write(&output.parameters, &parameters);
        let [width, height] = output.size;
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(layout::GROUP_PASS, &output.bind_group, &[]);
        pass.dispatch_workgroups(width.div_ceil(layout::TILE), height.div_ceil(layout::TILE), 1);
    }
}
