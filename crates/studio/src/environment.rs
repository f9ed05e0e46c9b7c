//! Environments by name, lights for them, and both worked out for a renderer.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{Quat, Vec3};
use gnomon_envmap::{Equirect, Grade, LoadOptions, builtin, load};
use gnomon_lights::fit::FitSettings;
use gnomon_lights::{DistantLight, DocumentError, FitOptions, LightDocument, LightSet, clamped};
use gnomon_messages::quoted;
use gnomon_picture::RgbImage;
use gnomon_reference::{MOST_UNASKED_TRIANGLES, Sky};
use gnomon_renderer::{PreparedLighting, RenderSettings};
use gnomon_scene::{Camera, Scene};
use gnomon_scene_files::EnvironmentSource;

use crate::look::EnvironmentLook;
use crate::studio::LightingKey;
use crate::{Look, SceneFiles, SceneSource, Stage, StudioError};

/// What a name means: a built-in environment, or else a file. Whoever means a file called like a built-in one writes `./room`.
pub fn environment_named(name: &str) -> EnvironmentSource {
    match builtin::names().any(|builtin| builtin == name) {
        true => EnvironmentSource::Builtin(name.to_owned()),
        false => EnvironmentSource::File(PathBuf::from(name)),
    }
}

/// What is infinitely far around a scene, as its look has it but for its turn and its grade ([`Stage::grade`]): these change nothing that is made of it.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// What lights, but for `lights`.
    map: Arc<Equirect>,
    /// Lights beside it.
    lights: Arc<[DistantLight]>,
    /// The rig whose lights they are, as it shines; then they are all lights there are, and no more are fitted to the map.
    rig: Option<Arc<LightDocument>>,
    /// The map before its brightest light became lights, where it did.
    unclamped: Option<Arc<Equirect>>,
    /// What the camera sees behind the scene, where that is another.
    background: Option<Arc<Equirect>>,
    /// Stops that suit it.
    exposure: f32,
}

/// A map that lights all by itself and is seen.
impl From<Arc<Equirect>> for Surroundings {
    fn from(map: Arc<Equirect>) -> Self {
        let exposure = map.suitable_exposure();
        let lights = Arc::default();
        Self { map, lights, rig: None, unclamped: None, background: None, exposure }
    }
}

impl Surroundings {
    /// The map that lights.
    pub fn map(&self) -> &Arc<Equirect> {
        &self.map
    }

    /// The same with all of its light, where some of it became lights.
    pub fn whole_map(&self) -> &Arc<Equirect> {
        self.unclamped.as_ref().unwrap_or(&self.map)
    }

    /// The rig in the place of fitted lights, as it shines.
    pub fn rig(&self) -> Option<&LightDocument> {
        self.rig.as_deref()
    }

    /// Lights beside it: a rig's, and what was taken out of the brightest texels ([`EnvironmentLook::clamp`]).
    pub fn lights(&self) -> &[DistantLight] {
        &self.lights
    }

    /// Stops that bring the environment's mean to 0.5, as its file has it.
    pub fn exposure(&self) -> f32 {
        self.exposure
    }

    /// For the reference.
    pub(crate) fn sky(&self, grade: Grade) -> Sky<'_> {
        let background = self.background.as_ref().unwrap_or(&self.map);
        Sky { map: &self.map, lights: &self.lights, background, grade }
    }

    /// What a fit takes for a scene under these.
    fn fit_options(&self, look: &Look, scene: &FitScene) -> Result<FitOptions, StudioError> {
        match self.rig.is_some() {
            true => Ok(look.fit.options(scene.ground)?),
            false => scene.options(&look.fit),
        }
    }

    /// Lights and ambient rest: a rig's own, or by a fit with these options.
    ///
    /// # Errors
    /// As [`fit_lights`].
    pub fn fit_lights(&self, fit: &FitSettings, options: &FitOptions) -> Result<LightSet, StudioError> {
        if self.rig.is_some() {
            let set = LightSet::new("rig", self.lights.to_vec(), Equirect::clone(&self.map));
            return Ok(LightSet { stands_alone: true, ..set });
        }
        let mut set = fit_lights(fit, options, &self.map)?;
        set.lights.extend_from_slice(&self.lights);
        Ok(LightSet { taken_out: self.lights.len(), ..set })
    }

    /// Whether these are the very same: whoever changes one replaces it.
    pub(crate) fn is(&self, other: &Self) -> bool {
        let same_background = match (&self.background, &other.background) {
            (None, None) => true,
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            _ => false,
        };
        Arc::ptr_eq(&self.map, &other.map) && Arc::ptr_eq(&self.lights, &other.lights) && same_background
    }
}

