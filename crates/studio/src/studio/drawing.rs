//! Frames of a session, their times, and the frame rate that they hold.

use gnomon_renderer::Frame;
#[cfg(not(target_arch = "wasm32"))]
use gnomon_renderer::PassTiming;
use gnomon_renderer::layers::{LayerRequest, RenderedLayers};
use gnomon_renderer::lod::LevelOfDetail;

use super::{Studio, Update};
use crate::StudioError;
use crate::frame_rate::{DrawnFrame, FrameRate};

impl Studio {
    /// Draws a frame of so many pixels and reads it back, see [`gnomon_renderer::Renderer::render_async`].
    ///
    /// # Errors
    /// As there, and as [`Studio::camera`].
    pub fn frame_async(
        &mut self,
        width: u32,
        height: u32,
    ) -> impl Future<Output = Result<Frame, StudioError>> + Send + use<> {
        let frame = self.camera().map(|camera| self.renderer.render_async(&camera, width, height));
        async move { Ok(frame?.await?) }
    }

    /// The same, waited for.
    ///
    /// # Errors
    /// As [`Studio::frame_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn frame(&mut self, width: u32, height: u32) -> Result<Frame, StudioError> {
        Ok(self.renderer.render(&self.stage.camera()?, width, height)?)
    }

    /// Draws a frame with layers, see [`gnomon_renderer::Renderer::render_layers_async`].
    ///
    /// # Errors
    /// As there, and as [`Studio::camera`].
    pub fn frame_layers_async<R: Into<LayerRequest>>(
        &mut self,
        width: u32,
        height: u32,
        layers: R,
    ) -> impl Future<Output = Result<(Frame, RenderedLayers), StudioError>> + Send + use<R> {
        let camera = self.camera();
        let frame = camera.map(|camera| self.renderer.render_layers_async(&camera, width, height, layers));
        async move { Ok(frame?.await?) }
    }

    /// The same, waited for.
    ///
    /// # Errors
    /// As [`Studio::frame_layers_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn frame_layers(
        &mut self,
        width: u32,
        height: u32,
        layers: impl Into<LayerRequest>,
    ) -> Result<(Frame, RenderedLayers), StudioError> {
        Ok(self.renderer.render_layers(&self.stage.camera()?, width, height, layers)?)
    }

    /// Takes the look for that of the frame before, see [`gnomon_renderer::Renderer::remember_for_motion`].
    ///
    /// # Errors
    /// As there, and as [`Studio::camera`].
    pub fn remember_for_motion(&mut self) -> Result<(), StudioError> {
        Ok(self.renderer.remember_for_motion(&self.stage.camera()?)?)
    }

    /// Draws a frame without waiting for it; [`gnomon_renderer::Renderer::display_view`] shows it.
    ///
    /// # Errors
    /// As [`gnomon_renderer::Renderer::submit`].
    pub fn submit(&mut self, width: u32, height: u32) -> Result<(), StudioError> {
        let number = self.renderer.submit(&self.stage.camera()?, width, height)?;
        if self.times_passes() {
            let (level, is_debug_view) = (self.level_of_detail(), self.renderer.shows_debug_view());
            let frame = DrawnFrame { level, size: [width, height], is_debug_view, passes: Vec::new() };
            self.in_flight.add(number, frame);
        }
        Ok(())
    }

    /// Draws a frame without reading it back, and waits until the device is idle: what a benchmark times.
    ///
    /// # Errors
    /// As [`gnomon_renderer::Renderer::draw`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn draw(&mut self, width: u32, height: u32) -> Result<Vec<PassTiming>, StudioError> {
        Ok(self.renderer.draw(&self.stage.camera()?, width, height)?)
    }

    /// Whether passes are timed from the next frame on, see [`gnomon_renderer::MeasureSettings::profile`].
    pub fn set_profile(&mut self, profile: bool) {
        self.profile = profile;
        self.renderer.set_profile(self.times_passes());
    }

    pub(super) fn times_passes(&self) -> bool {
        self.profile || self.frame_rate.is_some()
    }

    /// Holds a frame rate from now on, or no longer: [`Studio::poll`] then changes lights, maps and shadow sampling of the look as the
    /// times of submitted frames come.
    ///
    /// # Errors
    /// As [`Studio::set_look`], for the level of detail that the frame rate begins with.
    pub fn hold_frame_rate(&mut self, frame_rate: Option<FrameRate>) -> Result<(), StudioError> {
        if let Some(frame_rate) = &frame_rate {
            self.set_level_of_detail(frame_rate.first())?;
        }
        self.frame_rate = frame_rate;
        self.renderer.set_profile(self.times_passes());
        Ok(())
    }

    /// The frame rate that is held, and what has become of it.
    pub fn frame_rate(&self) -> Option<&FrameRate> {
        self.frame_rate.as_ref()
    }

    /// Frames whose times [`Studio::poll`] has found since this was asked last, where passes are timed.
    pub fn take_times(&mut self) -> Vec<DrawnFrame> {
        std::mem::take(&mut self.timed)
    }

    /// Takes the times in that have come, and lets the frame rate follow them.
    pub(super) fn follow_times(&mut self) -> Option<Update> {
        let come = match self.renderer.take_times() {
            Ok(come) => come,
            Err(error) => return Some(Update::Failed(error.into())),
        };
        let mut next = None;
        for timed in come {
            let Some(drawn) = self.in_flight.take(timed) else { continue };
            // Times of lights that are on their way out say nothing of those that are asked for.
            let counts = !drawn.is_debug_view && !self.is_busy();
            let asked_for = self.asked_for();
            if let Some(frame_rate) = self.frame_rate.as_mut().filter(|_| counts) {
                next = frame_rate.follow(&drawn, asked_for);
            }
            self.timed.push(drawn);
        }
        match self.set_level_of_detail(next?) {
            Ok(()) => Some(Update::LevelOfDetail),
            Err(error) => Some(Update::Failed(error)),
        }
    }

    /// What the next frame is drawn with.
    fn level_of_detail(&self) -> LevelOfDetail {
        LevelOfDetail { lights: self.lights.lights.len() as u32, ..self.asked_for() }
    }

    /// What the look asks for.
    fn asked_for(&self) -> LevelOfDetail {
        let look = self.look();
        let lights = look.fit.light_count.unwrap_or(self.lights.lights.len());
        LevelOfDetail::of(&look.techniques, lights as u32)
    }

    fn set_level_of_detail(&mut self, level: LevelOfDetail) -> Result<(), StudioError> {
        let asked_for = self.asked_for();
        self.edit(|look| {
            // A number of lights that stays needs no other fit.
            if level.lights != asked_for.lights {
                // A threshold would decide it.
                (look.fit.light_count, look.fit.threshold) = (Some(level.lights as usize), None);
            }
            level.set(&mut look.techniques);
        })
    }
}
