//! The ray-traced truth.

use gnomon::reference::{ReferenceOptions, render};
use gnomon::studio::CHECKED_PIXELS;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::environment::Environment;
use crate::scene::Scene;
use crate::view::{Size, View};
use crate::{arrays, picture, work};

/// Ray-traces a picture on all cores: float32 (height, width, 3), with `variance` two of them.
#[pyfunction]
#[pyo3(signature = (scene, camera=None, environment=None, size=None, *, samples=256, seed=0, variance=false, progress=None, **options))]
#[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
pub fn reference<'py>(
    py: Python<'py>,
    scene: &Bound<'py, Scene>,
    camera: Option<&Bound<'py, PyAny>>,
    environment: Option<&Environment>,
    size: Option<Size>,
    samples: u32,
    seed: u64,
    variance: bool,
    progress: Option<&Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let view = View::of(scene, camera, environment, size, options)?;
    let [width, height] = view.size();
    let estimate = work::run(py, progress, |job| {
        let stage = view.stage()?;
        let (scene, camera) = stage.for_reference()?;
        let tell = |share| job.tell(share);
        let options = ReferenceOptions {
            width,
            height,
            samples_per_pixel: samples,
            background: stage.look().shows_environment(),
            reflections: stage.reflects_scene(),
            seed,
            progress: Some(&tell),
            cancel: Some(job.cancel()),
        };
        Ok(render(&scene, &camera, stage.sky(), &options)?)
    })?;
    let mean = arrays::picture(py, &estimate.mean)?;
    match variance {
        true => Ok(PyTuple::new(py, [mean, arrays::picture(py, &estimate.variance)?])?.into_any()),
        false => Ok(mean),
    }
}

/// How far a picture is from the truth, told by so many of its pixels, which are ray-traced: relative RMSE and its standard error.
#[pyfunction]
#[pyo3(signature = (radiance, scene, camera=None, environment=None, *, pixels=CHECKED_PIXELS, **options))]
pub fn check<'py>(
    py: Python<'py>,
    radiance: &Bound<'py, PyAny>,
    scene: &Bound<'py, Scene>,
    camera: Option<&Bound<'py, PyAny>>,
    environment: Option<&Environment>,
    pixels: usize,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let radiance = arrays::to_picture(radiance, "the picture")?;
    let size = [radiance.width(), radiance.height()];
    let view = View::of(scene, camera, environment, Some(Size(size)), options)?;
    let error = work::run(py, None, |job| view.stage()?.check_until(&radiance, pixels, job.cancel()))?;
    picture::document(py, &error)
}
