use gnomon_shaders::layout;

use crate::bindings::{Binding, D2, set_groups};
use crate::compose::RADIANCE_FORMAT;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Samples of the picture that lights are summed at, and the sums: the shadow buffer (DeCoro and Rusinkiewicz 2008, section 3.2). One
/// point stands for a tile of `sampling` x `sampling` samples; samples unlike the points around them have their own.
pub(crate) struct ShadingPoints {
    /// Bind group of the passes that list points.
    list_group: wgpu::BindGroup,
    /// Own bind group of the pass that sums light.
    pub light_group: wgpu::BindGroup,
    /// Own bind group of the passes that make a picture of the sums.
    pub compose_group: wgpu::BindGroup,
    /// Arguments of an indirect dispatch over all points.
    pub dispatch: wgpu::Buffer,
    /// The points themselves, [`layout::ShadingPoint`]s.
    pub list: wgpu::Buffer,
    /// How many there is room for.
    pub capacity: u64,
    /// Which sums are kept.
    pub planes: SumPlanes,
    count: wgpu::Buffer,
    /// Of the target.
    pub sample_size: [u32; 2],
    sampling: u32,
}

/// Lists the points of a frame.
pub(crate) struct ShadingPointsPass {
    list_layout: wgpu::BindGroupLayout,
    pub light_layout: wgpu::BindGroupLayout,
    pub compose_layout: wgpu::BindGroupLayout,
    choose: wgpu::ComputePipeline,
    refine: wgpu::ComputePipeline,
    dispatch_size: wgpu::ComputePipeline,
}

/// Bytes of what is kept for every shading point: the point, and what light gives it.
const POINT_BYTES: u64 = 20;
const DIFFUSE_BYTES: u64 = 16;
const SPECULAR_BYTES: u64 = 12;
const NEAR_BYTES: u64 = 12;

/// What a scene needs beside sums of diffuse light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SumPlanes {
    /// Some surface is glossy.
    pub specular: bool,
    /// The scene has lights of its own.
    pub near: bool,
}

/// Bytes of the largest buffer for a picture of `sample_size` samples.
pub(crate) fn largest_buffer(sample_size: [u32; 2], sampling: u32) -> u64 {
    capacity(sample_size, sampling) * POINT_BYTES.max(DIFFUSE_BYTES)
}

/// Room for points: all samples where each has its own, else every tile's and those of every second sample.
fn capacity(sample_size: [u32; 2], sampling: u32) -> u64 {
    let [width, height] = sample_size.map(u64::from);
    let side = u64::from(sampling);
    let room = match sampling {
        1 => width * height,
        _ => width.div_ceil(side) * height.div_ceil(side) + (width * height).div_ceil(2),
    };
    // Buffers have a least size: so many points fill it.
    room.max(16)
}

impl ShadingPointsPass {
    pub fn new(
        gpu: &Gpu,
        view_layout: &wgpu::BindGroupLayout,
        gbuffer_layout: &wgpu::BindGroupLayout,
    ) -> Result<Self, RenderError> {
        let written = Binding::Storage { read_only: false };
        let read = Binding::Storage { read_only: true };
        let numbered = |label, bindings: &[Binding]| {
            let bindings: Vec<_> = (0..).zip(bindings.iter().copied()).collect();
            gpu.layout(label, wgpu::ShaderStages::COMPUTE, &bindings)
        };
        let list_layout = numbered("shading points", &[written; 5]);
        let module = gpu.shader("shading_points", &[])?;
        let picture = Binding::StorageTexture { format: RADIANCE_FORMAT, dimension: D2 };
        let groups = [
            (layout::GROUP_FRAME, view_layout),
            (layout::GROUP_SURFACE, gbuffer_layout),
            (layout::GROUP_PASS, &list_layout),
        ];
        Ok(Self {
            light_layout: numbered("sums of light", &[read, read, written, written, written]),
            compose_layout: numbered("sums to compose", &[read, read, read, read, read, read, picture]),
            choose: gpu.compute_pipeline(&module, "choose", &groups),
            refine: gpu.compute_pipeline(&module, "refine", &groups),
            dispatch_size: gpu.compute_pipeline(&module, "dispatch_size", &groups),
            list_layout,
        })
    }

