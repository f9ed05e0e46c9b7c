//! Basis images of half floats with mip chains.

use super::{DEPTH_FORMAT, IMAGES, Images};
use crate::bindings::{Binding, D2_ARRAY, level_view};
use crate::depth_maps::DepthMaps;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

const BASIS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Bytes of one light's images: four of 8 bytes a texel and group, linear depth of 4; a full mip chain holds 4/3 of its top level.
pub(super) fn bytes_per_light(groups: u32, resolution: u32) -> u64 {
    u64::from(resolution).pow(2) * (u64::from(groups) * 4 * 8 + 4) * 4 / 3
}

pub(super) struct MipChain {
    basis: Dispatch,
    basis_depth: Dispatch,
    basis_depth_group: wgpu::BindGroup,
    steps: Vec<MipStep>,
    mip_rgba16: wgpu::ComputePipeline,
    mip_r32: wgpu::ComputePipeline,
    resolution: u32,
    groups: u32,
}

struct Dispatch {
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
}

/// One level of one texture.
struct MipStep {
    bind_group: wgpu::BindGroup,
    size: u32,
    basis: bool,
}

impl MipChain {
    pub fn new(
        gpu: &Gpu,
        parameters: &wgpu::Buffer,
        sampler: &wgpu::Sampler,
        groups: u32,
        maps: &DepthMaps,
    ) -> Result<(Self, Images), RenderError> {
        let resolution = maps.resolution;
        let capacity = maps.capacity.max(1);
        let levels = resolution.ilog2() + 1;
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let image = |label, layers, format| {
            gpu.texture(label, [resolution, resolution, layers], levels, format, usage)
        };
        let images = Images {
            basis: IMAGES.map(|label| image(label, capacity * groups, BASIS_FORMAT)),
            depth: image("linear depth", capacity, DEPTH_FORMAT),
        };

        let compute = wgpu::ShaderStages::COMPUTE;
        let sampled = Binding::Texture { dimension: D2_ARRAY, filterable: true };
        let written = |format| Binding::StorageTexture { format, dimension: D2_ARRAY };
        let module = gpu.shader("basis", &[])?;
        let basis_layout = gpu.layout(
            "basis",
            compute,
            &[
                (0, Binding::Uniform),
                (1, Binding::Depth { dimension: D2_ARRAY }),
                (2, written(BASIS_FORMAT)),
                (3, written(BASIS_FORMAT)),
                (4, written(BASIS_FORMAT)),
                (5, written(BASIS_FORMAT)),
            ],
        );
        // The depth map alone, for the entry point that does not write the basis.
        let source_layout =
            gpu.layout("basis source", compute, &[(1, Binding::Depth { dimension: D2_ARRAY })]);
        let depth_layout = gpu.layout("linear depth", compute, &[(0, written(DEPTH_FORMAT))]);
        let top = images.basis.each_ref().map(|image| level_view(image, 0));
        let source = wgpu::BindingResource::TextureView(&maps.array);
        let mut basis_resources = vec![(0, parameters.as_entire_binding()), (1, source.clone())];
        basis_resources
            .extend((2..).zip(&top).map(|(i, view)| (i, wgpu::BindingResource::TextureView(view))));
        let basis = Dispatch {
            pipeline: gpu.compute_pipeline(&module, "basis", &[Some(&basis_layout)]),
            bind_group: gpu.bind_group("basis", &basis_layout, &basis_resources),
        };
        let basis_depth = Dispatch {
            pipeline: gpu.compute_pipeline(
                &module,
                "basis_depth",
                &[Some(&source_layout), Some(&depth_layout)],
            ),
            bind_group: gpu.bind_group("basis source", &source_layout, &[(1, source)]),
        };
        let top_depth = level_view(&images.depth, 0);
        let basis_depth_group = gpu.bind_group(
            "linear depth",
            &depth_layout,
            &[(0, wgpu::BindingResource::TextureView(&top_depth))],
        );

        let module = gpu.shader("downsample", &[])?;
        let mip_layout = |binding, format| {
            let bindings = [(0, sampled), (binding, written(format)), (3, Binding::Sampler)];
            gpu.layout("downsample", compute, &bindings)
        };
        let (rgba16_layout, r32_layout) = (mip_layout(1, BASIS_FORMAT), mip_layout(2, DEPTH_FORMAT));
        let mut steps = Vec::new();
        for level in 1..levels {
            let basis_images = images.basis.iter().map(|image| (image, true));
            for (image, basis) in basis_images.chain([(&images.depth, false)]) {
                let (fine, coarse) = (level_view(image, level - 1), level_view(image, level));
                let (layout, binding) = if basis { (&rgba16_layout, 1) } else { (&r32_layout, 2) };
                let bind_group = gpu.bind_group(
                    "downsample",
                    layout,
                    &[
                        (0, wgpu::BindingResource::TextureView(&fine)),
                        (binding, wgpu::BindingResource::TextureView(&coarse)),
                        (3, wgpu::BindingResource::Sampler(sampler)),
                    ],
                );
                steps.push(MipStep { bind_group, size: resolution >> level, basis });
            }
        }
        let chain = Self {
            basis,
            basis_depth,
            basis_depth_group,
            steps,
            mip_rgba16: gpu.compute_pipeline(&module, "downsample_rgba16", &[Some(&rgba16_layout)]),
            mip_r32: gpu.compute_pipeline(&module, "downsample_r32", &[Some(&r32_layout)]),
            resolution,
            groups,
        };
        Ok((chain, images))
    }

    pub fn encode(&self, recorder: &mut Recorder<'_>, light_count: u32) {
        let tiles = |size: u32| size.div_ceil(8);
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        let full = tiles(self.resolution);
        pass.set_pipeline(&self.basis.pipeline);
        pass.set_bind_group(0, &self.basis.bind_group, &[]);
        pass.dispatch_workgroups(full, full, light_count * self.groups);
        pass.set_pipeline(&self.basis_depth.pipeline);
        pass.set_bind_group(0, &self.basis_depth.bind_group, &[]);
        pass.set_bind_group(1, &self.basis_depth_group, &[]);
        pass.dispatch_workgroups(full, full, light_count);
        for step in &self.steps {
            pass.set_pipeline(if step.basis { &self.mip_rgba16 } else { &self.mip_r32 });
            pass.set_bind_group(0, &step.bind_group, &[]);
            let layers = if step.basis { light_count * self.groups } else { light_count };
            pass.dispatch_workgroups(tiles(step.size), tiles(step.size), layers);
        }
    }
}
