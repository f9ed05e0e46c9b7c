//! Shadow techniques, side by side on one interface.
//!
//! A technique is a WGSL module with `visibility(light, position_world, normal_world, n) -> f32`, of the geometric and the shading
//! normal, and, if it needs them, images made every frame from the lights' depth maps. To add one: a file here, its module, and a line in `TECHNIQUES`.

mod convolution;
mod downsample;
mod hard;
mod hard_linear;
mod moments;
mod none;
mod pcf;
mod pcss;

use crate::bindings::{Binding, D2_ARRAY};
use crate::depth_maps::DepthMaps;
use crate::recorder::Recorder;
use crate::settings::in_range;
use crate::{Gpu, RenderError};

pub use convolution::{ConvolutionSettings, Footprint, Prefilter};
pub use hard::HardSettings;
pub use hard_linear::HardLinearSettings;
pub use moments::MomentSettings;
pub use pcf::PcfSettings;
pub use pcss::PcssSettings;

/// Parameters of all techniques.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowSettings {
    /// Convolution soft shadows.
    pub convolution: ConvolutionSettings,
    /// Hard shadow maps.
    pub hard: HardSettings,
    /// Hard shadow maps of linear depth.
    pub hard_linear: HardLinearSettings,
    /// Percentage-closer filtering.
    pub pcf: PcfSettings,
    /// Percentage-closer soft shadows.
    pub pcss: PcssSettings,
    /// Moment soft shadow maps.
    pub moments: MomentSettings,
}

/// A way to tell how much of a light a point sees.
pub(crate) trait ShadowTechnique: Sync {
    /// Name for people and files.
    fn name(&self) -> &'static str;
    /// One line for help texts.
    fn summary(&self) -> &'static str;
    /// WGSL module that fills the slot `shadow`.
    fn module(&self, _: &ShadowSettings) -> &'static str;
    /// Features of the device that it needs beyond WebGPU's core.
    fn needed_features(&self) -> wgpu::Features {
        wgpu::Features::empty()
    }
    /// Whether the lights' depth maps are drawn for it.
    fn needs_depth_maps(&self) -> bool;
    /// Whether grounds are drawn into the maps of lights of which they block nothing, too.
    fn draws_grounds(&self) -> bool {
        false
    }
    /// GPU memory of one light's images at a map resolution, depth map not counted [bytes].
    fn bytes_per_light(&self, _: &ShadowSettings, _resolution: u32) -> u64 {
        0
    }
    /// Layers that one light needs in the technique's largest texture array.
    fn layers_per_light(&self, _: &ShadowSettings) -> u32 {
        1
    }
    /// Images and bindings for the depth maps of a batch of lights; `visibility`'s `light` counts within the batch.
    fn resources(
        &self,
        gpu: &Gpu,
        settings: &ShadowSettings,
        maps: &DepthMaps,
    ) -> Result<Box<dyn ShadowResources>, RenderError>;
}

/// What a technique keeps on the GPU.
pub(crate) trait ShadowResources: Send {
    /// Layout of the shadow technique's bind group.
    fn layout(&self) -> &wgpu::BindGroupLayout;
    /// The bind group.
    fn bind_group(&self) -> &wgpu::BindGroup;
    /// Makes images from the depth maps of the first `light_count` lights.
    fn encode(&self, recorder: &mut Recorder<'_>, light_count: u32);
}

/// A technique that looks only at the depth maps themselves.
struct DepthMapTechnique {
    name: &'static str,
    summary: &'static str,
    module: &'static str,
    /// Bytes of the module's uniform for maps of a resolution.
    parameters: fn(&ShadowSettings, u32) -> Result<Vec<u8>, RenderError>,
}

impl ShadowTechnique for DepthMapTechnique {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        self.module
    }

    fn needs_depth_maps(&self) -> bool {
        true
    }

    fn resources(
        &self,
        gpu: &Gpu,
        settings: &ShadowSettings,
        maps: &DepthMaps,
    ) -> Result<Box<dyn ShadowResources>, RenderError> {
        let parameters = (self.parameters)(settings, maps.resolution)?;
        Ok(Box::new(DepthMapsOnly::with_parameters(gpu, self.name, &parameters, maps)))
    }
}

/// Bindings of a technique that makes no images of its own.
struct DepthMapsOnly {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
}

impl DepthMapsOnly {
    /// `parameters` at binding 0, the depth maps at 1 and at 2 a bilinear sampler that gives 1 where the reference depth is no
    /// deeper than what is stored.
    fn with_parameters(gpu: &Gpu, label: &'static str, parameters: &[u8], maps: &DepthMaps) -> Self {
        let layout = gpu.layout(
            label,
            wgpu::ShaderStages::COMPUTE,
            &[
                (0, Binding::Uniform),
                (1, Binding::Depth { dimension: D2_ARRAY }),
                (2, Binding::ComparisonSampler),
            ],
        );
        let parameters = gpu.buffer_with(label, parameters, wgpu::BufferUsages::UNIFORM);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("lit if nearer"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(wgpu::CompareFunction::LessEqual),
            ..Default::default()
        });
        let bind_group = gpu.bind_group(
            label,
            &layout,
            &[
                (0, parameters.as_entire_binding()),
                (1, wgpu::BindingResource::TextureView(&maps.array)),
                (2, wgpu::BindingResource::Sampler(&sampler)),
            ],
        );
        Self { layout, bind_group }
    }
}

impl ShadowResources for DepthMapsOnly {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn encode(&self, _: &mut Recorder<'_>, _light_count: u32) {}
}

/// Every technique.
const TECHNIQUES: &[&dyn ShadowTechnique] = &[
    &convolution::Convolution,
    &pcss::PCSS,
    &moments::Moments,
    &pcf::PCF,
    &hard::HARD,
    &hard_linear::HARD_LINEAR,
    &none::None,
];

/// Name and one-line summary of every technique.
pub fn names() -> impl Iterator<Item = (&'static str, &'static str)> {
    TECHNIQUES.iter().map(|technique| (technique.name(), technique.summary()))
}

/// The technique called `name`.
///
/// # Errors
/// [`RenderError::UnknownName`] lists the names there are.
pub(crate) fn by_name(name: &str) -> Result<&'static dyn ShadowTechnique, RenderError> {
    TECHNIQUES.iter().copied().find(|technique| technique.name() == name).ok_or_else(|| {
        RenderError::UnknownName {
            what: "shadow technique",
            name: name.to_owned(),
            choices: TECHNIQUES.iter().map(|technique| technique.name()).collect::<Vec<_>>().join(", "),
        }
    })
}

/// The same, where the device has what it needs.
///
/// # Errors
/// As [`by_name`], and [`RenderError::NeedsFeature`].
pub(crate) fn usable(gpu: &Gpu, name: &str) -> Result<&'static dyn ShadowTechnique, RenderError> {
    let technique = by_name(name)?;
    gpu.require(technique.name(), technique.needed_features())?;
    Ok(technique)
}