    /// Buffers for a picture of `sample_size` samples, which becomes `radiance`.
    ///
    /// # Errors
    /// [`RenderError::OverLimit`] where the adapter allows no buffer that large.
    pub fn points(
        &self,
        gpu: &Gpu,
        sample_size: [u32; 2],
        sampling: u32,
        planes: SumPlanes,
        radiance: &wgpu::TextureView,
    ) -> Result<ShadingPoints, RenderError> {
        let [width, height] = sample_size.map(u64::from);
        let side = u64::from(sampling);
        let (samples, tiles) = (width * height, width.div_ceil(side) * height.div_ceil(side));
        let capacity = capacity(sample_size, sampling);
        let (wanted, limit) = (largest_buffer(sample_size, sampling), gpu.largest_storage());
        if wanted > limit {
            return Err(RenderError::OverLimit {
                what: "bytes to sum light at every sample (fewer samples a pixel or coarser shadow sampling need less)",
                wanted,
                limit,
                adapter: gpu.adapter().name.clone(),
            });
        }
        let storage = wgpu::BufferUsages::STORAGE;
        let point_bytes = capacity * POINT_BYTES;
        let points = gpu.empty_buffer("shading points", point_bytes, storage);
        let count = gpu.empty_buffer("number of points", 4, storage | wgpu::BufferUsages::COPY_DST);
        let point_of_tile = gpu.empty_buffer("points of tiles", 4 * tiles, storage);
        let own = if sampling == 1 { 1 } else { samples };
        let point_of_sample = gpu.empty_buffer("points of samples", 4 * own, storage);
        let dispatch = gpu.empty_buffer("dispatch", 16, storage | wgpu::BufferUsages::INDIRECT);
        let plane = |label, is_kept: bool, bytes| {
            gpu.empty_buffer(label, if is_kept { capacity * bytes } else { 0 }, storage)
        };
        let diffuse = plane("sums of diffuse light", true, DIFFUSE_BYTES);
        let specular = plane("sums of specular light", planes.specular, SPECULAR_BYTES);
        let near = plane("sums of near light", planes.near, NEAR_BYTES);
        let group = |label, layout, buffers: &[&wgpu::Buffer], written: Option<&wgpu::TextureView>| {
            let buffers = buffers.iter().map(|buffer| buffer.as_entire_binding());
            let written = written.map(wgpu::BindingResource::TextureView);
            gpu.bind_group(label, layout, &(0..).zip(buffers.chain(written)).collect::<Vec<_>>())
        };
        Ok(ShadingPoints {
            list_group: group(
                "shading points",
                &self.list_layout,
                &[&points, &count, &point_of_tile, &point_of_sample, &dispatch],
                None,
            ),
            light_group: group(
                "sums of light",
                &self.light_layout,
                &[&points, &dispatch, &diffuse, &specular, &near],
                None,
            ),
            compose_group: group(
                "sums to compose",
                &self.compose_layout,
                &[&points, &point_of_tile, &point_of_sample, &diffuse, &specular, &near],
                Some(radiance),
            ),
            dispatch,
            list: points,
            capacity,
            planes,
            count,
            sample_size,
            sampling,
        })
    }

    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        points: &ShadingPoints,
        view_group: &wgpu::BindGroup,
        gbuffer_group: &wgpu::BindGroup,
    ) {
        recorder.encoder.clear_buffer(&points.count, 0, None);
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        let groups = [
            (layout::GROUP_FRAME, view_group),
            (layout::GROUP_SURFACE, gbuffer_group),
            (layout::GROUP_PASS, &points.list_group),
        ];
        set_groups(&mut pass, &groups);
        let [tile_columns, tile_rows] = points.sample_size.map(|side| side.div_ceil(points.sampling));
        pass.set_pipeline(&self.choose);
        pass.dispatch_workgroups(tile_columns.div_ceil(layout::TILE), tile_rows.div_ceil(layout::TILE), 1);
        if points.sampling > 1 {
            let [width, height] = points.sample_size;
            pass.set_pipeline(&self.refine);
            pass.dispatch_workgroups(width.div_ceil(layout::TILE), height.div_ceil(layout::TILE), 1);
        }
        pass.set_pipeline(&self.dispatch_size);
        pass.dispatch_workgroups(1, 1, 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_as_large_as_its_struct() {
        assert_eq!(layout::size::<layout::ShadingPoint>(), POINT_BYTES);
    }

    #[test]
    fn the_default_at_1920_x_1080_fits_what_web_gpu_guarantees() {
        let techniques = crate::TechniqueSettings::default();
        let size = [1920, 1080].map(|side: u32| side * techniques.supersample);
        let limits = wgpu::Limits::default();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let points = capacity(size, techniques.shadow_sampling);
        let largest = largest_buffer(size, techniques.shadow_sampling);
        println!("{points} points, the largest buffer {largest} bytes");
        assert!(largest <= limit, "{largest} of {limit}");
        for bytes in [POINT_BYTES, DIFFUSE_BYTES, SPECULAR_BYTES, NEAR_BYTES] {
            assert!(points * bytes <= largest);
        }
        // What is kept for every sample.
        assert!(4 * u64::from(size[0]) * u64::from(size[1]) <= limit);
        assert!(size[0] <= limits.max_texture_dimension_2d);
    }
}
