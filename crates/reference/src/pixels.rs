use std::sync::atomic::Ordering;

use glam::{DVec3, UVec2};
use gnomon_scene::{Camera, Scene};
use rayon::prelude::*;

use crate::render::{batch_mean, check, sky_tracer};
use crate::{ReferenceError, ReferenceOptions, Sky};

/// Two means of each of some pixels of [`crate::render`]'s picture, by column and row. All are independent of each other, also those of a pixel that
/// is asked for twice. Of the options, `samples_per_pixel` are those of one mean; nobody is told of the progress.
///
/// # Errors
/// See [`ReferenceError`].
pub fn trace_pixels<'a>(
    scene: &Scene,
    camera: &Camera,
    environment: impl Into<Sky<'a>>,
    options: &ReferenceOptions,
    pixels: &[UVec2],
) -> Result<Vec<[DVec3; 2]>, ReferenceError> {
    let sky = environment.into();
    check(camera, &[sky.map, sky.background], options)?;
    let tracer = sky_tracer(scene, sky, options)?;
    let &ReferenceOptions { width, height, seed, samples_per_pixel, cancel, .. } = options;
    let size = UVec2::new(width, height);
    let traced = pixels.par_iter().enumerate().with_max_len(1).map(|(index, &pixel)| {
        if cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
            return Err(ReferenceError::Cancelled);
        }
        let mean = |which: u32| {
            let batch = (2 * index as u32).wrapping_add(which);
            batch_mean(&tracer, camera, (size, pixel), (seed, batch), samples_per_pixel)
        };
        Ok([mean(0), mean(1)])
    });
    traced.collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use gnomon_envmap::builtin::by_name;

    use super::*;
    use crate::render;

    #[test]
    fn the_means_are_those_of_the_picture_and_independent() {
        let scene = gnomon_scene::builtin::by_name("three-boxes").unwrap();
        let (map, camera) = (by_name("room").unwrap(), &scene.cameras[0]);
        let options =
            ReferenceOptions { width: 12, height: 9, samples_per_pixel: 512, ..ReferenceOptions::default() };
        let whole = render(&scene, camera, &map, &options).unwrap();
        let pixels: Vec<UVec2> = (0..108).map(|index| UVec2::new(index % 12, index / 12)).collect();
        let few = ReferenceOptions { samples_per_pixel: 32, seed: 1, ..options };
        let trace = |pixels: &[UVec2]| trace_pixels(&scene, camera, &map, &few, pixels).unwrap();
        // Products of independent noises cancel out; squares of one do not.
        let (mut product, mut square) = (0.0, 0.0);
        for (pixel, [first, second]) in pixels.iter().zip(trace(&pixels)) {
            let truth = whole.mean.get(pixel.x, pixel.y).as_dvec3();
            let (first, second) = (first - truth, second - truth);
            product += (first * second).element_sum();
            square += 0.5 * (first * first + second * second).element_sum();
        }
        assert!(square > 0.0 && product.abs() < 0.35 * square, "{product} of {square}");
        let [again, twice] = trace(&[UVec2::new(5, 6); 2])[..] else { panic!("two pixels") };
        assert!(again[0] != again[1] && again[0] != twice[0] && again[1] != twice[1]);
        assert_eq!(trace(&[UVec2::new(5, 6)])[0], again);
    }

    #[test]
    fn it_can_be_cancelled_and_refuses_what_render_refuses() {
        let scene = gnomon_scene::builtin::by_name("three-boxes").unwrap();
        let (map, camera) = (by_name("room").unwrap(), &scene.cameras[0]);
        let stop = AtomicBool::new(true);
        let options = ReferenceOptions { cancel: Some(&stop), ..ReferenceOptions::default() };
        let trace = |options| trace_pixels(&scene, camera, &map, &options, &[UVec2::ONE]);
        assert_eq!(trace(options), Err(ReferenceError::Cancelled));
        let none = ReferenceOptions { samples_per_pixel: 0, ..ReferenceOptions::default() };
        assert_eq!(trace(none), Err(ReferenceError::NoSamples));
    }
}
