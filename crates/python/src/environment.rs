//! Environments.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnomon::envmap::{Equirect, from_bytes, from_picture};
use gnomon::options::OptionSpec;
use gnomon::picture::tonemap::{ToneMapping, tone_mapped};
use gnomon::studio::{
    EnvironmentLook, Look, StudioError, Surroundings, environment_named, load_surroundings,
};
use gnomon_messages::quoted;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::refused;
use crate::{arrays, keywords, work};

/// What is infinitely far around a scene. It does not change; a turn, strength or tint is another one that shares its map.
#[pyclass(frozen, from_py_object, module = "gnomon")]
#[derive(Clone)]
pub struct Environment {
    pub surroundings: Surroundings,
    /// Which it is and how it is turned, for a picture's look.
    pub look: Look,
    warnings: Vec<String>,
    /// What it was made of, to be made of it elsewhere.
    source: Arc<Py<PyAny>>,
    keywords: Arc<Py<PyDict>>,
}

/// What a pickled environment is restored from: source, options, turn, strength, tint.
type Pickled = (Py<PyAny>, Py<PyDict>, f32, f32, [f32; 3]);

/// What an environment is read from.
enum Source {
    /// The look names it.
    Named,
    Bytes(Vec<u8>),
    Map(gnomon::picture::RgbImage),
}

impl Environment {
    /// That of a scene's file.
    pub fn of_scene(py: Python<'_>, project: &gnomon::studio::Project) -> PyResult<Self> {
        let (surroundings, warnings) = work::run(py, None, |_| project.surroundings())?;
        let mut look = Look::default();
        (look.map, look.environment) = (project.look.map.clone(), project.look.environment.clone());
        let (source, keywords) = (Arc::new(py.None()), Arc::new(PyDict::new(py).unbind()));
        Ok(Self { surroundings, look, warnings, source, keywords })
    }

    /// The map that lights, with its strength and tint.
    fn map(&self) -> Equirect {
        self.surroundings.map().times(self.look.environment.grade().light)
    }
}

fn read(source: Source, look: &Look) -> Result<(Surroundings, Vec<String>), StudioError> {
    let (map, warnings) = match source {
        Source::Named => return load_surroundings(look),
        Source::Bytes(bytes) => {
            let environment = from_bytes(Path::new("environment"), &bytes, look.environment.load_options())?;
            let warnings = environment.warnings();
            (environment.map, warnings)
        }
        Source::Map(picture) => {
            let (map, report) = from_picture(picture);
            let changed = report.nan + report.negative + report.infinite;
            let warning = format!("{changed} texels that are no radiance were changed");
            (map, if changed > 0 { vec![warning] } else { Vec::new() })
        }
    };
    Ok((Surroundings::from(Arc::new(map)).clamped(&look.environment), warnings))
}

#[pymethods]
impl Environment {
    #[staticmethod]
    #[pyo3(signature = (source, **options))]
    fn load(
        py: Python<'_>,
        source: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut look = Look::default();
        let kept = options.map_or_else(|| Ok(PyDict::new(py)), |options| options.copy())?;
        let given = keywords::given::<EnvironmentLook>(options, keywords::key as fn(&OptionSpec) -> String)?;
        given.apply(&mut look.environment);
        let named = source.extract::<PathBuf>();
        let read_from = if let Ok(path) = named {
            let text = path.to_str().ok_or_else(|| refused("the path is no text"))?;
            look.map = Some(environment_named(text));
            Source::Named
        } else if let Ok(bytes) = source.cast::<PyBytes>() {
            Source::Bytes(bytes.as_bytes().to_vec())
        } else {
            let picture = arrays::to_picture(source, "an environment")?;
            if picture.width() != 2 * picture.height() || picture.height() == 0 {
                let (width, height) = (picture.width(), picture.height());
                return Err(refused(format!(
                    "an environment as an array is an equirect map, twice as wide as high, not {width} x {height}"
                )));
            }
            Source::Map(picture)
        };
        let is_map = !matches!(read_from, Source::Named);
        if is_map && (look.environment.rig.is_some() || look.environment.background_map.is_some()) {
            return Err(refused("`rig` and `background_map` go with an environment that is a file"));
        }
        let is_array = matches!(read_from, Source::Map(_));
        let (surroundings, warnings) = work::run(py, None, |_| read(read_from, &look))?;
        // Whoever changes an array afterwards changes nothing here.
        let source = if is_array {
            source.call_method0("copy").unwrap_or_else(|_| source.clone())
        } else {
            source.clone()
        };
        let (source, keywords) = (Arc::new(source.unbind()), Arc::new(kept.unbind()));
        Ok(Self { surroundings, look, warnings, source, keywords })
    }

    /// The same turned to so many degrees about +y.
    fn rotated(&self, degrees: f32) -> PyResult<Self> {
        let mut other = self.clone();
        if !degrees.is_finite() {
            return Err(refused("an environment is turned by a finite number of degrees"));
        }
        other.look.environment.rotation = degrees;
        Ok(other)
    }

    /// The same of another strength or tint: what is not given stays as it is.
    #[pyo3(signature = (**options))]
    fn graded(&self, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let key = |spec: &OptionSpec| match spec.key {
            "strength" | "tint" => spec.key.to_owned(),
            _ => String::new(),
        };
        let mut other = self.clone();
        keywords::given::<EnvironmentLook>(options, key)?.apply(&mut other.look.environment);
        Ok(other)
    }

    #[getter]
    fn rotation(&self) -> f32 {
        self.look.environment.rotation
    }

    #[getter]
    fn exposure(&self) -> f32 {
        self.surroundings.exposure()
    }

    #[getter]
    fn radiance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::picture(py, self.map().radiance())
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let shown = tone_mapped(self.map().radiance(), ToneMapping::default(), self.exposure());
        crate::picture::encoded(py, &shown)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let map = self.surroundings.map();
        let source = self.source.bind(py);
        let name =
            source.extract::<PathBuf>().map_or("map".to_owned(), |path| quoted(&path.to_string_lossy()));
        format!(
            "<gnomon.Environment {name}: {} x {} texels, turned {} degrees>",
            map.width(),
            map.height(),
            self.rotation()
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Pickled)> {
        let py = slf.py();
        let this = slf.get();
        if this.source.bind(py).is_none() {
            return Err(refused(
                "a scene's own environment goes with its scene: pickle that, or load the map",
            ));
        }
        let restore = slf.get_type().getattr("_restored")?;
        let EnvironmentLook { rotation, strength, tint, .. } = this.look.environment;
        Ok((restore, (this.source.clone_ref(py), this.keywords.clone_ref(py), rotation, strength, tint)))
    }

    #[staticmethod]
    fn _restored(
        py: Python<'_>,
        source: &Bound<'_, PyAny>,
        keywords: &Bound<'_, PyDict>,
        rotation: f32,
        strength: f32,
        tint: [f32; 3],
    ) -> PyResult<Self> {
        let mut restored = Self::load(py, source, Some(keywords))?.rotated(rotation)?;
        (restored.look.environment.strength, restored.look.environment.tint) = (strength, tint);
        Ok(restored)
    }
}
