//! Nearest and farthest depth in squares of texels of depth maps: tells at once where nothing blocks and where everything does.

use gnomon_shaders::layout;

use super::depth_maps::DepthMaps;
use crate::bindings::{Binding, D2_ARRAY, array_view, level_view};
use crate::{Gpu, RenderError};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

/// A pyramid over depth maps. Its first level has half the texels of the maps along each side, its last one has one.
pub(super) struct MinMax {
    /// All levels, to be loaded from.
    pub view: wgpu::TextureView,
    first: wgpu::ComputePipeline,
    next: wgpu::ComputePipeline,
    /// Bind group and edge length of every level.
    levels: Vec<(wgpu::BindGroup, u32)>,
}

impl MinMax {
    /// Room for the maps' pyramid.
    pub fn new(gpu: &Gpu, maps: &DepthMaps) -> Result<Self, RenderError> {
        let side = (maps.resolution / 2).max(1);
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let size = [side, side, maps.capacity.max(1)];
        let texture = gpu.texture("depth ranges", size, side.ilog2() + 1, FORMAT, usage);
        let compute = wgpu::ShaderStages::COMPUTE;
        let written = (2, Binding::StorageTexture { format: FORMAT, dimension: D2_ARRAY });
        let of_maps = [(0, Binding::Depth { dimension: D2_ARRAY }), written];
        let of_level = [(1, Binding::Texture { dimension: D2_ARRAY, filterable: false }), written];
        let first_layout = gpu.layout("depth ranges", compute, &of_maps);
        let next_layout = gpu.layout("depth ranges", compute, &of_level);
        let views: Vec<_> = (0..texture.mip_level_count()).map(|level| level_view(&texture, level)).collect();
        let view = wgpu::BindingResource::TextureView;
        let mut levels = Vec::with_capacity(views.len());
        for (level, coarse) in views.iter().enumerate() {
            let group = match level.checked_sub(1).and_then(|finer| views.get(finer)) {
                None => gpu.bind_group(
                    "depth ranges",
                    &first_layout,
                    &[(0, view(&maps.array)), (2, view(coarse))],
                ),
                Some(fine) => {
                    gpu.bind_group("depth ranges", &next_layout, &[(1, view(fine)), (2, view(coarse))])
                }
            };
            levels.push((group, side >> level));
        }
        let shader = gpu.shader("min_max", &[])?;
        Ok(Self {
            view: array_view(&texture),
            first: gpu.compute_pipeline(&shader, "first_level", &[(layout::GROUP_PASS, &first_layout)]),
            next: gpu.compute_pipeline(&shader, "next_level", &[(layout::GROUP_PASS, &next_layout)]),
            levels,
        })
    }

    /// GPU memory for one map of a resolution, in bytes.
    pub fn bytes_per_light(resolution: u32) -> u64 {
        // A quarter of the texels, of eight bytes, and a third more for the levels above.
        8 * u64::from(resolution).pow(2) / 3
    }

    /// Fills the pyramid of the first so many layers.
    pub fn encode(&self, pass: &mut wgpu::ComputePass<'_>, layers: u32) {
        for (level, (group, side)) in self.levels.iter().enumerate() {
            let tiles = side.div_ceil(layout::TILE);
            pass.set_pipeline(if level == 0 { &self.first } else { &self.next });
            pass.set_bind_group(layout::GROUP_PASS, group, &[]);
            pass.dispatch_workgroups(tiles, tiles, layers);
        }
    }
}
