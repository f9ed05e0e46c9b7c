//! The session, as a worker of the page holds it.

use std::sync::Arc;

use gnomon_options::Given;
use gnomon_picture::ldr::encode_png;
use gnomon_picture::tonemap::tone_mapped;
use gnomon_renderer::{PassTiming, RenderError};
use gnomon_scene::{Camera, Orbit, ReflectanceSettings};
use gnomon_scene_files::EnvironmentSource;
use gnomon_studio::{CameraLook, Look, Pace, Project, SceneSource, Stage, Studio, Update, environment_named};
use serde::{Deserialize, Serialize};
use wasm_bindgen::prelude::*;
use web_sys::OffscreenCanvas;

use crate::canvas::{Canvas, Device};
use crate::detail::Detail;
use crate::error::PageError;
use crate::files::Files;
use crate::frames::Frames;
use crate::panel;
use crate::split::Split;
use crate::tracer::rgba;

/// After the last movement the picture is still taken to be moving for so long [ms].
const SETTLES_AFTER: f64 = 400.0;

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

#[derive(Serialize)]
struct Notice {
    is_error: bool,
    text: String,
}

/// What a page shows beside the picture.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Status {
    /// What was opened, for people.
    scene: String,
    environment: String,
    triangles: usize,
    lights: usize,
    clips: usize,
    duration: Option<f32>,
    time: f32,
    playing: bool,
    /// Whether something is loaded or fitted, or still to be drawn.
    busy: bool,
    loading: bool,
    moving: bool,
    device_lost: bool,
    /// Pixels of the picture that was drawn last.
    drawn: [u32; 2],
    frames: u64,
    frame_ms: f64,
    passes: Vec<PassTiming>,
    level: String,
    adapter: String,
    notices: Vec<Notice>,
}

