use std::time::Instant;

use serde::Serialize;

use crate::{Gpu, RenderError};

/// Time that one pass of a frame took.
#[derive(Clone, Debug, Serialize)]
pub struct PassTiming {
    /// Name of the pass.
    pub name: &'static str,
    /// Wall-clock milliseconds from submission until the device was idle.
    pub milliseconds: f64,
}

/// Records the passes of one frame. When it profiles, it submits each pass alone and waits for it: slower than one
/// submission, but true on every driver, where timestamp queries are not.
pub(crate) struct Recorder<'a> {
    pub gpu: &'a Gpu,
    pub encoder: wgpu::CommandEncoder,
    profile: bool,
    started: Instant,
    timings: Vec<PassTiming>,
}

impl<'a> Recorder<'a> {
    pub fn new(gpu: &'a Gpu, profile: bool) -> Self {
        Self { gpu, encoder: new_encoder(gpu), profile, started: Instant::now(), timings: Vec::new() }
    }

    /// Ends the pass called `name`: everything recorded since the last call. Times of passes with one name add up.
    pub fn end_pass(&mut self, name: &'static str) -> Result<(), RenderError> {
        if self.profile {
            self.submit()?;
            self.gpu.wait()?;
            let milliseconds = self.started.elapsed().as_secs_f64() * 1e3;
            match self.timings.iter_mut().find(|timing| timing.name == name) {
                Some(timing) => timing.milliseconds += milliseconds,
                None => self.timings.push(PassTiming { name, milliseconds }),
            }
            self.started = Instant::now();
        }
        Ok(())
    }

    /// Submits what is left and gives the timings, empty unless profiling.
    pub fn finish(mut self) -> Result<Vec<PassTiming>, RenderError> {
        self.submit()?;
        Ok(self.timings)
    }

    fn submit(&mut self) -> Result<(), RenderError> {
        let encoder = std::mem::replace(&mut self.encoder, new_encoder(self.gpu));
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.check()
    }
}

fn new_encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") })
}
