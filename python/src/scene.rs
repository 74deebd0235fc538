//! Scenes from dicts, texts, files and names, with overrides.

use crate::convert::{from_toml, to_toml};
use crate::errors::{Origin, exception, scene_error, scene_file_error, scenes_error};
use makadam_compare::scenes;
use makadam_frames::plan;
use makadam_measure::observables::catalogue;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::{Path, PathBuf};

/// A scene: the definition of a simulation, its measurements and comparisons. SI units throughout.
///
/// Args:
///     source: A dict with the keys of a scene's document; the text of a TOML document; the path of a TOML file, or of a folder
///         with a `scene.toml`; or the name of a built-in scene, see `makadam.scenes()`. A text of more than one line is read as a
///         document.
///     overrides: Values that replace those of the source, by their paths: `{"material.grain.friction": 0.3, "population[0].count": 100}`.
///         Missing keys are added; `None` removes a key.
///
/// Raises:
///     makadam.SceneNotFoundError: There is no such file or scene.
///     makadam.SceneError: The scene is invalid; `path` is the location, `problem` the violation, `remedy` the valid input.
#[pyclass(frozen, module = "makadam", name = "Scene", eq)]
#[derive(Clone, Debug)]
pub struct Scene {
    /// Scene with its measurement and comparison tables.
    pub plan: plan::MeasuredScene,
    /// Source file; a name in angle brackets if there is none.
    pub file: PathBuf,
    /// Text of the document.
    pub text: String,
    /// True if the document equals the file.
    pub as_written: bool,
}

/// Equality of plans, independent of their source.
impl PartialEq for Scene {
    fn eq(&self, other: &Scene) -> bool {
        self.plan == other.plan
    }
}

/// Placeholder path of a scene without a file; no record exists next to it.
const NO_FILE: &str = "<scene>/scene.toml";

impl Scene {
    /// Source, for errors.
    pub fn origin(&self) -> Origin<'_> {
        let file = Some(self.file.as_path()).filter(|file| *file != Path::new(NO_FILE));
        Origin { file, text: &self.text, lines: self.as_written }
    }

    fn read(py: Python<'_>, file: Option<PathBuf>, text: String, as_written: bool) -> PyResult<Scene> {
        let origin = Origin { file: file.as_deref(), text: &text, lines: as_written };
        let folder = file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let plan = scenes::plan(&text, folder).map_err(|error| scene_error(py, &error, origin))?;
        let name = file.clone().unwrap_or_else(|| NO_FILE.into());
        catalogue::check(&plan, &text, &name).map_err(|error| scene_file_error(py, &error, Some(origin)))?;
        Ok(Scene { plan, file: name, text, as_written })
    }

    /// Reads a scene from any source.
    pub fn of(source: &Bound<'_, PyAny>) -> PyResult<Scene> {
        match source.cast::<Scene>() {
            Ok(scene) => Ok(scene.get().clone()),
            Err(_) => Scene::new(source, None),
        }
    }

    fn document(&self, py: Python<'_>) -> PyResult<toml::Value> {
        let document = toml::Value::try_from(&self.plan);
        let mut document = document.map_err(|error| exception(py, "SceneError", &error.to_string()))?;
        // Values set by an accuracy are not written again.
        if self.plan.accuracy.is_some()
            && let Some(solver) = document.get_mut("solver").and_then(toml::Value::as_table_mut)
        {
            solver.remove("step");
            solver.remove("stop");
        }
        Ok(document)
    }

    /// Returns the scene with another plan and a new document, so that all results contain the change.
    pub fn with_plan(self, py: Python<'_>, plan: plan::MeasuredScene) -> PyResult<Scene> {
        let scene = Scene { plan, as_written: false, ..self };
        Ok(Scene { text: written(py, &scene.document(py)?)?, ..scene })
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (source, overrides = None))]
    fn new(source: &Bound<'_, PyAny>, overrides: Option<&Bound<'_, PyDict>>) -> PyResult<Scene> {
        let py = source.py();
        let overrides = overrides.filter(|overrides| !overrides.is_empty());
        let (file, text, written) = if let Ok(dict) = source.cast::<PyDict>() {
            (None, written(py, &to_toml(dict, "", 0)?)?, false)
        } else if let Ok(scene) = source.cast::<Scene>() {
            let scene = scene.get();
            let file = scene.origin().file.map(Path::to_path_buf);
            (file, scene.text.clone(), scene.as_written)
        } else if let Some(document) =
            source.cast::<PyString>().ok().map(|text| text.to_string()).filter(|text| text.contains('\n'))
        {
            (None, document, true)
        } else {
            let Ok(name) = source.extract::<PathBuf>() else {
                let what = format!(
                    "no scene of a {}; give a dict, the text of a TOML document, a path or a name",
                    source.get_type()
                );
                return Err(pyo3::exceptions::PyTypeError::new_err(what));
            };
            let name = name.display().to_string();
            let file = scenes::find(&name, &scenes::roots()).map_err(|error| scenes_error(py, &error, None))?;
            let text = scenes::text(&file).map_err(|error| scenes_error(py, &error, None))?;
            (Some(file), text, true)
        };
        let Some(overrides) = overrides else { return Scene::read(py, file, text, written) };
        let parsed: Result<toml::Table, _> = toml::from_str(&text);
        let Ok(table) = parsed else {
            // The scene reader reports the problem in the text.
            return Scene::read(py, file, text, written);
        };
        let mut document = toml::Value::Table(table);
        for (path, value) in overrides {
            let path: String = path.extract()?;
            let value = if value.is_none() { None } else { Some(to_toml(&value, &path, 0)?) };
            put(&mut document, &path, value)
                .map_err(|problem| exception(py, "SceneError", &format!("override {path}: {problem}")))?;
        }
        Scene::read(py, file, self::written(py, &document)?, false)
    }

    /// Returns the scene with replaced values: see `Scene`.
    fn with_overrides(slf: &Bound<'_, Self>, overrides: &Bound<'_, PyDict>) -> PyResult<Scene> {
        Scene::new(slf.as_any(), Some(overrides))
    }

    /// Short name.
    #[getter]
    fn name(&self) -> &str {
        &self.plan.name
    }

    /// Purpose of the scene in one sentence.
    #[getter]
    fn description(&self) -> &str {
        &self.plan.description
    }

    /// Source file; None for a dict or a text.
    #[getter]
    fn file(&self) -> Option<String> {
        self.origin().file.map(|file| file.display().to_string())
    }

    /// Simulated time of a run, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.plan.duration
    }

    /// Time step, s.
    #[getter]
    fn time_step(&self) -> f64 {
        self.plan.solver.step
    }

    /// Default seed of the positions and radii of grains.
    #[getter]
    fn seed(&self) -> u64 {
        self.plan.seed
    }

    /// Acceleration of gravity at the start, m/s2.
    #[getter]
    fn gravity(&self) -> (f64, f64, f64) {
        self.plan.gravity.into()
    }

    /// Number of grains.
    #[getter]
    fn grains(&self) -> usize {
        self.plan.grain_count()
    }

    /// Names of the materials.
    #[getter]
    fn materials(&self) -> Vec<String> {
        self.plan.material.keys().cloned().collect()
    }

    /// Names of the walls, in the order of their numbers in contacts.
    #[getter]
    fn walls(&self) -> Vec<String> {
        self.plan.wall.iter().map(|wall| wall.name.clone()).collect()
    }

    /// Returns the preflight warnings; empty if there are none.
    fn findings(&self) -> Vec<String> {
        let findings = self.plan.findings(self.as_written.then_some(self.text.as_str()));
        findings.iter().map(ToString::to_string).collect()
    }

    /// Returns the scene as a dict with every default value; `Scene(scene.to_dict())` is the same scene.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_toml(py, &self.document(py)?)
    }

    /// Returns the scene as the text of a TOML document with every default value.
    fn to_toml(&self, py: Python<'_>) -> PyResult<String> {
        written(py, &self.document(py)?)
    }

    fn __repr__(&self) -> String {
        format!(
            "<makadam.Scene '{}': {} grains, {} walls, {} s>",
            self.plan.name,
            self.grains(),
            self.plan.wall.len(),
            self.plan.duration
        )
    }

    /// Restores a scene from the data of `__reduce__`.
    #[staticmethod]
    fn _of_parts(py: Python<'_>, text: String, file: Option<PathBuf>, as_written: bool) -> PyResult<Scene> {
        Scene::read(py, file, text, as_written)
    }

    #[allow(clippy::type_complexity)] // What Python's pickle wants.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String, Option<PathBuf>, bool))> {
        let scene = slf.get();
        let file = scene.origin().file.map(Path::to_path_buf);
        Ok((slf.get_type().getattr("_of_parts")?, (scene.text.clone(), file, scene.as_written)))
    }

    fn __hash__(&self) -> u64 {
        makadam_frames::provenance::scene_hash(&self.plan)
    }
}

