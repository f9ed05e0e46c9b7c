use glam::{Mat4, Vec3};
use gnomon_shaders::layout;

use crate::bindings::{Binding, D2_ARRAY, array_view, set_groups};
use crate::materials::tables::{self, TableTextures};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// What lobes reflect of the whole environment for every normal that a viewer sees (DeCoro and Rusinkiewicz 2008, section 3.1).
pub(crate) struct RadianceCache {
    lobes: Vec<layout::CachedLobe>,
    resolution: u32,
    samples: u32,
    /// A [`layout::RadianceCache`].
    pub parameters: wgpu::Buffer,
    /// Shares that f0 and f90 weigh, a layer a lobe.
    pub maps: [wgpu::TextureView; 2],
}

/// Fills the cache.
pub(crate) struct RadianceCachePass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl RadianceCache {
    /// A cache of so many texels a side for `lobes`, of which the first [`layout::MAX_CACHED_LOBES`] count, each texel from `samples`
    /// samples of its lobe.
    pub fn new(gpu: &Gpu, mut lobes: Vec<layout::CachedLobe>, resolution: u32, samples: u32) -> Self {
        lobes.truncate(layout::MAX_CACHED_LOBES as usize);
        let side = if lobes.is_empty() { 1 } else { resolution };
        let map = |label| {
            let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
            let size = [side, side, lobes.len().max(1) as u32];
            array_view(&gpu.texture(label, size, 1, FORMAT, usage))
        };
        let maps = [map("cached radiance of f0"), map("cached radiance of f90")];
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let parameters = gpu.empty_buffer("radiance cache", layout::size::<layout::RadianceCache>(), usage);
        Self { lobes, resolution, samples, parameters, maps }
    }

    /// Whether as many lobes as these can take the place of its own.
    pub fn has_room_for(&self, lobes: &[layout::CachedLobe]) -> bool {
        lobes.len().min(layout::MAX_CACHED_LOBES as usize) == self.lobes.len()
    }

    /// Takes other lobes for the next frame, where [`RadianceCache::has_room_for`] them.
    pub fn rewrite(&mut self, mut lobes: Vec<layout::CachedLobe>) {
        lobes.truncate(self.lobes.len());
        self.lobes = lobes;
    }

    /// Takes the frame's direction to the viewer, and how the environment is turned.
    pub fn write(&self, gpu: &Gpu, to_viewer: Vec3, environment_from_world: Mat4) {
        let (right, up) = to_viewer.any_orthonormal_pair();
        let mut lobes = [layout::CachedLobe::default(); layout::MAX_CACHED_LOBES as usize];
        lobes[..self.lobes.len()].copy_from_slice(&self.lobes);
        let parameters = layout::RadianceCache {
            right,
            count: self.lobes.len() as u32,
            up,
            samples: self.samples,
            to_viewer,
            environment_from_world,
            lobes,
        };
        gpu.write(&self.parameters, &parameters);
    }
}

impl RadianceCachePass {
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let written = Binding::StorageTexture { format: FORMAT, dimension: D2_ARRAY };
        let bindings = [(0, Binding::Uniform), (1, Binding::LOADED), (2, written), (3, written)];
        let own = gpu.layout("radiance cache", wgpu::ShaderStages::COMPUTE, &bindings);
        let module = gpu.shader("radiance_cache", &[])?;
        let tables = gpu.layout("tables", wgpu::ShaderStages::COMPUTE, &tables::bindings());
        let groups = [(layout::GROUP_SURFACE, &tables), (layout::GROUP_PASS, &own)];
        let pipeline = gpu.compute_pipeline(&module, "fill_cache", &groups);
        Ok(Self { layout: own, pipeline })
    }

    /// The pass's bind group; `environment` has mip levels.
    pub fn group(
        &self,
        gpu: &Gpu,
        cache: &RadianceCache,
        environment: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let [f0, f90] = &cache.maps;
        let resources = [
            (0, cache.parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(environment)),
            (2, wgpu::BindingResource::TextureView(f0)),
            (3, wgpu::BindingResource::TextureView(f90)),
        ];
        gpu.bind_group("radiance cache", &self.layout, &resources)
    }

    /// `group` is the pass's own, `tables` those of the scene's materials.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        cache: &RadianceCache,
        group: &wgpu::BindGroup,
        tables: &TableTextures,
    ) {
        if cache.lobes.is_empty() {
            return;
        }
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        set_groups(&mut pass, &[(layout::GROUP_SURFACE, &tables.group), (layout::GROUP_PASS, group)]);
        let groups = cache.resolution.div_ceil(layout::TILE);
        pass.dispatch_workgroups(groups, groups, cache.lobes.len() as u32);
    }
}
