use gnomon_shaders::layout;

use crate::bindings::{Binding, D2_ARRAY, level_view};
use crate::{Gpu, RenderError};

/// Fills every level of a texture array's mip chain from the one above it, through a kernel whose texels overlap.
pub(super) struct Downsample {
    pipeline: wgpu::ComputePipeline,
    /// Bind group and edge length of every level from the second on.
    levels: Vec<(wgpu::BindGroup, u32)>,
}

impl Downsample {
    /// For a square `texture` of half floats, or of one or four 32-bit floats; `trilinear` as [`trilinear_sampler`] makes it.
    pub fn new(gpu: &Gpu, texture: &wgpu::Texture, trilinear: &wgpu::Sampler) -> Result<Self, RenderError> {
        let format = texture.format();
        let (entry, written) = match format {
            wgpu::TextureFormat::R32Float => ("downsample_r32", 2),
            wgpu::TextureFormat::Rgba32Float => ("downsample_rgba32", 4),
            _ => ("downsample_rgba16", 1),
        };
        let own = gpu.layout(
            "downsample",
            wgpu::ShaderStages::COMPUTE,
            &[
                (0, Binding::Texture { dimension: D2_ARRAY, filterable: true }),
                (written, Binding::StorageTexture { format, dimension: D2_ARRAY }),
                (3, Binding::Sampler),
            ],
        );
        let views: Vec<_> = (0..texture.mip_level_count()).map(|level| level_view(texture, level)).collect();
        let group = |pair: &[wgpu::TextureView]| match pair {
            [fine, coarse] => {
                let sampler = wgpu::BindingResource::Sampler(trilinear);
                let (fine, coarse) =
                    (wgpu::BindingResource::TextureView(fine), wgpu::BindingResource::TextureView(coarse));
                let resources = [(0, fine), (written, coarse), (3, sampler)];
                Some(gpu.bind_group("downsample", &own, &resources))
            }
            _ => None,
        };
        let sizes = (1..).map(|level| texture.width() >> level);
        Ok(Self {
            pipeline: gpu.compute_pipeline(
                &gpu.shader("downsample", &[])?,
                entry,
                &[(layout::GROUP_PASS, &own)],
            ),
            levels: views.windows(2).filter_map(group).zip(sizes).collect(),
        })
    }

    /// Of the first so many layers.
    pub fn encode(&self, pass: &mut wgpu::ComputePass<'_>, layers: u32) {
        pass.set_pipeline(&self.pipeline);
        for (group, size) in &self.levels {
            let tiles = size.div_ceil(layout::TILE);
            pass.set_bind_group(layout::GROUP_PASS, group, &[]);
            pass.dispatch_workgroups(tiles, tiles, layers);
        }
    }
}

/// Linear within levels and between them; beyond an edge lies the edge.
pub(super) fn trilinear_sampler(gpu: &Gpu) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("trilinear"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    })
}
