use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use glam::{DVec3, UVec2, Vec3};
use gnomon_envmap::{Equirect, Grade};
use gnomon_lights::{DistantLight, LightSet};
use gnomon_picture::{LUMINANCE, RgbImage};
use gnomon_scene::{Camera, Scene};
use rayon::prelude::*;

use crate::camera_ray::check_camera;
use crate::environment::EnvironmentSampler;
use crate::illumination::Illumination;
use crate::sampler::{Decision, Sequence};
use crate::shade::Tracer;
use crate::traced_scene::TracedScene;
use crate::welford::Welford;
use crate::{ReferenceError, camera_ray};

/// Largest picture: 64 million pixels, 1.6 GB of mean and variance.
pub const MAX_PIXELS: u64 = 1 << 26;

/// Independent batches of samples of a pixel. Samples of a batch are stratified together, so only the spread of batch
/// means tells the variance without bias; 32 give it within a quarter, and lose little stratification.
const BATCHES: u32 = 32;

/// How to render a reference picture.
#[derive(Clone, Copy)]
pub struct ReferenceOptions<'a> {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples of a pixel, at least 2; above 32 rounded up to a multiple of 32. Powers of two are the most even.
    pub samples_per_pixel: u32,
    /// Whether the environment is seen behind the scene.
    pub background: bool,
    /// Whether glossy lobes reflect the scene, too, as it is in direct light: one more bounce off them. Else they reflect light alone, and
    /// what the scene hides of it is black.
    pub reflections: bool,
    /// The same seed gives the same picture, bit for bit.
    pub seed: u64,
    /// Told the finished share, 0..1, now and then, from any thread.
    pub progress: Option<&'a (dyn Fn(f32) + Sync)>,
    /// Set it to stop early, with [`ReferenceError::Cancelled`].
    pub cancel: Option<&'a AtomicBool>,
}

impl Default for ReferenceOptions<'_> {
    fn default() -> Self {
        Self {
            width: 1024,
            height: 768,
            samples_per_pixel: 256,
            background: true,
            reflections: true,
            seed: 0,
            progress: None,
            cancel: None,
        }
    }
}

/// An unbiased estimate of every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Mean radiance.
    pub mean: RgbImage,
    /// Variance of `mean` (the square of its standard error), estimated without bias.
    pub variance: RgbImage,
    /// Samples that every pixel got.
    pub samples_per_pixel: u32,
}

/// What is infinitely far away. A map alone is one.
#[derive(Clone, Copy, Debug)]
pub struct Sky<'a> {
    /// Light from everywhere.
    pub map: &'a Equirect,
    /// Lights beside it: they light surfaces and are mirrored, and the camera does not see them.
    pub lights: &'a [DistantLight],
    /// What the camera sees behind the scene.
    pub background: &'a Equirect,
    /// Factors of all of these.
    pub grade: Grade,
}

impl<'a> From<&'a Equirect> for Sky<'a> {
    fn from(map: &'a Equirect) -> Self {
        Self { map, lights: &[], background: map, grade: Grade::NONE }
    }
}

impl<'a> From<&'a Arc<Equirect>> for Sky<'a> {
    fn from(map: &'a Arc<Equirect>) -> Self {
        Self::from(&**map)
    }
}

/// Whether a fit's residual map is blocked by the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ResidualShadows {
    /// The scene blocks it as it blocks the lights: what an exact renderer would make of the set.
    Cast,
    /// It reaches every surface, as ambient light does: what the GPU renderer makes of it.
    #[default]
    Ignore,
}

/// The scene under the environment itself and the scene's own lights.
///
/// # Errors
/// See [`ReferenceError`].
pub fn render<'a>(
    scene: &Scene,
    camera: &Camera,
    environment: impl Into<Sky<'a>>,
    options: &ReferenceOptions,
) -> Result<Estimate, ReferenceError> {
    let sky = environment.into();
    check(camera, &[sky.map, sky.background], options)?;
    estimate(&sky_tracer(scene, sky, options)?, camera, options)
}

/// The scene without anything behind it, and how much each pixel hides of what is put there, row by row from the top: by two pictures of the same
/// samples, before black and before white.
///
/// # Errors
/// See [`ReferenceError`].
pub fn render_with_alpha<'a>(
    scene: &Scene,
    camera: &Camera,
    environment: impl Into<Sky<'a>>,
    options: &ReferenceOptions,
) -> Result<(Estimate, Vec<f32>), ReferenceError> {
    let sky = environment.into();
    let black = ReferenceOptions { background: false, ..*options };
    let white = Equirect::new(RgbImage::filled(2, 1, Vec3::ONE));
    let estimate = render(scene, camera, sky, &black)?;
    let over_white = render(
        scene,
        camera,
        Sky { background: &white, grade: Grade { background: Vec3::ONE, ..sky.grade }, ..sky },
        &ReferenceOptions { background: true, ..*options },
    )?;
    let pairs = over_white.mean.texels().iter().zip(estimate.mean.texels());
    let alpha =
        pairs.map(|(white, black)| (1.0 - (*white - *black).dot(LUMINANCE)).clamp(0.0, 1.0)).collect();
    Ok((estimate, alpha))
}

