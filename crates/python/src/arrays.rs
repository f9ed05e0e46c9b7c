//! Arrays in and out. Whatever numpy takes is taken: its own arrays, DLPack's, nested lists.

use glam::{Mat4, Vec2, Vec3, Vec4};
use gnomon::picture::RgbImage;
use gnomon_messages::one_line;
use pyo3::buffer::{Element, PyBuffer};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::error::refused;

/// An array of numpy over a copy of `bytes`: the only one that is made.
pub fn array<'py>(
    py: Python<'py>,
    bytes: &[u8],
    dtype: &str,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    // Of a bytearray, so that it can be written.
    let flat = py.import("numpy")?.call_method1("frombuffer", (PyByteArray::new(py, bytes), dtype))?;
    flat.call_method1("reshape", (shape.to_vec(),))
}

/// An empty picture stays one: `frombuffer` refuses no bytes.
pub fn floats<'py>(py: Python<'py>, values: &[f32], shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    if values.is_empty() {
        return py.import("numpy")?.call_method1("zeros", (shape.to_vec(), "float32"));
    }
    array(py, bytemuck::cast_slice(values), "float32", shape)
}

/// Corners of triangles: int64 (n, 3).
pub fn indices<'py>(py: Python<'py>, triangles: &[[u32; 3]]) -> PyResult<Bound<'py, PyAny>> {
    let corners: Vec<i64> = triangles.iter().flatten().map(|&corner| i64::from(corner)).collect();
    if corners.is_empty() {
        return py.import("numpy")?.call_method1("zeros", ((0, 3), "int64"));
    }
    array(py, bytemuck::cast_slice(&corners), "int64", &[triangles.len(), 3])
}

/// A picture: float32 (height, width, 3).
pub fn picture<'py>(py: Python<'py>, picture: &RgbImage) -> PyResult<Bound<'py, PyAny>> {
    let shape = [picture.height() as usize, picture.width() as usize, 3];
    floats(py, bytemuck::cast_slice(picture.texels()), &shape)
}

/// A matrix as numpy has it, by rows: float32 (4, 4).
pub fn matrix<'py>(py: Python<'py>, matrix: Mat4) -> PyResult<Bound<'py, PyAny>> {
    floats(py, &matrix.transpose().to_cols_array(), &[4, 4])
}

/// The numbers of an array of this type with rows of `width`, and how many rows there are; `what` names it in the error.
fn rows<T: Element>(
    array: &Bound<'_, PyAny>,
    dtype: &str,
    width: usize,
    what: &str,
) -> PyResult<(Vec<T>, Vec<usize>)> {
    let py = array.py();
    let numpy = py.import("numpy")?;
    let array = match array.hasattr("__dlpack__")? && !array.hasattr("__array__")? {
        true => numpy.call_method1("from_dlpack", (array,)),
        false => Ok(array.clone()),
    };
    let array = array.and_then(|array| numpy.call_method1("ascontiguousarray", (array, dtype)));
    let array = array.map_err(|error| {
        refused(format!("{what} must be an array of numbers: {}", one_line(&error.to_string())))
    })?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if shape.len() < 2 || shape.last() != Some(&width) {
        return Err(refused(format!("{what} must be an array (..., {width}), not {shape:?}")));
    }
    if shape.contains(&0) {
        return Ok((Vec::new(), shape));
    }
    Ok((PyBuffer::<T>::get(&array)?.to_vec(py)?, shape))
}

fn finite(values: &[f32], what: &str) -> PyResult<()> {
    match values.iter().all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err(refused(format!("{what} must be finite"))),
    }
}

/// An array (height, width, 3) as a picture.
pub fn to_picture(array: &Bound<'_, PyAny>, what: &str) -> PyResult<RgbImage> {
    let (values, shape) = rows::<f32>(array, "float32", 3, what)?;
    let texels = values.chunks_exact(3).map(Vec3::from_slice).collect();
    let picture = match *shape.as_slice() {
        [height, width, 3] => {
            let sides = u32::try_from(width).ok().zip(u32::try_from(height).ok());
            sides.and_then(|(width, height)| RgbImage::from_texels(width, height, texels))
        }
        _ => None,
    };
    picture.ok_or_else(|| refused(format!("{what} must be an array (height, width, 3), not {shape:?}")))
}

/// An array (n, 3) of finite numbers.
pub fn vectors(array: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<Vec3>> {
    let (values, _) = rows::<f32>(array, "float32", 3, what)?;
    finite(&values, what)?;
    Ok(values.chunks_exact(3).map(Vec3::from_slice).collect())
}

/// An array (n, 2) of finite numbers.
pub fn pairs(array: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<Vec2>> {
    let (values, _) = rows::<f32>(array, "float32", 2, what)?;
    finite(&values, what)?;
    Ok(values.chunks_exact(2).map(Vec2::from_slice).collect())
}

/// An array (n, 3) of colours, none negative, with alpha 1.
pub fn colors(array: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<Vec4>> {
    let colors = vectors(array, what)?;
    match colors.iter().all(|color| color.min_element() >= 0.0) {
        true => Ok(colors.into_iter().map(|color| color.extend(1.0)).collect()),
        false => Err(refused(format!("{what} must not be negative"))),
    }
}

/// An array (n, 3) of indices below `count`.
pub fn triangles(array: &Bound<'_, PyAny>, count: usize, what: &str) -> PyResult<Vec<[u32; 3]>> {
    let (values, _) = rows::<i64>(array, "int64", 3, what)?;
    let index =
        |value: i64| usize::try_from(value).ok().filter(|index| *index < count).map(|index| index as u32);
    let triangle = |corners: &[i64]| Some([index(corners[0])?, index(corners[1])?, index(corners[2])?]);
    let triangles: Option<Vec<_>> = values.chunks_exact(3).map(triangle).collect();
    triangles.ok_or_else(|| refused(format!("{what} must be indices of the {count} vertices, from 0")))
}

/// A matrix (4, 4) of finite numbers, by rows.
pub fn to_matrix(array: &Bound<'_, PyAny>, what: &str) -> PyResult<Mat4> {
    let (values, shape) = rows::<f32>(array, "float32", 4, what)?;
    let cells: [f32; 16] =
        values.try_into().map_err(|_| refused(format!("{what} must be a matrix (4, 4), not {shape:?}")))?;
    finite(&cells, what)?;
    let matrix = Mat4::from_cols_array(&cells).transpose();
    match matrix.row(3) == Vec4::W {
        true => Ok(matrix),
        false => Err(refused(format!("the last row of {what} must be 0, 0, 0, 1"))),
    }
}

/// An array (height, width) of which what is true counts.
pub fn to_mask(array: &Bound<'_, PyAny>) -> PyResult<gnomon::picture::Mask> {
    let py = array.py();
    let bools = py.import("numpy")?.call_method1("ascontiguousarray", (array, "bool"))?;
    let shape: Vec<usize> = bools.getattr("shape")?.extract()?;
    let [height, width] = *shape.as_slice() else {
        return Err(refused(format!("a mask must be an array (height, width), not {shape:?}")));
    };
    let bytes = bools.call_method0("tobytes")?;
    let inside = bytes.extract::<&[u8]>()?.iter().map(|&byte| byte != 0).collect();
    let [width, height] = [width, height].map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    Ok(gnomon::picture::Mask { width, height, inside })
}
