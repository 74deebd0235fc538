//! The judge: recordings, observables, comparison with the peers.

use crate::convert::plain;
use crate::errors::exception;
use crate::frame::Frame;
use crate::scene::Scene;
use crate::stepping::beside;
use makadam_validation::compare::{CodeRuns, Harvest, Reference, comparison};
use makadam_validation::observables::{catalogue, measure, measure_frames, series};
use makadam_validation::peers::{Code, CodeError, Job, Lammps, Liggghts, Makadam, Yade};
use makadam_validation::provenance::{Build, utc};
use makadam_validation::qualify::OneScene;
use makadam_validation::recording;
use makadam_validation::report::Qualification;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

/// One run of a scene: its frames, and where they came from. `makadam.simulate` makes them, and `Recording.load` reads them.
///
/// Args:
///     scene: What is simulated and measured.
///     frames: Frames in the order of time, the last one at the end of the run.
///     seed: Seed of the run.
///     wall_seconds: Wall time of the steps, s.
///     time_step: Time step, s; that of the scene where none is given.
#[pyclass(frozen, module = "makadam", name = "Recording")]
pub struct Recording {
    scene: Scene,
    recording: Arc<recording::Recording>,
}

#[pymethods]
impl Recording {
    #[new]
    #[pyo3(signature = (scene, frames, seed=1, wall_seconds=0.0, time_step=None))]
    fn new(
        scene: &Bound<'_, PyAny>,
        frames: Vec<PyRef<'_, Frame>>,
        seed: u64,
        wall_seconds: f64,
        time_step: Option<f64>,
    ) -> PyResult<Recording> {
        let py = scene.py();
        let scene = Scene::of(scene)?;
        let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
            return Err(exception(py, "JudgeError", "a recording needs at least one frame"));
        };
        let recording = recording::Recording {
            scene: scene.plan.name.clone(),
            code: "Makadam".into(),
            version: Build::here().summary(),
            seed,
            time_step: time_step.unwrap_or(scene.plan.solver.step),
            rayleigh_fraction: None,
            stiffness_factor: 1.0,
            threads: 1,
            wall_seconds,
            simulated_seconds: (last.0.time - first.0.time).max(f64::MIN_POSITIVE),
            frames: frames.iter().map(|frame| (*frame.0).clone()).collect(),
            lacks: Vec::new(),
            alarms: Vec::new(),
        };
        Ok(Recording { scene, recording: Arc::new(recording) })
    }

    /// Reads a recording from a file that `save`, or `makadam` itself, has written.
    ///
    /// Raises:
    ///     makadam.Error: The file cannot be read, or is damaged.
    #[staticmethod]
    fn load(scene: &Bound<'_, PyAny>, file: PathBuf) -> PyResult<Recording> {
        let py = scene.py();
        let recording =
            recording::Recording::load(&file).map_err(|error| exception(py, "JudgeError", &error.to_string()))?;
        Ok(Recording { scene: Scene::of(scene)?, recording: Arc::new(recording) })
    }

    /// Writes the recording to a file, with a seal by which damage is seen.
    fn save(&self, py: Python<'_>, file: PathBuf) -> PyResult<()> {
        self.recording.save(&file).map_err(|error| exception(py, "JudgeError", &error.to_string()))
    }

    /// The scene.
    #[getter]
    fn scene(&self) -> Scene {
        self.scene.clone()
    }

    /// The code that was run: Makadam, YADE or LIGGGHTS.
    #[getter]
    fn code(&self) -> &str {
        &self.recording.code
    }

    /// Seed of the positions and radii at the start.
    #[getter]
    fn seed(&self) -> u64 {
        self.recording.seed
    }

    /// Time step, s.
    #[getter]
    fn time_step(&self) -> f64 {
        self.recording.time_step
    }

    /// Wall time of the steps, s.
    #[getter]
    fn wall_seconds(&self) -> f64 {
        self.recording.wall_seconds
    }

    /// Frames, in the order of time.
    #[getter]
    fn frames(&self) -> Vec<Frame> {
        self.recording.frames.iter().cloned().map(Frame::of).collect()
    }

    /// What the scene measures of the frames from `measure.from` on: a list of rows, each a dict of `observable`, `unit`, `value`,
    /// `standard_error` (within the run, over blocks of time; None for too few frames) and `frames`. What cannot be measured is left out.
    fn measure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let measured = py.detach(|| measure(&self.scene.plan, &self.recording));
        plain(py, &measured)
    }

    /// Observables over time, a list of dicts of `observable`, `time` (s) and `value`, one point a frame: the dynamic angle of repose
    /// (degrees) where the scene measures it.
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let found = py.detach(|| series(&self.scene.plan, &self.recording));
        plain(py, &found)
    }

    fn __repr__(&self) -> String {
        let recording::Recording { scene, code, seed, frames, .. } = &*self.recording;
        format!("<makadam.Recording of {scene} by {code}, seed {seed}: {} frames>", frames.len())
    }
}

