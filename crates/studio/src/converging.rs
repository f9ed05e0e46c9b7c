//! A reference picture that converges in the background.

use std::convert::Infallible;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use gnomon_envmap::Grade;
use gnomon_metrics::{relative_rmse, signed_difference};
use gnomon_picture::RgbImage;
use gnomon_reference::{Estimate, Progressive, ReferenceError, ReferenceOptions};
use gnomon_scene::{Camera, Scene};

use crate::executor::end_slice;
use crate::{Executor, Stage, StudioError, Surroundings};

/// Samples a pixel of one pass: few, so that the first picture comes soon, and enough to be stratified.
const SAMPLES_PER_PASS: u32 = 4;

/// A reference so far.
#[derive(Clone, Debug)]
pub struct ReferencePicture {
    /// Mean radiance.
    pub mean: Arc<RgbImage>,
    /// Samples that every pixel got.
    pub samples_per_pixel: u32,
    /// Its own noise: the root of the mean variance over the mean. 0 while nothing is known of it, before the second pass.
    pub noise: f64,
}

impl ReferencePicture {
    /// How far a drawn picture is from it: relative root mean square error, noise included.
    ///
    /// # Errors
    /// [`StudioError::Metrics`] for pictures of different sizes or with NaN.
    pub fn relative_rmse(&self, picture: &RgbImage) -> Result<f64, StudioError> {
        Ok(relative_rmse(picture, &self.mean)?)
    }

    /// Where and which way a drawn picture differs: mid grey where equal, lighter where the picture is brighter; a difference of the
    /// reference's mean reaches white or black. To be shown without tone mapping.
    ///
    /// # Errors
    /// As [`ReferencePicture::relative_rmse`].
    pub fn difference(&self, picture: &RgbImage) -> Result<RgbImage, StudioError> {
        let scale = mean(&self.mean).clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX));
        Ok(signed_difference(picture, &self.mean, scale as f32)?)
    }
}

/// What a reference depends on.
#[derive(Clone)]
struct Key {
    scene: Arc<Scene>,
    surroundings: Surroundings,
    rotation: f32,
    grade: Grade,
    background: bool,
    reflections: bool,
    camera: Camera,
    size: [u32; 2],
}

impl Key {
    fn is(&self, other: &Self) -> bool {
        // The stage replaces what somebody else holds rather than changing it.
        Arc::ptr_eq(&self.scene, &other.scene)
            && self.surroundings.is(&other.surroundings)
            && (self.rotation, self.grade, self.size) == (other.rotation, other.grade, other.size)
            && (self.background, self.reflections) == (other.background, other.reflections)
            && self.camera == other.camera
    }
}

/// What the task has come to.
type Progress = Mutex<Result<Option<ReferencePicture>, ReferenceError>>;

/// A reference of a stage that is being traced, no device needed. [`crate::Studio::converge`] keeps one for a session.
pub struct Converging {
    key: Key,
    tracing: Tracing,
}

/// One task at a time: what is set up before the first pass cannot be broken off, and is not worth doing for what has changed since.
enum Tracing {
    /// For the task that traced before, which has been told to end.
    Waits(Running),
    Runs(Passes),
}

/// Held by the task, too, for as long as there is one.
#[derive(Clone)]
struct Running(Arc<()>);

impl Running {
    fn has_ended(&self) -> bool {
        Arc::strong_count(&self.0) == 1
    }
}

/// A task that adds passes until this is dropped.
struct Passes {
    cancel: Arc<AtomicBool>,
    progress: Arc<Progress>,
    running: Running,
}

impl Drop for Passes {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Converging {
    /// Goes on with `before` where it is still of this stage and size in pixels, or starts anew once its task has ended. Passes are added
    /// where `executor` says.
    ///
    /// # Errors
    /// As [`Stage::camera`].
    pub fn follow(
        before: Option<Self>,
        stage: &Stage,
        size: [u32; 2],
        executor: &dyn Executor,
    ) -> Result<Self, StudioError> {
        let key = Key {
            scene: Arc::clone(stage.scene()),
            surroundings: stage.surroundings().clone(),
            rotation: stage.look().environment.rotation,
            grade: stage.grade(),
            background: stage.look().shows_environment(),
            reflections: stage.reflects_scene(),
            camera: stage.camera()?,
            size,
        };
        let last = match before {
            Some(before) if matches!(before.tracing, Tracing::Runs(_)) && before.key.is(&key) => {
                return Ok(before);
            }
            Some(Self { tracing: Tracing::Runs(passes), .. }) => Some(passes.running.clone()),
            Some(Self { tracing: Tracing::Waits(last), .. }) => Some(last),
            None => None,
        };
        let tracing = match last {
            Some(last) if !last.has_ended() => Tracing::Waits(last),
            _ => Tracing::Runs(Passes::start(&key, stage, executor)?),
        };
        Ok(Self { key, tracing })
    }