/// Reads or makes the surroundings of a look as they are, neither turned nor graded; with what had to be repaired, a line each.
///
/// # Errors
/// Unreadable files, pictures of no known layout, names of nothing, rigs that cannot be.
pub fn load_surroundings(look: &Look) -> Result<(Surroundings, Vec<String>), StudioError> {
    surroundings_of(None, look)
}

/// The same for a scene of this source: where a program gives the scene's files, those that the look names are of these.
pub(crate) fn surroundings_of(
    source: Option<&SceneSource>,
    look: &Look,
) -> Result<(Surroundings, Vec<String>), StudioError> {
    let files =
        source.and_then(|source| if let SceneSource::Files(files) = source { Some(files) } else { None });
    let reader = Reader { files, warnings: Vec::new() };
    reader.read(look)
}

/// Reads maps, and keeps what had to be repaired.
struct Reader<'a> {
    files: Option<&'a SceneFiles>,
    warnings: Vec<String>,
}

impl Reader<'_> {
    fn read(mut self, look: &Look) -> Result<(Surroundings, Vec<String>), StudioError> {
        let environment = &look.environment;
        let mut surroundings = match &environment.rig {
            Some(rig) => self.rig(Path::new(rig), look)?,
            None => self.environment(look)?.into(),
        };
        surroundings = surroundings.clamped(environment);
        if let Some(background) = &environment.background_map {
            surroundings.background =
                Some(Arc::new(self.map(Path::new(background), LoadOptions::default())?));
        }
        Ok((surroundings, self.warnings))
    }

    fn environment(&mut self, look: &Look) -> Result<Arc<Equirect>, StudioError> {
        let names = || builtin::names().collect::<Vec<_>>().join(", ");
        match &look.map {
            None => Err(StudioError::Request(format!(
                "there is no environment: give one with --env (a file, or {})",
                names()
            ))),
            Some(EnvironmentSource::Builtin(name)) => {
                Ok(Arc::new(builtin::by_name(name).ok_or_else(|| no_environment(name, &names()))?))
            }
            Some(EnvironmentSource::File(path)) => {
                let is_there = self.files.is_some() || path.exists();
                match self.map(path, look.environment.load_options()) {
                    Err(_) if !is_there => Err(no_environment(&path.to_string_lossy(), &names())),
                    map => Ok(Arc::new(map?)),
                }
            }
        }
    }

    fn map(&mut self, path: &Path, options: LoadOptions<'_>) -> Result<Equirect, StudioError> {
        let environment = match self.files {
            Some(files) => files.environment(path, options)?,
            None => load(path, options)?,
        };
        self.warnings.extend(environment.warnings().iter().map(|w| format!("{}: {w}", path.display())));
        Ok(environment.map)
    }

    /// Lights and maps of a rig; the maps lie where it says, seen from there.
    fn rig(&mut self, path: &Path, look: &Look) -> Result<Surroundings, StudioError> {
        let invalid =
            |what: String| StudioError::Request(format!("{} is no light rig: {what}", path.display()));
        let text = match self.files {
            Some(files) => files.text(path)?,
            None => std::fs::read_to_string(path)
                .map_err(|source| StudioError::Read { path: path.to_owned(), source })?,
        };
        let refused = |error: DocumentError| invalid(quoted(&error.to_string()));
        let mut rig = LightDocument::from_json(&text).map_err(refused)?;
        if let Some(edited) = look.edited_rig() {
            edited.apply(&mut rig);
            rig.check().map_err(refused)?;
        }
        let beside = |file: &String| path.parent().unwrap_or(Path::new("")).join(file);
        let mut map = match &rig.residual {
            Some(file) => self.map(&beside(file), LoadOptions::default())?,
            None if rig.residual_flux.iter().any(|flux| *flux > 0.0) => {
                return Err(invalid(
                    "its lights leave a map (residual_flux), but it names none (residual)".to_owned(),
                ));
            }
            None => black(),
        };
        let mut background = match (&look.map, &rig.background) {
            (Some(_), _) => Some(self.environment(look)?),
            (None, Some(file)) => Some(Arc::new(self.map(&beside(file), LoadOptions::default())?)),
            (None, None) => None,
        };
        let exposure = background.as_deref().unwrap_or(&map).suitable_exposure();
        if look.edited_rig().is_some_and(|edited| edited.solo.is_some()) {
            let residual = std::mem::replace(&mut map, black());
            background.get_or_insert_with(|| Arc::new(residual));
        }
        let lights = rig.shining().into();
        Ok(Surroundings {
            map: Arc::new(map),
            lights,
            rig: Some(Arc::new(rig)),
            unclamped: None,
            background,
            exposure,
        })
    }
}

