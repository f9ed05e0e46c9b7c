use gnomon_brdf::Surface;
use gnomon_options::{Group, Options, choice, choices, number, power_of_two, settings, whole};
use gnomon_picture::tonemap::ToneMapping;
use gnomon_shaders::layout::CachedLobe;

use crate::ambient::{self, Ambient};
use crate::batch_plan::ShadowSizing;
use crate::bumps::{BumpShadows, Bumps, MaterialHeights, Preparation};
use crate::composite::{self, Compositing};
use crate::gloss::{GlossPath, Reflections};
use crate::shadow::{self, ShadowSettings, Techniques, VisibilityPath};
use crate::unshadowed::{self, Unshadowed};
use crate::{Gpu, RenderError};

/// How frames are drawn, in parts that change together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderSettings {
    /// How radiance is shown: constants of the next frame.
    pub display: DisplaySettings,
    /// Which light is in the picture: what sums of light are of.
    pub paths: LightPaths,
    /// What lights are made of an environment beside those of its fit: they are made anew.
    pub lighting: LightingSettings,
    /// How visibility is found and light is summed: pipelines, shadow maps and buffers are made anew, meshes and lights stay.
    pub techniques: TechniqueSettings,
    /// What is measured along the way: the next frame.
    pub measure: MeasureSettings,
}

static DISPLAY: Group = Group { table: "", heading: "Display", condition: None };
static LIGHT_PATHS: Group = Group { table: "", heading: "Light", condition: None };
static LIGHTING: Group = Group { table: "", heading: "Lights", condition: None };
static TECHNIQUES: Group = Group { table: "", heading: "Shadows", condition: None };
const COMPOSITING: &str = "Compositing";
const SAMPLING: &str = "Sampling";
const BUMPS: &str = "Bumps";

choices! {
    /// What is seen behind the scene.
    pub enum Background {
        /// The environment.
        Environment = "environment",
        /// Nothing: black.
        None = "none",
        /// Nothing: pictures have an alpha channel, straight in PNG and premultiplied in EXR files.
        Transparent = "transparent",
    }
}

settings! {
    /// How radiance becomes a displayed picture.
    pub struct DisplaySettings in DISPLAY {
        /// Stops by which the picture is brightened; EXR files hold radiance as it is.
        exposure: Option<f32> = None,
            number(-100.0, 100.0).unit("EV").automatic("what brings the environment's mean to 0.5", 0.0);
        /// How radiance is brought into the range of a display.
        tone_mapping: ToneMapping = ToneMapping::default(), choice(ToneMapping::choices);
        /// What is seen behind the scene.
        background: Background = Background::default(), choice(Background::choices);
    }
}

settings! {
    /// Which ways of light are in the picture.
    pub struct LightPaths in LIGHT_PATHS {
        /// What glossy surfaces reflect beside the lights and the environment. It needs rays for gloss, and lights that are no rig's.
        reflections: Reflections = Reflections::default(), choice(Reflections::choices);
    }
}

settings! {
    /// What becomes of the light that a fit leaves over.
    pub struct LightingSettings in LIGHTING {
        /// What the ambient rest of a fit does about shadows.
        ambient: String = "cells".to_owned(), choice(ambient::choices);
        /// Most lights or probes that the ambient rest may become.
        ambient_cells: usize = 32, whole(6, 4096);
    }
}

