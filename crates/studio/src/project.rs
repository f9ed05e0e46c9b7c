//! A scene with the look that its file asks for.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use gnomon_lights::fit::FitSettings;
use gnomon_options::{Given, Options};
use gnomon_renderer::{DisplaySettings, LightPaths, LightingSettings, TechniqueSettings};
use gnomon_scene::{Emission, Ground, ReflectanceSettings, Scene, builtin};
use gnomon_scene_files::{
    Axes, ENVIRONMENT_KEYS, FileResolver, LoadOptions, LoadedScene, load, load_from, read_sections,
};
use serde::{Deserialize, Deserializer};

use crate::environment::surroundings_of;
use crate::look::{AnimationLook, CameraLook, EnvironmentLook, PictureSettings, SceneLook};
use crate::{Look, Paper, SceneFiles, StudioError, Surroundings};

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SceneSource {
    /// A built-in scene, by its name.
    Builtin(String),
    /// A file.
    File(PathBuf),
    /// A file that a program gives, with those that it names. An environment that its look names is one of these.
    Files(SceneFiles),
    /// None: a program made the scene. This is what it is called.
    Made(String),
}

impl SceneSource {
    /// What a name means: a built-in scene, or else a file. Whoever means a file called like a built-in scene writes `./column`.
    pub fn named(name: &str) -> Self {
        match builtin::NAMES.contains(&name) {
            true => Self::Builtin(name.to_owned()),
            false => Self::File(PathBuf::from(name)),
        }
    }
}

impl SceneSource {
    /// Reads the scene as a look has it; files that do not say with these axes.
    ///
    /// # Errors
    /// Names of nothing, files that cannot be used, a material variant that they do not have.
    pub(crate) fn load(&self, look: &Look, axes: Axes) -> Result<LoadedScene, StudioError> {
        let variant = look.scene.variant.clone();
        let options = LoadOptions { aspect: look.picture.aspect(), variant, axes, ..LoadOptions::default() };
        Ok(match self {
            Self::Builtin(name) => {
                if let Some(variant) = &options.variant {
                    let variant = gnomon_messages::quoted(variant);
                    return Err(StudioError::Request(format!(
                        "the built-in scene {name} has no material variant '{variant}'"
                    )));
                }
                let scene = builtin::by_name(name)?;
                LoadedScene { scene, environment: None, ground: Ground::None, variant: None, axes }
            }
            Self::File(path) => load(path, &options)?,
            Self::Files(files) => load_from(files.path(), files.resolver(), &options)?,
            Self::Made(name) => {
                return Err(StudioError::Request(format!(
                    "{name} was made by a program: there is no file of it to be read with other axes or another variant"
                )));
            }
        })
    }
}

impl std::fmt::Display for SceneSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Builtin(name) | Self::Made(name) => f.write_str(name),
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Files(files) => write!(f, "{}", files.path().display()),
        }
    }
}

/// A loaded scene, and how it is to be looked at.
#[derive(Clone, Debug)]
pub struct Project {
    /// Where the scene is from.
    pub source: SceneSource,
    /// The scene as its file has it: [`Look::scene`], [`Look::reflectance`] and the like are not applied yet.
    pub scene: Scene,
    /// The look that was asked for, with what the file says in its place.
    pub look: Look,
    /// Whether the look's environment is the file's own.
    pub(crate) brings_environment: bool,
}

/// Tables of a scene file that say how it is drawn.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Sections {
    bump_scale: Option<f32>,
    ground_camera_height: Option<f32>,
    lamp_strength: Option<f32>,
    emission: Option<Emission>,
    paper: Paper,
    #[serde(deserialize_with = "Given::deserialize::<FitSettings, _>")]
    fit: Given,
    #[serde(
        deserialize_with = "Given::deserialize::<(LightPaths, (LightingSettings, TechniqueSettings)), _>"
    )]
    render: Given,
    #[serde(deserialize_with = "Given::deserialize::<(PictureSettings, DisplaySettings), _>")]
    display: Given,
    #[serde(deserialize_with = "Given::deserialize::<AnimationLook, _>")]
    animation: Given,
    #[serde(deserialize_with = "environment_options")]
    environment: Given,
    surface: Vec<SurfaceEntry>,
}

/// The options among the keys of `[environment]`.
fn environment_options<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Given, D::Error> {
    Given::deserialize_beside::<EnvironmentLook, D>(&ENVIRONMENT_KEYS, deserializer)
}

