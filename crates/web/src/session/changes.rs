//! What a page changes: options, the view, the canvas.

use gnomon_scene::Orbit;
use gnomon_studio::CameraLook;
use wasm_bindgen::prelude::*;
use web_sys::OffscreenCanvas;

use super::Session;
use crate::detail::Detail;
use crate::error::PageError;
use crate::panel;
use crate::split::Split;

#[wasm_bindgen]
impl Session {
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
}

impl Session {
    fn move_view(&mut self, change: impl FnOnce(&mut Orbit)) -> Result<(), PageError> {
        let Some(orbit) = &mut self.orbit else { return Ok(()) };
        change(orbit);
        let camera = orbit.camera();
        self.moved = self.now;
        self.edit(|look| look.camera = CameraLook::Free(camera))
    }
}