/// Returns the text of a document.
fn written(py: Python<'_>, document: &toml::Value) -> PyResult<String> {
    let text = toml::to_string(document).map_err(|error| exception(py, "SceneError", &error.to_string()))?;
    Ok(text + "\n")
}

/// Sets or removes a value at a path of a document.
fn put(document: &mut toml::Value, path: &str, value: Option<toml::Value>) -> Result<(), String> {
    let steps: Vec<String> = path.replace('[', ".").replace(']', "").split('.').map(String::from).collect();
    let Some((last, above)) = steps.split_last().filter(|_| steps.iter().all(|step| !step.is_empty())) else {
        return Err("is no path; give one such as material.grain.friction or population[0].count".into());
    };
    let mut place = document;
    for step in above {
        place = match place {
            toml::Value::Table(table) => {
                table.entry(step.clone()).or_insert_with(|| toml::Value::Table(toml::Table::new()))
            }
            toml::Value::Array(array) => item(array, step)?,
            _ => return Err(format!("there is nothing below '{step}'")),
        };
    }
    match (place, value) {
        (toml::Value::Table(table), Some(value)) => {
            table.insert(last.clone(), value);
        }
        (toml::Value::Table(table), None) => {
            table.remove(last).ok_or_else(|| format!("'{last}' is not there to be removed"))?;
        }
        (toml::Value::Array(array), Some(value)) => *item(array, last)? = value,
        (toml::Value::Array(array), None) => {
            item(array, last)?;
            array.remove(last.parse().unwrap_or_default());
        }
        _ => return Err(format!("'{last}' lies in what is neither a table nor a list")),
    }
    Ok(())
}

fn item<'a>(array: &'a mut [toml::Value], step: &str) -> Result<&'a mut toml::Value, String> {
    let items = array.len();
    let index: usize = step.parse().map_err(|_| format!("'{step}' is no number, and a list of {items} lies there"))?;
    array.get_mut(index).ok_or_else(|| format!("there is no {index}: the list has {items} entries, counted from 0"))
}

/// Names of the built-in scenes, and of those in a folder `reference-scenes` here or above, sorted.
#[pyfunction(name = "scenes")]
pub fn known() -> Vec<String> {
    scenes::known(&scenes::roots())
}
