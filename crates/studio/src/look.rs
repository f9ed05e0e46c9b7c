//! Everything that a picture depends on beside the scene, as plain data.

use std::collections::BTreeMap;

use glam::Vec3;
use gnomon_brdf::Surface;
use gnomon_envmap::{Grade, LoadOptions, Projection};
use gnomon_lights::fit::FitSettings;
use gnomon_options::{
    Given, Group, OptionField, OptionSpec, Options, angle, any_number, choice, color, file, number, settings,
    size, text,
};
use gnomon_renderer::{
    Background, DisplaySettings, LightPaths, LightingSettings, MeasureSettings, RenderSettings,
    TechniqueSettings,
};
use gnomon_scene::{CAMERA_HEIGHT, Camera, Emission, Ground, ReflectanceSettings};
use gnomon_scene_files::{Axes, EnvironmentSource, UNITS, UpAxis};
use serde::{Deserialize, Serialize};

use crate::{EditedRig, StudioError};

/// How a scene is looked at. The default is what `gnomon render` does without options.
///
/// The tables of a scene file (`SCENE_FORMAT.md`) are its parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Look {
    /// Which lights stand for the environment: `[fit]`.
    pub fit: FitSettings,
    /// Which light is in the picture: of `[render]`.
    pub paths: LightPaths,
    /// What becomes of the light that they leave over: of `[render]`.
    pub lighting: LightingSettings,
    /// How visibility is found and light is summed: of `[render]`.
    pub techniques: TechniqueSettings,
    /// The picture's frame: of `[display]`.
    pub picture: PictureSettings,
    /// How radiance is shown: of `[display]`. An exposure that is left to the program brings the environment's mean to 0.5, so that pictures
    /// of a moving scene keep one exposure; in a scene file it is left to what `[environment]` says.
    pub display: DisplaySettings,
    /// Which environment lights the scene: a file or a built-in one.
    pub map: Option<EnvironmentSource>,
    /// How it is read and turned: of `[environment]`.
    pub environment: EnvironmentLook,
    /// Its light rig as it is edited, where it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rig: Option<EditedRig>,
    /// From where it is seen.
    pub camera: CameraLook,
    /// What is added to it: of the outer table.
    pub scene: SceneLook,
    /// Its pose: `[animation]`.
    pub animation: AnimationLook,
    /// Reflectance of every material but the ground's.
    pub reflectance: Option<ReflectanceSettings>,
    /// Reflectance of single materials, by their number in the scene with its ground; goes before `reflectance`.
    pub surfaces: BTreeMap<usize, ReflectanceSettings>,
}

/// Options of the scene and its pose.
pub static SCENE: Group = Group { table: "", heading: "Scene", condition: None };
/// Options of the environment.
pub static ENVIRONMENT: Group = Group { table: "", heading: "Environment", condition: None };
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

settings! {
    /// How an environment is read and turned.
    pub struct EnvironmentLook in ENVIRONMENT {
        /// Layout of the environment's file, where its shape does not tell.
        projection: Option<Projection> = None, choice(Projection::choices).automatic("by its shape", 0.0);
        /// Layer of an OpenEXR environment, or one channel of it by its whole name.
        layer: Option<String> = None, text().automatic("the one that is plainly the picture", 0.0).flag("env-layer");
        /// Turn of the environment about +y by the right-hand rule.
        rotation: f32 = 0.0, angle().flag("env-rotation");
        /// Factor of all its light. The exposure that is left to the program stays that of the file.
        strength: f32 = 1.0, number(0.0, 1e6).flag("env-strength");
        /// Factor of each of its colors.
        tint: [f32; 3] = [1.0, 1.0, 1.0], color().flag("env-tint");
        /// Clamp the map that lights at this radiance, before its strength and tint; what is above it becomes lights, up to 64 where it is wide.
        /// The camera sees the whole map.
        clamp: Option<f32> = None, number(1e-9, 1e9).automatic("none", 10.0).flag("env-clamp");
        /// Lights in its place: a light rig as gnomon decompose writes it, edited or not. An environment that is given is then only seen
        /// behind the scene, else the rig's own map is.
        rig: Option<String> = None, file().automatic("none: lights are fitted", 0.0).flag("rig");
        /// Another map behind the scene, which lights nothing.
        background_map: Option<String> = None, file().automatic("the environment", 0.0).flag("background-map");
    }
}

impl EnvironmentLook {
    /// What the environment's radiance is multiplied by. A background of its own is seen as it is.
    pub fn grade(&self) -> Grade {
        let light = self.strength * Vec3::from(self.tint);
        let background = if self.background_map.is_some() { Vec3::ONE } else { light };
        Grade { light, background }
    }

    /// With other paths of its files.
    pub(crate) fn with_files<E>(&self, to: impl Fn(&str) -> Result<String, E>) -> Result<Self, E> {
        let moved = |file: &Option<String>| file.as_deref().map(&to).transpose();
        let (rig, background_map) = (moved(&self.rig)?, moved(&self.background_map)?);
        Ok(Self { rig, background_map, ..self.clone() })
    }

    /// Takes over how another is turned and graded: maps, lights and what is made of them stay as they are.
    pub(crate) fn shown_as(&self, other: &Self) -> Self {
        Self { rotation: other.rotation, strength: other.strength, tint: other.tint, ..self.clone() }
    }
}

impl EnvironmentLook {
    /// How the environment's file is read.
    pub fn load_options(&self) -> LoadOptions<'_> {
        LoadOptions { projection: self.projection, layer: self.layer.as_deref() }
    }
}

