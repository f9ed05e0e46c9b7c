//! Shadow techniques, side by side on one interface.
//!
//! To add one: a file here that implements [`technique::ShadowTechnique`], a line in `TECHNIQUES`, and a WGSL module with `visibility()` unless it
//! fills a buffer.

mod buffered;
mod convolution;
mod depth_map;
pub(crate) mod depth_maps;
mod downsample;
mod hard;
mod hard_linear;
mod min_max;
mod moments;
mod none;
mod pcf;
mod pcss;
mod rays;
mod silhouettes;
mod stencil;
pub(crate) mod technique;
mod wedges;
mod windows;

use std::f32::consts::PI;

use buffered::Buffered;
use gnomon_options::{Choice, choices, settings};
use gnomon_scene::{AreaLightShape, Bounds, PlacedLight};
use technique::ShadowTechnique;

use crate::{Gpu, RenderError};

pub use convolution::{ConvolutionSettings, Footprint, Prefilter};
pub use hard::HardSettings;
pub use hard_linear::HardLinearSettings;
pub use moments::MomentSettings;
pub use pcf::PcfSettings;
pub use pcss::PcssSettings;
pub use rays::RaySettings;
pub use wedges::WedgeSettings;
pub use windows::WindowSettings;

settings! {
    /// Parameters of all techniques.
    pub struct ShadowSettings with {
        /// Convolution soft shadows.
        convolution: ConvolutionSettings;
        /// Hard shadow maps.
        hard: HardSettings;
        /// Hard shadow maps of linear depth.
        hard_linear: HardLinearSettings;
        /// Percentage-closer filtering.
        pcf: PcfSettings;
        /// Percentage-closer soft shadows.
        pcss: PcssSettings;
        /// Moment soft shadow maps.
        moments: MomentSettings;
        /// Shadow rays.
        rays: RaySettings;
        /// Penumbra wedges.
        wedges: WedgeSettings;
        /// Backprojection and bitmask soft shadows.
        windows: WindowSettings;
    }
}

choices! {
    /// How the sum of light learns what every point sees. The picture is the same, up to the rounding of a buffer's entries.
    pub enum VisibilityPath {
        /// The technique's function is called for each pair of a light and a point.
        Inline = "inline",
        /// A pass of its own writes it to a buffer, light by light, which the sum reads.
        Buffered = "buffered",
    }
}

/// Every technique.
const TECHNIQUES: [&dyn ShadowTechnique; 12] = [
    &convolution::Convolution,
    &pcss::PCSS,
    &moments::Moments,
    &windows::BACKPROJECTION,
    &windows::BITMASK,
    &pcf::PCF,
    &hard::HARD,
    &hard_linear::HARD_LINEAR,
    &rays::Rays,
    &wedges::WEDGES,
    &stencil::Stencil,
    &none::None,
];

/// The same through a buffer.
static BUFFERED: [Buffered; TECHNIQUES.len()] = Buffered::all(TECHNIQUES);

/// The name of the choice that takes techniques by what they are for.
const AUTO: (&str, &str) =
    ("auto", "percentage-closer soft shadows; in an interior and under wide lamps shadow rays");

/// Name and one-line summary of every technique.
pub fn names() -> impl Iterator<Item = (&'static str, &'static str)> {
    TECHNIQUES.iter().map(|technique| (technique.name(), technique.summary()))
}

/// The same as choices of an option.
pub(crate) fn choices() -> Vec<Choice> {
    std::iter::once(AUTO).chain(names()).map(|(name, summary)| Choice { name, summary }).collect()
}

/// The techniques in force.
#[derive(Clone, Copy)]
pub(crate) struct Techniques {
    pub usual: &'static dyn ShadowTechnique,
    /// Where lights stand for what comes into an interior, or lamps are wide, and the adapter has room for what it needs.
    pub wide: &'static dyn ShadowTechnique,
}

/// Lamps that together fill so much [sr] of what is seen from the scene's middle are wide: a map from their middles does not tell which of their
/// parts near blockers hide. A square of ten degrees.
const WIDE_LAMPS: f32 = 0.03;

/// Whether lamps are wide in a scene with such a box around it.
pub(crate) fn lamps_are_wide(lamps: &[PlacedLight], around: Option<Bounds>) -> bool {
    let Some(around) = around else { return false };
    let middle = 0.5 * (around.min + around.max);
    let filled = |lamp: &PlacedLight| match lamp.shape {
        AreaLightShape::Sun { .. } => 0.0,
        AreaLightShape::Rectangle { size } => size.element_product() / lamp.center.distance_squared(middle),
        AreaLightShape::Disk { radius } | AreaLightShape::Sphere { radius } => {
            PI * radius * radius / lamp.center.distance_squared(middle)
        }
    };
    lamps.iter().map(filled).sum::<f32>() >= WIDE_LAMPS
}

/// The technique called `name`.
///
/// # Errors
/// [`RenderError::UnknownName`] lists the names there are.
pub(crate) fn by_name(name: &str, path: VisibilityPath) -> Result<Techniques, RenderError> {
    let choice = |name: &str| -> Result<&'static dyn ShadowTechnique, RenderError> {
        let mut pairs = TECHNIQUES.into_iter().zip(&BUFFERED);
        let found = pairs.find(|(technique, _)| technique.name() == name);
        let (inline, buffered): (&'static dyn ShadowTechnique, _) =
            found.ok_or_else(|| RenderError::UnknownName {
                what: "shadow technique",
                name: name.to_owned(),
                choices: choices().iter().map(|choice| choice.name).collect::<Vec<_>>().join(", "),
            })?;
        Ok(match path {
            VisibilityPath::Buffered if !inline.fills_buffer() => buffered,
            _ => inline,
        })
    };
    let [usual, wide] = if name == AUTO.0 { ["pcss", "rays"] } else { [name, name] };
    Ok(Techniques { usual: choice(usual)?, wide: choice(wide)? })
}

/// The same, where the device has what they need.
///
/// # Errors
/// As [`by_name`], and [`RenderError::NeedsFeature`].
pub(crate) fn usable(gpu: &Gpu, name: &str, path: VisibilityPath) -> Result<Techniques, RenderError> {
    let techniques = by_name(name, path)?;
    for technique in [techniques.usual, techniques.wide] {
        gpu.require(technique.name(), technique.needed_features())?;
    }
    Ok(techniques)
}
