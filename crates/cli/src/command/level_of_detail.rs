use clap::Args;
use gnomon::lights::{FitOptions, LightSet, fit};
use gnomon::renderer::lod::{FrameTimes, LevelOfDetail, LodController, LodRange, LodState};
use gnomon::renderer::{Gpu, GpuOptions, Renderer};
use gnomon::studio::{Look, Stage};
use serde_json::{Value, json};

use crate::error::CliError;
use crate::options::positive;

/// How long a frame may take.
#[derive(Args, Clone, Copy, Debug)]
pub struct LevelOfDetailArgs {
    /// Frames a second to hold: chooses lights, shadow maps and shadow sampling from measured times, with at most the detail that
    /// --light-count (200 where not given), --shadow-resolution and --shadow-sampling ask for
    #[arg(long, value_name = "FPS", conflicts_with_all = ["budget_ms", "threshold", "frames", "duration"], value_parser = positive)]
    target_fps: Option<f32>,

    /// The same, as milliseconds a frame
    #[arg(long, value_name = "MS", conflicts_with_all = ["threshold", "frames", "duration"], value_parser = positive)]
    budget_ms: Option<f32>,
}

impl LevelOfDetailArgs {
    /// Milliseconds that a frame may take, where any are given.
    pub fn budget_ms(&self) -> Option<f64> {
        self.budget_ms.map(f64::from).or(self.target_fps.map(|fps| 1000.0 / f64::from(fps)))
    }
}

/// Frames without a change after which a choice stands, and frames after which it does anyway.
const STEADY_FRAMES: usize = 20;
const MOST_FRAMES: usize = 200;

/// What a controller chose, and how it came to it.
pub struct Settled {
    /// The settings.
    level: LevelOfDetail,
    budget_ms: f64,
    state: LodState,
    frames: Vec<(LevelOfDetail, f64)>,
}

/// Draws frames until the settings no longer change.
///
/// # Errors
/// No adapter, a fit without lights, a scene beyond the adapter's limits.
pub fn settle(budget_ms: f64, gpu_options: &GpuOptions, stage: &Stage) -> Result<Settled, CliError> {
    let look = stage.look();
    let (method, options) = (&look.fit.method, stage.fit_options()?);
    // A threshold of the scene file would decide the number of lights.
    let options = FitOptions { threshold: None, ..options };
    let settings = look.settings(stage.exposure());
    let ([width, height], camera) = (look.picture.size, stage.camera()?);
    if method == "none" {
        return Err(CliError::usage(
            "a frame rate is held by the number of lights: choose some with --lights",
        ));
    }
    options.validate()?;
    let widest = LodRange::default();
    let best = LevelOfDetail {
        lights: options.light_count.map_or(widest.best.lights, |count| count as u32),
        shadow_resolution: settings.techniques.shadow_resolution,
        shadow_sampling: settings.techniques.shadow_sampling,
    };
    let least = LevelOfDetail {
        lights: widest.least.lights.min(best.lights),
        shadow_resolution: widest.least.shadow_resolution.min(best.shadow_resolution),
        shadow_sampling: widest.least.shadow_sampling.max(best.shadow_sampling),
    };
    let mut controller = LodController::new(budget_ms, LodRange { least, best })?;
    let fitted = |level: LevelOfDetail| -> Result<LightSet, CliError> {
        let options = FitOptions { light_count: Some(level.lights as usize), ..options };
        Ok(fit::by_name(method, &options)?.fit(stage.environment())?)
    };
    let mut level = controller.level();
    let mut lights = fitted(level)?;
    let gpu = Gpu::new(gpu_options)?;
    let mut renderer = Renderer::new(&gpu, settings.with(|s| s.measure.profile = true))?;
    renderer.set_scene(stage.scene())?;
    renderer.set_environment_rotation(stage.world_from_environment())?;
    renderer.set_lighting(stage.environment(), &lights)?;
    renderer.set_level_of_detail(level, &lights)?;
    let (mut frames, mut steady) = (Vec::new(), 0);
    while steady < STEADY_FRAMES && frames.len() < MOST_FRAMES {
        let times = FrameTimes::from_passes(&renderer.draw(&camera, width, height)?);
        frames.push((level, times.total()));
        let next = controller.next(level, &times);
        let is_steady = next == level && controller.state() != LodState::Settling;
        steady = if is_steady { steady + 1 } else { 0 };
        if next.lights != level.lights {
            lights = fitted(next)?;
        }
        if next != level {
            renderer.set_level_of_detail(next, &lights)?;
        }
        level = next;
    }
    Ok(Settled { level, budget_ms, state: controller.state(), frames })
}

impl Settled {
    /// A look with these settings.
    pub fn look(&self, look: &Look) -> Look {
        let mut look = look.clone();
        look.fit.light_count = Some(self.level.lights as usize);
        look.fit.threshold = None;
        look.techniques.shadow_resolution = self.level.shadow_resolution;
        look.techniques.shadow_sampling = self.level.shadow_sampling;
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
        let last = self.frames.iter().rev().take_while(|(level, _)| *level == self.level);
        super::render::median(last.take(STEADY_FRAMES).map(|(_, milliseconds)| *milliseconds).collect())
    }

    /// Everything, for the statistics.
    pub fn document(&self) -> Value {
        let frames = self.frames.iter().map(|(level, milliseconds)| {
            json!({
                "lights": level.lights, "shadow_resolution": level.shadow_resolution,
                "shadow_sampling": level.shadow_sampling, "milliseconds": milliseconds,
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
