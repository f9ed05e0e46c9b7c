//! Cameras.

use glam::Vec3;
use gnomon::scene;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value};

use crate::arrays;
use crate::error::{raised, refused};
use crate::view::Size;

/// A view, as the command's `--camera` has it: a text, or keywords as the keys of a scene file's `[camera]`.
#[pyclass(frozen, from_py_object, module = "gnomon")]
#[derive(Clone)]
pub struct Camera(pub scene::Camera);

/// A number or a list of them, whatever holds them.
fn json(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    let value = match value.hasattr("tolist")? {
        true => value.call_method0("tolist")?,
        false => value.clone(),
    };
    match value.extract::<f64>() {
        Ok(number) => Ok(number.into()),
        Err(_) => value.try_iter()?.map(|part| json(&part?)).collect::<PyResult<Vec<_>>>().map(Value::from),
    }
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (text=None, *, world_from_camera=None, **settings))]
    fn new(
        text: Option<&str>,
        world_from_camera: Option<&Bound<'_, PyAny>>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        if let Some(text) = text {
            return match (world_from_camera, settings) {
                (None, None) => text.parse().map(Self).map_err(|error: scene::SceneError| raised(error)),
                _ => Err(refused("a camera is given by a text or by keywords, not by both")),
            };
        }
        let mut table = Map::new();
        for (key, value) in settings.into_iter().flatten() {
            table.insert(key.extract()?, json(&value)?);
        }
        if let Some(matrix) = world_from_camera {
            let matrix = arrays::to_matrix(matrix, "world_from_camera")?.as_dmat4();
            let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis];
            let columns = columns.map(|column| Value::from(column.truncate().to_array().to_vec()));
            table.insert("matrix".to_owned(), Value::from(columns.to_vec()));
        }
        let camera = serde_json::from_value(Value::Object(table));
        camera
            .map(Self)
            .map_err(|error| refused(format!("camera: {}", gnomon_messages::one_line(&error.to_string()))))
    }

    #[getter]
    fn world_from_camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::matrix(py, self.0.world_from_camera)
    }

    #[getter]
    fn eye(&self) -> [f32; 3] {
        self.0.eye().to_array()
    }

    /// The matrix of a pinhole as OpenCV has it, float32 (3, 3).
    fn intrinsics<'py>(&self, py: Python<'py>, size: Size) -> PyResult<Bound<'py, PyAny>> {
        let Some([fx, fy, cx, cy]) = self.0.intrinsics(size.0) else {
            return Err(refused("a parallel view has no focal length"));
        };
        let cells = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0].map(|cell| cell as f32);
        arrays::floats(py, &cells, &[3, 3])
    }

    /// Pixels and depths [m] of world points, float32 (n, 3).
    fn project<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        size: Size,
    ) -> PyResult<Bound<'py, PyAny>> {
        let points = arrays::vectors(points, "points")?;
        let seen: Vec<Vec3> = points.iter().map(|&point| self.0.project(point, size.0)).collect();
        arrays::floats(py, bytemuck::cast_slice(&seen), &[seen.len(), 3])
    }

    fn __repr__(&self) -> String {
        let settings = serde_json::to_string(&self.0).unwrap_or_default();
        format!("gnomon.Camera({settings})")
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        // Only maps with keys that are no strings can fail.
        let document = serde_json::to_string(&slf.get().0).unwrap_or_default();
        Ok((slf.get_type().getattr("_from_json")?, (document,)))
    }

    #[staticmethod]
    fn _from_json(document: &str) -> PyResult<Self> {
        serde_json::from_str(document).map(Self).map_err(|error| refused(format!("camera: {error}")))
    }
}
