//! A reference picture that converges on a thread.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use gnomon_envmap::Equirect;
use gnomon_image::RgbImage;
use gnomon_metrics::{relative_rmse, signed_difference};
use gnomon_reference::{Progressive, ReferenceError, ReferenceOptions};
use gnomon_scene::{Camera, Scene};

use crate::{Stage, StudioError};

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
    environment: Arc<Equirect>,
    rotation: f32,
    camera: Camera,
    size: [u32; 2],
}

impl Key {
    fn is(&self, other: &Self) -> bool {
        // The stage replaces what somebody else holds rather than changing it.
        Arc::ptr_eq(&self.scene, &other.scene)
            && Arc::ptr_eq(&self.environment, &other.environment)
            && (self.rotation, self.size) == (other.rotation, other.size)
            && self.camera == other.camera
    }
}

/// What the thread has come to.
type Progress = Mutex<Result<Option<ReferencePicture>, ReferenceError>>;

/// A thread that adds passes until it is dropped.
pub(crate) struct Converging {
    key: Key,
    cancel: Arc<AtomicBool>,
    progress: Arc<Progress>,
    thread: JoinHandle<()>,
}

impl Drop for Converging {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Converging {
    /// Goes on with `before` where it is still of this stage, or starts anew.
    pub fn follow(before: Option<Self>, stage: &Stage, size: [u32; 2]) -> Result<Self, StudioError> {
        let key = Key {
            scene: Arc::clone(stage.scene()),
            environment: Arc::clone(stage.environment()),
            rotation: stage.look().environment.rotation,
            camera: stage.camera()?,
            size,
        };
        match before {
            Some(before) if before.key.is(&key) => Ok(before),
            _ => Self::start(key, stage),
        }
    }

    fn start(key: Key, stage: &Stage) -> Result<Self, StudioError> {
        let (scene, camera) = stage.for_reference()?;
        let environment = Arc::clone(&key.environment);
        let [width, height] = key.size;
        let cancel = Arc::new(AtomicBool::new(false));
        let progress: Arc<Progress> = Arc::new(Mutex::new(Ok(None)));
        let (cancelled, told) = (Arc::clone(&cancel), Arc::clone(&progress));
        let trace = move || {
            let options = ReferenceOptions {
                width,
                height,
                samples_per_pixel: SAMPLES_PER_PASS,
                ..ReferenceOptions::default()
            };
            let mut passes = Progressive::new(&scene, &camera, &environment, &options)?;
            loop {
                passes.add_pass(&cancelled)?;
                let estimate = passes.estimate();
                let noise = mean(&estimate.variance).max(0.0).sqrt() / mean(&estimate.mean);
                let picture = ReferencePicture {
                    mean: Arc::new(estimate.mean),
                    samples_per_pixel: estimate.samples_per_pixel,
                    noise: if noise.is_finite() { noise } else { 0.0 },
                };
                *told.lock().unwrap_or_else(PoisonError::into_inner) = Ok(Some(picture));
            }
        };
        let told = Arc::clone(&progress);
        let thread = thread::Builder::new().name("reference".to_owned()).spawn(move || {
            let ended: Result<std::convert::Infallible, ReferenceError> = trace();
            let Err(error) = ended;
            *told.lock().unwrap_or_else(PoisonError::into_inner) = Err(error);
        });
        let thread = thread.map_err(|_| StudioError::Thread("the reference"))?;
        Ok(Self { key, cancel, progress, thread })
    }

    /// The picture so far.
    pub fn picture(&self) -> Result<Option<ReferencePicture>, StudioError> {
        // Asked first: a thread that ends says why before it does.
        let ended = self.thread.is_finished();
        let picture = self.progress.lock().unwrap_or_else(PoisonError::into_inner).clone()?;
        if ended { Err(StudioError::Thread("the reference")) } else { Ok(picture) }
    }
}

/// Mean over pixels and channels.
fn mean(picture: &RgbImage) -> f64 {
    let sum: f64 = picture.texels().iter().map(|texel| texel.as_dvec3().element_sum()).sum();
    sum / (3.0 * picture.texels().len().max(1) as f64)
}
