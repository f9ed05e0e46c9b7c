//! Where scenes come from: paths, names of what is built in, bytes.

use std::collections::HashMap;
use std::path::PathBuf;

use gnomon::studio::{SceneFiles, SceneSource};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::refused;

/// What Python gives to be loaded. `format` is the extension of a file of such bytes.
pub fn source(given: &Bound<'_, PyAny>, format: Option<&str>) -> PyResult<SceneSource> {
    if let Ok(path) = given.extract::<PathBuf>() {
        let text = path.to_str().ok_or_else(|| refused("the path is no text"))?;
        return Ok(SceneSource::named(text));
    }
    let Ok(bytes) = given.cast::<PyBytes>() else {
        return Err(refused("a scene is loaded from a path, the name of a built-in one, or bytes"));
    };
    let bytes = bytes.as_bytes().to_vec();
    let format = format.or_else(|| sniffed(&bytes)).ok_or_else(|| {
        refused(
            "these bytes do not say what they are: give format='obj', 'gltf', 'toml' or another extension",
        )
    })?;
    let path = PathBuf::from(format!("scene.{format}"));
    Ok(SceneSource::Files(SceneFiles::new(path.clone(), HashMap::from([(path, bytes)]))))
}

/// The format that bytes begin like.
fn sniffed(bytes: &[u8]) -> Option<&'static str> {
    [(b"glTF".as_slice(), "glb"), (b"ply", "ply"), (b"solid", "stl")]
        .into_iter()
        .find(|(start, _)| bytes.starts_with(start))
        .map(|(_, format)| format)
}
