//! A scene with the look that its file asks for.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use gnomon_scene::{Ground, ReflectanceSettings, Scene, builtin};
use gnomon_scene_files::{EnvironmentSource, LoadOptions, LoadedScene, load, read_sections};
use serde::Deserialize;

use crate::look::{AnimationLook, CameraLook, DisplayLook, FitLook, RenderLook};
use crate::{Look, StudioError};

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SceneSource {
    /// A built-in scene, by its name.
    Builtin(String),
    /// A file.
    File(PathBuf),
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

impl std::fmt::Display for SceneSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Builtin(name) => f.write_str(name),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

/// A loaded scene, and how it is to be looked at.
#[derive(Clone, Debug)]
pub struct Project {
    /// Where the scene is from.
    pub source: SceneSource,
    /// The scene as its file has it: [`Look::ground`], [`Look::reflectance`] and the like are not applied yet.
    pub scene: Scene,
    /// The look that was asked for, with what the file says in its place.
    pub look: Look,
}

/// Tables of a scene file that say how it is drawn.
#[derive(Default, Deserialize)]
struct Sections {
    fit: Option<FitLook>,
    render: Option<RenderLook>,
    display: Option<DisplayLook>,
    animation: Option<AnimationLook>,
    #[serde(default)]
    surface: Vec<SurfaceEntry>,
}

/// `[[surface]]`: the reflectance of one material, or of all.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceEntry {
    material: Option<usize>,
    reflectance: ReflectanceSettings,
}

impl Project {
    /// Loads a scene to be looked at as `look` says. What the scene file says goes before it, table by table; camera, animation, ground
    /// and surfaces are always the scene's own. `size` goes before the file's picture size.
    ///
    /// # Errors
    /// Names of nothing, files that cannot be used.
    pub fn open(name: &str, look: Look, size: Option<[u32; 2]>) -> Result<Self, StudioError> {
        Self::open_source(SceneSource::named(name), look, size)
    }

    /// [`Project::open`] of what need not be a name.
    ///
    /// # Errors
    /// As [`Project::open`].
    pub fn open_source(
        source: SceneSource,
        mut look: Look,
        size: Option<[u32; 2]>,
    ) -> Result<Self, StudioError> {
        let sections = match &source {
            SceneSource::Builtin(_) => None,
            SceneSource::File(path) if !path.exists() => return Err(no_scene(path)),
            SceneSource::File(path) => read_sections::<Sections>(path)?,
        };
        let Sections { fit, render, display, animation, surface } = sections.unwrap_or_default();
        look.fit = fit.unwrap_or(look.fit);
        look.render = render.unwrap_or(look.render);
        let exposure = display.as_ref().and_then(|display| display.exposure);
        look.display = display.map_or(look.display.clone(), |display| DisplayLook {
            exposure: display.exposure.or(look.display.exposure),
            ..display
        });
        look.display.size = size.unwrap_or(look.display.size);
        look.animation = animation.unwrap_or_default();
        look.camera = CameraLook::Automatic;
        look.reflectance = None;
        look.surfaces = BTreeMap::new();
        for SurfaceEntry { material, reflectance } in surface {
            match material {
                Some(material) => drop(look.surfaces.insert(material, reflectance)),
                None => look.reflectance = Some(reflectance),
            }
        }
        let LoadedScene { scene, environment, ground } = match &source {
            SceneSource::Builtin(name) => {
                let scene = builtin::by_name(name)?;
                LoadedScene { scene, environment: None, ground: Ground::None }
            }
            SceneSource::File(path) => {
                load(path, &LoadOptions { aspect: look.display.aspect(), ..LoadOptions::default() })?
            }
        };
        look.ground = ground;
        if let Some(own) = environment {
            look.environment.source = Some(own.source);
            look.environment.projection = own.projection;
            look.environment.rotation = own.rotation_degrees;
            look.display.exposure = exposure.or(own.exposure_ev);
        }
        Ok(Self { source, scene, look })
    }

    /// Another environment than the file's. A turn and a projection that the file gives belong to its own and go with it; its exposure
    /// stays.
    pub fn set_environment(&mut self, source: EnvironmentSource) {
        self.look.environment.source = Some(source);
        self.look.environment.projection = None;
        self.look.environment.rotation = 0.0;
    }
}

fn no_scene(path: &Path) -> StudioError {
    let names = builtin::NAMES.join(", ");
    StudioError::Request(format!(
        "there is no scene '{}': no such file, and the built-in ones are {names}",
        path.display()
    ))
}
