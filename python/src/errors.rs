//! Conversion of errors of the solver and the validation to Python exceptions, defined in `makadam/errors.py`.

use makadam::SettingError;
use makadam::scene::{SceneError, SceneFileError};
use makadam_compare::prepared::StartError;
use makadam_compare::scenes;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::Path;

/// Creates an exception of `makadam.errors`, by the name of its class.
pub fn exception(py: Python<'_>, class: &str, message: &str) -> PyErr {
    with_details(py, class, message, |_| Ok(()))
}

/// Warns the caller, with the class of the package's warnings.
pub fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    let class = py.import("makadam.errors")?.getattr("MakadamWarning")?;
    py.import("warnings")?.call_method1("warn", (message, class, 2)).map(|_| ())
}

/// Builds an exception with attributes.
fn with_details(
    py: Python<'_>,
    class: &str,
    message: &str,
    fill: impl FnOnce(&Bound<'_, PyDict>) -> PyResult<()>,
) -> PyErr {
    let made = || -> PyResult<PyErr> {
        let class = py.import("makadam.errors")?.getattr(class)?;
        let details = PyDict::new(py);
        fill(&details)?;
        Ok(PyErr::from_value(class.call((message,), Some(&details))?))
    };
    made().unwrap_or_else(|error| error)
}

/// Source of a scene, for its errors.
#[derive(Clone, Copy)]
pub struct Origin<'a> {
    /// Source file, if any.
    pub file: Option<&'a Path>,
    /// Text of the document.
    pub text: &'a str,
    /// True if a person wrote the text, so that line numbers help.
    pub lines: bool,
}

/// Converts an invalid scene to an exception.
pub fn scene_error(py: Python<'_>, error: &SceneError, origin: Origin<'_>) -> PyErr {
    let SceneError::Invalid(fault) = error else {
        return exception(py, "SceneError", &error.to_string());
    };
    let (problem, remedy) = fault.in_words();
    let line = fault.line(origin.text);
    let place = match fault.place() {
        place if place.is_empty() => place_at(origin.text, line),
        place => place,
    };
    described(py, &place, &problem, &remedy, Some(line), origin)
}

/// Converts an error of reading a scene file.
pub fn scene_file_error(py: Python<'_>, error: &SceneFileError, origin: Option<Origin<'_>>) -> PyErr {
    match (error, origin) {
        (SceneFileError::Invalid { line, problem, remedy, .. }, Some(origin)) => {
            let place = line.map_or_else(String::new, |line| place_at(origin.text, line));
            described(py, &place, problem, remedy, *line, origin)
        }
        (SceneFileError::Missing { .. }, _) => exception(py, "SceneNotFoundError", &error.to_string()),
        _ => exception(py, "SceneError", &error.to_string()),
    }
}

/// Converts an error of finding a scene.
pub fn scenes_error(py: Python<'_>, error: &scenes::SceneError, origin: Option<Origin<'_>>) -> PyErr {
    match error {
        scenes::SceneError::Unknown { .. } => exception(py, "SceneNotFoundError", &error.to_string()),
        scenes::SceneError::File(error) => scene_file_error(py, error, origin),
        scenes::SceneError::Change(_) => exception(py, "SceneError", &error.to_string()),
    }
}

fn described(
    py: Python<'_>,
    place: &str,
    problem: &str,
    remedy: &str,
    line: Option<usize>,
    origin: Origin<'_>,
) -> PyErr {
    let line = line.filter(|_| origin.lines);
    let head = match (origin.file, line) {
        (Some(file), Some(line)) => format!("{}:{line}: ", file.display()),
        (Some(file), None) => format!("{}: ", file.display()),
        (None, Some(line)) => format!("line {line}: "),
        (None, None) => String::new(),
    };
    // The text reader does not state the location itself.
    let named = if place.is_empty() || problem.starts_with(place) { String::new() } else { format!("{place}: ") };
    with_details(py, "SceneError", &format!("{head}{named}{problem}; {remedy}"), |details| {
        details.set_item("path", place)?;
        details.set_item("line", line)?;
        details.set_item("file", origin.file.map(|file| file.display().to_string()))?;
        details.set_item("problem", problem)?;
        details.set_item("remedy", remedy)
    })
}

/// Path of the key in a line of a document, such as `wall[0].motion`; empty for a line without a key.
fn place_at(text: &str, line: usize) -> String {
    let Ok(document) = toml::de::DeTable::parse(text) else { return String::new() };
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let end = start + text[start..].find('\n').unwrap_or(text.len() - start);
    let mut best = (0, String::new());
    look(document.get_ref(), "", [start, end], &mut best);
    best.1
}

/// Finds the deepest key that begins in a stretch of a text.
fn look(table: &toml::de::DeTable<'_>, above: &str, [start, end]: [usize; 2], best: &mut (usize, String)) {
    for (key, value) in table {
        let dot = if above.is_empty() { "" } else { "." };
        let path = format!("{above}{dot}{}", key.get_ref());
        note(key.span().start, &path, [start, end], best);
        within(value.get_ref(), &path, [start, end], best);
    }
}

fn note(at: usize, path: &str, [start, end]: [usize; 2], best: &mut (usize, String)) {
    if at >= start && at <= end && path.len() > best.1.len() {
        *best = (at, path.to_string());
    }
}

fn within(value: &toml::de::DeValue<'_>, path: &str, stretch: [usize; 2], best: &mut (usize, String)) {
    match value {
        toml::de::DeValue::Table(table) => look(table, path, stretch, best),
        toml::de::DeValue::Array(array) => {
            for (index, item) in array.iter().enumerate() {
                let path = format!("{path}[{index}]");
                if item.get_ref().is_table() {
                    note(item.span().start, &path, stretch, best);
                }
                within(item.get_ref(), &path, stretch, best);
            }
        }
        _ => {}
    }
}

/// Converts a setting that the machine or the scene does not support to an exception.
pub fn setting_error(py: Python<'_>, error: &SettingError) -> PyErr {
    exception(py, "SettingError", &error.to_string())
}

/// Converts an error of starting a run.
pub fn start_error(py: Python<'_>, error: &StartError, origin: Origin<'_>) -> PyErr {
    match error {
        StartError::Scene(error) => scenes_error(py, error, Some(origin)),
        StartError::Execution(error) => setting_error(py, error),
        StartError::InvalidState(_) => exception(py, "InvalidStateError", &error.to_string()),
        StartError::Interrupted => exception(py, "Interrupted", &error.to_string()),
        StartError::Write(_) | StartError::Checkpoint(_) => exception(py, "Error", &error.to_string()),
    }
}
