//! The Python module `gnomon._gnomon`: a thin layer that turns arrays, names and keyword arguments into what the library takes, and back.
//!
//! Every call that takes long runs on a thread of its own without the interpreter's lock ([`work`]), so that other Python threads go on
//! and Ctrl-C stops it. What a class holds is behind an `Arc` or a lock: no call can see half of another's change.

mod arrays;
mod camera;
mod dataset;
mod environment;
mod error;
mod keywords;
mod layers;
mod lights;
mod mesh;
mod picture;
mod renderer;
mod scene;
mod truth;
mod view;
mod work;

use pyo3::prelude::*;

/// Registers everything.
#[pymodule]
mod _gnomon {
    #[pymodule_export]
    use super::camera::Camera;
    #[pymodule_export]
    use super::dataset::Dataset;
    #[pymodule_export]
    use super::environment::Environment;
    #[pymodule_export]
    use super::error::{DeviceLost, Error};
    #[pymodule_export]
    use super::lights::{Lights, fit};
    #[pymodule_export]
    use super::picture::{compare, png, read, tone_map, write};
    #[pymodule_export]
    use super::renderer::{Renderer, adapters};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::truth::{check, reference};

    use pyo3::prelude::*;

    /// The version.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
