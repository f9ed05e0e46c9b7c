//! What a session begins with, and other scenes and environments.

use gnomon_options::Given;
use gnomon_scene::{Camera, ReflectanceSettings};
use gnomon_scene_files::EnvironmentSource;
use gnomon_studio::{CameraLook, Look, Pace, Project, SceneSource, Stage, Studio, environment_named};
use serde::Deserialize;
use wasm_bindgen::prelude::*;
use web_sys::OffscreenCanvas;

use super::{Notice, Session};
use crate::canvas::{Canvas, Device};
use crate::detail::Detail;
use crate::error::PageError;
use crate::files::Files;
use crate::frames::Frames;
use crate::panel;

/// Files by their paths, on their way from the page.
#[wasm_bindgen]
#[derive(Default)]
pub struct FileSet(Vec<(String, Vec<u8>)>);

#[wasm_bindgen]
impl FileSet {
    /// None yet.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one.
    pub fn add(&mut self, path: String, bytes: Vec<u8>) {
        self.0.push((path, bytes));
    }

    pub(crate) fn into_files(self) -> Files {
        Files::new(self.0)
    }
}

/// What a page begins with.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase", deny_unknown_fields)]
struct Request {
    /// A built-in scene, or a path among the files.
    scene: String,
    /// The same of an environment; without one that of the scene, or a built-in one.
    environment: Option<String>,
    /// Names of options with texts.
    options: Vec<(String, String)>,
    camera: Option<Camera>,
    reflectance: Option<ReflectanceSettings>,
    /// Pixels of the canvas.
    size: [u32; 2],
}

/// Environment of scenes that bring none.
const DEFAULT_ENVIRONMENT: &str = "room";
/// Samples along a pixel's side that a page begins with: it has to do with any GPU.
const SUPERSAMPLE: u32 = 2;

#[wasm_bindgen]
impl Session {
    /// Opens a device for a canvas, and a scene on it, by a request as JSON. Files are those that the request names.
    pub async fn open(canvas: OffscreenCanvas, request: &str, files: FileSet) -> Result<Session, PageError> {
        let Request { scene, environment, options, camera, reflectance, size } =
            serde_json::from_str(request)?;
        let (files, source, environment) = located(files.0, &scene, environment)?;
        let mut notices = Vec::new();
        let mut given = Given::default();
        for (name, text) in &options {
            if let Err(error) = panel::give(&mut given, name, text) {
                notices.push(Notice { is_error: true, text: error.to_string() });
            }
        }
        let mut look = Look::default();
        look.techniques.supersample = SUPERSAMPLE;
        look.picture.size = size;
        let mut project = Project::open_source(source, look, &given)?;
        let default = || (!project.look.has_environment()).then(|| environment_named(DEFAULT_ENVIRONMENT));
        if let Some(environment) = environment.or_else(default) {
            project.look.set_environment(environment);
            given.apply(&mut project.look);
        }
        if let Some(camera) = camera {
            project.look.camera = CameraLook::Free(camera);
        }
        project.look.reflectance = reflectance.or(project.look.reflectance);
        let device = Device::open().await?;
        let studio = Studio::new(&device.gpu, Stage::new(project)?)?;
        let mut session = Self {
            canvas: Canvas::new(&device, canvas)?,
            split: None,
            files,
            opening: None,
            orbit: None,
            detail: Detail::default(),
            frames: Frames::default(),
            pace: Pace::default(),
            size,
            stale: true,
            now: 0.0,
            moved: f64::NEG_INFINITY,
            playing: false,
            passes: Vec::new(),
            notices,
            device,
            studio,
        };
        session.studio.set_profile(true);
        session.take_view();
        Ok(session)
    }

    /// Loads another scene: a built-in one, or the file of that path.
    #[wasm_bindgen(js_name = openScene)]
    pub fn open_scene(&mut self, scene: &str, files: FileSet) -> Result<(), PageError> {
        let (files, source, _) = located(files.0, scene, None)?;
        files.take_environment_of(&self.files, self.studio.look());
        self.detail.restore(&mut self.studio)?;
        self.studio.load_scene(source);
        self.opening = Some(files);
        Ok(())
    }

    /// Takes another environment: a built-in one, or the first of these files.
    #[wasm_bindgen(js_name = setEnvironment)]
    pub fn set_environment(&mut self, name: &str, files: FileSet) -> Result<(), PageError> {
        let mut source = environment_named(name);
        for (path, bytes) in files.0 {
            source = EnvironmentSource::File(self.files.put(&path, bytes));
        }
        self.edit(|look| {
            look.set_environment(source);
            look.display.exposure = None;
        })
    }
}

/// Where a scene and an environment of these names are.
fn located(
    files: Vec<(String, Vec<u8>)>,
    scene: &str,
    environment: Option<String>,
) -> Result<(Files, SceneSource, Option<EnvironmentSource>), PageError> {
    let is_among = |name: &str| files.iter().any(|(path, _)| path == name);
    let environment = environment.map(|name| match is_among(&name) {
        true => EnvironmentSource::File(gnomon_scene_files::plain(name.as_ref())),
        false => environment_named(&name),
    });
    if is_among(scene) {
        let files = Files::new(files);
        let source = files.source(scene);
        return Ok((files, source, environment));
    }
    let (built_in, source) = Files::of_builtin(scene)?;
    for (path, bytes) in files {
        built_in.put(&path, bytes);
    }
    Ok((built_in, source, environment))
}
