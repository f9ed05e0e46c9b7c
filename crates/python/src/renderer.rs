//! The renderer: a graphics device, and on it whatever was drawn last.

use std::sync::{Arc, Mutex, PoisonError};

use gnomon::picture::RgbImage;
use gnomon::renderer::layers::{Layer, RenderedLayers};
use gnomon::renderer::{AdapterSummary, Gpu, GpuOptions, RenderError, list_adapters};
use gnomon::studio::{Stage, Studio, StudioError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::environment::Environment;
use crate::error::refused;
use crate::layers::{Pictures, layers_named};
use crate::lights::Lights;
use crate::scene::Scene;
use crate::view::{Size, View};
use crate::{picture, work};

/// Draws scenes on one graphics adapter. Threads that share one take turns; pictures do not depend on what was drawn before.
#[pyclass(frozen, module = "gnomon")]
pub struct Renderer {
    options: GpuOptions,
    adapter: AdapterSummary,
    reason: String,
    session: Mutex<Session>,
}

/// A device while there is one, and what lies on it.
#[derive(Default)]
struct Session {
    gpu: Option<Gpu>,
    studio: Option<Studio>,
}

impl Session {
    /// Draws a stage. What it shares with the one before stays where it is; a device that was lost is opened anew.
    fn draw(
        &mut self,
        options: &GpuOptions,
        stage: Stage,
        layers: &[Layer],
    ) -> Result<(RgbImage, RenderedLayers), StudioError> {
        let drawn = self.drawn(options, stage, layers);
        if matches!(drawn, Err(StudioError::Render(RenderError::DeviceLost { .. }))) {
            *self = Self::default();
        }
        drawn
    }

    fn drawn(
        &mut self,
        options: &GpuOptions,
        stage: Stage,
        layers: &[Layer],
    ) -> Result<(RgbImage, RenderedLayers), StudioError> {
        let [width, height] = stage.look().picture.size;
        let gpu = match &self.gpu {
            Some(gpu) => gpu.clone(),
            None => self.gpu.insert(Gpu::new(options)?).clone(),
        };
        let studio = match &mut self.studio {
            Some(studio) => {
                studio.set_stage(stage)?;
                studio
            }
            None => self.studio.insert(Studio::new(&gpu, stage)?),
        };
        let (frame, layers) = studio.frame_layers(width, height, layers)?;
        Ok((frame.radiance, layers))
    }
}

/// Why an adapter was taken.
fn reason(options: &GpuOptions, all: &[AdapterSummary]) -> String {
    let usable = all.iter().filter(|adapter| adapter.usable).count();
    match &options.adapter {
        Some(name) => format!("the fastest whose name holds '{name}'"),
        None if usable == 1 => "the only one that can draw".to_owned(),
        None if all.iter().any(|adapter| adapter.usable && adapter.kind != "software") => {
            format!("the fastest of {usable}")
        }
        None => format!("the fastest of {usable}; there is no graphics processor with a driver"),
    }
}

/// One view, or as many as there are pictures.
fn each<'py>(
    value: Option<&Bound<'py, PyAny>>,
    count: &mut usize,
    what: &str,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let Some(value) = value else { return Ok(Vec::new()) };
    let Ok(list) = value.cast::<PyList>() else { return Ok(vec![value.clone()]) };
    if *count != 1 && *count != list.len() || list.is_empty() {
        return Err(refused(format!("{} {what} do not go with {count} pictures", list.len())));
    }
    *count = list.len();
    Ok(list.iter().collect())
}

#[pymethods]
impl Renderer {
    #[new]
    #[pyo3(signature = (adapter=None))]
    fn new(py: Python<'_>, adapter: Option<String>) -> PyResult<Self> {
        let options = GpuOptions { adapter };
        let (gpu, all) = work::run(py, None, |_| Ok((Gpu::new(&options)?, list_adapters())))?;
        let (adapter, reason) = (gpu.adapter().clone(), reason(&options, &all));
        let session = Mutex::new(Session { gpu: Some(gpu), studio: None });
        Ok(Self { options, adapter, reason, session })
    }

