use clap::Args;
use gnomon::renderer::lod::{LevelOfDetail, LodRange, LodState};
use gnomon::renderer::{Gpu, GpuOptions};
use gnomon::studio::{DrawnFrame, FrameRate, Look, Stage, Studio, Update};
use serde_json::{Value, json};

use crate::error::CliError;
use crate::options::positive;

/// How long a frame may take.
#[derive(Args, Clone, Copy, Debug)]
pub struct LevelOfDetailArgs {
    /// Frames a second to hold: chooses lights, shadow maps and shadow sampling from measured times, with at most the detail that
    /// --light-count (200 where not given), --shadow-resolution and --shadow-sampling ask for
    #[arg(long, value_name = "FPS", conflicts_with_all = ["budget_ms", "threshold", "frames", "duration"], allow_negative_numbers = true, value_parser = positive)]
    target_fps: Option<f32>,

    /// The same, as milliseconds a frame
    #[arg(long, value_name = "MS", conflicts_with_all = ["threshold", "frames", "duration"], allow_negative_numbers = true, value_parser = positive)]
    budget_ms: Option<f32>,
}

impl LevelOfDetailArgs {
    /// Milliseconds that a frame may take, where any are given.
    pub fn budget_ms(&self) -> Option<f64> {
        self.budget_ms.map(f64::from).or(self.target_fps.map(|fps| 1000.0 / f64::from(fps)))
    }
}

/// Frames after which a choice stands even if it has not settled.
const MOST_FRAMES: usize = 200;
/// Frames whose median is told.
const LAST_FRAMES: usize = 20;

/// What a frame rate came to, and how.
pub struct Settled {
    /// The settings.
    level: LevelOfDetail,
    budget_ms: f64,
    state: LodState,
    frames: Vec<DrawnFrame>,
}

/// Draws frames until the settings no longer change.
///
/// # Errors
/// No adapter, a fit without lights, a scene beyond the adapter's limits.
pub fn settle(budget_ms: f64, gpu_options: &GpuOptions, stage: &Stage) -> Result<Settled, CliError> {
    let look = stage.look();
    if look.fit.method == "none" {
        return Err(CliError::usage(
            "a frame rate is held by the number of lights: choose some with --lights",
        ));
    }
    let lights = look.fit.light_count.map_or(LodRange::default().best.lights, |count| count as u32);
    let best = LevelOfDetail::of(&look.techniques, lights);
    let frame_rate = FrameRate::new(budget_ms, LodRange::up_to(best))?;
    let [width, height] = look.picture.size;
    let mut studio = Studio::new(&Gpu::new(gpu_options)?, stage.clone())?;
    studio.hold_frame_rate(Some(frame_rate))?;
    let mut frames: Vec<DrawnFrame> = Vec::new();
    while frames.len() < MOST_FRAMES && !studio.frame_rate().is_some_and(FrameRate::is_steady) {
        let failed = studio.wait().into_iter().find_map(|update| match update {
            Update::Failed(error) => Some(error),
            _ => None,
        });
        failed.map_or(Ok(()), Err)?;
        studio.submit(width, height)?;
        studio.renderer().wait()?;
        studio.poll();
        frames.extend(studio.take_times());
    }
    let state = studio.frame_rate().map_or(LodState::Settling, FrameRate::state);
    let level = frames.last().map_or(best, |frame| frame.level);
    Ok(Settled { level, budget_ms, state, frames })
}

impl Settled {
    /// A look with these settings.
    pub fn look(&self, look: &Look) -> Look {
        let mut look = look.clone();
        look.fit.light_count = Some(self.level.lights as usize);
        look.fit.threshold = None;
        self.level.set(&mut look.techniques);
        look
    }

    /// One line for people: what was chosen and what became of the budget.
    pub fn summary(&self) -> String {
        let LevelOfDetail { lights, shadow_resolution, shadow_sampling } = self.level;
        let found = match self.state {
            LodState::Settling => "not settled",
            LodState::Met => "met",
            LodState::Best => "met with all the detail allowed",
            LodState::BudgetTooLow => "too low even for the least detail",
        };
        let milliseconds = self.milliseconds();
        format!(
            "{lights} lights, shadow maps of {shadow_resolution}, shadow sampling {shadow_sampling}: {milliseconds:.1} ms a frame \
             ({:.1} a second) after {} frames; the budget of {:.1} ms is {found}",
            1000.0 / milliseconds,
            self.frames.len(),
            self.budget_ms,
        )
    }

    /// Median of the last frames [ms].
    fn milliseconds(&self) -> f64 {
        let last = self.frames.iter().rev().take_while(|frame| frame.level == self.level);
        super::render::median(last.take(LAST_FRAMES).map(DrawnFrame::milliseconds).collect())
    }

    /// Everything, for the statistics.
    pub fn document(&self) -> Value {
        let frames = self.frames.iter().map(|frame| {
            let LevelOfDetail { lights, shadow_resolution, shadow_sampling } = frame.level;
            json!({
                "lights": lights, "shadow_resolution": shadow_resolution, "shadow_sampling": shadow_sampling,
                "milliseconds": frame.milliseconds(),
            })
        });
        json!({
            "budget_milliseconds": self.budget_ms,
            "milliseconds": self.milliseconds(),
            "state": format!("{:?}", self.state),
            "frames": frames.collect::<Vec<_>>(),
        })
    }
}