/// A scene on a canvas.
#[wasm_bindgen]
pub struct Session {
    device: Device,
    canvas: Canvas,
    split: Option<Split>,
    studio: Studio,
    files: Files,
    /// Those of a scene that is being loaded.
    opening: Option<Files>,
    orbit: Option<Orbit>,
    detail: Detail,
    frames: Frames,
    pace: Pace,
    size: [u32; 2],
    stale: bool,
    /// Times of the page's clock [ms].
    now: f64,
    moved: f64,
    playing: bool,
    passes: Vec<PassTiming>,
    notices: Vec<Notice>,
}

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

    /// Goes on after the loss of the device.
    pub async fn reopen(&mut self) -> Result<(), PageError> {
        let device = Device::open().await?;
        self.studio.reopen(&device.gpu)?;
        self.canvas = self.canvas.reopened(&device)?;
        let split = self.split.take().map(|split| split.reopened(&device, &self.studio));
        self.split = split.transpose()?;
        (self.device, self.frames, self.stale) = (device, Frames::default(), true);
        self.notices.push(Notice {
            is_error: false,
            text: "the graphics device was lost and opened anew".to_owned(),
        });
        Ok(())
    }

    /// Destroys the device, as a driver's reset does.
    #[wasm_bindgen(js_name = loseDevice)]
    pub fn lose_device(&self) {
        self.device.gpu.device().destroy();
    }

    /// Does what there is to do at a time of the page's clock [ms]: background work a slice, a picture where one is due. Whether more is
    /// to be done soon.
    pub fn frame(&mut self, now: f64) -> Result<bool, PageError> {
        let step = now - std::mem::replace(&mut self.now, now);
        self.take_updates()?;
        if let Some(ended) = self.frames.take_ended(now) {
            if self.detail.is_held() {
                self.pace.drawn(ended.divisor, ended.milliseconds);
            }
        }
        for frame in self.studio.take_times() {
            self.passes = frame.passes;
        }
        if self.device_is_lost() {
            return Ok(false);
        }
        if self.playing {
            self.go_on_by(step)?;
        }
        let moving = self.is_moving();
        if self.detail.follow(&mut self.studio, moving)? {
            self.stale = true;
        }
        if self.stale && !self.frames.are_waited_for() {
            self.draw(moving)?;
        }
        Ok(self.stale || self.frames.are_waited_for() || moving || self.studio.is_busy())
    }

    /// Pixels of the canvas.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), PageError> {
        let size = [width.max(1), height.max(1)];
        if size != self.size {
            self.size = size;
            let frames_itself = self.studio.look().camera == CameraLook::Automatic;
            self.edit(|look| look.picture.size = size)?;
            if frames_itself {
                self.take_view();
            }
        }
        Ok(())
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

    /// Gives an option a value, both as texts.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), PageError> {
        let mut result = Ok(());
        let clip = self.studio.look().animation.clip.clone();
        self.edit(|look| {
            result = panel::set(look, name, value);
            if look.animation.clip != clip {
                look.animation.time = 0.0;
            }
        })?;
        result?;
        let animation = &self.studio.look().animation;
        if animation.clip != clip {
            self.playing = animation.clip.is_some();
            if self.studio.look().camera == CameraLook::Automatic {
                self.take_view();
            }
        }
        Ok(())
    }

    /// Gives all models another reflectance; an empty name leaves every material its own.
    #[wasm_bindgen(js_name = setModel)]
    pub fn set_model(&mut self, name: &str) -> Result<(), PageError> {
        self.edit(|look| panel::set_model(look, name))
    }

    /// Sets a parameter of that: three numbers, or none to leave it to the scene.
    #[wasm_bindgen(js_name = setParameter)]
    pub fn set_parameter(&mut self, name: &str, value: Option<Vec<f32>>) -> Result<(), PageError> {
        let value = value.and_then(|value| <[f32; 3]>::try_from(value).ok());
        self.edit(|look| panel::set_parameter(look, name, value))
    }

    /// Runs or stops the clip.
    pub fn play(&mut self, playing: bool) {
        self.playing = playing && self.studio.look().animation.clip.is_some();
    }

    /// Turns the view around what it looks at: to the right and up [rad].
    pub fn turn(&mut self, x: f32, y: f32) -> Result<(), PageError> {
        self.move_view(|orbit| orbit.turn(glam::Vec2::new(x, y)))
    }

    /// Moves the view to the right and up, in its widths.
    pub fn pan(&mut self, x: f32, y: f32) -> Result<(), PageError> {
        self.move_view(|orbit| orbit.pan(glam::Vec2::new(x, y)))
    }

    /// Multiplies the distance.
    pub fn dolly(&mut self, factor: f32) -> Result<(), PageError> {
        self.move_view(|orbit| orbit.dolly(factor))
    }

    /// Frames the scene.
    #[wasm_bindgen(js_name = frameScene)]
    pub fn frame_scene(&mut self) -> Result<(), PageError> {
        self.edit(|look| look.camera = CameraLook::Automatic)?;
        self.take_view();
        Ok(())
    }

    /// Turns the environment by so many degrees.
    #[wasm_bindgen(js_name = turnEnvironment)]
    pub fn turn_environment(&mut self, by: f32) -> Result<(), PageError> {
        self.moved = self.now;
        self.edit(|look| {
            let turned = look.environment.rotation + by;
            look.environment.rotation = (turned + 180.0).rem_euclid(360.0) - 180.0;
        })
    }

    /// Frames a second that the level of detail holds while something moves; 0 leaves it as it is set.
    #[wasm_bindgen(js_name = holdFrameRate)]
    pub fn hold_frame_rate(&mut self, frames_a_second: f64) -> Result<(), PageError> {
        self.detail.restore(&mut self.studio)?;
        self.detail = Detail::holding(frames_a_second);
        Ok(())
    }

    /// Shows the scene without shadows on another canvas, or no longer.
    #[wasm_bindgen(js_name = setSplit)]
    pub fn set_split(&mut self, canvas: Option<OffscreenCanvas>) -> Result<(), PageError> {
        self.split = canvas.map(|canvas| Split::new(&self.device, canvas, &self.studio)).transpose()?;
        self.stale = true;
        Ok(())
    }

    /// What a panel offers, as JSON.
    pub fn panel(&self) -> Result<String, PageError> {
        let mut in_force = self.studio.look_in_force();
        let mut look = self.studio.look().clone();
        self.detail.put_back(&mut look);
        self.detail.put_back(&mut in_force);
        let sections = panel::sections(&look, &in_force, &self.studio.stage().clips());
        Ok(serde_json::to_string(&(sections, panel::material(&look), panel::built_in()))?)
    }

    /// What else a page shows, as JSON. Notices are told once.
    pub fn status(&mut self) -> Result<String, PageError> {
        let (look, stage) = (self.studio.look(), self.studio.stage());
        let clips = stage.clips();
        let duration = clips.iter().find(|clip| clip.is_chosen).map(|clip| clip.duration);
        let moving = self.is_moving();
        let status = Status {
            scene: scene_name(stage.source()),
            environment: environment_name(look),
            triangles: self.studio.scene().triangle_count(),
            lights: self.studio.lights().lights.len(),
            clips: clips.len(),
            duration,
            time: duration.map_or(0.0, |duration| look.animation.time.rem_euclid(duration.max(1e-3))),
            playing: self.playing,
            busy: self.studio.is_busy()
                || self.stale
                || self.frames.are_waited_for()
                || self.detail.is_held(),
            loading: self.studio.is_busy(),
            moving,
            device_lost: self.device_is_lost(),
            drawn: self.frames.size(),
            frames: self.frames.count(),
            frame_ms: self.frames.milliseconds(),
            passes: self.passes.clone(),
            level: self.detail.words(&self.studio),
            adapter: self.device.gpu.adapter().name.clone(),
            notices: std::mem::take(&mut self.notices),
        };
        Ok(serde_json::to_string(&status)?)
    }

    /// The map with its lights outlined, half as high as wide: RGBA, 8 bits a channel.
    pub fn map(&self, width: u32) -> Vec<u8> {
        rgba(&gnomon_lights::preview(self.studio.environment(), self.studio.lights(), width))
    }

    /// The picture at the canvas's size, as it is set: a PNG.
    pub async fn png(&mut self) -> Result<Vec<u8>, PageError> {
        let frame = self.full_frame(self.size)?.await?;
        let stage = self.studio.stage();
        let shown = tone_mapped(&frame, stage.look().display.tone_mapping, stage.exposure());
        encode_png(&shown).map_err(PageError::Request)
    }

    /// Radiance of the picture in so many pixels, three numbers each, top row first.
    pub async fn radiance(&mut self, width: u32, height: u32) -> Result<Vec<f32>, PageError> {
        let frame = self.full_frame([width, height])?.await?;
        Ok(frame.texels().iter().flat_map(|texel| texel.to_array()).collect())
    }

    /// A scene file of which `gnomon render` makes the same picture, for a place beside the scene's files.
    #[wasm_bindgen(js_name = sceneFile)]
    pub fn scene_file(&mut self) -> Result<String, PageError> {
        self.detail.restore(&mut self.studio)?;
        Ok(self.studio.stage().scene_file()?)
    }

    /// The look as JSON, for a tracer.
    pub fn look(&mut self) -> Result<String, PageError> {
        self.detail.restore(&mut self.studio)?;
        Ok(serde_json::to_string(self.studio.look())?)
    }

    /// What has been changed, as the part of a request that a link can carry.
    pub fn link(&self) -> Result<String, PageError> {
        let mut look = self.studio.look().clone();
        self.detail.put_back(&mut look);
        let camera = if let CameraLook::Free(camera) = &look.camera { Some(camera) } else { None };
        let link = serde_json::json!({
            "options": panel::changes(&look),
            "camera": camera,
            "reflectance": look.reflectance,
        });
        Ok(link.to_string())
    }

    /// Path of the scene's file.
    #[wasm_bindgen(js_name = scenePath)]
    pub fn scene_path(&self) -> String {
        match self.studio.stage().source() {
            SceneSource::Files(files) => files.path().to_string_lossy().into_owned(),
            source => source.to_string(),
        }
    }

    /// All files of the scene and its environment, for a tracer.
    #[wasm_bindgen(js_name = sceneFiles)]
    pub fn scene_files(&self) -> js_sys::Map {
        let files = js_sys::Map::new();
        for (path, bytes) in self.files.all() {
            files.set(&path.into(), &js_sys::Uint8Array::from(&*bytes).into());
        }
        files
    }
}

