//! Recordings and their measurements.

use crate::convert::plain;
use crate::errors::{exception, warn};
use crate::frame::{Frame, check_frames, snapshots};
use crate::pictures::{Frames, PageRequest, PictureRequest};
use crate::scene::Scene;
use crate::settings::{Whole, seed_of};
use crate::stepping::beside;
use makadam::scene::populate;
use makadam::snapshot::Snapshot;
use makadam_compare::codes::{CodeError, CodeName, Job, Purpose};
use makadam_frames::output::{file_stem, run_folder};
use makadam_frames::provenance::Build;
use makadam_frames::recording;
use makadam_measure::observables::{catalogue, measure, measure_frames, series};
use numpy::PyArray3;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Run of a scene: its frames and their origin. Made by `makadam.simulate`, or read by `Recording.load`.
///
/// Args:
///     scene: Simulated and measured scene.
///     frames: Frames in the order of time, the last one at the end of the run.
///     seed: Seed of the run, `simulation.seed`; defaults to the scene's seed. Radii drawn by a scene must be those of the seed.
///     wall_seconds: Wall time of the steps, s.
///     time_step: Time step, s; defaults to that of the scene.
#[pyclass(frozen, module = "makadam", name = "Recording")]
pub struct Recording {
    pub scene: Scene,
    pub recording: Arc<recording::Recording>,
}

#[pymethods]
impl Recording {
    #[new]
    #[pyo3(signature = (scene, frames, seed=None, wall_seconds=0.0, time_step=None))]
    fn new(
        scene: &Bound<'_, PyAny>,
        frames: Vec<PyRef<'_, Frame>>,
        seed: Option<Whole>,
        wall_seconds: f64,
        time_step: Option<f64>,
    ) -> PyResult<Recording> {
        let py = scene.py();
        let scene = Scene::of(scene)?;
        let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
            return Err(exception(py, "JudgeError", "a recording needs at least one frame"));
        };
        check_frames(py, &scene, &snapshots(&frames))?;
        let seed = seed_of(py, seed)?.unwrap_or(scene.plan.seed);
        check_seed(&scene, seed, &first.0).map_err(|problem| exception(py, "JudgeError", &problem))?;
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
            core_seconds: None,
            simulated_seconds: (last.0.time - first.0.time).max(f64::MIN_POSITIVE),
            frames: frames.iter().map(|frame| (*frame.0).clone()).collect(),
            lacks: Vec::new(),
            alarms: Vec::new(),
            notes: Vec::new(),
        };
        Ok(Recording { scene, recording: Arc::new(recording) })
    }

    /// Reads a recording from a file written by `save` or by the `makadam` command.
    ///
    /// Raises:
    ///     makadam.JudgeError: The file cannot be read, is damaged, or contains a recording of another scene.
    #[staticmethod]
    fn load(scene: &Bound<'_, PyAny>, file: PathBuf) -> PyResult<Recording> {
        let py = scene.py();
        let scene = Scene::of(scene)?;
        let recording =
            recording::Recording::load(&file).map_err(|error| exception(py, "JudgeError", &error.to_string()))?;
        recording.belongs_to(&scene.plan).map_err(|problem| {
            exception(py, "JudgeError", &format!("{}: {problem}; give the scene that was recorded", file.display()))
        })?;
        Ok(Recording { scene, recording: Arc::new(recording) })
    }

    /// Writes the recording to a file, with a checksum that detects damage.
    fn save(&self, py: Python<'_>, file: PathBuf) -> PyResult<()> {
        self.recording.save(&file).map_err(|error| exception(py, "JudgeError", &error.to_string()))
    }

    /// The scene.
    #[getter]
    fn scene(&self) -> Scene {
        self.scene.clone()
    }

    /// Name of the simulation code: Makadam, YADE, LIGGGHTS, LAMMPS or MigFlow.
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

    /// Measures the frames from `measure.from` on: a list of rows, each a dict of `observable`, `unit`, `value`, `standard_error`
    /// (within the run, over blocks of time; None for too few frames) and `frames`. Observables without a value are omitted.
    fn measure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        if let Some(first) = self.recording.alarms.iter().find(|alarm| alarm.fatal) {
            warn(py, &first.words())?;
        }
        let measured = py.detach(|| measure(&self.scene.plan, &self.recording));
        plain(py, &measured)
    }

    /// Observables over time, a list of dicts of `observable`, `time` (s) and `value`, one point per frame: the dynamic angle of
    /// repose (degrees), if the scene measures it.
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let found = py.detach(|| series(&self.scene.plan, &self.recording));
        plain(py, &found)
    }

    /// Writes the frames into a folder like `makadam run`: see `makadam.Simulation.save_frames`.
    #[pyo3(signature = (folder, *, walls=true))]
    fn save_frames(&self, py: Python<'_>, folder: PathBuf, walls: bool) -> PyResult<()> {
        Frames { frames: self.arcs(), scene: self.scene.plan.clone() }.save(py, folder, walls)
    }

    /// Draws the frame nearest to a time (s), or the last one: see `makadam.Simulation.picture`.
    #[pyo3(signature = (file=None, time=None, *, field=None, range=None, view="natural", clip=None, walls=true, all_grains=false, size=[1200, 900]))]
    #[allow(clippy::too_many_arguments)] // They have names in Python.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        file: Option<PathBuf>,
        time: Option<f64>,
        field: Option<String>,
        range: Option<[f64; 2]>,
        view: &str,
        clip: Option<&str>,
        walls: bool,
        all_grains: bool,
        size: [usize; 2],
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let frame = self.frame_at(time).map_err(|problem| exception(py, "JudgeError", &problem))?;
        let frames = Frames { frames: vec![Arc::new(frame.clone())], scene: self.scene.plan.clone() };
        frames.picture(py, file, PictureRequest { field, range, view, clip, walls, all_grains, size })
    }

    /// Writes the frames as one HTML file to turn, cut and play in a browser: see `makadam.Simulation.view`.
    #[pyo3(signature = (file, *, fields=None, every=None, megabytes=200.0, contacts=true, walls=true, all_grains=false))]
    #[allow(clippy::too_many_arguments)] // They have names in Python.
    fn view(
        &self,
        py: Python<'_>,
        file: PathBuf,
        fields: Option<Vec<String>>,
        every: Option<usize>,
        megabytes: f64,
        contacts: bool,
        walls: bool,
        all_grains: bool,
    ) -> PyResult<()> {
        let request = PageRequest { fields, every, megabytes, contacts, walls, all_grains };
        Frames { frames: self.arcs(), scene: self.scene.plan.clone() }.view(py, file, request)
    }

    /// Restores a recording from the data of `__reduce__`.
    #[staticmethod]
    fn _of_bytes(scene: &Bound<'_, PyAny>, bytes: &[u8]) -> PyResult<Recording> {
        let read = recording::Recording::parse(bytes);
        let recording =
            read.map_err(|problem| exception(scene.py(), "JudgeError", &format!("the recording {problem}")))?;
        Ok(Recording { scene: Scene::of(scene)?, recording: Arc::new(recording) })
    }

    #[allow(clippy::type_complexity)] // What Python's pickle wants.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Scene, Bound<'py, PyBytes>))> {
        let Recording { scene, recording } = slf.get();
        let bytes = PyBytes::new(slf.py(), &recording.to_bytes());
        Ok((slf.get_type().getattr("_of_bytes")?, (scene.clone(), bytes)))
    }

    fn __repr__(&self) -> String {
        let recording::Recording { scene, code, seed, frames, .. } = &*self.recording;
        format!("<makadam.Recording of {scene} by {code}, seed {seed}: {} frames>", frames.len())
    }
}