settings! {
    /// What is added to a scene, and how its files are meant.
    pub struct SceneLook in SCENE {
        /// What lies under the models: under their lowest point, over the whole of the clip that plays.
        ground: Ground = Ground::None, choice(Ground::choices).varies("fade for glTF, OBJ, PLY and STL files that bring no ground, none for others");
        /// Height of the environment's camera over a projected ground: what is seen in the environment straight below it lies there.
        ground_camera_height: f32 = CAMERA_HEIGHT, number(1e-6, 1e6).unit("m").only_for("ground", &["projected"]);
        /// What becomes of surfaces that emit light. Up to 32 flat parts become up to 64 lights.
        emission: Emission = Emission::Lights, choice(Emission::choices);
        /// Factor of the light of the scene's own lights, those of glTF files in candela and lux; 0 leaves them out.
        lamp_strength: f32 = 1.0, number(0.0, 1e6);
        /// Material variant of glTF models that is shown, by its name.
        variant: Option<String> = None, text().automatic("each model's own materials", 0.0);
        /// The axis that points up in files that do not say: OBJ, PLY and STL.
        up: UpAxis = UpAxis::Y, choice(UpAxis::choices);
        /// Length of the unit of files that do not say: OBJ, PLY and STL.
        unit: f32 = 1.0, number(1e-6, 1e6).unit("m").words(&UNITS);
        /// Factor of the heights of materials.
        bump_scale: f32 = 1.0, number(-1e3, 1e3);
    }
}

impl SceneLook {
    /// Axes and unit, as readers of files take them.
    pub(crate) fn axes(&self) -> Axes {
        Axes { up: Some(self.up), unit: Some(self.unit) }
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

settings! {
    /// Which pose of an animated scene.
    pub struct AnimationLook in SCENE {
        /// Clip that plays, by its name, or by its number from 0 where none has that name.
        clip: Option<String> = None, text().automatic("none: the models as they stand", 0.0);
        /// Time in the clip; beyond its end it starts again.
        time: f32 = 0.0, any_number("s");
    }
}

impl Look {
    /// Takes over what has changed from `before` to `after`, of the parts that are no scene's own.
    pub(crate) fn keep_changes(&mut self, before: &Self, after: &Self) {
        let own = (self.scene.clone(), self.animation.clone());
        Given::changes(before, after).apply(self);
        (self.scene, self.animation) = own;
        if !before.has_map_of(after) {
            // Another file comes as it is turned now.
            self.map.clone_from(&after.map);
            self.environment = after.environment.clone();
            self.rig.clone_from(&after.rig);
        }
    }

    /// Whether the environment is the same but for its turn.
    pub(crate) fn has_map_of(&self, other: &Self) -> bool {
        let own = self.environment.shown_as(&other.environment);
        (&self.map, &own, self.edited_rig()) == (&other.map, &other.environment, other.edited_rig())
    }

    /// Whether the environment is seen behind the scene.
    pub fn shows_environment(&self) -> bool {
        self.display.background == Background::Environment
    }

    /// Whether there is something around the scene.
    pub fn has_environment(&self) -> bool {
        self.map.is_some() || self.environment.rig.is_some()
    }

    /// Takes another environment, as it is.
    pub fn set_environment(&mut self, source: EnvironmentSource) {
        self.map = Some(source);
        (self.environment, self.rig) = Default::default();
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
            paths: self.paths.clone(),
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
        self.paths.visit(see);
        self.lighting.visit(see);
        self.techniques.visit(see);
        self.picture.visit(see);
        self.display.visit(see);
        self.scene.visit(see);
        self.animation.visit(see);
        self.environment.visit(see);
    }

    fn visit_mut(&mut self, see: &mut dyn FnMut(&'static OptionSpec, &mut dyn OptionField)) {
        self.fit.visit_mut(see);
        self.paths.visit_mut(see);
        self.lighting.visit_mut(see);
        self.techniques.visit_mut(see);
        self.picture.visit_mut(see);
        self.display.visit_mut(see);
        self.scene.visit_mut(see);
        self.animation.visit_mut(see);
        self.environment.visit_mut(see);
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
            let Some((option, values)) = spec.condition() else { continue };
            let other = specs::<Look>().into_iter().find(|other| other.name() == option).unwrap();
            for value in values {
                assert!(other.parse(value).is_ok(), "{} is for {option} {value}", spec.name());
            }
        }
    }

    #[test]
    fn what_a_new_scene_brings_goes_before_all_but_what_was_changed() {
        let asked = Look::default();
        let mut now = asked.clone();
        now.environment.rotation = 30.0;
        now.display.tone_mapping = ToneMapping::Linear;
        now.animation.time = 3.0;
        let sky = Some(EnvironmentSource::Builtin("sky".to_owned()));
        let file = EnvironmentLook {
            projection: Some(Projection::Equirect),
            rotation: 5.0,
            ..EnvironmentLook::default()
        };
        let mut brought = Look { map: sky, environment: file.clone(), ..Look::default() };
        (brought.display.exposure, brought.display.background) = (Some(2.0), Background::None);
        let mut kept = brought.clone();
        kept.keep_changes(&asked, &now);
        assert_eq!(kept.environment, EnvironmentLook { rotation: 30.0, ..file });
        assert_eq!((&kept.map, &kept.animation), (&brought.map, &brought.animation));
        let tone_mapping = ToneMapping::Linear;
        assert_eq!(kept.display, DisplaySettings { tone_mapping, ..brought.display.clone() });
        // Another environment that was chosen meanwhile comes whole.
        now.map = Some(EnvironmentSource::Builtin("room".to_owned()));
        let mut chosen = brought;
        chosen.keep_changes(&asked, &now);
        assert_eq!((chosen.map, chosen.environment), (now.map, now.environment));
    }
}
