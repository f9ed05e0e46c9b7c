//! What a page is told: what goes on, pictures, and what it may save.

use gnomon_picture::RgbImage;
use gnomon_picture::ldr::encode_png;
use gnomon_picture::tonemap::tone_mapped;
use gnomon_renderer::PassTiming;
use gnomon_scene_files::EnvironmentSource;
use gnomon_studio::{CameraLook, Look, SceneSource};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::Session;
use crate::error::PageError;
use crate::panel;
use crate::tracer::rgba;

#[derive(Serialize)]
pub(super) struct Notice {
    pub is_error: bool,
    pub text: String,
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

#[wasm_bindgen]
impl Session {
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
    fn full_frame(
        &mut self,
        [width, height]: [u32; 2],
    ) -> Result<impl Future<Output = Result<RgbImage, PageError>> + use<>, PageError> {
        self.detail.restore(&mut self.studio)?;
        self.stale = true;
        let frame = self.studio.frame_async(width, height);
        Ok(async move { Ok(frame.await?.radiance) })
    }
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