/// A map of nothing.
fn black() -> Equirect {
    Equirect::new(RgbImage::filled(8, 4, Vec3::ZERO))
}

impl Surroundings {
    /// The same with the brightest light of the map as lights, as a look asks for. The camera sees the whole map.
    #[must_use]
    pub fn clamped(mut self, look: &EnvironmentLook) -> Self {
        let Some(limit) = look.clamp else { return self };
        let (map, lights) = clamped(&self.map, limit);
        if !lights.is_empty() {
            self.background.get_or_insert_with(|| Arc::clone(&self.map));
            self.unclamped = Some(std::mem::replace(&mut self.map, Arc::new(map)));
            self.lights = self.lights.iter().cloned().chain(lights).collect();
        }
        self
    }
}

fn no_environment(name: &str, names: &str) -> StudioError {
    StudioError::Request(format!(
        "there is no environment '{}': no such file, and the built-in ones are {names}",
        quoted(name)
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
    Loaded(Surroundings),
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
    pub surroundings: Surroundings,
    pub lights: LightSet,
    pub prepared: PreparedLighting,
    pub warnings: Vec<String>,
    /// What it was made for.
    pub lit_for: LightingKey,
}

/// Reads where that is needed, fits and filters.
pub(crate) fn work_out(request: LightingRequest) -> Result<LightingResult, StudioError> {
    let LightingRequest { map, look, scene } = request;
    let (surroundings, warnings) = match map {
        MapSource::Loaded(surroundings) => (surroundings, Vec::new()),
        MapSource::Unread(source) => surroundings_of(Some(&source), &look)?,
    };
    let options = surroundings.fit_options(&look, &scene)?;
    lit(surroundings, warnings, (&look, &scene), &options)
}

/// The lighting of a stage; `None` where it is that of the same surroundings which was worked out for `in_force`.
pub(crate) fn work_out_unless(
    stage: &Stage,
    in_force: Option<&LightingKey>,
) -> Result<Option<LightingResult>, StudioError> {
    let (surroundings, look, scene) = (stage.surroundings(), stage.look(), stage.fit_scene());
    let options = surroundings.fit_options(look, &scene)?;
    // Lights of an interior are those of its pose and camera, which no key tells.
    let is_interior = options.arrival.is_some();
    if !is_interior && in_force == Some(&LightingKey::of(look, scene.ground, false)) {
        return Ok(None);
    }
    lit(surroundings.clone(), Vec::new(), (look, &scene), &options).map(Some)
}

/// Fits and filters.
fn lit(
    surroundings: Surroundings,
    mut warnings: Vec<String>,
    (look, scene): (&Look, &FitScene),
    options: &FitOptions,
) -> Result<LightingResult, StudioError> {
    let triangles = scene.scene.triangle_count();
    if triangles > MOST_UNASKED_TRIANGLES && scene.camera.is_some() && look.fit.heeds_arrival() {
        warnings.push(format!(
            "{triangles} triangles are too many to find out whether the scene is an interior: its lights are those of an open one"
        ));
    }
    let lights = surroundings.fit_lights(&look.fit, options)?;
    let settings = RenderSettings { lighting: look.lighting.clone(), ..RenderSettings::default() };
    let mut prepared = match surroundings.unclamped.as_ref().filter(|_| surroundings.rig.is_none()) {
        // Unshadowed light is that of the whole map.
        Some(whole) => PreparedLighting::new(whole, &lights, &settings)?.with_mirrored(&surroundings.map),
        None => PreparedLighting::new(&surroundings.map, &lights, &settings)?,
    };
    if let Some(background) = &surroundings.background {
        prepared = prepared.with_background(Equirect::clone(background));
    }
    let lit_for = LightingKey::of(look, scene.ground, options.arrival.is_some());
    Ok(LightingResult { surroundings, lights, prepared, warnings, lit_for })
}

/// The lighting of a stage.
pub(crate) fn work_out_stage(stage: &Stage) -> Result<LightingResult, StudioError> {
    let map = MapSource::Loaded(stage.surroundings().clone());
    work_out(LightingRequest { map, look: stage.look().clone(), scene: stage.fit_scene() })
}