    /// The picture so far; `None` before its first pass.
    ///
    /// # Errors
    /// [`StudioError::Reference`] for what the tracer refuses: an empty picture, a camera without a lens.
    pub fn picture(&self) -> Result<Option<ReferencePicture>, StudioError> {
        match &self.tracing {
            Tracing::Waits(_) => Ok(None),
            Tracing::Runs(passes) => passes.picture(),
        }
    }
}

impl Passes {
    fn start(key: &Key, stage: &Stage, executor: &dyn Executor) -> Result<Self, StudioError> {
        let (scene, camera) = stage.for_reference()?;
        let (surroundings, grade) = (key.surroundings.clone(), key.grade);
        let [width, height] = key.size;
        let options = ReferenceOptions {
            width,
            height,
            samples_per_pixel: SAMPLES_PER_PASS,
            background: key.background,
            reflections: key.reflections,
            ..ReferenceOptions::default()
        };
        let passes = Self {
            cancel: Arc::new(AtomicBool::new(false)),
            progress: Arc::new(Mutex::new(Ok(None))),
            running: Running(Arc::new(())),
        };
        let (cancelled, told) = (Arc::clone(&passes.cancel), Arc::clone(&passes.progress));
        let running = passes.running.clone();
        let task = async move {
            // Dropped last, after the scene.
            let _running = running;
            let (scene, surroundings) = (scene, surroundings);
            let tell = |progress| *told.lock().unwrap_or_else(PoisonError::into_inner) = progress;
            let traced = async {
                let mut passes = Progressive::new(&scene, &camera, surroundings.sky(grade), &options)?;
                loop {
                    passes.add_pass(&cancelled)?;
                    tell(Ok(Some(picture_of(passes.estimate()))));
                    end_slice().await;
                }
            };
            let ended: Result<Infallible, ReferenceError> = traced.await;
            let Err(error) = ended;
            tell(Err(error));
        };
        executor.spawn("reference", Box::pin(task));
        Ok(passes)
    }

    fn picture(&self) -> Result<Option<ReferencePicture>, StudioError> {
        // Asked first: a task that ends says why before it does.
        let has_ended = self.running.has_ended();
        let picture = self.progress.lock().unwrap_or_else(PoisonError::into_inner).clone()?;
        if has_ended { Err(StudioError::Background("the reference")) } else { Ok(picture) }
    }
}

fn picture_of(estimate: Estimate) -> ReferencePicture {
    let noise = mean(&estimate.variance).max(0.0).sqrt() / mean(&estimate.mean);
    ReferencePicture {
        mean: Arc::new(estimate.mean),
        samples_per_pixel: estimate.samples_per_pixel,
        noise: if noise.is_finite() { noise } else { 0.0 },
    }
}

/// Mean over pixels and channels.
fn mean(picture: &RgbImage) -> f64 {
    let sum: f64 = picture.texels().iter().map(|texel| texel.as_dvec3().element_sum()).sum();
    sum / (3.0 * picture.texels().len().max(1) as f64)
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use gnomon_options::Given;

    use super::*;
    use crate::look::CameraLook;
    use crate::{Look, Project, Slices, Threads, environment_named};

    fn stage() -> Stage {
        let mut project = Project::open("terrain", Look::default(), &Given::default()).unwrap();
        project.look.set_environment(environment_named("room"));
        Stage::new(project).unwrap()
    }

    #[test]
    fn a_look_that_changes_all_the_time_keeps_one_thread_busy() {
        let mut stage = stage();
        let mut traced = None;
        for step in 0..20 {
            let mut look = stage.look().clone();
            look.camera = CameraLook::Free(Camera::look_at(
                glam::Vec3::new(3.0, 2.0, step as f32),
                glam::Vec3::ZERO,
                0.7,
            ));
            stage.set_look(look).unwrap();
            traced = Some(Converging::follow(traced, &stage, [8, 6], &Threads).unwrap());
            // Beside the stage and what is traced, threads hold the scene.
            let threads = Arc::strong_count(stage.scene()) - 2;
            assert!(threads <= 1, "{threads} threads after {step} changes");
        }
        // What was asked for last is traced, once there is a thread for it.
        let deadline = Instant::now() + Duration::from_secs(60);
        while traced.as_ref().unwrap().picture().unwrap().is_none() {
            assert!(Instant::now() < deadline);
            std::thread::sleep(Duration::from_millis(2));
            traced = Some(Converging::follow(traced, &stage, [8, 6], &Threads).unwrap());
        }
        assert_eq!(traced.unwrap().key.camera, stage.camera().unwrap());
    }

    #[test]
    fn without_threads_every_slice_adds_a_pass() {
        let (mut stage, executor) = (stage(), Slices::default());
        let mut traced = Converging::follow(None, &stage, [8, 6], &executor).unwrap();
        let samples = |traced: &Converging| traced.picture().unwrap().map(|so_far| so_far.samples_per_pixel);
        assert_eq!(samples(&traced), None);
        for passes in 1..4 {
            assert!(executor.run_slices());
            assert_eq!(samples(&traced), Some(passes * SAMPLES_PER_PASS));
        }
        let mut look = stage.look().clone();
        look.environment.rotation = 20.0;
        stage.set_look(look).unwrap();
        traced = Converging::follow(Some(traced), &stage, [8, 6], &executor).unwrap();
        assert!(!executor.run_slices(), "the task before goes on");
        traced = Converging::follow(Some(traced), &stage, [8, 6], &executor).unwrap();
        assert!(executor.run_slices());
        assert_eq!(samples(&traced), Some(SAMPLES_PER_PASS));
    }
}