/// The scene under a sky, ready to be traced.
pub(crate) fn sky_tracer<'a>(
    scene: &'a Scene,
    sky: Sky<'a>,
    options: &ReferenceOptions,
) -> Result<Tracer<'a>, ReferenceError> {
    let Grade { light, background } = sky.grade;
    let lights: Vec<_> = sky.lights.iter().map(|of_sky| of_sky.times(light)).collect();
    Ok(Tracer {
        scene: TracedScene::new(scene)?,
        shadowed: Illumination::new(Some(EnvironmentSampler::new(sky.map, light)), &lights)
            .with_near(&scene.placed_lights()),
        unshadowed: None,
        background: options.background.then_some((sky.background, background)),
        reflections: options.reflections,
        unshadowed_irradiance: Mutex::default(),
    })
}

/// The scene under fitted lights, their residual and the scene's own lights, in front of `background`: what the fit leaves of
/// the truth with exact shadows.
///
/// # Errors
/// See [`ReferenceError`].
pub fn render_lights(
    scene: &Scene,
    camera: &Camera,
    lights: &LightSet,
    residual_shadows: ResidualShadows,
    background: &Equirect,
    options: &ReferenceOptions,
) -> Result<Estimate, ReferenceError> {
    check(camera, &[&lights.residual, background], options)?;
    let residual = EnvironmentSampler::new(&lights.residual, Vec3::ONE);
    let (shadowed, unshadowed) = match residual_shadows {
        ResidualShadows::Cast => (Illumination::new(Some(residual), &lights.lights), None),
        ResidualShadows::Ignore => {
            (Illumination::new(None, &lights.lights), Some(Illumination::new(Some(residual), &[])))
        }
    };
    let shadowed = shadowed.with_near(&scene.placed_lights());
    let background = options.background.then_some((background, Vec3::ONE));
    let unshadowed_irradiance = Mutex::default();
    let scene = TracedScene::new(scene)?;
    let reflections = options.reflections;
    let tracer = Tracer { scene, shadowed, unshadowed, background, reflections, unshadowed_irradiance };
    estimate(&tracer, camera, options)
}

pub(crate) fn check(
    camera: &Camera,
    maps: &[&Equirect],
    options: &ReferenceOptions,
) -> Result<(), ReferenceError> {
    let &ReferenceOptions { width, height, samples_per_pixel, .. } = options;
    if width == 0 || height == 0 {
        return Err(ReferenceError::EmptyPicture { width, height });
    }
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(ReferenceError::PictureTooLarge { width, height });
    }
    if samples_per_pixel == 0 {
        return Err(ReferenceError::NoSamples);
    }
    if maps.iter().any(|map| map.width() == 0 || map.height() == 0) {
        return Err(ReferenceError::EmptyEnvironment);
    }
    check_camera(camera)
}

fn estimate(
    tracer: &Tracer,
    camera: &Camera,
    options: &ReferenceOptions,
) -> Result<Estimate, ReferenceError> {
    let &ReferenceOptions { width, height, seed, .. } = options;
    let requested = options.samples_per_pixel.max(2);
    let batches = requested.min(BATCHES);
    let batch_size = requested.div_ceil(batches);
    let size = UVec2::new(width, height);
    let cancelled = || options.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed));

    let mut mean = RgbImage::filled(width, height, Vec3::ZERO);
    let mut variance = RgbImage::filled(width, height, Vec3::ZERO);
    let finished_rows = AtomicU32::new(0);
    let rows = mean
        .texels_mut()
        .par_chunks_mut(width as usize)
        .zip(variance.texels_mut().par_chunks_mut(width as usize))
        .enumerate();
    // Single rows, so that a slow part of the picture is spread over all threads.
    rows.with_max_len(1).try_for_each(|(y, (mean_row, variance_row))| {
        for (x, (mean, variance)) in mean_row.iter_mut().zip(variance_row).enumerate() {
            if cancelled() {
                return Err(ReferenceError::Cancelled);
            }
            let pixel = UVec2::new(x as u32, y as u32);
            let mut sums = Welford::default();
            for batch in 0..batches {
                let value = batch_mean(tracer, camera, (size, pixel), (seed, batch), batch_size);
                sums.add(value, batch + 1);
            }
            (*mean, *variance) = (sums.mean.as_vec3(), sums.variance_of_mean(batches).as_vec3());
        }
        if let Some(progress) = options.progress {
            let finished = finished_rows.fetch_add(1, Ordering::Relaxed) + 1;
            progress(finished as f32 / height as f32);
        }
        Ok(())
    })?;
    Ok(Estimate { mean, variance, samples_per_pixel: batches * batch_size })
}

/// Mean radiance of so many samples of a pixel, which are stratified together.
pub(crate) fn batch_mean(
    tracer: &Tracer,
    camera: &Camera,
    (size, pixel): (UVec2, UVec2),
    (seed, batch): (u64, u32),
    samples: u32,
) -> DVec3 {
    let sequence = Sequence::new(seed, pixel.y * size.x + pixel.x, batch);
    let sum: DVec3 = (0..samples)
        .map(|index| {
            let place = pixel.as_vec2() + sequence.pair(index, Decision::Pixel).as_vec2();
            let ray = camera_ray(camera, size, place);
            tracer.radiance(&ray, &sequence, index).as_dvec3()
        })
        .sum();
    sum / f64::from(samples)
}
