//! Pictures: files, display, differences.

use std::path::PathBuf;

use gnomon::metrics;
use gnomon::picture::ldr::{encode_png, srgb8};
use gnomon::picture::tonemap::{ToneMapping, tone_mapped};
use gnomon::picture::{self, RgbImage};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::refused;
use crate::{arrays, work};

/// A display-linear picture as a PNG file.
pub fn encoded<'py>(py: Python<'py>, shown: &RgbImage) -> PyResult<Bound<'py, PyBytes>> {
    Ok(PyBytes::new(py, &encode_png(shown).map_err(refused)?))
}

fn mapping(name: &str) -> PyResult<ToneMapping> {
    let known = || ToneMapping::ALL.iter().map(|mapping| mapping.name()).collect::<Vec<_>>().join(", ");
    ToneMapping::from_name(name).ok_or_else(|| refused(format!("tone mapping is one of: {}", known())))
}

fn shown(radiance: &Bound<'_, PyAny>, exposure: f32, tone_mapping: &str) -> PyResult<RgbImage> {
    Ok(tone_mapped(&arrays::to_picture(radiance, "the picture")?, mapping(tone_mapping)?, exposure))
}

/// Radiance as a display shows it: uint8 (height, width, 3), sRGB.
#[pyfunction]
#[pyo3(signature = (radiance, exposure=0.0, tone_mapping="neutral"))]
pub fn tone_map<'py>(
    py: Python<'py>,
    radiance: &Bound<'py, PyAny>,
    exposure: f32,
    tone_mapping: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let shown = shown(radiance, exposure, tone_mapping)?;
    arrays::array(py, &srgb8(&shown), "uint8", &[shown.height() as usize, shown.width() as usize, 3])
}

/// The same as a PNG file.
#[pyfunction]
#[pyo3(signature = (radiance, exposure=0.0, tone_mapping="neutral"))]
pub fn png<'py>(
    py: Python<'py>,
    radiance: &Bound<'py, PyAny>,
    exposure: f32,
    tone_mapping: &str,
) -> PyResult<Bound<'py, PyBytes>> {
    encoded(py, &shown(radiance, exposure, tone_mapping)?)
}

/// Reads a picture's radiance.
#[pyfunction]
pub fn read(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let decoded = work::run(py, None, |_| Ok(picture::read(&path)?))?;
    arrays::picture(py, &decoded.image)
}

/// Writes radiance: EXR and HDR as it is, PNG exposed and tone-mapped.
#[pyfunction]
#[pyo3(signature = (path, radiance, exposure=0.0, tone_mapping="neutral"))]
pub fn write(
    py: Python<'_>,
    path: PathBuf,
    radiance: &Bound<'_, PyAny>,
    exposure: f32,
    tone_mapping: &str,
) -> PyResult<()> {
    let is_shown = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    let written = match is_shown {
        true => shown(radiance, exposure, tone_mapping)?,
        false => arrays::to_picture(radiance, "the picture")?,
    };
    work::run(py, None, |_| Ok(picture::write(&path, &written)?))
}

/// How far a picture is from a reference: what `gnomon compare` prints, as a dict.
#[pyfunction]
#[pyo3(signature = (picture, reference, mask=None))]
pub fn compare<'py>(
    py: Python<'py>,
    picture: &Bound<'py, PyAny>,
    reference: &Bound<'py, PyAny>,
    mask: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (picture, reference) =
        (arrays::to_picture(picture, "the picture")?, arrays::to_picture(reference, "the reference")?);
    let mask = mask.map(arrays::to_mask).transpose()?.map(metrics::Mask::from);
    let compared = work::run(py, None, |_| Ok(metrics::compare(&picture, &reference, mask.as_ref())?))?;
    document(py, &compared)
}

/// What the library writes as JSON, as Python's own values: those that a file's reader gets, single precision with all of its digits. A number
/// that JSON lacks is None.
pub fn document<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyDict>> {
    let value = serde_json::to_value(value).map_err(|error| refused(error.to_string()))?;
    Ok(py.import("json")?.call_method1("loads", (value.to_string(),))?.cast_into()?)
}