impl Session {
    fn device_is_lost(&self) -> bool {
        matches!(self.device.gpu.check(), Err(RenderError::DeviceLost { .. }))
    }

    fn is_moving(&self) -> bool {
        self.playing || self.now - self.moved < SETTLES_AFTER
    }

    fn edit(&mut self, change: impl FnOnce(&mut Look)) -> Result<(), PageError> {
        self.detail.edit(&mut self.studio, change)?;
        self.stale = true;
        Ok(())
    }

    fn move_view(&mut self, change: impl FnOnce(&mut Orbit)) -> Result<(), PageError> {
        let Some(orbit) = &mut self.orbit else { return Ok(()) };
        change(orbit);
        let camera = orbit.camera();
        self.moved = self.now;
        self.edit(|look| look.camera = CameraLook::Free(camera))
    }

    fn take_view(&mut self) {
        if let Ok(camera) = self.studio.camera() {
            self.orbit = Some(Orbit::from_camera(&camera, self.studio.scene().bounds()));
        }
    }

    fn go_on_by(&mut self, milliseconds: f64) -> Result<(), PageError> {
        // A tab that was hidden goes on where it was.
        let step = (milliseconds * 1e-3).clamp(0.0, 0.5) as f32;
        self.edit(|look| look.animation.time += step)
    }