/// Why a code gave nothing, as an exception.
fn code_error(py: Python<'_>, error: &CodeError) -> PyErr {
    match error {
        CodeError::Scene(error) => crate::errors::scenes_error(py, error, None),
        CodeError::Execution(error) => crate::errors::setting_error(py, error),
        CodeError::Worthless { .. } => exception(py, "WorthlessError", &error.to_string()),
        CodeError::Interrupted { .. } => exception(py, "Interrupted", &error.to_string()),
        _ => exception(py, "JudgeError", &error.to_string()),
    }
}

fn code_of(py: Python<'_>, name: &str) -> PyResult<Box<dyn Code + Send>> {
    Ok(match name.to_lowercase().as_str() {
        "makadam" => Box::new(Makadam),
        "yade" => Box::new(Yade::default()),
        "liggghts" => Box::new(Liggghts::default()),
        "lammps" => Box::new(Lammps::default()),
        _ => {
            let message = format!("no code '{name}': give makadam, yade, liggghts or lammps");
            return Err(exception(py, "JudgeError", &message));
        }
    })
}

/// Runs a scene from its start to its end in one code, on one core, and keeps a frame each `measure.interval`.
///
/// Args:
///     scene: A scene, or what `makadam.Scene` takes.
///     seed: Seed of the positions and radii; the scene's where none is given.
///     code: `makadam`, `yade`, `liggghts` or `lammps`; other codes than Makadam where they are installed.
///     rayleigh_fraction: Time step of the explicit codes over the Rayleigh step.
///     time_limit: Wall time after which another code is stopped, s.
///
/// Raises:
///     makadam.JudgeError: The code is not installed, cannot express the scene or failed.
///     makadam.WorthlessError: The run came to a state that makes its numbers worthless.
#[pyfunction]
#[pyo3(signature = (scene, seed=None, *, code="makadam", rayleigh_fraction=0.2, time_limit=86400.0))]
pub fn simulate(
    scene: &Bound<'_, PyAny>,
    seed: Option<u64>,
    code: &str,
    rayleigh_fraction: f64,
    time_limit: f64,
) -> PyResult<Recording> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    let code = code_of(py, code)?;
    if code.version().is_none() {
        return Err(code_error(py, &CodeError::Missing { code: code.name() }));
    }
    let work_folder = std::env::temp_dir().join(format!("makadam-{}", std::process::id()));
    let seed = seed.unwrap_or(scene.plan.seed);
    let limit = Duration::try_from_secs_f64(time_limit)
        .map_err(|error| exception(py, "JudgeError", &format!("time_limit {time_limit}: {error}")))?;
    let recorded = beside(py, || {
        code.simulate(&Job {
            scene: &scene.plan,
            scene_file: &scene.file,
            seed,
            stiffness_factor: 1.0,
            rayleigh_fraction,
            work_folder: &work_folder,
            time_limit: limit,
            progress: &|_| {},
        })
    })?;
    let recording = recorded.map_err(|error| code_error(py, &error))?;
    Ok(Recording { scene, recording: Arc::new(recording) })
}

/// What a scene measures of frames: see `Recording.measure`; all frames that are given count.
#[pyfunction]
#[pyo3(name = "_measure")]
pub fn measure_of_frames<'py>(
    scene: &Bound<'py, PyAny>,
    frames: Vec<PyRef<'py, Frame>>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    let snapshots: Vec<_> = frames.iter().map(|frame| frame.0.clone()).collect();
    let measured = py.detach(|| {
        let frames: Vec<_> = snapshots.iter().map(|snapshot| &**snapshot).collect();
        let Ok(measured) = measure_frames(&scene.plan, &frames[..]);
        measured
    });
    plain(py, &measured.unwrap_or_default())
}

/// Names of all observables, and the group of each, as `measure.observables` of a scene names it.
#[pyfunction]
pub fn observables(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let found = PyDict::new(py);
    for name in catalogue::known() {
        found.set_item(name, catalogue::group_of(name).map(|(_, group)| group))?;
    }
    Ok(found)
}

