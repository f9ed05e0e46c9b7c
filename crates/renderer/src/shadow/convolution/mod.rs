mod mip;
mod sat;
#[cfg(test)]
mod tests;

use gnomon_shaders::{layout, twin::series};

use super::downsample::trilinear_sampler;
use super::{ShadowResources, ShadowSettings, ShadowTechnique, in_range};
use crate::bindings::{Binding, D2_ARRAY, array_view};
use crate::depth_maps::DepthMaps;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Convolution soft shadows (Annen et al. 2008, sections 3 and 4.1).
pub(super) struct Convolution;

/// How the basis images are filtered (Annen et al. 2008, section 4.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Prefilter {
    /// Mip maps of half floats.
    #[default]
    MipChain,
    /// Summed-area tables of 32-bit floats: kernels are boxes of the light's own width and height, a disk's that of its variance.
    SummedAreaTable,
}

/// Shape of the kernels of a mip chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Footprint {
    /// One trilinear lookup as wide as the light is on average.
    #[default]
    Isotropic,
    /// Level by the light's short side and up to four lookups along its long one: true up to sides of 4 to 1, wider beyond.
    Anisotropic,
}

/// Parameters of convolution soft shadows.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvolutionSettings {
    /// Terms of the Fourier series, M: 1 to 16.
    pub order: u32,
    /// How the images are filtered.
    pub prefilter: Prefilter,
    /// Shape of the kernels of [`Prefilter::MipChain`].
    pub footprints: Footprint,
    /// Times that the shadow map's plane is put at the average blocker depth, each under the kernel of the plane before, 0 to 4: 1
    /// is the paper's two-step lookup (section 3.2). 0 leaves the plane at the near plane: penumbrae are as wide as for a
    /// blocker there, and there is no blocker depth to sharpen by.
    pub plane_iterations: u32,
    /// Value of the filtered series that counts as dark, 0 to 0.4; ringing stays below it. With 0 here and a `white_point` of
    /// 1 ringing is not suppressed.
    pub black_point: f32,
    /// Value of the filtered series that counts as lit, 0.6 to 1; ringing stays above it.
    pub white_point: f32,
    /// Strength of the darkening at contacts, A of eq. 9, 0 to 1000; 0 switches it off.
    pub sharpening_a: f32,
    /// Falloff of the darkening with blocker distance as a share of the depth range, B of eq. 9, 0 to 1000.
    pub sharpening_b: f32,
    /// Distance towards the light by which a receiver is moved in the final lookup, as a share of the depth range over M, 0 to 1:
    /// the series' own resolution.
    pub depth_bias: f32,
    /// Factor on every kernel's width, 0 to 10. Stretching the series between `black_point` and `white_point` narrows penumbrae;
    /// this widens them again.
    pub footprint_scale: f32,
    /// Places of the depth map itself that are looked at for blockers too near for the series, each between four texels, 0 to 64; where
    /// there are such blockers, as many are filtered again. 0 leaves contacts to the series, as the paper does.
    pub contact_samples: u32,
    /// Distance from the receiver up to which blockers are looked for in the depth map, as a share of the depth range over M, 0
    /// to 4. The series takes over where it sees nothing but blockers at that distance.
    pub contact_reach: f32,
}

impl ConvolutionSettings {
    /// The paper's method alone: contacts are left to the series and darkened by sharpening.
    pub fn paper() -> Self {
        Self {
            order: 4,
            prefilter: Prefilter::default(),
            footprints: Footprint::default(),
            plane_iterations: 1,
            black_point: 0.02,
            white_point: 0.9,
            sharpening_a: 15.0,
            sharpening_b: 20.0,
            depth_bias: 0.24,
            footprint_scale: 1.4,
            contact_samples: 0,
            contact_reach: 0.85,
        }
    }
}

impl Default for ConvolutionSettings {
    /// The depth map tells what is near: contacts need no darkening, and the series may have more bias. Kernels have the closed form's
    /// penumbrae.
    fn default() -> Self {
        Self {
            sharpening_a: 0.0,
            depth_bias: 0.26,
            footprint_scale: 1.415,
            contact_samples: 8,
            ..Self::paper()
        }
    }
}

/// `M x` at which a series of M terms first reaches 1 after its step at 0: Si(2 pi M x) = pi / 2.
const SERIES_LIT_AT: f32 = 0.3066;

/// The basis images, as `series.wgsl` orders them.
const IMAGES: [&str; 4] = ["basis sin", "basis cos", "basis z sin", "basis z cos"];
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// What is filtered: basis images and linear depth.
struct Images {
    basis: [wgpu::Texture; 4],
    depth: wgpu::Texture,
}

impl ConvolutionSettings {
    /// RGBA layers of a light in one basis image.
    fn groups(&self) -> u32 {
        self.order.clamp(1, 16).div_ceil(4)
    }

