//! Everything that a picture depends on beside the scene, as plain data.

use std::collections::BTreeMap;

use gnomon_brdf::Surface;
use gnomon_envmap::Projection;
use gnomon_lights::fit::FitSettings;
use gnomon_options::{Given, Group, OptionField, OptionSpec, Options, settings, size};
use gnomon_renderer::{
    DisplaySettings, LightingSettings, MeasureSettings, RenderSettings, TechniqueSettings,
};
use gnomon_scene::{Camera, Ground, ReflectanceSettings};
use gnomon_scene_files::EnvironmentSource;
use serde::{Deserialize, Serialize};

use crate::StudioError;

/// How a scene is looked at. The default is what `gnomon render` does without options.
///
/// The tables of a scene file (`SCENE_FORMAT.md`) are its parts: `[fit]`, `[render]` and `[display]` hold its options, `[animation]`,
/// `[environment]`, `[camera]`, `ground` and `[[surface]]` are as that format has them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Look {
    /// Which lights stand for the environment: `[fit]`.
    pub fit: FitSettings,
    /// What becomes of the light that they leave over: of `[render]`.
    pub lighting: LightingSettings,
    /// How visibility is found and light is summed: of `[render]`.
    pub techniques: TechniqueSettings,
    /// The picture's frame: of `[display]`.
    pub picture: PictureSettings,
    /// How radiance is shown: of `[display]`. An exposure that is left to the program brings the environment's mean to 0.5, so that pictures
    /// of a moving scene keep one exposure; in a scene file it is left to what `[environment]` says.
    pub display: DisplaySettings,
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

static PICTURE: Group = Group { table: "", heading: "Display", condition: None };

settings! {
    /// The picture's frame.
    pub struct PictureSettings in PICTURE {
        /// Width and height of the picture.
        size: [u32; 2] = [1024, 768], size();
    }
}

impl PictureSettings {
    /// Width over height.
    pub fn aspect(&self) -> f32 {
        let [width, height] = self.size.map(|side| side.max(1) as f32);
        width / height
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
        Given::changes(before, after).apply(self);
        let (environment, was, is) = (&mut self.environment, &before.environment, &after.environment);
        if (&was.source, &was.projection) != (&is.source, &is.projection) {
            // Another file comes as it is turned now.
            environment.clone_from(is);
        }
        if was.rotation != is.rotation {
            environment.rotation = is.rotation;
        }
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
    pub fn settings(&self, automatic_exposure: f32) -> RenderSettings {
        let exposure = Some(self.display.exposure.unwrap_or(automatic_exposure));
        RenderSettings {
            display: DisplaySettings { exposure, ..self.display.clone() },
            lighting: self.lighting.clone(),
            techniques: self.techniques.clone(),
            measure: MeasureSettings::default(),
        }
    }
}

/// All options of a look.
impl Options for Look {
    fn visit(&self, see: &mut dyn FnMut(&'static OptionSpec, &dyn OptionField)) {
        self.fit.visit(see);
        self.lighting.visit(see);
        self.techniques.visit(see);
        self.picture.visit(see);
        self.display.visit(see);
    }

    fn visit_mut(&mut self, see: &mut dyn FnMut(&'static OptionSpec, &mut dyn OptionField)) {
        self.fit.visit_mut(see);
        self.lighting.visit_mut(see);
        self.techniques.visit_mut(see);
        self.picture.visit_mut(see);
        self.display.visit_mut(see);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use gnomon_options::specs;
    use gnomon_picture::tonemap::ToneMapping;

    use super::*;

    #[test]
    fn every_option_has_a_name_of_its_own_and_a_default_that_it_may_be() {
        let names: Vec<String> = specs::<Look>().iter().map(|spec| spec.name()).collect();
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{names:?}");
        Look::default().check().unwrap();
        for spec in specs::<Look>() {
            assert!(!spec.help().contains('`') && !spec.heading().is_empty(), "{}", spec.name());
            let Some((option, value)) = spec.condition() else { continue };
            let other = specs::<Look>().into_iter().find(|other| other.name() == option).unwrap();
            assert!(other.parse(value).is_ok(), "{} is for {option} {value}", spec.name());
        }
    }

    #[test]
    fn what_a_new_scene_brings_goes_before_all_but_what_was_changed() {
        let asked = Look::default();
        let mut now = asked.clone();
        now.environment.rotation = 30.0;
        now.display.tone_mapping = ToneMapping::Linear;
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
        let tone_mapping = ToneMapping::Linear;
        assert_eq!(kept.display, DisplaySettings { tone_mapping, ..brought.display.clone() });
        // Another environment that was chosen meanwhile comes whole.
        now.environment.source = Some(EnvironmentSource::Builtin("room".to_owned()));
        let mut chosen = brought;
        chosen.keep_changes(&asked, &now);
        assert_eq!(chosen.environment, now.environment);
    }
}
