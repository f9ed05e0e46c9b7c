mod mip;
mod sat;
#[cfg(test)]
mod tests;

use gnomon_options::{Group, choice, choices, number, settings, whole};
use gnomon_shaders::{layout, twin::series};

use super::ShadowSettings;
use super::depth_map::{MapFilter, MapShadows};
use super::depth_maps::{DepthMaps, MapDepth};
use super::downsample::trilinear_sampler;
use super::technique::{ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::bindings::{Binding, D2_ARRAY, array_view};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Convolution soft shadows (Annen et al. 2008, sections 3 and 4.1).
pub(super) struct Convolution;

choices! {
    /// How the basis images are filtered (Annen et al. 2008, section 4.1).
    pub enum Prefilter {
        /// Mip chains of half floats.
        MipChain = "mip",
        /// Summed-area tables of 32-bit floats: kernels are boxes of the light's own width and height, a disk's that of its variance.
        SummedAreaTable = "sat",
    }
}

choices! {
    /// Shape of the kernels of a mip chain.
    pub enum Footprint {
        /// One trilinear lookup as wide as the light is on average.
        Isotropic = "isotropic",
        /// Level by the light's short side and up to four lookups along its long one: true up to sides of 4 to 1, wider beyond.
        Anisotropic = "anisotropic",
    }
}

static GROUP: Group = Group {
    table: "convolution",
    heading: "Convolution soft shadows (convolution)",
    condition: Some(("shadows", &["convolution"])),
};

settings! {
    /// Parameters of convolution soft shadows. By default the depth map tells what is near ([`ConvolutionSettings::contact_samples`]):
    /// contacts need no darkening, the series may have more bias, and kernels have the closed form's penumbrae.
    pub struct ConvolutionSettings in GROUP {
        /// Terms of the Fourier series, M. More tell blockers apart that are closer to the receiver, and cost time and memory for every
        /// four.
        order: u32 = 4, whole(1, 16).alias("order");
        /// How the images are filtered.
        prefilter: Prefilter = Prefilter::default(), choice(Prefilter::choices).alias("prefilter");
        /// Shape of the kernels of a mip chain.
        footprints: Footprint = Footprint::default(), choice(Footprint::choices);
        /// Times that the shadow map's plane is put at the average blocker depth, each under the kernel of the plane before: 1 is the
        /// paper's two-step lookup (section 3.2). 0 leaves the plane at the near plane: penumbrae are as wide as for a blocker there, and
        /// there is no blocker depth to sharpen by.
        plane_iterations: u32 = 1, whole(0, 4);
        /// Value of the filtered series that counts as dark; ringing stays below it. With 0 here and a white point of 1 ringing is not
        /// suppressed.
        black_point: f32 = 0.02, number(0.0, 0.4);
        /// Value of the filtered series that counts as lit; ringing stays above it.
        white_point: f32 = 0.9, number(0.6, 1.0);
        /// Strength of the darkening at contacts, A of eq. 9; 0 switches it off.
        sharpening_a: Option<f32> = None,
            number(0.0, 1000.0).automatic("0, or 15 where contacts are left to the series", 15.0);
        /// Falloff of the darkening with blocker distance as a share of the depth range, B of eq. 9.
        sharpening_b: f32 = 20.0, number(0.0, 1000.0);
        /// Distance towards the light by which a receiver is moved in the final lookup, as a share of the depth range over M, the series'
        /// own resolution.
        depth_bias: Option<f32> = None,
            number(0.0, 1.0).automatic("0.26, or 0.24 where contacts are left to the series", 0.26);
        /// Factor on every kernel's width. Stretching the series between black and white point narrows penumbrae; this widens them again.
        footprint_scale: Option<f32> = None,
            number(0.0, 10.0).automatic("1.415, or 1.4 where contacts are left to the series", 1.415);
        /// Places of the depth map itself that are looked at for blockers too near for the series, each between four texels; where there
        /// are such blockers, as many are filtered again. 0 leaves contacts to the series and its sharpening, as the paper does.
        contact_samples: u32 = 8, whole(0, 64).alias("contact-samples");
        /// Distance from the receiver up to which blockers are looked for in the depth map, as a share of the depth range over M. The
        /// series takes over where it sees nothing but blockers at that distance.
        contact_reach: f32 = 0.85, number(0.0, 4.0);
    }
}

impl ConvolutionSettings {
    /// The paper's method alone: contacts are left to the series and darkened by sharpening.
    pub fn paper() -> Self {
        Self { contact_samples: 0, ..Self::default() }
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
        self.order.div_ceil(4)
    }

    fn parameters(&self, resolution: u32) -> layout::ConvolutionParameters {
        let far: [[glam::Vec4; 2]; 4] =
            std::array::from_fn(|group| series::series_phases(series::SERIES_DEPTH_SCALE, group as u32));
        let order = self.order as f32;
        let by_contacts = |with: f32, without: f32| if self.contact_samples == 0 { without } else { with };
        layout::ConvolutionParameters {
            order: self.order,
            groups: self.groups(),
            resolution: resolution as f32,
            max_level: resolution.ilog2() as f32,
            black_point: self.black_point,
            white_point: self.white_point,
            sharpening_a: self.sharpening_a.unwrap_or(by_contacts(0.0, 15.0)),
            sharpening_b: self.sharpening_b,
            depth_bias: self.depth_bias.unwrap_or(by_contacts(0.26, 0.24)) / order,
            average_bias: SERIES_LIT_AT / order,
            footprint_scale: self.footprint_scale.unwrap_or(by_contacts(1.415, 1.4)),
            plane_iterations: self.plane_iterations,
            contact_samples: self.contact_samples,
            contact_reach: self.contact_reach.max(1e-3) / order,
            far_sin: far.map(|phases| phases[1]),
            far_cos: far.map(|phases| phases[0]),
        }
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

    fn has_sharp_maps(&self) -> bool {
        false
    }

    fn depth_maps(&self) -> Option<MapDepth> {
        Some(MapDepth::Linear)
    }

    /// In a kernel at the foot of a wall a ground stands in for contacts that a few terms cannot resolve: without it pictures are off by a
    /// sixteenth more.
    fn draws_grounds(&self) -> bool {
        true
    }

    fn memory(&self, settings: &ShadowSettings, resolution: u32) -> ShadowMemory {
        let groups = settings.convolution.groups();
        let images = match settings.convolution.prefilter {
            Prefilter::MipChain => mip::bytes_per_light(groups, resolution),
            Prefilter::SummedAreaTable => sat::bytes_per_light(groups, resolution),
        };
        ShadowMemory { per_light: DepthMaps::bytes_per_light(resolution) + images, per_pair: 0 }
    }

    fn layers_per_light(&self, settings: &ShadowSettings) -> u32 {
        settings.convolution.groups()
    }

    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError> {
        MapShadows::boxed(context, MapDepth::Linear, |maps| {
            Filtered::new(context.gpu, &context.settings.convolution, maps)
        })
    }
}

/// The maps' filtered images.
struct Filtered {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
    filter: Filter,
}

enum Filter {
    MipChain(mip::MipChain),
    SummedAreaTable(sat::SummedAreaTables),
}

impl Filtered {
    fn new(gpu: &Gpu, settings: &ConvolutionSettings, maps: &DepthMaps) -> Result<Self, RenderError> {
        let parameters = settings.parameters(maps.resolution);
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

impl MapFilter for Filtered {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn encode(&self, recorder: &mut Recorder<'_>, light_count: u32) {
        match &self.filter {
            Filter::MipChain(chain) => chain.encode(recorder, light_count),
            Filter::SummedAreaTable(tables) => tables.encode(recorder, light_count),
        }
    }
}
