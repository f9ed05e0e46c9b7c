use gnomon_options::{Group, number, settings};
use gnomon_shaders::layout;

use super::ShadowSettings;
use super::depth_map::{MapFilter, MapShadows};
use super::depth_maps::{DepthMaps, MapDepth};
use super::downsample::{Downsample, trilinear_sampler};
use super::technique::{ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::bindings::{Binding, D2_ARRAY, array_view, level_view};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Moment soft shadow maps with four moments (Peters and Klein 2015; Peters, Muenstermann, Wetzstein and Klein 2016).
pub(super) struct Moments;

static GROUP: Group = Group {
    table: "moments",
    heading: "Moment soft shadow maps (moments)",
    condition: Some(("shadows", &["moments"])),
};

settings! {
    /// Parameters of moment soft shadow maps.
    pub struct MomentSettings in GROUP {
        /// Share of a wide distribution mixed into every lookup against rounding. Moments of 32 bits need a hundredth of what 16 bits
        /// need, and every share leaks light.
        moment_bias: f32 = 1e-6, number(0.0, 1.0);
        /// Distance towards the light by which a receiver is moved, as a share of the depth range.
        depth_bias: f32 = 0.002, number(0.0, 1.0);
        /// Factor on every kernel's width. At 1.2, with an intensity scale of 1, the penumbra of one light over a plane has its closed
        /// form's width; where many depths meet under a kernel the moments leak light, the more the wider it is, and pictures of many
        /// lights have the least error with narrower ones.
        footprint_scale: f32 = 0.6, number(0.0, 10.0);
        /// Factor on the shadow, which the moments only bound from below.
        intensity_scale: f32 = 1.1, number(1.0, 2.0);
        /// Factor on the offset along the normal: filtered moments need less of it than single texels.
        normal_offset_scale: f32 = 0.5, number(0.0, 10.0);
    }
}

/// Half floats would lose the moments' differences, and 16-bit
/// normalised storage textures are no part of WebGPU.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

impl ShadowTechnique for Moments {
    fn name(&self) -> &'static str {
        "moments"
    }

    fn summary(&self) -> &'static str {
        "moment soft shadow maps: four filtered moments of depth (Peters et al. 2016)"
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        "shadow_moments"
    }

    /// Moments must be filtered in 32 bits.
    fn needed_features(&self) -> wgpu::Features {
        wgpu::Features::FLOAT32_FILTERABLE
    }

    fn has_sharp_maps(&self) -> bool {
        false
    }

    fn depth_maps(&self) -> Option<MapDepth> {
        Some(MapDepth::Linear)
    }

    fn memory(&self, _: &ShadowSettings, resolution: u32) -> ShadowMemory {
        // A full mip chain holds 4/3 of its top level; 16 bytes a texel.
        let images = 16 * u64::from(resolution).pow(2) * 4 / 3;
        ShadowMemory { per_light: DepthMaps::bytes_per_light(resolution) + images, per_pair: 0 }
    }

    fn layers_per_light(&self, _: &ShadowSettings) -> u32 {
        1
    }

    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError> {
        MapShadows::boxed(context, MapDepth::Linear, |maps| {
            Images::new(context.gpu, &context.settings.moments, maps)
        })
    }
}

/// The maps' moments with mip levels.
struct Images {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
    moments: wgpu::ComputePipeline,
    moments_group: wgpu::BindGroup,
    levels: Downsample,
    resolution: u32,
}

impl Images {
    fn new(gpu: &Gpu, settings: &MomentSettings, maps: &DepthMaps) -> Result<Self, RenderError> {
        let resolution = maps.resolution;
        let levels = resolution.ilog2() + 1;
        let parameters = layout::MomentParameters {
            resolution: resolution as f32,
            max_level: (levels - 1) as f32,
            moment_bias: settings.moment_bias,
            depth_bias: settings.depth_bias,
            footprint_scale: settings.footprint_scale,
            intensity_scale: settings.intensity_scale,
            normal_offset_scale: settings.normal_offset_scale,
        };
        let parameters = gpu.shared_buffer("moments", &parameters, wgpu::BufferUsages::UNIFORM);
        let image = gpu.texture(
            "moments",
            [resolution, resolution, maps.capacity.max(1)],
            levels,
            FORMAT,
            wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING,
        );
        let trilinear = trilinear_sampler(gpu);

        let compute = wgpu::ShaderStages::COMPUTE;
        let sampled = Binding::Texture { dimension: D2_ARRAY, filterable: true };
        let written = Binding::StorageTexture { format: FORMAT, dimension: D2_ARRAY };
        let shadow_layout = gpu.layout(
            "moment shadows",
            compute,
            &[(0, Binding::Uniform), (1, sampled), (2, Binding::Sampler)],
        );
        let whole = array_view(&image);
        let bind_group = gpu.bind_group(
            "moment shadows",
            &shadow_layout,
            &[
                (0, parameters.as_entire_binding()),
                (1, wgpu::BindingResource::TextureView(&whole)),
                (2, wgpu::BindingResource::Sampler(&trilinear)),
            ],
        );

        let top = level_view(&image, 0);
        let view = wgpu::BindingResource::TextureView;
        let moments_layout =
            gpu.layout("moments", compute, &[(0, Binding::Depth { dimension: D2_ARRAY }), (1, written)]);
        let moments_group =
            gpu.bind_group("moments", &moments_layout, &[(0, view(&maps.array)), (1, view(&top))]);
        Ok(Self {
            layout: shadow_layout,
            bind_group,
            moments: gpu.compute_pipeline(
                &gpu.shader("moments", &[])?,
                "moments",
                &[(layout::GROUP_PASS, &moments_layout)],
            ),
            moments_group,
            levels: Downsample::new(gpu, &image, &trilinear)?,
            resolution,
        })
    }
}

impl MapFilter for Images {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn encode(&self, recorder: &mut Recorder<'_>, light_count: u32) {
        let tiles = self.resolution.div_ceil(layout::TILE);
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.moments);
        pass.set_bind_group(layout::GROUP_PASS, &self.moments_group, &[]);
        pass.dispatch_workgroups(tiles, tiles, light_count);
        self.levels.encode(&mut pass, light_count);
    }
}
