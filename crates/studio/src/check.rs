//! How far a picture is from ray-traced truth, told by a few of its pixels.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use gnomon_envmap::Grade;
use gnomon_lights::LightSet;
use gnomon_metrics::{PixelSample, SampledError};
use gnomon_picture::RgbImage;
use gnomon_reference::{ReferenceOptions, trace_pixels};
use gnomon_renderer::{Frame, RenderError};
use gnomon_scene::{Camera, Scene};

use crate::{Executor, Look, Stage, StudioError, Surroundings};

/// Pixels that a single picture is checked by.
pub const CHECKED_PIXELS: usize = 256;

/// Samples of each of the two means of a pixel: with these the tracer's noise adds little to what the choice of pixels leaves open.
const SAMPLES: u32 = 1024;

/// Of places and samples: another than that of a reference by default, whose noise is thus independent.
const SEED: u64 = 0x636865636b;

impl Stage {
    /// How far a picture of this stage is from ray-traced truth: an estimate of its relative root mean square error, background included, by so many
    /// of its pixels, which are traced on all cores. The same picture gives the same number.
    ///
    /// # Errors
    /// [`StudioError::Metrics`] for a picture with NaN or without pixels, [`StudioError::Reference`].
    pub fn check(&self, radiance: &RgbImage, pixels: usize) -> Result<SampledError, StudioError> {
        Truth::of(self)?.check(radiance, pixels, None)
    }

    /// The same, given up once `cancel` is set.
    ///
    /// # Errors
    /// As [`Stage::check`], and [`gnomon_reference::ReferenceError::Cancelled`].
    pub fn check_until(
        &self,
        radiance: &RgbImage,
        pixels: usize,
        cancel: &AtomicBool,
    ) -> Result<SampledError, StudioError> {
        Truth::of(self)?.check(radiance, pixels, Some(cancel))
    }
}

/// What the truth of a picture depends on.
struct Truth {
    scene: Arc<Scene>,
    camera: Camera,
    surroundings: Surroundings,
    grade: Grade,
    background: bool,
    reflections: bool,
}

impl Truth {
    fn of(stage: &Stage) -> Result<Self, StudioError> {
        let (scene, camera) = stage.for_reference()?;
        let background = stage.look().shows_environment();
        let (surroundings, grade) = (stage.surroundings().clone(), stage.grade());
        Ok(Self { scene, camera, surroundings, grade, background, reflections: stage.reflects_scene() })
    }

    fn check(
        &self,
        radiance: &RgbImage,
        pixels: usize,
        cancel: Option<&AtomicBool>,
    ) -> Result<SampledError, StudioError> {
        let sample = PixelSample::of(radiance, pixels, SEED)?;
        let options = ReferenceOptions {
            width: radiance.width(),
            height: radiance.height(),
            samples_per_pixel: SAMPLES,
            background: self.background,
            reflections: self.reflections,
            seed: SEED,
            progress: None,
            cancel,
        };
        let sky = self.surroundings.sky(self.grade);
        let traced = trace_pixels(&self.scene, &self.camera, sky, &options, &sample.places())?;
        Ok(sample.error(&traced))
    }
}

/// What a picture depends on.
pub(crate) struct Shown {
    pub look: Look,
    pub scene: Arc<Scene>,
    pub surroundings: Surroundings,
    pub lights: Arc<LightSet>,
    pub size: [u32; 2],
}

impl Shown {
    fn is(&self, other: &Self) -> bool {
        // The session replaces what somebody else holds rather than changing it.
        Arc::ptr_eq(&self.scene, &other.scene)
            && self.surroundings.is(&other.surroundings)
            && Arc::ptr_eq(&self.lights, &other.lights)
            && (&self.look, self.size) == (&other.look, other.size)
    }
}

/// What the task has come to: nothing before it ends.
type Answer = Arc<Mutex<Option<Result<SampledError, StudioError>>>>;

/// A picture that is being checked in the background. Dropped, it stops.
pub(crate) struct Checking {
    shown: Shown,
    answer: Answer,
    cancel: Arc<AtomicBool>,
}

impl Drop for Checking {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Checking {
    /// Whether it is of a picture that depends on the same.
    pub fn is_of(&self, shown: &Shown) -> bool {
        self.shown.is(shown)
    }

    /// Starts with a frame that has been submitted.
    pub fn start(
        shown: Shown,
        stage: &Stage,
        frame: impl Future<Output = Result<Frame, RenderError>> + Send + 'static,
        executor: &dyn Executor,
    ) -> Result<Self, StudioError> {
        let truth = Truth::of(stage)?;
        let (answer, cancel) = (Answer::default(), Arc::new(AtomicBool::new(false)));
        let (task_answer, cancelled) = (Arc::clone(&answer), Arc::clone(&cancel));
        let task = async move {
            let checked = async {
                let frame = frame.await?;
                truth.check(&frame.radiance, CHECKED_PIXELS, Some(&cancelled))
            };
            let checked = checked.await;
            *task_answer.lock().unwrap_or_else(PoisonError::into_inner) = Some(checked);
        };
        executor.spawn("check", Box::pin(task));
        Ok(Self { shown, answer, cancel })
    }

    /// What it has found, `None` before that. An error is told once.
    pub fn found(&self) -> Result<Option<SampledError>, StudioError> {
        let mut answer = self.answer.lock().unwrap_or_else(PoisonError::into_inner);
        match answer.take() {
            Some(Ok(error)) => {
                *answer = Some(Ok(error));
                Ok(Some(error))
            }
            Some(Err(error)) => Err(error),
            None => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use gnomon_envmap::Equirect;
    use gnomon_options::Given;
    use gnomon_reference::ReferenceError;

    use super::*;
    use crate::{Project, Slices, environment_named};

    #[test]
    fn a_check_that_nobody_waits_for_is_given_up() {
        let mut project = Project::open("three-boxes", Look::default(), &Given::default()).unwrap();
        project.look.set_environment(environment_named("room"));
        let stage = Stage::new(project).unwrap();
        let executor = Slices::default();
        let start = || {
            let shown = Shown {
                look: stage.look().clone(),
                scene: Arc::clone(stage.scene()),
                surroundings: stage.surroundings().clone(),
                lights: Arc::new(LightSet::new("none", Vec::new(), Equirect::clone(stage.environment()))),
                size: [16, 12],
            };
            let radiance = RgbImage::filled(16, 12, glam::Vec3::ONE);
            let frame = Frame { radiance, alpha: Vec::new(), display: Vec::new(), timings: Vec::new() };
            Checking::start(shown, &stage, std::future::ready(Ok(frame)), &executor).unwrap()
        };
        let kept = start();
        assert!(matches!(kept.found(), Ok(None)));
        assert!(!executor.run_slices());
        let error = kept.found().unwrap().unwrap();
        assert!(error.relative_rmse > 0.1, "a white picture is right: {error}");
        assert_eq!(kept.found().unwrap(), Some(error), "it is still known");

        let dropped = start();
        let answer = Arc::clone(&dropped.answer);
        drop(dropped);
        assert!(!executor.run_slices());
        let answer = answer.lock().unwrap().take();
        assert!(matches!(answer, Some(Err(StudioError::Reference(ReferenceError::Cancelled)))), "{answer:?}");
    }
}
