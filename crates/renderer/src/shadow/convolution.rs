use gnomon_shaders::layout;

use super::{ShadowResources, ShadowSettings, ShadowTechnique};
use crate::bindings::{Binding, D2_ARRAY, array_view, level_view};
use crate::depth_maps::DepthMaps;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Convolution soft shadows on mip maps (Annen et al. 2008, sections 3 and 4.1).
pub(super) struct Convolution;

/// Parameters of convolution soft shadows.
#[derive(Clone, Debug)]
pub struct ConvolutionSettings {
    /// Terms of the Fourier series, M: 1 to 16.
    pub order: u32,
    /// Value of the filtered series that counts as dark; ringing stays below it.
    pub black_point: f32,
    /// Value of the filtered series that counts as lit; ringing stays above it.
    pub white_point: f32,
    /// Strength of the darkening at contacts, A of eq. 9; 0 switches it off.
    pub sharpening_a: f32,
    /// Falloff of the darkening with blocker distance as a share of the depth range, B of eq. 9.
    pub sharpening_b: f32,
    /// Distance towards the light by which a receiver is moved in the final lookup, as a share of the depth range over M:
    /// the series' own resolution.
    pub depth_bias: f32,
    /// Factor on every kernel's width. Stretching the series between `black_point` and `white_point` narrows penumbrae; this
    /// widens them again.
    pub footprint_scale: f32,
}

impl Default for ConvolutionSettings {
    fn default() -> Self {
        Self {
            order: 4,
            black_point: 0.02,
            white_point: 0.9,
            sharpening_a: 15.0,
            sharpening_b: 20.0,
            depth_bias: 0.24,
            footprint_scale: 1.4,
        }
    }
}

/// `M x` at which a series of M terms first reaches 1 after its step at 0: Si(2 pi M x) = pi / 2.
const SERIES_LIT_AT: f32 = 0.3066;

const BASIS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

impl ShadowTechnique for Convolution {
    fn name(&self) -> &'static str {
        "convolution"
    }

    fn summary(&self) -> &'static str {
        "convolution soft shadows: filtered Fourier series of the shadow test (Annen et al. 2008)"
    }

    fn module(&self) -> &'static str {
        "shadow_convolution"
    }

    fn needs_depth_maps(&self) -> bool {
        true
    }

    fn bytes_per_light(&self, settings: &ShadowSettings, resolution: u32) -> u64 {
        // Four images of 8 bytes a texel and group, linear depth of 4; a full mip chain holds 4/3 of its top level.
        let groups = u64::from(settings.convolution.order.div_ceil(4));
        u64::from(resolution).pow(2) * 4 / 3 * (groups * 4 * 8 + 4)
    }

    fn layers_per_light(&self, settings: &ShadowSettings) -> u32 {
        settings.convolution.order.div_ceil(4)
    }

    fn resources(
        &self,
        gpu: &Gpu,
        settings: &ShadowSettings,
        maps: &DepthMaps,
    ) -> Result<Box<dyn ShadowResources>, RenderError> {
        Ok(Box::new(Resources::new(gpu, &settings.convolution, maps)?))
    }
}

