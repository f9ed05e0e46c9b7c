use serde::Serialize;

use crate::gpu::ReadBack;
use crate::{Gpu, RenderError};

/// Time that one pass of a frame took.
#[derive(Clone, Debug, Serialize)]
pub struct PassTiming {
    /// Name of the pass.
    pub name: &'static str,
    /// By the GPU's time stamps; where these are not to be had or not true, by the wall clock from submission until the device was idle.
    pub milliseconds: f64,
}

/// Adds times to those of the passes with the same names.
pub(crate) fn add_times(sums: &mut Vec<PassTiming>, times: impl IntoIterator<Item = PassTiming>) {
    for PassTiming { name, milliseconds } in times {
        match sums.iter_mut().find(|sum| sum.name == name) {
            Some(sum) => sum.milliseconds += milliseconds,
            None => sums.push(PassTiming { name, milliseconds }),
        }
    }
}

/// How passes are timed.
pub(crate) enum Clock {
    /// They are not.
    Off,
    /// By stamps between them, which are read back later.
    Stamps(Stamps),
    /// Each is submitted alone and waited for: slow, but true on every driver.
    #[cfg(not(target_arch = "wasm32"))]
    Wall { pass_began: std::time::Instant, times: Vec<PassTiming> },
}

impl Clock {
    pub fn stamps(gpu: &Gpu) -> Self {
        Self::Stamps(Stamps::new(gpu))
    }

    #[cfg(not(target_arch = "wasm32"))]
    pub fn wall() -> Self {
        Self::Wall { pass_began: std::time::Instant::now(), times: Vec::new() }
    }
}

/// Records the passes of one frame.
pub(crate) struct Recorder<'a> {
    pub gpu: &'a Gpu,
    pub encoder: &'a mut wgpu::CommandEncoder,
    clock: Clock,
}

impl<'a> Recorder<'a> {
    pub fn new(gpu: &'a Gpu, encoder: &'a mut wgpu::CommandEncoder, mut clock: Clock) -> Self {
        if let Clock::Stamps(stamps) = &mut clock {
            stamps.write(encoder, "");
        }
        Self { gpu, encoder, clock }
    }

    /// Ends the pass called `name`: everything recorded since the last call. Times of passes with one name add up.
    ///
    /// # Errors
    /// The device failed, where it is waited for.
    pub fn end_pass(&mut self, name: &'static str) -> Result<(), RenderError> {
        match &mut self.clock {
            Clock::Off => {}
            Clock::Stamps(stamps) => stamps.write(self.encoder, name),
            #[cfg(not(target_arch = "wasm32"))]
            Clock::Wall { pass_began, times } => {
                submit(self.gpu, self.encoder);
                self.gpu.wait()?;
                let milliseconds = pass_began.elapsed().as_secs_f64() * 1e3;
                add_times(times, [PassTiming { name, milliseconds }]);
                *pass_began = std::time::Instant::now();
            }
        }
        Ok(())
    }

    /// Submits what is recorded so far: what is written from now on is for what follows.
    pub fn submit(&mut self) {
        submit(self.gpu, self.encoder);
    }

    /// What was timed.
    pub fn finish(self) -> FrameTimings {
        match self.clock {
            Clock::Off => FrameTimings::Known(Vec::new()),
            Clock::Stamps(stamps) => stamps.read_back(self.gpu, self.encoder),
            #[cfg(not(target_arch = "wasm32"))]
            Clock::Wall { times, .. } => FrameTimings::Known(times),
        }
    }
}

fn submit(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
    let recorded = std::mem::replace(encoder, new_encoder(gpu));
    gpu.queue.submit([recorded.finish()]);
}

pub(crate) fn new_encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") })
}

/// Most stamps of a frame. Where it has more passes the last ones count as one.
const MOST_STAMPS: u32 = 1024;

/// Time stamps between the passes of a frame.
pub(crate) struct Stamps {
    queries: wgpu::QuerySet,
    /// Of the pass before each stamp; none before the first.
    names: Vec<&'static str>,
}

impl Stamps {
    /// For a device with `TIMESTAMP_QUERY`.
    fn new(gpu: &Gpu) -> Self {
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("pass times"),
            ty: wgpu::QueryType::Timestamp,
            count: MOST_STAMPS,
        });
        Self { queries, names: Vec::new() }
    }

    /// WebGPU writes stamps only where passes begin and end; an empty one does.
    fn write(&mut self, encoder: &mut wgpu::CommandEncoder, name: &'static str) {
        let index = self.names.len() as u32;
        if index == MOST_STAMPS {
            return;
        }
        self.names.push(name);
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("time stamp"),
            timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                query_set: &self.queries,
                beginning_of_pass_write_index: Some(index),
                end_of_pass_write_index: None,
            }),
        });
    }

    fn read_back(self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) -> FrameTimings {
        let count = self.names.len() as u32;
        let size = u64::from(count) * size_of::<u64>() as u64;
        let resolved = gpu.empty_buffer(
            "pass times",
            size,
            wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
        );
        encoder.resolve_query_set(&self.queries, 0..count, &resolved, 0);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let copy = gpu.empty_buffer("pass times read back", size, usage);
        encoder.copy_buffer_to_buffer(&resolved, 0, &copy, 0, size);
        FrameTimings::Coming(StampsReadBack {
            ticks: ReadBack::of_buffer(gpu, encoder, copy),
            names: self.names,
            nanoseconds_per_tick: f64::from(gpu.queue.get_timestamp_period()),
        })
    }
}

/// Stamps on their way back.
pub(crate) struct StampsReadBack {
    ticks: ReadBack,
    names: Vec<&'static str>,
    nanoseconds_per_tick: f64,
}

/// Times of a frame's passes: some are known only once the GPU has drawn it.
pub(crate) enum FrameTimings {
    Known(Vec<PassTiming>),
    Coming(StampsReadBack),
}

impl FrameTimings {
    pub async fn passes(self) -> Result<Vec<PassTiming>, RenderError> {
        match self {
            Self::Known(times) => Ok(times),
            Self::Coming(stamps) => {
                let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&stamps.ticks.await?);
                Ok(between(&ticks, &stamps.names, stamps.nanoseconds_per_tick))
            }
        }
    }
}

fn between(ticks: &[u64], names: &[&'static str], nanoseconds_per_tick: f64) -> Vec<PassTiming> {
    let pairs = ticks.windows(2).zip(names.iter().skip(1));
    let times = pairs.map(|(pair, &name)| {
        let ticks = pair[1].saturating_sub(pair[0]) as f64;
        PassTiming { name, milliseconds: ticks * nanoseconds_per_tick * 1e-6 }
    });
    let mut sums = Vec::new();
    add_times(&mut sums, times);
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_lie_between_stamps_and_those_of_one_name_add_up() {
        let names = ["", "maps", "light", "maps", "light"];
        let ticks = [10, 20, 50, 60, 59, 0, 0];
        let times: Vec<_> = between(&ticks, &names, 1e6).iter().map(|t| (t.name, t.milliseconds)).collect();
        assert_eq!(times, [("maps", 20.0), ("light", 30.0)]);
    }
}
