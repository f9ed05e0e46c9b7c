//! Environments by name, lights for them, and both worked out for a renderer.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Quat;
use gnomon_envmap::{Environment, Equirect, builtin, load};
use gnomon_lights::fit::FitSettings;
use gnomon_lights::{FitOptions, LightSet};
use gnomon_renderer::{PreparedLighting, RenderSettings};
use gnomon_scene::{Camera, Scene};
use gnomon_scene_files::EnvironmentSource;

use crate::studio::LightingKey;
use crate::{Look, SceneSource, Stage, StudioError};

/// What a name means: a built-in environment, or else a file. Whoever means a file called like a built-in one writes `./room`.
pub fn environment_named(name: &str) -> EnvironmentSource {
    match builtin::names().any(|builtin| builtin == name) {
        true => EnvironmentSource::Builtin(name.to_owned()),
        false => EnvironmentSource::File(PathBuf::from(name)),
    }
}

/// Reads or makes the environment of a look as it is, not turned; with what had to be repaired, a line each.
///
/// # Errors
/// Unreadable files, pictures of no known layout, names of nothing.
pub fn load_environment(look: &Look) -> Result<(Equirect, Vec<String>), StudioError> {
    let names = || builtin::names().collect::<Vec<_>>().join(", ");
    match &look.map {
        None => Err(StudioError::Request(format!(
            "there is no environment: give one with --env (a file, or {})",
            names()
        ))),
        Some(EnvironmentSource::Builtin(name)) => {
            let map = builtin::by_name(name).ok_or_else(|| no_environment(name, &names()))?;
            Ok((map, Vec::new()))
        }
        Some(EnvironmentSource::File(path)) => {
            let options = look.environment.load_options();
            let environment = load(Path::new(path), options).map_err(|error| match path.exists() {
                true => error.into(),
                false => no_environment(&path.to_string_lossy(), &names()),
            })?;
            Ok(with_warnings(path, environment))
        }
    }
}

/// The same for a scene of this source: where a program gives the scene's files, the environment's is one of them.
pub(crate) fn environment_of(
    source: &SceneSource,
    look: &Look,
) -> Result<(Equirect, Vec<String>), StudioError> {
    match (source, &look.map) {
        (SceneSource::Files(files), Some(EnvironmentSource::File(path))) => {
            Ok(with_warnings(path, files.environment(path, look.environment.load_options())?))
        }
        _ => load_environment(look),
    }
}

fn with_warnings(path: &Path, environment: Environment) -> (Equirect, Vec<String>) {
    let warnings = environment.warnings().iter().map(|w| format!("{}: {w}", path.display())).collect();
    (environment.map, warnings)
}

fn no_environment(name: &str, names: &str) -> StudioError {
    StudioError::Request(format!(
        "there is no environment '{}': no such file, and the built-in ones are {names}",
        gnomon_messages::quoted(name)
    ))
}

/// Lights and ambient rest of an environment, by a fit with these options.
///
/// # Errors
/// Unknown fit, option out of range.
pub fn fit_lights(
    fit: &FitSettings,
    options: &FitOptions,
    environment: &Equirect,
) -> Result<LightSet, StudioError> {
    Ok(match fit.fit_with(options)? {
        Some(fit) => fit.fit(environment)?,
        None => LightSet::new("none", Vec::new(), environment.clone()),
    })
}

/// What a fit may know of a scene.
#[derive(Clone)]
pub struct FitScene {
    pub(crate) scene: Arc<Scene>,
    pub(crate) camera: Option<Camera>,
    /// Width over height of the picture.
    pub(crate) aspect: f32,
    pub(crate) world_from_environment: Quat,
    /// Whether it stands on one.
    pub(crate) ground: bool,
}

impl FitScene {
    /// What a look's fit takes for the scene. In an interior rays find out what arrives (0.1 s).
    ///
    /// # Errors
    /// As [`FitSettings::options`], and a scene that cannot be traced.
    pub fn options(&self, fit: &FitSettings) -> Result<FitOptions, StudioError> {
        let mut options = fit.options(self.ground)?;
        if let Some(camera) = self.camera.as_ref().filter(|_| fit.heeds_arrival()) {
            let arrival = gnomon_reference::interior_arrival(
                &self.scene,
                camera,
                self.aspect,
                self.world_from_environment,
            )?;
            options.arrival = arrival.map(Arc::new);
        }
        Ok(options)
    }
}

/// An environment, or where to get it.
pub(crate) enum MapSource {
    Loaded(Arc<Equirect>),
    /// As a scene of this source names it.
    Unread(SceneSource),
}

/// What is to be worked out, on any thread.
pub(crate) struct LightingRequest {
    pub map: MapSource,
    /// Environment, fit and the treatment of the ambient rest count.
    pub look: Look,
    pub scene: FitScene,
}

/// An environment ready for a renderer.
pub(crate) struct LightingResult {
    pub map: Arc<Equirect>,
    pub lights: LightSet,
    pub prepared: PreparedLighting,
    pub warnings: Vec<String>,
    /// What it was made for.
    pub lit_for: LightingKey,
}

/// Reads where that is needed, fits and filters.
pub(crate) fn work_out(request: LightingRequest) -> Result<LightingResult, StudioError> {
    let LightingRequest { map, look, scene } = request;
    let (map, warnings) = match map {
        MapSource::Loaded(map) => (map, Vec::new()),
        MapSource::Unread(source) => {
            let (map, warnings) = environment_of(&source, &look)?;
            (Arc::new(map), warnings)
        }
    };
    let options = scene.options(&look.fit)?;
    let lights = fit_lights(&look.fit, &options, &map)?;
    let settings = RenderSettings { lighting: look.lighting.clone(), ..RenderSettings::default() };
    let prepared = PreparedLighting::new(&map, &lights, &settings)?;
    let lit_for = LightingKey::of(&look, scene.ground, options.arrival.is_some());
    Ok(LightingResult { map, lights, prepared, warnings, lit_for })
}

/// The lighting of a stage.
pub(crate) fn work_out_stage(stage: &Stage) -> Result<LightingResult, StudioError> {
    let map = MapSource::Loaded(Arc::clone(stage.environment()));
    work_out(LightingRequest { map, look: stage.look().clone(), scene: stage.fit_scene() })
}