/// `[[surface]]`: the reflectance of one material, or of all.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceEntry {
    material: Option<usize>,
    reflectance: ReflectanceSettings,
}

impl Project {
    /// A scene that a program made, to be looked at as by default.
    pub fn made(name: &str, scene: Scene) -> Self {
        let source = SceneSource::Made(name.to_owned());
        Self { source, scene, look: Look::default(), brings_environment: false }
    }

    /// Reads the environment of the look; with what had to be repaired, a line each.
    ///
    /// # Errors
    /// As [`crate::load_surroundings`].
    pub fn surroundings(&self) -> Result<(Surroundings, Vec<String>), StudioError> {
        surroundings_of(Some(&self.source), &self.look)
    }

    /// Loads a scene to be looked at as `look` says. What the scene file says goes before it, option by option, and what is
    /// `given` before both; camera, animation, ground and surfaces are always the scene's own.
    ///
    /// # Errors
    /// Names of nothing, files that cannot be used.
    pub fn open(name: &str, look: Look, given: &Given) -> Result<Self, StudioError> {
        Self::open_source(SceneSource::named(name), look, given)
    }

    /// [`Project::open`] of what need not be a name.
    ///
    /// # Errors
    /// As [`Project::open`].
    pub fn open_source(source: SceneSource, mut look: Look, given: &Given) -> Result<Self, StudioError> {
        let sections = match &source {
            SceneSource::Builtin(_) | SceneSource::Made(_) => None,
            SceneSource::File(path) if !path.exists() => return Err(no_scene(path)),
            SceneSource::File(path) => read_sections::<Sections>(path, &FileResolver)?,
            SceneSource::Files(files) => read_sections::<Sections>(files.path(), files.resolver())?,
        };
        let sections = sections.unwrap_or_default();
        let of_scene = sections.of_scene(SceneLook::default());
        let Sections { paper, fit, render, display, animation, environment, surface, .. } = sections;
        let folder = match &source {
            SceneSource::Builtin(_) | SceneSource::Made(_) => None,
            SceneSource::File(path) => path.parent(),
            SceneSource::Files(files) => files.path().parent(),
        };
        let folder = folder.unwrap_or(Path::new(""));
        let environment =
            environment.map_files::<EnvironmentLook>(|file| folder.join(file).to_string_lossy().into_owned());
        (look.scene, look.animation) = Default::default();
        [&paper.given(), &fit, &render, &display, &animation, given]
            .into_iter()
            .for_each(|given| given.apply(&mut look));
        look.camera = CameraLook::Automatic;
        look.reflectance = None;
        look.surfaces = BTreeMap::new();
        for SurfaceEntry { material, reflectance } in surface {
            match material {
                Some(material) => drop(look.surfaces.insert(material, reflectance)),
                None => look.reflectance = Some(reflectance),
            }
        }
        look.scene = of_scene;
        look.scene.check()?;
        given.apply(&mut look.scene);
        let asked = look.scene.axes();
        let axes =
            Axes { up: asked.up.filter(|_| given.has("up")), unit: asked.unit.filter(|_| given.has("unit")) };
        let LoadedScene { scene, environment: own, ground, variant, axes } = source.load(&look, axes)?;
        look.scene.ground = ground;
        look.scene.variant = variant;
        look.scene.up = axes.up.unwrap_or(look.scene.up);
        look.scene.unit = axes.unit.unwrap_or(look.scene.unit);
        let brings_environment = own.is_some();
        if let Some(own) = own {
            look.map = own.source;
            look.environment = EnvironmentLook::default();
            look.display.exposure = own.exposure_ev;
        }
        // What the environment brings gives way, too.
        [&environment, &display, given].into_iter().for_each(|given| given.apply(&mut look));
        Ok(Self { source, scene, look, brings_environment })
    }
}

impl Sections {
    /// A look with what they say of the scene.
    fn of_scene(&self, look: SceneLook) -> SceneLook {
        SceneLook {
            bump_scale: self.bump_scale.unwrap_or(look.bump_scale),
            ground_camera_height: self.ground_camera_height.unwrap_or(look.ground_camera_height),
            lamp_strength: self.lamp_strength.unwrap_or(look.lamp_strength),
            emission: self.emission.unwrap_or(look.emission),
            ..look
        }
    }
}

fn no_scene(path: &Path) -> StudioError {
    let names = builtin::NAMES.join(", ");
    StudioError::Request(format!(
        "there is no scene '{}': no such file, and the built-in ones are {names}",
        path.display()
    ))
}
