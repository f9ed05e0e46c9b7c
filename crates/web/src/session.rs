//! The session, as a worker of the page holds it.

use std::sync::Arc;

use gnomon_renderer::{PassTiming, RenderError};
use gnomon_scene::Orbit;
use gnomon_studio::{Look, Pace, Studio, Update};
use wasm_bindgen::prelude::*;

use crate::canvas::{Canvas, Device};
use crate::detail::Detail;
use crate::error::PageError;
use crate::files::Files;
use crate::frames::Frames;
use crate::split::Split;

mod changes;
mod opening;
mod told;

pub use opening::FileSet;
use told::Notice;

/// After the last movement the picture is still taken to be moving for so long [ms].
const SETTLES_AFTER: f64 = 400.0;

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

    /// Whether the device was lost: a page at rest is told so by nothing else.
    #[wasm_bindgen(js_name = deviceIsLost)]
    pub fn device_is_lost(&self) -> bool {
        matches!(self.device.gpu.check(), Err(RenderError::DeviceLost { .. }))
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
}

impl Session {
    fn is_moving(&self) -> bool {
        self.playing || self.now - self.moved < SETTLES_AFTER
    }

    fn edit(&mut self, change: impl FnOnce(&mut Look)) -> Result<(), PageError> {
        self.detail.edit(&mut self.studio, change)?;
        self.stale = true;
        Ok(())
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
}