    /// The adapter: its name, backend, kind, driver and limits, and the reason why it was taken.
    #[getter]
    fn adapter<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let adapter = picture::document(py, &self.adapter)?;
        adapter.set_item("reason", &self.reason)?;
        Ok(adapter)
    }

    /// Draws a picture: float32 (height, width, 3), linear Rec. 709 radiance; with layers a dict of it and of them.
    #[pyo3(signature = (scene, camera=None, environment=None, size=None, *, layers=None, **options))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        scene: &Bound<'py, Scene>,
        camera: Option<&Bound<'py, PyAny>>,
        environment: Option<&Environment>,
        size: Option<Size>,
        layers: Option<Vec<String>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let view = View::of(scene, camera, environment, size, options)?;
        let [width, height] = view.size().map(|side| side as usize);
        let has_layers = layers.is_some();
        let layers = layers_named(layers)?;
        let mut pictures = Pictures::default();
        work::run(py, None, |_| {
            let stage = view.stage()?;
            let mut session = self.session.lock().unwrap_or_else(PoisonError::into_inner);
            let (radiance, layers) = session.draw(&self.options, stage, &layers)?;
            pictures.add(&radiance, layers);
            Ok(())
        })?;
        pictures.arrays(py, &[height, width], has_layers)
    }

    /// Draws several pictures: float32 (n, height, width, 3), with layers a dict. Scenes, cameras and environments are each one, or a list of n.
    #[pyo3(signature = (scenes, cameras=None, environments=None, size=None, *, layers=None, progress=None, **options))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn render_batch<'py>(
        &self,
        py: Python<'py>,
        scenes: &Bound<'py, PyAny>,
        cameras: Option<&Bound<'py, PyAny>>,
        environments: Option<&Bound<'py, PyAny>>,
        size: Option<Size>,
        layers: Option<Vec<String>>,
        progress: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut count = 1;
        let scenes = each(Some(scenes), &mut count, "scenes")?;
        let cameras = each(cameras, &mut count, "cameras")?;
        let environments = each(environments, &mut count, "environments")?;
        let of = |list: &[Bound<'py, PyAny>], number: usize| {
            list.get(if list.len() == 1 { 0 } else { number }).cloned()
        };
        let mut views = Vec::with_capacity(count);
        for number in 0..count {
            let scene = of(&scenes, number).map(|scene| scene.cast_into::<Scene>()).transpose()?;
            let Some(scene) = scene else { return Err(refused("there is no scene")) };
            let environment = of(&environments, number);
            let environment = environment.as_ref().map(|value| value.cast::<Environment>()).transpose()?;
            views.push(View::of(
                &scene,
                of(&cameras, number).as_ref(),
                environment.map(|environment| environment.get()),
                size,
                options,
            )?);
        }
        let size = views[0].size();
        if views.iter().any(|view| view.size() != size) {
            return Err(refused("the pictures of a batch are equally large: give their size"));
        }
        let [width, height] = size.map(|side| side as usize);
        let has_layers = layers.is_some();
        let layers = layers_named(layers)?;
        let mut pictures = Pictures::default();
        work::run(py, progress, |job| {
            let mut session = self.session.lock().unwrap_or_else(PoisonError::into_inner);
            for (number, view) in views.into_iter().enumerate() {
                if job.is_cancelled() {
                    break;
                }
                let (radiance, layers) = session.draw(&self.options, view.stage()?, &layers)?;
                pictures.add(&radiance, layers);
                job.tell((number + 1) as f32 / count as f32);
            }
            Ok(())
        })?;
        pictures.arrays(py, &[count, height, width], has_layers)
    }

    /// The lights of the picture that was drawn last, not turned; None before the first.
    #[getter]
    fn lights(&self, py: Python<'_>) -> PyResult<Option<Lights>> {
        work::run(py, None, |_| {
            let session = self.session.lock().unwrap_or_else(PoisonError::into_inner);
            Ok(session.studio.as_ref().map(|studio| {
                let factor = studio.stage().grade().light;
                Lights {
                    set: Arc::new(studio.lights().times(factor)),
                    map: Arc::new(studio.environment().times(factor)),
                }
            }))
        })
    }

    /// Loses the device, as a driver's reset does; for tests.
    fn _lose_device(&self, py: Python<'_>) -> PyResult<()> {
        work::run(py, None, |_| {
            let session = self.session.lock().unwrap_or_else(PoisonError::into_inner);
            session.gpu.iter().for_each(|gpu| gpu.device().destroy());
            Ok(())
        })
    }

    fn __repr__(&self) -> String {
        let AdapterSummary { name, backend, .. } = &self.adapter;
        format!("<gnomon.Renderer on {name} ({backend}), {}>", self.reason)
    }
}

/// All adapters, those that cannot draw included.
#[pyfunction]
pub fn adapters(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let all = work::run(py, None, |_| Ok(list_adapters()))?;
    all.iter().map(|adapter| picture::document(py, adapter)).collect()
}