settings! {
    /// How visibility is found and light is summed.
    pub struct TechniqueSettings in TECHNIQUES {
        /// Shadow technique.
        shadows: String = "auto".to_owned(), choice(shadow::choices);
        /// How the sum of light learns what techniques find.
        visibility: VisibilityPath = VisibilityPath::default(), choice(VisibilityPath::choices);
        /// Texels along each side of the shadow map of a light of 20 degrees; wider ones have fewer.
        shadow_resolution: u32 = 256, power_of_two(16, 8192);
        /// Most texels along each side of the shadow map of a smaller light that gives more than a sixty-fourth of all light: a sun, a lamp.
        sharp_shadow_resolution: u32 = 2048, power_of_two(16, 8192);
        /// How large the lights' shadow maps are.
        shadow_sizing: ShadowSizing = ShadowSizing::default(), choice(ShadowSizing::choices);
        /// Memory for shadow maps and their images; lights that do not fit take turns.
        shadow_memory: u32 = 1024, whole(1, 1 << 20).unit("MiB");
        /// Distance by which receivers are moved along their normal against self-shadowing, in texels of the shadow map.
        normal_offset: f32 = 1.5, number(0.0, 64.0).unit("texels");
        /// Distance by which simpler meshes, drawn into the shadow maps of wide lights in place of those of many triangles, may deviate
        /// from them, in texels of the shadow map; 0 draws all triangles.
        caster_deviation: f32 = 0.25, number(0.0, 16.0).unit("texels");
        /// How shadows and unshadowed light become one picture.
        compositing: String = "ratio".to_owned(), choice(composite::choices).under(COMPOSITING);
        /// Where unshadowed light comes from.
        unshadowed: String = "auto".to_owned(), choice(unshadowed::choices).under(COMPOSITING);
        /// How glossy surfaces learn what the scene hides of their reflections.
        gloss: GlossPath = GlossPath::default(), choice(GlossPath::choices).under(COMPOSITING);
        /// Rays of a glossy lobe at a point; four times as many samples are taken of unshadowed light.
        gloss_samples: u32 = 64, whole(1, 256).under(COMPOSITING);
        /// Texels along each side of a lobe's map in the radiance cache.
        radiance_cache_resolution: u32 = 128, whole(16, 1024).under(COMPOSITING);
        /// Samples of a lobe for every texel of the radiance cache.
        radiance_cache_samples: u32 = 128, whole(1, 4096).under(COMPOSITING);
        /// What heights of materials do.
        bumps: Bumps = Bumps::default(), choice(Bumps::choices).under(BUMPS);
        /// How it is kept from which directions bumps are lit.
        bump_shadows: BumpShadows = BumpShadows::default(), choice(BumpShadows::choices).under(BUMPS);
        /// Samples along each side of a pixel; their mean is the pixel.
        supersample: u32 = 4, whole(1, 8).under(SAMPLING);
        /// Samples along each side of a tile over which lights are summed once. Samples unlike the tiles around them are lit by
        /// themselves, so that edges stay sharp (DeCoro and Rusinkiewicz 2008, section 3.2).
        shadow_sampling: u32 = 8, power_of_two(1, 32).under(SAMPLING);
        /// The same for suns, lamps and the scene's own lights, whose shadows are sharper: those that may have larger maps.
        sharp_shadow_sampling: u32 = 4, power_of_two(1, 32).under(SAMPLING);
        /// Where the share of light that arrives changes by more from one tile to the next, light is summed at each pixel, that of sharp
        /// lights at each sample; 1 leaves that out.
        shadow_contrast: f32 = 0.2, number(0.0, 1.0).under(SAMPLING);
        /// Surfaces behind one another that are lit each by itself where light passes them in part; of those farther behind each sample shows
        /// one by chance. Nothing where a scene has none.
        blended_layers: u32 = 4, whole(1, 16).under(SAMPLING);
    } with {
        /// Parameters of the techniques.
        shadow_settings: ShadowSettings;
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
    /// [`RenderError::Option`] for the first that does not.
    pub fn check(&self) -> Result<(), RenderError> {
        self.display.check()?;
        self.paths.check()?;
        self.lighting.check()?;
        self.techniques.check()?;
        Ok(())
    }
}

/// Settings, and what their names stand for.
#[derive(Clone)]
pub(crate) struct Chosen {
    pub settings: RenderSettings,
    pub shadows: Techniques,
    pub ambient: &'static Ambient,
    pub compositing: &'static Compositing,
    pub unshadowed: &'static Unshadowed,
}

impl Chosen {
    /// # Errors
    /// As [`RenderSettings::check`], and [`RenderError::NeedsFeature`] for a technique that the device cannot do.
    pub fn new(gpu: &Gpu, settings: RenderSettings) -> Result<Self, RenderError> {
        settings.check()?;
        let RenderSettings { lighting, techniques, .. } = &settings;
        Ok(Self {
            shadows: shadow::usable(gpu, &techniques.shadows, techniques.visibility)?,
            ambient: ambient::by_name(&lighting.ambient)?,
            compositing: composite::by_name(&techniques.compositing)?,
            unshadowed: unshadowed::by_name(&techniques.unshadowed)?,
            settings,
        })
    }

    /// Takes over what `lighting` was worked out with for the ambient rest.
    pub fn take_rest(&mut self, ambient: &'static Ambient, ambient_cells: usize) {
        self.ambient = ambient;
        self.settings.lighting = LightingSettings { ambient: ambient.name.to_owned(), ambient_cells };
    }

    /// What is to be prepared of a scene's heights.
    pub fn preparation(&self, heights: &[MaterialHeights]) -> Option<Preparation> {
        let techniques = &self.settings.techniques;
        Preparation::new(techniques.bumps, techniques.bump_shadows, heights)
    }

    /// The lobes of a scene's surfaces that the radiance cache is for.
    pub fn cached_lobes(&self, surfaces: &[Surface]) -> Vec<CachedLobe> {
        match self.compositing.needs_unshadowed {
            true => self.unshadowed.cached_lobes(surfaces),
            false => Vec::new(),
        }
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
