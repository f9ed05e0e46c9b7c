//! Everything that a picture depends on beside the scene, as plain data.

use std::collections::BTreeMap;

use gnomon_brdf::Surface;
use gnomon_envmap::Projection;
use gnomon_lights::FitOptions;
use gnomon_lights::fit::{by_name, sampler_by_name};
use gnomon_picture::tonemap::ToneMapping;
use gnomon_renderer::shadow::{ConvolutionSettings, Prefilter, ShadowSettings};
use gnomon_renderer::{RenderSettings, ShadowSizing};
use gnomon_scene::{Camera, Ground, ReflectanceSettings};
use gnomon_scene_files::EnvironmentSource;
use serde::{Deserialize, Serialize};

use crate::StudioError;

/// How a scene is looked at. The default is what `gnomon render` does without options.
///
/// The tables of a scene file (`SCENE_FORMAT.md`) are its parts: `[fit]`, `[render]`, `[display]` and `[animation]` by their own fields,
/// `[environment]`, `[camera]`, `ground` and `[[surface]]` as that format has them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Look {
    /// Which lights stand for the environment.
    pub fit: FitLook,
    /// How the GPU draws.
    pub render: RenderLook,
    /// How radiance is shown.
    pub display: DisplayLook,
    /// What lights the scene.
    pub environment: EnvironmentLook,
    /// From where it is seen.
    pub camera: CameraLook,
    /// Its pose.
    pub animation: AnimationLook,
    /// What lies under the models: under their lowest point, over the whole of the clip that plays.
    pub ground: Ground,
    /// Reflectance of every material but the ground's.
    pub reflectance: Option<ReflectanceSettings>,
    /// Reflectance of single materials, by their number in the scene with its ground; goes before `reflectance`.
    pub surfaces: BTreeMap<usize, ReflectanceSettings>,
}

/// How lights are fitted to the environment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FitLook {
    /// One of [`gnomon_lights::fit::methods`], or `none` for ambient light only.
    pub method: String,
    /// Number of lights; `None` leaves it to the fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light_count: Option<usize>,
    /// Where the fit stops, above 0 and below 1, instead of a number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f32>,
    /// Largest angular width and height of a light [degrees].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_extent: Option<f32>,
    /// One of [`gnomon_lights::fit::samplers`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampler: Option<String>,
    /// Seed of random samplers.
    pub seed: u64,
}

impl Default for FitLook {
    /// A fit that leaves no light unshadowed, so that the picture's error stays small under every environment measured, and the one that
    /// does it with the fewest lights.
    fn default() -> Self {
        Self {
            method: "optimized".to_owned(),
            light_count: None,
            threshold: None,
            max_extent: None,
            sampler: None,
            seed: 0,
        }
    }
}

impl FitLook {
    /// What the fits take, for a scene without a ground.
    ///
    /// # Errors
    /// [`StudioError::Fit`] for a sampler that does not exist.
    pub fn options(&self) -> Result<FitOptions, StudioError> {
        Ok(FitOptions {
            light_count: self.light_count,
            threshold: self.threshold,
            max_extent: self.max_extent.map(f32::to_radians),
            sampler: self.sampler.as_deref().map(sampler_by_name).transpose()?,
            seed: self.seed,
            ground: false,
        })
    }

    /// Whether a scene that stands on a ground gets other lights for it.
    pub(crate) fn heeds_ground(&self) -> bool {
        let fit =
            self.options().map(|options| by_name(&self.method, &FitOptions { ground: true, ..options }));
        fit.is_ok_and(|fit| fit.is_ok_and(|fit| fit.heeds_ground()))
    }

    /// Whether there is such a fit, and its options are in range.
    pub(crate) fn check(&self) -> Result<(), StudioError> {
        let options = self.options()?;
        if self.method != "none" {
            by_name(&self.method, &options)?;
        }
        Ok(())
    }
}

/// How convolution shadows are filtered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PrefilterName {
    /// Mip chains.
    #[default]
    Mip,
    /// Summed-area tables.
    Sat,
}

/// How large the lights' shadow maps are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SizingName {
    /// The wider the light, the coarser its map.
    #[default]
    Footprint,
    /// All alike.
    Uniform,
}

