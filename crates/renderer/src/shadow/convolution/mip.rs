//! Basis images of half floats with mip chains.

use gnomon_shaders::layout;

use super::super::downsample::Downsample;
use super::{DEPTH_FORMAT, IMAGES, Images};
use crate::bindings::{Binding, D2_ARRAY, level_view};
use crate::recorder::Recorder;
use crate::shadow::depth_maps::DepthMaps;
use crate::{Gpu, RenderError};

const BASIS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Bytes of one light's images: four of 8 bytes a texel and group, linear depth of 4; a full mip chain holds 4/3 of its top level.
pub(super) fn bytes_per_light(groups: u32, resolution: u32) -> u64 {
    u64::from(resolution).pow(2) * (u64::from(groups) * 4 * 8 + 4) * 4 / 3
}

pub(super) struct MipChain {
    basis: Dispatch,
    basis_depth: Dispatch,
    /// Of the basis images.
    basis_levels: Vec<Downsample>,
    depth_levels: Downsample,
    resolution: u32,
    groups: u32,
}

struct Dispatch {
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
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
        let depth_layout = gpu.layout(
            "linear depth",
            compute,
            &[(1, Binding::Depth { dimension: D2_ARRAY }), (6, written(DEPTH_FORMAT))],
        );
        let top = images.basis.each_ref().map(|image| level_view(image, 0));
        let source = wgpu::BindingResource::TextureView(&maps.array);
        let mut basis_resources = vec![(0, parameters.as_entire_binding()), (1, source.clone())];
        basis_resources
            .extend((2..).zip(&top).map(|(i, view)| (i, wgpu::BindingResource::TextureView(view))));
        let basis = Dispatch {
            pipeline: gpu.compute_pipeline(&module, "basis", &[(layout::GROUP_PASS, &basis_layout)]),
            bind_group: gpu.bind_group("basis", &basis_layout, &basis_resources),
        };
        let top_depth = level_view(&images.depth, 0);
        let depth_resources = [(1, source), (6, wgpu::BindingResource::TextureView(&top_depth))];
        let basis_depth = Dispatch {
            pipeline: gpu.compute_pipeline(&module, "basis_depth", &[(layout::GROUP_PASS, &depth_layout)]),
            bind_group: gpu.bind_group("linear depth", &depth_layout, &depth_resources),
        };

        let mut basis_levels = Vec::new();
        for image in &images.basis {
            basis_levels.push(Downsample::new(gpu, image, sampler)?);
        }
        let chain = Self {
            basis,
            basis_depth,
            basis_levels,
            depth_levels: Downsample::new(gpu, &images.depth, sampler)?,
            resolution,
            groups,
        };
        Ok((chain, images))
    }

    pub fn encode(&self, recorder: &mut Recorder<'_>, light_count: u32) {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        let full = self.resolution.div_ceil(layout::TILE);
        pass.set_pipeline(&self.basis.pipeline);
        pass.set_bind_group(layout::GROUP_PASS, &self.basis.bind_group, &[]);
        pass.dispatch_workgroups(full, full, light_count * self.groups);
        pass.set_pipeline(&self.basis_depth.pipeline);
        pass.set_bind_group(layout::GROUP_PASS, &self.basis_depth.bind_group, &[]);
        pass.dispatch_workgroups(full, full, light_count);
        for levels in &self.basis_levels {
            levels.encode(&mut pass, light_count * self.groups);
        }
        self.depth_levels.encode(&mut pass, light_count);
    }
}