struct Resources {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
    basis: Dispatch,
    basis_depth: Dispatch,
    basis_depth_group: wgpu::BindGroup,
    mips: Vec<MipStep>,
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

impl Resources {
    fn new(gpu: &Gpu, settings: &ConvolutionSettings, maps: &DepthMaps) -> Result<Self, RenderError> {
        if !(1..=16).contains(&settings.order) {
            return Err(RenderError::OutOfRange {
                what: "series order",
                range: "1 to 16".to_owned(),
                value: settings.order.to_string(),
            });
        }
        let groups = settings.order.div_ceil(4);
        let capacity = maps.capacity.max(1);
        let layers = capacity * groups;
        let resolution = maps.resolution;
        let levels = resolution.ilog2() + 1;
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let image = |label, layers, format| {
            gpu.texture(label, [resolution, resolution, layers], levels, format, usage)
        };
        let basis_images: Vec<wgpu::Texture> = ["basis sin", "basis cos", "basis z sin", "basis z cos"]
            .into_iter()
            .map(|label| image(label, layers, BASIS_FORMAT))
            .collect();
        let depth_image = image("linear depth", capacity, DEPTH_FORMAT);

        let parameters = layout::ConvolutionParameters {
            order: settings.order,
            groups,
            resolution: resolution as f32,
            max_level: (levels - 1) as f32,
            black_point: settings.black_point,
            white_point: settings.white_point,
            sharpening_a: settings.sharpening_a,
            sharpening_b: settings.sharpening_b,
            depth_bias: settings.depth_bias / settings.order as f32,
            average_bias: SERIES_LIT_AT / settings.order as f32,
            footprint_scale: settings.footprint_scale,
            padding: 0.0,
        };
        let parameters =
            gpu.buffer_with("convolution", bytemuck::bytes_of(&parameters), wgpu::BufferUsages::UNIFORM);

        let compute = wgpu::ShaderStages::COMPUTE;
        let sampled = Binding::Texture { dimension: D2_ARRAY, filterable: true };
        let layout = gpu.layout(
            "convolution",
            compute,
            &[
                (0, Binding::Uniform),
                (1, sampled),
                (2, sampled),
                (3, sampled),
                (4, sampled),
                (5, sampled),
                (6, Binding::Sampler),
            ],
        );
        let trilinear = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("trilinear"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let views: Vec<_> = basis_images.iter().chain([&depth_image]).map(array_view).collect();
        let mut resources = vec![(0, parameters.as_entire_binding())];
        resources.extend((1..).zip(&views).map(|(i, view)| (i, wgpu::BindingResource::TextureView(view))));
        resources.push((6, wgpu::BindingResource::Sampler(&trilinear)));
        let bind_group = gpu.bind_group("convolution", &layout, &resources);

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
        let top: Vec<_> = basis_images.iter().map(|image| level_view(image, 0)).collect();
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
        let top_depth = level_view(&depth_image, 0);
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
        let mut mips = Vec::new();
        for level in 1..levels {
            let images = basis_images.iter().map(|image| (image, true));
            for (image, basis) in images.chain([(&depth_image, false)]) {
                let (fine, coarse) = (level_view(image, level - 1), level_view(image, level));
                let (layout, binding) = if basis { (&rgba16_layout, 1) } else { (&r32_layout, 2) };
                let bind_group = gpu.bind_group(
                    "downsample",
                    layout,
                    &[
                        (0, wgpu::BindingResource::TextureView(&fine)),
                        (binding, wgpu::BindingResource::TextureView(&coarse)),
                        (3, wgpu::BindingResource::Sampler(&trilinear)),
                    ],
                );
                mips.push(MipStep { bind_group, size: resolution >> level, basis });
            }
        }
        Ok(Self {
            layout,
            bind_group,
            basis,
            basis_depth,
            basis_depth_group,
            mips,
            mip_rgba16: gpu.compute_pipeline(&module, "downsample_rgba16", &[Some(&rgba16_layout)]),
            mip_r32: gpu.compute_pipeline(&module, "downsample_r32", &[Some(&r32_layout)]),
            resolution,
            groups,
        })
    }
}

impl ShadowResources for Resources {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn encode(&self, recorder: &mut Recorder<'_>, light_count: u32) {
        if light_count == 0 {
            return;
        }
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
        for step in &self.mips {
            pass.set_pipeline(if step.basis { &self.mip_rgba16 } else { &self.mip_r32 });
            pass.set_bind_group(0, &step.bind_group, &[]);
            let layers = if step.basis { light_count * self.groups } else { light_count };
            pass.dispatch_workgroups(tiles(step.size), tiles(step.size), layers);
        }
    }
}
