//! Times of passes: which clock tells them, and those of frames that nobody waits for.

use std::pin::Pin;
use std::task::{Context, Poll, Waker};

use gnomon_scene::Camera;

use super::Renderer;
use super::bands::Band;
use crate::RenderError;
use crate::recorder::{Clock, FrameTimings, PassTiming};

/// Frames whose times are on their way. Where nobody asks for them, later frames are not timed.
const MOST_IN_FLIGHT: usize = 8;

/// Times of a frame that was submitted some frames ago.
#[derive(Clone, Debug)]
pub struct TimedFrame {
    /// Its number, as [`Renderer::submit`] gave it.
    pub number: u64,
    /// Times of its passes.
    pub passes: Vec<PassTiming>,
}

type Times = Pin<Box<dyn Future<Output = Result<Vec<PassTiming>, RenderError>> + Send>>;

/// Submitted frames, and the times that are still to come.
#[derive(Default)]
pub(super) struct FramesInFlight {
    submitted: u64,
    times: Vec<(u64, Times)>,
}

impl FramesInFlight {
    /// Takes in another frame, and gives its number.
    pub fn add(&mut self, timings: Option<FrameTimings>) -> u64 {
        self.submitted += 1;
        if let Some(timings) = timings {
            self.times.push((self.submitted, Box::pin(timings.passes())));
        }
        self.submitted
    }

    /// Whether the times of another frame are kept.
    pub fn has_room(&self) -> bool {
        self.times.len() < MOST_IN_FLIGHT
    }
}

impl Renderer {
    /// The times of frames that have come since this was asked last, in the order of their [`Renderer::submit`]. They come some frames
    /// late: asking waits for nothing.
    ///
    /// # Errors
    /// The device failed.
    pub fn take_times(&mut self) -> Result<Vec<TimedFrame>, RenderError> {
        // Browsers poll by themselves.
        #[cfg(not(target_arch = "wasm32"))]
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        let mut context = Context::from_waker(Waker::noop());
        let mut come = Vec::new();
        let mut result = Ok(());
        self.in_flight.times.retain_mut(|(number, times)| match times.as_mut().poll(&mut context) {
            Poll::Pending => true,
            Poll::Ready(Ok(passes)) => {
                come.push(TimedFrame { number: *number, passes });
                false
            }
            Poll::Ready(Err(error)) => {
                result = Err(error);
                false
            }
        });
        result.map(|()| come)
    }

    /// Whether frames are timed by the GPU's own stamps, so that nothing waits for them.
    pub fn times_come_late(&self) -> bool {
        self.settings().measure.profile && self.gpu.stamps_are_true.get() == Some(&true)
    }

    /// What times the passes of a frame, after [`Renderer::judge_clocks`].
    pub(super) fn clock(&self) -> Clock {
        match self.gpu.stamps_are_true.get() {
            _ if !self.settings().measure.profile => Clock::Off,
            Some(true) => Clock::stamps(&self.gpu),
            #[cfg(not(target_arch = "wasm32"))]
            _ => Clock::wall(),
            #[cfg(target_arch = "wasm32")]
            _ => Clock::Off,
        }
    }

    /// Finds out, once for a device and only where times are wanted, whether its time stamps are true.
    pub(super) fn judge_clocks(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        band: &Band,
    ) -> Result<(), RenderError> {
        if !self.settings().measure.profile || self.gpu.stamps_are_true.get().is_some() {
            return Ok(());
        }
        let has_stamps = self.gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let are_true = has_stamps && self.stamps_agree_with_the_wall_clock(camera, size, band)?;
        let _ = self.gpu.stamps_are_true.set(are_true);
        Ok(())
    }

    /// There is no waiting in a browser, and its stamps are its own.
    #[cfg(target_arch = "wasm32")]
    fn stamps_agree_with_the_wall_clock(
        &mut self,
        _: &Camera,
        _: [u32; 2],
        _: &Band,
    ) -> Result<bool, RenderError> {
        Ok(true)
    }

    /// Draws a few frames by both clocks.
    #[cfg(not(target_arch = "wasm32"))]
    fn stamps_agree_with_the_wall_clock(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        band: &Band,
    ) -> Result<bool, RenderError> {
        let mut agreeing = 0;
        for _ in 0..FRAMES_TO_JUDGE {
            self.gpu.wait()?;
            let mut encoder = crate::recorder::new_encoder(&self.gpu);
            let clock = Clock::stamps(&self.gpu);
            let timings = self.record_band(&mut encoder, camera, size, band, clock)?;
            let began = std::time::Instant::now();
            self.gpu.queue.submit([encoder.finish()]);
            self.gpu.wait()?;
            let wall_ms = began.elapsed().as_secs_f64() * 1e3;
            let stamps_ms = self.gpu.wait_for(timings.passes())?.iter().map(|pass| pass.milliseconds).sum();
            agreeing += usize::from(agree(stamps_ms, wall_ms));
        }
        Ok(2 * agreeing > FRAMES_TO_JUDGE)
    }
}

/// Frames that are drawn by both clocks.
#[cfg(not(target_arch = "wasm32"))]
const FRAMES_TO_JUDGE: usize = 3;
/// What submission and waiting may take beside the passes [ms].
#[cfg(not(target_arch = "wasm32"))]
const OVERHEAD_MS: f64 = 1.0;

/// Whether the passes of a frame can take so long by their stamps, of all the time from submission until the device was idle.
#[cfg(not(target_arch = "wasm32"))]
fn agree(stamps_ms: f64, wall_ms: f64) -> bool {
    (0.5 * wall_ms - OVERHEAD_MS..=1.1 * wall_ms + 0.1 * OVERHEAD_MS).contains(&stamps_ms)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_that_tell_next_to_nothing_or_too_much_are_not_believed() {
        // Mesa 22's software rasteriser.
        assert!(!agree(0.02, 231.0));
        assert!(!agree(400.0, 231.0));
        assert!(agree(228.0, 231.0) && agree(150.0, 231.0));
        // A frame so short that waiting for it takes longer.
        assert!(agree(0.1, 0.6));
    }
}
