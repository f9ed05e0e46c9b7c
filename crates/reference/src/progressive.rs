use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, UVec2};
use gnomon_picture::RgbImage;
use gnomon_scene::{Camera, Scene};
use rayon::prelude::*;

use crate::render::{batch_mean, check, sky_tracer};
use crate::shade::Tracer;
use crate::welford::Welford;
use crate::{Estimate, ReferenceError, ReferenceOptions, Sky};

/// A reference picture that gets better pass by pass, of the scene under the environment itself and the scene's own lights, as
/// [`crate::render`] has it.
pub struct Progressive<'a> {
    tracer: Tracer<'a>,
    camera: Camera,
    size: UVec2,
    seed: u64,
    samples_per_pass: u32,
    passes: u32,
    /// Over the passes.
    pixels: Vec<Welford>,
}

impl<'a> Progressive<'a> {
    /// A picture without any sample yet. Of the options, `samples_per_pixel` are those of one pass; powers of two are the most even.
    ///
    /// # Errors
    /// See [`ReferenceError`].
    pub fn new(
        scene: &'a Scene,
        camera: &Camera,
        environment: impl Into<Sky<'a>>,
        options: &ReferenceOptions,
    ) -> Result<Self, ReferenceError> {
        let sky = environment.into();
        check(camera, &[sky.map, sky.background], options)?;
        let &ReferenceOptions { width, height, seed, samples_per_pixel, .. } = options;
        Ok(Self {
            tracer: sky_tracer(scene, sky, options)?,
            camera: camera.clone(),
            size: UVec2::new(width, height),
            seed,
            samples_per_pass: samples_per_pixel,
            passes: 0,
            pixels: vec![Welford::default(); width as usize * height as usize],
        })
    }

    /// Adds a pass, on all cores. Where it is cancelled the picture is useless: pixels differ in their number of passes.
    ///
    /// # Errors
    /// [`ReferenceError::Cancelled`] once `cancel` is set.
    pub fn add_pass(&mut self, cancel: &AtomicBool) -> Result<(), ReferenceError> {
        let Self { tracer, camera, size, seed, samples_per_pass, passes, pixels } = self;
        let (tracer, camera, passes_before) = (&*tracer, &*camera, *passes);
        let rows = pixels.par_chunks_mut(size.x as usize).enumerate().with_max_len(1);
        rows.try_for_each(|(y, row)| {
            for (x, sums) in row.iter_mut().enumerate() {
                if cancel.load(Ordering::Relaxed) {
                    return Err(ReferenceError::Cancelled);
                }
                let pixel = UVec2::new(x as u32, y as u32);
                let value =
                    batch_mean(tracer, camera, (*size, pixel), (*seed, passes_before), *samples_per_pass);
                sums.add(value, passes_before + 1);
            }
            Ok(())
        })?;
        *passes += 1;
        Ok(())
    }

    /// Mean and variance so far; before the second pass nothing is known of the variance, which is then 0.
    pub fn estimate(&self) -> Estimate {
        let picture = |value: &dyn Fn(&Welford) -> DVec3| {
            RgbImage::from_fn(self.size.x, self.size.y, |x, y| {
                value(&self.pixels[(y * self.size.x + x) as usize]).as_vec3()
            })
        };
        Estimate {
            mean: picture(&|sums| sums.mean),
            variance: picture(&|sums| sums.variance_of_mean(self.passes)),
            samples_per_pixel: self.passes * self.samples_per_pass,
        }
    }
}

#[cfg(test)]
mod tests {
    use gnomon_envmap::builtin::by_name;

    use super::*;
    use crate::render;

    #[test]
    fn as_many_passes_as_batches_give_the_same_picture() {
        let scene = gnomon_scene::builtin::by_name("three-boxes").unwrap();
        let map = by_name("room").unwrap();
        let options =
            ReferenceOptions { width: 12, height: 9, samples_per_pixel: 64, ..ReferenceOptions::default() };
        let expected = render(&scene, &scene.cameras[0], &map, &options).unwrap();
        let passes = ReferenceOptions { samples_per_pixel: 2, ..options };
        let mut progressive = Progressive::new(&scene, &scene.cameras[0], &map, &passes).unwrap();
        let go_on = AtomicBool::new(false);
        for _ in 0..32 {
            progressive.add_pass(&go_on).unwrap();
        }
        assert_eq!(progressive.estimate(), expected);
        go_on.store(true, Ordering::Relaxed);
        assert_eq!(progressive.add_pass(&go_on), Err(ReferenceError::Cancelled));
    }
}
