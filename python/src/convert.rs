//! Conversion between Python values, TOML values, and other values that serde can write.

use crate::errors::exception;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use toml::Value as Toml;

/// Maximum nesting depth of a document.
const DEEPEST: usize = 32;

/// Converts a Python value to a TOML value; `place` is its path, for errors. NumPy numbers and arrays are converted to plain
/// values, and keys with the value `None` are omitted.
pub fn to_toml(value: &Bound<'_, PyAny>, place: &str, depth: usize) -> PyResult<Toml> {
    let py = value.py();
    let refuse = |what: String| Err(exception(py, "SceneError", &format!("{place}: {what}")));
    if depth > DEEPEST {
        return refuse("is nested too deeply; a scene is a dict of numbers, texts, lists and dicts".into());
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Toml::Boolean(flag.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        return match value.extract::<i64>() {
            Ok(number) => Ok(Toml::Integer(number)),
            Err(_) => refuse(format!("{value} is too large for a whole number of 64 bits")),
        };
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Toml::Float(value.extract()?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Toml::String(text.to_str()?.to_string()));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        let mut table = toml::Table::new();
        for (key, item) in dict {
            let Ok(key) = key.extract::<String>() else {
                return refuse(format!("the key {key} is no text"));
            };
            if !item.is_none() {
                let dot = if place.is_empty() { "" } else { "." };
                table.insert(key.clone(), to_toml(&item, &format!("{place}{dot}{key}"), depth + 1)?);
            }
        }
        return Ok(Toml::Table(table));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter()?.enumerate();
        let read = |(index, item): (usize, PyResult<Bound<'_, PyAny>>)| {
            to_toml(&item?, &format!("{place}[{index}]"), depth + 1)
        };
        return items.map(read).collect::<PyResult<_>>().map(Toml::Array);
    }
    // NumPy arrays and numbers.
    if value.hasattr("tolist")? {
        return to_toml(&value.call_method0("tolist")?, place, depth + 1);
    }
    refuse(format!(
        "a value of type {} has no place in a scene; give numbers, texts, lists and dicts",
        value.get_type()
    ))
}

/// Converts a TOML value to a Python value.
pub fn from_toml<'py>(py: Python<'py>, value: &Toml) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Toml::Boolean(flag) => PyBool::new(py, *flag).to_owned().into_any(),
        Toml::Integer(number) => number.into_pyobject(py)?.into_any(),
        Toml::Float(number) => PyFloat::new(py, *number).into_any(),
        Toml::String(text) => PyString::new(py, text).into_any(),
        Toml::Datetime(time) => PyString::new(py, &time.to_string()).into_any(),
        Toml::Array(items) => {
            let items = items.iter().map(|item| from_toml(py, item)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, items)?.into_any()
        }
        Toml::Table(table) => {
            let dict = PyDict::new(py);
            for (key, item) in table {
                dict.set_item(key, from_toml(py, item)?)?;
            }
            dict.into_any()
        }
    })
}

/// Converts a serialisable value to a Python value; dicts retain the order of their keys.
pub fn plain<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(|error| exception(py, "Error", &error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}