/// What is recorded of the peers on a scene: rows, each a dict of code, seed, observable, value and its standard error within the run.
#[pyfunction]
#[pyo3(name = "_reference")]
pub fn reference<'py>(scene: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyList>> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    let found = Reference::of_scene(&scene.file).map_err(|error| exception(py, "JudgeError", &error.to_string()))?;
    let rows = PyList::empty(py);
    let Some(found) = found else { return Ok(rows) };
    for runs in found.codes().iter().filter_map(|code| found.code(code)) {
        for run in &runs.runs {
            for measured in &run.measurements {
                let row = PyDict::new(py);
                row.set_item("code", &run.code)?;
                row.set_item("version", &run.version)?;
                row.set_item("seed", run.seed)?;
                row.set_item("observable", &measured.observable)?;
                row.set_item("unit", &measured.unit)?;
                row.set_item("value", measured.value)?;
                row.set_item("standard_error", measured.standard_error)?;
                row.set_item("frames", measured.frames)?;
                rows.append(row)?;
            }
        }
    }
    Ok(rows)
}

/// A comparison as a dict of rows, codes, notes and the verdict.
fn document<'py>(py: Python<'py>, qualification: &Qualification) -> PyResult<Bound<'py, PyDict>> {
    let comparison = &qualification.comparisons[0];
    let found = PyDict::new(py);
    found.set_item("rows", plain(py, &comparison.rows)?)?;
    found.set_item("codes", plain(py, &comparison.codes)?)?;
    found.set_item("notes", plain(py, &comparison.notes)?)?;
    found.set_item("verdict", plain(py, &qualification.verdict())?)?;
    Ok(found)
}

/// Runs a scene in several codes, or takes what is recorded of the peers, and compares.
#[pyfunction]
#[pyo3(name = "_compare")]
pub fn compare<'py>(
    scene: &Bound<'py, PyAny>,
    codes: Vec<String>,
    live: bool,
    seeds: Option<u64>,
    rayleigh_fraction: f64,
    time_limit: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    let limit = Duration::try_from_secs_f64(time_limit)
        .map_err(|error| exception(py, "JudgeError", &format!("time_limit {time_limit}: {error}")))?;
    let mut asked: Vec<Box<dyn Code + Send>> = Vec::new();
    for code in &codes {
        asked.push(code_of(py, code)?);
    }
    let judged = beside(py, || {
        let codes = asked.into_iter().map(|code| code as Box<dyn Code>).collect();
        OneScene {
            scene: &scene.plan,
            scene_file: &scene.file,
            codes,
            judged: "Makadam",
            live,
            seeds,
            rayleigh_fraction,
            time_limit: limit,
            announce: &|_| Box::new(|_| {}),
        }
        .judge()
        .map_err(|error| error.to_string())
    })?;
    let judged = judged.map_err(|message| exception(py, "JudgeError", &message))?;
    match &judged.failure {
        Some(failure) => Err(code_error(py, failure)),
        None => document(py, &judged.qualification),
    }
}

/// Compares runs that were made here with what is recorded of the peers.
#[pyfunction]
#[pyo3(name = "_compare_runs")]
pub fn compare_runs<'py>(
    scene: &Bound<'py, PyAny>,
    runs: Vec<PyRef<'py, Recording>>,
    codes: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    if scene.plan.compare.is_empty() {
        let message = format!("{} names nothing to compare; add observables under [[compare]]", scene.plan.name);
        return Err(exception(py, "JudgeError", &message));
    }
    let found = Reference::of_scene(&scene.file).map_err(|error| exception(py, "JudgeError", &error.to_string()))?;
    let recordings: Vec<_> = runs.iter().map(|run| run.recording.clone()).collect();
    let harvests = py.detach(|| {
        recordings.iter().map(|run| Harvest::of(&scene.plan, run, utc(SystemTime::now()))).collect::<Vec<_>>()
    });
    let name = recordings.first().map_or("Makadam", |run| run.code.as_str());
    let mut measured =
        vec![CodeRuns { provenance: "runs that the caller made".into(), ..CodeRuns::live(name, 1, harvests) }];
    let mut notes = Vec::new();
    for code in codes.iter().filter(|code| !code.eq_ignore_ascii_case("makadam")) {
        let code = code_of(py, code)?.name();
        let Some(recorded) = found.as_ref().and_then(|reference| reference.code(code)) else {
            let message = format!("nothing is recorded of {code} on the scene {}; leave it out", scene.plan.name);
            return Err(exception(py, "JudgeError", &message));
        };
        notes.push(format!("{code} was not run: its numbers are the recorded references ({})", recorded.provenance));
        if found.as_ref().and_then(|reference| reference.is_current(code, &scene.plan)) == Some(false) {
            notes.push(format!("the scene is not the one that {code} was recorded on"));
        }
        measured.push(recorded);
    }
    document(
        py,
        &Qualification {
            title: format!("Comparison of codes on the scene {}", scene.plan.name),
            tier: "compare".into(),
            comparisons: vec![comparison(&scene.plan, &measured, notes)],
            wall_seconds: 0.0,
            provenance: Default::default(),
            notes: Vec::new(),
            outside_spread: Vec::new(),
            unchecked: Vec::new(),
            laws: Vec::new(),
        },
    )
}
