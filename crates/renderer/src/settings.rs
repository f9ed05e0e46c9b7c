use gnomon_picture::tonemap::ToneMapping;

use crate::RenderError;
use crate::batch_plan::ShadowSizing;
use crate::shadow::{self, ShadowSettings};
use crate::{ambient, composite, unshadowed};

/// How frames are drawn, in parts that change together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderSettings {
    /// How radiance is shown: constants of the next frame.
    pub display: DisplaySettings,
    /// What lights are made of an environment beside those of its fit: they are made anew.
    pub lighting: LightingSettings,
    /// How visibility is found and light is summed: pipelines, shadow maps and buffers are made anew, meshes and lights stay.
    pub techniques: TechniqueSettings,
    /// What is measured along the way: the next frame.
    pub measure: MeasureSettings,
}

/// How radiance becomes a displayed picture.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplaySettings {
    /// Stops of exposure; 0 where nobody says.
    pub exposure: Option<f32>,
    /// Tone mapping.
    pub tone_mapping: ToneMapping,
    /// Draw the environment behind the scene.
    pub background: bool,
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self { exposure: None, tone_mapping: ToneMapping::default(), background: true }
    }
}

/// What becomes of the light that a fit leaves over.
#[derive(Clone, Debug, PartialEq)]
pub struct LightingSettings {
    /// Name of a way in [`crate::ambient::AMBIENTS`] to shadow the ambient rest.
    pub ambient: String,
    /// Lights or probes that the ambient rest may become, 6 to 4096.
    pub ambient_cells: usize,
}

impl Default for LightingSettings {
    fn default() -> Self {
        Self { ambient: "cells".to_owned(), ambient_cells: 32 }
    }
}

/// How visibility is found and light is summed.
#[derive(Clone, Debug, PartialEq)]
pub struct TechniqueSettings {
    /// One of [`crate::shadow::names`].
    pub shadows: String,
    /// Parameters of the techniques.
    pub shadow_settings: ShadowSettings,
    /// Edge length of the largest depth map in texels: a power of two, 16 to 8192.
    pub shadow_resolution: u32,
    /// How that becomes the size of each light's map.
    pub shadow_sizing: ShadowSizing,
    /// GPU memory for shadow maps and their images [MiB]. Lights that do not fit take turns.
    pub shadow_memory: u32,
    /// Receivers are moved along their normal by this many depth-map texels against self-shadowing.
    pub normal_offset: f32,
    /// What is drawn into the maps of wide lights may deviate from the scene by this many depth-map texels, 0 to 16; 0 draws all
    /// triangles for all lights.
    pub caster_deviation: f32,
    /// Name of a rule in [`crate::composite::COMPOSITINGS`].
    pub compositing: String,
    /// Name of a source in [`crate::unshadowed::UNSHADOWED`].
    pub unshadowed: String,
    /// Texels along the side of a lobe's map in the radiance cache, 16 to 1024.
    pub radiance_cache_resolution: u32,
    /// Samples along a pixel's side, 1 to 8; their mean is the pixel.
    pub supersample: u32,
    /// Samples along the side of a tile of the shadow buffer, 1, 2, 4, 8, 16 or 32: lights are summed once a tile, and wherever a
    /// sample is unlike the tiles around it (DeCoro and Rusinkiewicz 2008, section 3.2).
    pub shadow_sampling: u32,
}

impl Default for TechniqueSettings {
    fn default() -> Self {
        Self {
            shadows: "pcss".to_owned(),
            shadow_settings: ShadowSettings::default(),
            shadow_resolution: 256,
            shadow_sizing: ShadowSizing::default(),
            shadow_memory: 1024,
            normal_offset: 1.5,
            caster_deviation: 0.25,
            compositing: "ratio".to_owned(),
            unshadowed: "auto".to_owned(),
            radiance_cache_resolution: 128,
            supersample: 2,
            shadow_sampling: 2,
        }
    }
}

/// What is measured along the way.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeasureSettings {
    /// Time every pass: by the GPU's own stamps or, where a driver has none or they are not true, by submitting every pass alone and
    /// waiting for it, which is slow.
    pub profile: bool,
}

impl RenderSettings {
    /// These settings with a change.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// Whether all names stand for something and all numbers are in range.
    ///
    /// # Errors
    /// [`RenderError::UnknownName`] or [`RenderError::OutOfRange`] for the first that does not.
    pub fn check(&self) -> Result<(), RenderError> {
        let Self { display, lighting, techniques, .. } = self;
        shadow::by_name(&techniques.shadows)?;
        ambient::by_name(&lighting.ambient)?;
        composite::by_name(&techniques.compositing)?;
        unshadowed::by_name(&techniques.unshadowed)?;
        in_range("samples along a pixel's side", techniques.supersample, 1..=8)?;
        in_range("exposure", display.exposure.unwrap_or(0.0), -100.0..=100.0)?;
        in_range("deviation of shadow casters in texels", techniques.caster_deviation, 0.0..=16.0)?;
        in_range("cells of the ambient rest", lighting.ambient_cells, 6..=4096)?;
        in_range("resolution of the radiance cache", techniques.radiance_cache_resolution, 16..=1024)?;
        check_power_of_two("shadow map resolution", techniques.shadow_resolution, 16..=8192)?;
        check_power_of_two(
            "samples along the side of a tile of the shadow buffer",
            techniques.shadow_sampling,
            1..=32,
        )
    }
}

/// Settings come from people: `value`, if it lies in `range`.
pub(crate) fn in_range<T: PartialOrd + std::fmt::Display>(
    what: &'static str,
    value: T,
    range: std::ops::RangeInclusive<T>,
) -> Result<T, RenderError> {
    if range.contains(&value) {
        return Ok(value);
    }
    let range = format!("{} to {}", range.start(), range.end());
    Err(RenderError::OutOfRange { what, range, value: value.to_string() })
}

fn check_power_of_two(
    what: &'static str,
    value: u32,
    range: std::ops::RangeInclusive<u32>,
) -> Result<(), RenderError> {
    if range.contains(&value) && value.is_power_of_two() {
        return Ok(());
    }
    let range = format!("a power of two from {} to {}", range.start(), range.end());
    Err(RenderError::OutOfRange { what, range, value: value.to_string() })
}
