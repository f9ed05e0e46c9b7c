//! Lights that stand for an environment.

use std::sync::Arc;

use gnomon::envmap::Equirect;
use gnomon::lights::fit::{FitOptions, FitSettings};
use gnomon::lights::{LightSet, preview};
use gnomon::options::OptionSpec;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::environment::Environment;
use crate::{arrays, keywords, work};

/// Area lights and the map that they leave.
#[pyclass(frozen, module = "gnomon")]
pub struct Lights {
    pub set: Arc<LightSet>,
    pub map: Arc<Equirect>,
}

/// Width of the picture of a notebook [pixels].
const PREVIEW: u32 = 768;

/// Fits lights to an environment as it is turned, for a scene on a `ground` or not.
#[pyfunction]
#[pyo3(signature = (environment, *, ground=true, **options))]
pub fn fit(
    py: Python<'_>,
    environment: &Environment,
    ground: bool,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Lights> {
    let given = keywords::given::<FitSettings>(options, keywords::flag as fn(&OptionSpec) -> String)?;
    let mut settings = FitSettings::default();
    given.apply(&mut settings);
    let turn = environment.look.environment.rotation.to_radians();
    let surroundings = &environment.surroundings;
    let (set, map) = work::run(py, None, |_| {
        let options: FitOptions = settings.options(ground)?;
        let factor = environment.look.environment.grade().light;
        let set = surroundings.fit_lights(&settings, &options)?.times(factor);
        let map = Arc::new(surroundings.map().times(factor));
        Ok(if turn == 0.0 { (set, map) } else { (set.rotated(turn), Arc::new(map.rotated(turn))) })
    })?;
    Ok(Lights { set: Arc::new(set), map })
}

impl Lights {
    fn vectors<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&gnomon::lights::DistantLight) -> glam::Vec3,
    ) -> PyResult<Bound<'py, PyAny>> {
        let values: Vec<_> = self.set.lights.iter().map(of).collect();
        arrays::floats(py, bytemuck::cast_slice(&values), &[values.len(), 3])
    }
}

#[pymethods]
impl Lights {
    fn __len__(&self) -> usize {
        self.set.lights.len()
    }

    #[getter]
    fn method(&self) -> &'static str {
        self.set.method
    }

    /// Unit directions towards the lights, float32 (n, 3).
    #[getter]
    fn directions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.vectors(py, |light| light.direction)
    }

    #[getter]
    fn radiance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.vectors(py, |light| light.radiance)
    }

    /// Solid angles [sr], float32 (n,).
    #[getter]
    fn solid_angles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values: Vec<f32> = self.set.lights.iter().map(|light| light.solid_angle).collect();
        arrays::floats(py, &values, &[values.len()])
    }

    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::picture(py, self.set.residual.radiance())
    }

    /// The lights as `gnomon decompose` writes them.
    fn to_json(&self) -> String {
        // Only maps with keys that are no strings can fail.
        serde_json::to_string_pretty(&self.set.document()).unwrap_or_default()
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let picture = work::run(py, None, |_| Ok(preview(&self.map, &self.set, PREVIEW)))?;
        crate::picture::encoded(py, &picture)
    }

    fn __repr__(&self) -> String {
        format!("<gnomon.Lights {}: {} lights>", self.set.method, self.set.lights.len())
    }
}