    fn parameters(&self, resolution: u32) -> Result<layout::ConvolutionParameters, RenderError> {
        let order = in_range("series order", self.order, 1..=16)?;
        let far: [[glam::Vec4; 2]; 4] =
            std::array::from_fn(|group| series::series_phases(series::SERIES_DEPTH_SCALE, group as u32));
        Ok(layout::ConvolutionParameters {
            order,
            groups: self.groups(),
            resolution: resolution as f32,
            max_level: resolution.ilog2() as f32,
            black_point: in_range("black point of convolution shadows", self.black_point, 0.0..=0.4)?,
            white_point: in_range("white point of convolution shadows", self.white_point, 0.6..=1.0)?,
            sharpening_a: in_range("sharpening A", self.sharpening_a, 0.0..=1000.0)?,
            sharpening_b: in_range("sharpening B", self.sharpening_b, 0.0..=1000.0)?,
            depth_bias: in_range("depth bias of convolution shadows", self.depth_bias, 0.0..=1.0)?
                / order as f32,
            average_bias: SERIES_LIT_AT / order as f32,
            footprint_scale: in_range(
                "kernel scale of convolution shadows",
                self.footprint_scale,
                0.0..=10.0,
            )?,
            plane_iterations: in_range("iterations of the shadow map's plane", self.plane_iterations, 0..=4)?,
            contact_samples: in_range("contact samples", self.contact_samples, 0..=64)?,
            contact_reach: in_range("reach of contact samples", self.contact_reach, 0.0..=4.0)?.max(1e-3)
                / order as f32,
            far_sin: far.map(|phases| phases[1]),
            far_cos: far.map(|phases| phases[0]),
        })
    }
}

impl ShadowTechnique for Convolution {
    fn name(&self) -> &'static str {
        "convolution"
    }

    fn summary(&self) -> &'static str {
        "convolution soft shadows: filtered Fourier series of the shadow test (Annen et al. 2008)"
    }

    fn module(&self, settings: &ShadowSettings) -> &'static str {
        match (settings.convolution.prefilter, settings.convolution.footprints) {
            (Prefilter::SummedAreaTable, _) => "shadow_convolution_sat",
            (Prefilter::MipChain, Footprint::Isotropic) => "shadow_convolution",
            (Prefilter::MipChain, Footprint::Anisotropic) => "shadow_convolution_anisotropic",
        }
    }

    /// The average blocker depth must be filtered in 32 bits.
    fn needed_features(&self) -> wgpu::Features {
        wgpu::Features::FLOAT32_FILTERABLE
    }

    fn needs_depth_maps(&self) -> bool {
        true
    }

    /// In a kernel at the foot of a wall a ground stands in for contacts that a few terms cannot resolve: without it pictures are off by a
    /// sixteenth more.
    fn draws_grounds(&self) -> bool {
        true
    }

    fn bytes_per_light(&self, settings: &ShadowSettings, resolution: u32) -> u64 {
        let groups = settings.convolution.groups();
        match settings.convolution.prefilter {
            Prefilter::MipChain => mip::bytes_per_light(groups, resolution),
            Prefilter::SummedAreaTable => sat::bytes_per_light(groups, resolution),
        }
    }

    fn layers_per_light(&self, settings: &ShadowSettings) -> u32 {
        settings.convolution.groups()
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
    filter: Filter,
}

enum Filter {
    MipChain(mip::MipChain),
    SummedAreaTable(sat::SummedAreaTables),
}

impl Resources {
    fn new(gpu: &Gpu, settings: &ConvolutionSettings, maps: &DepthMaps) -> Result<Self, RenderError> {
        let parameters = settings.parameters(maps.resolution)?;
        let parameters = gpu.shared_buffer("convolution", &parameters, wgpu::BufferUsages::UNIFORM);
        let trilinear = trilinear_sampler(gpu);
        let groups = settings.groups();
        let (filter, images) = match settings.prefilter {
            Prefilter::MipChain => {
                let (chain, images) = mip::MipChain::new(gpu, &parameters, &trilinear, groups, maps)?;
                (Filter::MipChain(chain), images)
            }
            Prefilter::SummedAreaTable => {
                let (tables, images) = sat::SummedAreaTables::new(gpu, &parameters, groups, maps)?;
                (Filter::SummedAreaTable(tables), images)
            }
        };

        let sampled = Binding::Texture { dimension: D2_ARRAY, filterable: true };
        let layout = gpu.layout(
            "convolution",
            wgpu::ShaderStages::COMPUTE,
            &[
                (0, Binding::Uniform),
                (1, sampled),
                (2, sampled),
                (3, sampled),
                (4, sampled),
                (5, sampled),
                (6, Binding::Sampler),
                (7, Binding::Depth { dimension: D2_ARRAY }),
                (8, Binding::GatheringSampler),
            ],
        );
        let views: Vec<_> = images.basis.iter().chain([&images.depth]).map(array_view).collect();
        let mut resources = vec![(0, parameters.as_entire_binding())];
        resources.extend((1..).zip(&views).map(|(i, view)| (i, wgpu::BindingResource::TextureView(view))));
        let gathering = gpu
            .device
            .create_sampler(&wgpu::SamplerDescriptor { label: Some("gathering"), ..Default::default() });
        resources.push((6, wgpu::BindingResource::Sampler(&trilinear)));
        resources.push((7, wgpu::BindingResource::TextureView(&maps.array)));
        resources.push((8, wgpu::BindingResource::Sampler(&gathering)));
        let bind_group = gpu.bind_group("convolution", &layout, &resources);
        Ok(Self { layout, bind_group, filter })
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
        match &self.filter {
            Filter::MipChain(chain) => chain.encode(recorder, light_count),
            Filter::SummedAreaTable(tables) => tables.encode(recorder, light_count),
        }
    }
}