    fn take_updates(&mut self) -> Result<(), PageError> {
        let map = Arc::clone(self.studio.stage().environment());
        let updates = self.studio.poll();
        for text in self.studio.take_warnings() {
            self.notices.push(Notice { is_error: false, text });
        }
        for update in updates {
            self.stale = true;
            match update {
                Update::Scene => {
                    if let Some(files) = self.opening.take() {
                        self.files = files;
                    }
                    self.playing = false;
                    self.take_view();
                    self.split_anew()?;
                }
                Update::Lighting if !Arc::ptr_eq(&map, self.studio.stage().environment()) => {
                    self.files.keep_those_of(self.studio.look());
                    self.split_anew()?;
                }
                Update::Lighting | Update::LevelOfDetail => {}
                Update::Failed(error) => {
                    self.opening = None;
                    if !self.studio.is_busy() {
                        self.files.keep_those_of(self.studio.look());
                    }
                    self.notices.push(Notice { is_error: true, text: error.to_string() });
                }
            }
        }
        Ok(())
    }

    fn split_anew(&mut self) -> Result<(), PageError> {
        if let Some(split) = self.split.take() {
            self.split = Some(split.reopened(&self.device, &self.studio)?);
        }
        Ok(())
    }

    fn draw(&mut self, moving: bool) -> Result<(), PageError> {
        let divisor = self.pace.divisor(moving);
        let size = self.size.map(|side| (side / divisor).max(1));
        // What cannot be drawn is not tried again before something changes.
        self.stale = false;
        self.studio.submit(size[0], size[1])?;
        self.canvas.show(&self.device.gpu, self.studio.renderer(), self.size)?;
        if let Some(split) = &mut self.split {
            split.draw(&self.device.gpu, &self.studio, (size, self.size))?;
        }
        self.frames.submitted(&self.device.gpu, self.now, size, divisor);
        Ok(())
    }

    fn full_frame(
        &mut self,
        [width, height]: [u32; 2],
    ) -> Result<impl Future<Output = Result<gnomon_picture::RgbImage, PageError>> + use<>, PageError> {
        self.detail.restore(&mut self.studio)?;
        self.stale = true;
        let frame = self.studio.frame_async(width, height);
        Ok(async move { Ok(frame.await?.radiance) })
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

fn file_name(path: &std::path::Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn scene_name(source: &SceneSource) -> String {
    match source {
        SceneSource::Files(files) => {
            let name = file_name(files.path());
            let stem = name.strip_suffix(".toml").filter(|stem| gnomon_scene::builtin::NAMES.contains(stem));
            stem.map_or(name.clone(), str::to_owned)
        }
        source => source.to_string(),
    }
}

fn environment_name(look: &Look) -> String {
    match &look.map {
        None => "none".to_owned(),
        Some(EnvironmentSource::Builtin(name)) => name.clone(),
        Some(EnvironmentSource::File(path)) => file_name(path),
    }
}