/// Techniques and sizes: the part of [`RenderSettings`] that people choose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RenderLook {
    /// One of [`gnomon_renderer::shadow::names`].
    pub shadows: String,
    /// One of [`gnomon_renderer::composite::COMPOSITINGS`].
    pub compositing: String,
    /// One of [`gnomon_renderer::unshadowed::UNSHADOWED`].
    pub unshadowed: String,
    /// One of [`gnomon_renderer::ambient::AMBIENTS`].
    pub ambient: String,
    /// Lights or probes that the ambient rest may become, 6 to 4096.
    pub ambient_cells: usize,
    /// Texels along the side of the largest shadow map: a power of two, 16 to 8192.
    pub shadow_resolution: u32,
    /// How that becomes the size of each light's map.
    pub shadow_sizing: SizingName,
    /// Memory for shadow maps and their images [MiB].
    pub shadow_memory: u32,
    /// What is drawn into the maps of wide lights may deviate from the scene by so many texels, 0 to 16; 0 draws all triangles.
    pub caster_deviation: f32,
    /// Samples along the side of a tile of the shadow buffer: 1, 2, 4, 8, 16 or 32.
    pub shadow_sampling: u32,
    /// Terms of the convolution shadows' series, 1 to 16.
    pub order: u32,
    /// How convolution shadows are filtered.
    pub prefilter: PrefilterName,
    /// Places where convolution shadows look for near blockers, 0 to 64; 0 is the paper's method alone.
    pub contact_samples: u32,
    /// Samples along a pixel's side, 1 to 8.
    pub supersample: u32,
}

impl Default for RenderLook {
    fn default() -> Self {
        let settings = RenderSettings::default();
        let convolution = settings.techniques.shadow_settings.convolution;
        Self {
            shadows: settings.techniques.shadows,
            compositing: settings.techniques.compositing,
            unshadowed: settings.techniques.unshadowed,
            ambient: settings.lighting.ambient,
            ambient_cells: settings.lighting.ambient_cells,
            shadow_resolution: settings.techniques.shadow_resolution,
            shadow_sizing: SizingName::default(),
            shadow_memory: settings.techniques.shadow_memory,
            caster_deviation: settings.techniques.caster_deviation,
            shadow_sampling: settings.techniques.shadow_sampling,
            order: convolution.order,
            prefilter: PrefilterName::default(),
            contact_samples: convolution.contact_samples,
            supersample: settings.techniques.supersample,
        }
    }
}

/// How radiance becomes a displayed picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DisplayLook {
    /// Width and height [pixels].
    pub size: [u32; 2],
    /// Stops of exposure; `None` brings the environment's mean to 0.5, so that pictures of a moving scene keep one exposure. In a scene
    /// file `None` leaves it to what `[environment]` says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<f32>,
    /// Name of a [`ToneMapping`].
    pub tone_mapping: String,
    /// Show the environment behind the scene.
    pub background: bool,
}

impl Default for DisplayLook {
    fn default() -> Self {
        Self {
            size: [1024, 768],
            exposure: None,
            tone_mapping: ToneMapping::default().name().to_owned(),
            background: true,
        }
    }
}

impl DisplayLook {
    /// Width over height.
    pub fn aspect(&self) -> f32 {
        let [width, height] = self.size.map(|side| side.max(1) as f32);
        width / height
    }

    /// The tone mapping.
    ///
    /// # Errors
    /// [`StudioError::Request`] listing those that exist.
    pub fn tone_mapping(&self) -> Result<ToneMapping, StudioError> {
        ToneMapping::from_name(&self.tone_mapping).ok_or_else(|| {
            let names: Vec<_> = ToneMapping::ALL.iter().map(|rule| rule.name()).collect();
            StudioError::unknown("tone mapping", &self.tone_mapping, &names)
        })
    }
}

/// Which environment, and how it is turned.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentLook {
    /// A file or a built-in environment.
    pub source: Option<EnvironmentSource>,
    /// Name of the file's [`Projection`], where its shape does not tell.
    pub projection: Option<String>,
    /// Turn about +y by the right-hand rule [degrees].
    pub rotation: f32,
}

impl EnvironmentLook {
    /// The forced projection, if there is one.
    ///
    /// # Errors
    /// [`StudioError::Request`] listing those that exist.
    pub fn projection(&self) -> Result<Option<Projection>, StudioError> {
        let named = |name: &String| {
            Projection::from_name(name).ok_or_else(|| {
                let names: Vec<_> = Projection::all().map(Projection::name).collect();
                StudioError::unknown("projection", name, &names)
            })
        };
        self.projection.as_ref().map(named).transpose()
    }
}

/// Which view of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CameraLook {
    /// The scene's first camera, or else one that frames its models: at rest, or over the whole of the clip that plays.
    #[default]
    Automatic,
    /// One of the scene's, by name.
    Named(String),
    /// This one.
    Free(Camera),
}

/// Which pose of an animated scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AnimationLook {
    /// A clip by its name, or by its number from 0 where none has that name; `None` is the file's own pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<String>,
    /// Time in the clip [s]; what lies beyond its end starts from the beginning again.
    pub time: f32,
}