impl Recording {
    fn arcs(&self) -> Vec<Arc<Snapshot>> {
        self.recording.frames.iter().cloned().map(Arc::new).collect()
    }

    /// Returns the frame nearest to a time (s), or the last one; an error message for a time outside of the run.
    fn frame_at(&self, time: Option<f64>) -> Result<&Snapshot, String> {
        let (Some(first), Some(last)) = (self.recording.frames.first(), self.recording.frames.last()) else {
            return Err("the recording has no frames".into());
        };
        let Some(time) = time else { return Ok(last) };
        let slack = 1e-6 * (last.time - first.time).abs();
        if !(first.time - slack..=last.time + slack).contains(&time) {
            return Err(format!(
                "time: {time} s lies outside of the run, whose frames are from {} s to {} s",
                first.time, last.time
            ));
        }
        let off = |frame: &&Snapshot| (frame.time - time).abs();
        Ok(self.recording.frames.iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(last))
    }
}

/// Checks that a frame has the radii that the scene draws with a seed, and reports the first difference.
fn check_seed(scene: &Scene, seed: u64, frame: &Snapshot) -> Result<(), String> {
    let grains = populate(&scene.plan, seed).map_err(|error| error.to_string())?;
    let mut pairs = frame.particles.iter().zip(&grains);
    pairs.find(|(here, drawn)| here.radius != drawn.radius).map_or(Ok(()), |(here, drawn)| {
        Err(format!(
            "the frames are not of seed {seed} of '{}': grain {} has a radius of {} m, and that seed gives it {} m; give the seed of the \
             simulation that the frames were made of (its `seed`)",
            scene.plan.name, here.id, here.radius, drawn.radius
        ))
    })
}

