//! Keyword arguments as the library's options: every option of `gnomon render` is one, its dashes underscores.

use gnomon::options::{Given, OptionSpec, OptionValue, Options, specs};
use gnomon_messages::quoted;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

use crate::error::{raised, refused};

/// What somebody gave of the options of `T`, each by the name that `called` gives it.
pub fn given<T: Options + Default>(
    keywords: Option<&Bound<'_, PyDict>>,
    called: fn(&OptionSpec) -> String,
) -> PyResult<Given> {
    let specs = specs::<T>();
    let mut given = Given::default();
    for (key, value) in keywords.into_iter().flatten() {
        let key: String = key.extract()?;
        let is_meant = |spec: &&&OptionSpec| {
            called(spec) == key || spec.alias.is_some_and(|alias| alias.replace('-', "_") == key)
        };
        let spec = *specs.iter().find(is_meant).ok_or_else(|| unknown(&key, &specs, called))?;
        if spec
            .excludes
            .is_some_and(|other| specs.iter().any(|spec| spec.key == other && given.has(&spec.name())))
        {
            let other = spec.excludes.unwrap_or_default();
            return Err(refused(format!("`{key}` and `{other}` exclude each other")));
        }
        match value.cast::<PyString>() {
            Ok(text) => given.parse(spec, text.to_str()?),
            Err(_) => given.put(spec, option_value(&key, &value)?),
        }
        .map_err(raised)?;
    }
    Ok(given)
}

/// Its name on the command line, as Python writes it.
pub fn flag(spec: &OptionSpec) -> String {
    spec.name().replace('-', "_")
}

/// Its key in a scene file.
pub fn key(spec: &OptionSpec) -> String {
    spec.key.to_owned()
}

fn unknown(key: &str, specs: &[&'static OptionSpec], called: fn(&OptionSpec) -> String) -> PyErr {
    let known: Vec<String> = specs.iter().map(|spec| called(spec)).filter(|name| !name.is_empty()).collect();
    refused(format!("there is no option `{}`; there are: {}", quoted(key), known.join(", ")))
}

fn option_value(key: &str, value: &Bound<'_, PyAny>) -> PyResult<OptionValue> {
    if value.is_none() {
        return Ok(OptionValue::Automatic);
    }
    if let Ok(value) = value.cast::<PyBool>() {
        return Ok(OptionValue::Bool(value.is_true()));
    }
    if let Ok(value) = value.extract::<i64>() {
        return Ok(OptionValue::Whole(value));
    }
    if let Ok(value) = value.extract::<f32>() {
        return Ok(OptionValue::Number(value));
    }
    if let Ok(value) = value.extract::<[u32; 2]>() {
        return Ok(OptionValue::Size(value));
    }
    if let Ok(value) = value.extract::<[f32; 3]>() {
        return Ok(OptionValue::Color(value));
    }
    let kind = value.get_type().name()?;
    Err(refused(format!(
        "`{key}` cannot be a {kind}: it is a number, a text, a bool, None, a size or a color"
    )))
}
