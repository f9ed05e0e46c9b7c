//! Shadow techniques, side by side on one interface.
//!
//! A technique is a WGSL module with `visibility(light, position_world, normal_world) -> f32` and, if it needs them, images made
//! every frame from the lights' depth maps. To add one: a file here, its module, and a line in [`TECHNIQUES`].

mod convolution;
mod hard;
mod none;

use crate::depth_maps::DepthMaps;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

pub use convolution::ConvolutionSettings;
pub use hard::HardSettings;

/// Parameters of all techniques.
#[derive(Clone, Debug, Default)]
pub struct ShadowSettings {
    /// Convolution soft shadows.
    pub convolution: ConvolutionSettings,
    /// Hard shadow maps.
    pub hard: HardSettings,
}

/// A way to tell how much of a light a point sees.
pub(crate) trait ShadowTechnique: Sync {
    /// Name for people and files.
    fn name(&self) -> &'static str;
    /// One line for help texts.
    fn summary(&self) -> &'static str;
    /// WGSL module that fills the slot `shadow`.
    fn module(&self) -> &'static str;
    /// Whether the lights' depth maps are drawn for it.
    fn needs_depth_maps(&self) -> bool;
    /// Images and bindings for one set of depth maps.
    fn resources(
        &self,
        gpu: &Gpu,
        settings: &ShadowSettings,
        maps: &DepthMaps,
    ) -> Result<Box<dyn ShadowResources>, RenderError>;
}

/// What a technique keeps on the GPU.
pub(crate) trait ShadowResources: Send {
    /// Layout of bind group 2.
    fn layout(&self) -> &wgpu::BindGroupLayout;
    /// Bind group 2.
    fn bind_group(&self) -> &wgpu::BindGroup;
    /// Makes this frame's images from this frame's depth maps.
    fn encode(&self, recorder: &mut Recorder<'_>);
    /// GPU memory of the images in bytes.
    fn bytes(&self) -> u64;
}

/// Bindings of a technique that makes no images of its own.
struct DepthMapsOnly {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
}

impl ShadowResources for DepthMapsOnly {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn encode(&self, _: &mut Recorder<'_>) {}

    fn bytes(&self) -> u64 {
        0
    }
}

/// Every technique.
const TECHNIQUES: &[&dyn ShadowTechnique] = &[&convolution::Convolution, &hard::Hard, &none::None];

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