impl Look {
    /// Takes over what has changed from `before` to `after`, of the parts that are no scene's own.
    pub(crate) fn keep_changes(&mut self, before: &Self, after: &Self) {
        fn keep<T: Clone + PartialEq>(value: &mut T, before: &T, after: &T) {
            if before != after {
                value.clone_from(after);
            }
        }
        keep(&mut self.fit, &before.fit, &after.fit);
        keep(&mut self.render, &before.render, &after.render);
        let (display, was, is) = (&mut self.display, &before.display, &after.display);
        keep(&mut display.size, &was.size, &is.size);
        keep(&mut display.exposure, &was.exposure, &is.exposure);
        keep(&mut display.tone_mapping, &was.tone_mapping, &is.tone_mapping);
        keep(&mut display.background, &was.background, &is.background);
        let (environment, was, is) = (&mut self.environment, &before.environment, &after.environment);
        if (&was.source, &was.projection) != (&is.source, &is.projection) {
            // Another file comes as it is turned now.
            environment.clone_from(is);
        }
        keep(&mut environment.rotation, &was.rotation, &is.rotation);
    }

    /// Gives one material, by its number in the scene, the reflectance of a surface.
    ///
    /// # Errors
    /// [`StudioError::Scene`] for a parameter out of its range.
    pub fn set_surface(&mut self, material: usize, surface: &Surface) -> Result<(), StudioError> {
        self.surfaces.insert(material, ReflectanceSettings::of(surface)?);
        Ok(())
    }

    /// The renderer's settings, for an environment whose suitable exposure is `automatic_exposure` [stops].
    ///
    /// # Errors
    /// [`StudioError::Request`] for names of nothing; ranges are the renderer's to check.
    pub fn settings(&self, automatic_exposure: f32) -> Result<RenderSettings, StudioError> {
        let render = &self.render;
        let paper = render.contact_samples == 0;
        let convolution = if paper { ConvolutionSettings::paper() } else { ConvolutionSettings::default() };
        let tone_mapping = self.display.tone_mapping()?;
        Ok(RenderSettings::default().with(|s| {
            s.techniques.shadows = render.shadows.clone();
            s.techniques.shadow_settings = ShadowSettings {
                convolution: ConvolutionSettings {
                    contact_samples: render.contact_samples,
                    order: render.order,
                    prefilter: match render.prefilter {
                        PrefilterName::Mip => Prefilter::MipChain,
                        PrefilterName::Sat => Prefilter::SummedAreaTable,
                    },
                    ..convolution
                },
                ..ShadowSettings::default()
            };
            s.techniques.shadow_sizing = match render.shadow_sizing {
                SizingName::Footprint => ShadowSizing::Footprint,
                SizingName::Uniform => ShadowSizing::Uniform,
            };
            s.techniques.shadow_memory = render.shadow_memory;
            s.lighting.ambient = render.ambient.clone();
            s.lighting.ambient_cells = render.ambient_cells;
            s.techniques.compositing = render.compositing.clone();
            s.techniques.unshadowed = render.unshadowed.clone();
            s.techniques.shadow_resolution = render.shadow_resolution;
            s.techniques.supersample = render.supersample;
            s.techniques.caster_deviation = render.caster_deviation;
            s.techniques.shadow_sampling = render.shadow_sampling;
            s.display.exposure = Some(self.display.exposure.unwrap_or(automatic_exposure));
            s.display.tone_mapping = tone_mapping;
            s.display.background = self.display.background;
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_new_scene_brings_goes_before_all_but_what_was_changed() {
        let asked = Look::default();
        let mut now = asked.clone();
        now.environment.rotation = 30.0;
        now.display.tone_mapping = "linear".to_owned();
        let file = EnvironmentLook {
            source: Some(EnvironmentSource::Builtin("sky".to_owned())),
            projection: Some("equirect".to_owned()),
            rotation: 5.0,
        };
        let mut brought = Look { environment: file.clone(), ..Look::default() };
        (brought.display.exposure, brought.display.background) = (Some(2.0), false);
        let mut kept = brought.clone();
        kept.keep_changes(&asked, &now);
        assert_eq!(kept.environment, EnvironmentLook { rotation: 30.0, ..file });
        let tone_mapping = "linear".to_owned();
        assert_eq!(kept.display, DisplayLook { tone_mapping, ..brought.display.clone() });
        // Another environment that was chosen meanwhile comes whole.
        now.environment.source = Some(EnvironmentSource::Builtin("room".to_owned()));
        let mut chosen = brought;
        chosen.keep_changes(&asked, &now);
        assert_eq!(chosen.environment, now.environment);
    }
}