/// Converts the failure of a code to an exception.
pub fn code_error(py: Python<'_>, error: &CodeError) -> PyErr {
    match error {
        CodeError::Scene(error) => crate::errors::scenes_error(py, error, None),
        CodeError::Execution(error) => crate::errors::setting_error(py, error),
        CodeError::InvalidState { .. } => exception(py, "InvalidStateError", &error.to_string()),
        CodeError::Interrupted { .. } => exception(py, "Interrupted", &error.to_string()),
        _ => exception(py, "JudgeError", &error.to_string()),
    }
}

/// Returns the code with a name.
pub fn code_of(py: Python<'_>, name: &str) -> PyResult<CodeName> {
    CodeName::of(name).map_err(|error| exception(py, "JudgeError", &error.to_string()))
}

/// Runs a scene from start to end in one code, on one core, and records a frame per `measure.interval`.
///
/// Args:
///     scene: A scene, or a source accepted by `makadam.Scene`.
///     seed: Seed of the positions and radii; defaults to the scene's seed.
///     code: `makadam`, `yade`, `liggghts`, `lammps` or `migflow`; codes other than Makadam must be installed.
///     rayleigh_fraction: Time step of the explicit codes over the Rayleigh step.
///     time_limit: Wall time limit of another code, s.
///
/// Raises:
///     makadam.JudgeError: The code is not installed, cannot express the scene or failed.
///     makadam.InvalidStateError: The run reached a state that invalidates its results.
#[pyfunction]
#[pyo3(signature = (scene, seed=None, *, code="makadam", rayleigh_fraction=0.2, time_limit=86400.0))]
pub fn simulate(
    scene: &Bound<'_, PyAny>,
    seed: Option<Whole>,
    code: &str,
    rayleigh_fraction: f64,
    time_limit: f64,
) -> PyResult<Recording> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    let code = code_of(py, code)?.code();
    if code.version().is_none() {
        return Err(code_error(py, &CodeError::Missing { code: code.name() }));
    }
    let seed = seed_of(py, seed)?.unwrap_or(scene.plan.seed);
    let name = format!("{}-{}-s{seed}", file_stem(&scene.plan.name), file_stem(&code.name().to_lowercase()));
    let work_folder = run_folder(&name).map_err(|error| exception(py, "JudgeError", &error.to_string()))?;
    let limit = Duration::try_from_secs_f64(time_limit)
        .map_err(|error| exception(py, "JudgeError", &format!("time_limit {time_limit}: {error}")))?;
    let recorded = beside(py, || {
        let job = Job {
            scene: &scene.plan,
            scene_file: &scene.file,
            purpose: Purpose::Measuring,
            seed,
            stiffness_factor: 1.0,
            rayleigh_fraction,
            work_folder: &work_folder,
            time_limit: limit,
            progress: &|_| {},
        };
        code.simulate(&job)
    })?;
    let recording = recorded.map_err(|error| code_error(py, &error))?;
    // The recording contains the output of the code; a remaining folder is harmless.
    let _ = std::fs::remove_dir_all(&work_folder);
    for alarm in &recording.alarms {
        warn(py, &alarm.words())?;
    }
    Ok(Recording { scene, recording: Arc::new(recording) })
}

/// Measures frames by a scene: see `Recording.measure`; includes all given frames.
#[pyfunction]
#[pyo3(name = "_measure")]
pub fn measure_of_frames<'py>(
    scene: &Bound<'py, PyAny>,
    frames: Vec<PyRef<'py, Frame>>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    let snapshots = snapshots(&frames);
    check_frames(py, &scene, &snapshots)?;
    let measured = py.detach(|| {
        let frames: Vec<_> = snapshots.iter().map(|snapshot| &**snapshot).collect();
        let Ok(measured) = measure_frames(&scene.plan, &frames[..]);
        measured
    });
    plain(py, &measured.unwrap_or_default().measurements)
}

/// Returns the names of all observables with the group of each, as in `measure.observables` of a scene.
#[pyfunction]
pub fn observables(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let found = PyDict::new(py);
    for name in catalogue::known() {
        found.set_item(name, catalogue::group_of(name).map(|(_, group)| group))?;
    }
    Ok(found)
}
