//! Comparison with the reference codes: recorded references and verdicts.

use crate::convert::plain;
use crate::errors::exception;
use crate::judge::{Recording, code_error, code_of};
use crate::scene::Scene;
use crate::stepping::beside;
use makadam_compare::codes::{Code, CodeName};
use makadam_compare::compare::{CodeRuns, Harvest, Reference, comparison, noticed};
use makadam_frames::plan::{self, physics_hash};
use makadam_frames::provenance::utc;
use makadam_frames::recording;
use makadam_qualification::qualify::{OneScene, usual_codes};
use makadam_qualification::report::Qualification;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::time::{Duration, SystemTime};

/// Returns the recorded results of the reference codes on the present scene: rows, each a dict of code, seed, observable, value and its
/// standard error within the run.
#[pyfunction]
#[pyo3(name = "_reference")]
pub fn reference<'py>(scene: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyList>> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    let found = Reference::of_scene(&scene.file).map_err(|error| exception(py, "JudgeError", &error.to_string()))?;
    let rows = PyList::empty(py);
    let Some(found) = found else { return Ok(rows) };
    for runs in found.codes().iter().filter_map(|code| found.code_on(code, &scene.plan)) {
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

/// Returns a comparison as a dict of rows, codes, notes and the verdict.
fn document<'py>(py: Python<'py>, qualification: &Qualification) -> PyResult<Bound<'py, PyDict>> {
    let comparison = &qualification.comparisons[0];
    let found = PyDict::new(py);
    found.set_item("rows", plain(py, &comparison.rows)?)?;
    found.set_item("codes", plain(py, &comparison.codes)?)?;
    found.set_item("notes", plain(py, &comparison.notes)?)?;
    found.set_item("verdict", plain(py, &qualification.verdict())?)?;
    Ok(found)
}

/// Runs a scene in several codes, or uses the recorded results of the reference codes, and compares.
#[pyfunction]
#[pyo3(name = "_compare")]
pub fn compare<'py>(
    scene: &Bound<'py, PyAny>,
    codes: Option<Vec<String>>,
    live: bool,
    seeds: Option<u64>,
    rayleigh_fraction: f64,
    time_limit: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    let limit = Duration::try_from_secs_f64(time_limit)
        .map_err(|error| exception(py, "JudgeError", &format!("time_limit {time_limit}: {error}")))?;
    let asked = asked_or_usual(py, codes, &scene, live)?;
    let judged = beside(py, || {
        let codes = asked.into_iter().map(|name| -> Box<dyn Code> { name.code() }).collect();
        OneScene {
            scene: &scene.plan,
            scene_file: &scene.file,
            changes: &[],
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

/// Returns the requested codes, or the default codes of a scene.
fn asked_or_usual(py: Python<'_>, asked: Option<Vec<String>>, scene: &Scene, live: bool) -> PyResult<Vec<CodeName>> {
    match asked {
        Some(asked) => asked.iter().map(|name| code_of(py, name)).collect(),
        None => Ok(usual_codes(&scene.file, live)),
    }
}

/// Checks that runs can be seeds of one ensemble on a scene; returns the reason if not.
fn check_runs(scene: &Scene, runs: &[PyRef<'_, Recording>]) -> Result<(), String> {
    let hash = physics_hash(&scene.plan);
    for (place, run) in runs.iter().enumerate() {
        let recording = &run.recording;
        if physics_hash(&run.scene.plan) != hash {
            return Err(format!(
                "the run of seed {} is of {}, which is another scene than {}; give runs of the scene that is compared",
                recording.seed, run.scene.plan.name, scene.plan.name
            ));
        }
        whole(&scene.plan, recording)?;
        for earlier in runs[..place].iter().map(|earlier| &earlier.recording) {
            if earlier.seed == recording.seed {
                return Err(format!("two runs have seed {}; give each seed once", recording.seed));
            }
            // Without populations the seed has no effect.
            if earlier.frames == recording.frames && !scene.plan.population.is_empty() {
                return Err(format!(
                    "the runs of seeds {} and {} have the same frames: they are one run; give a run of each seed",
                    earlier.seed, recording.seed
                ));
            }
            if (&earlier.code, &earlier.version) != (&recording.code, &recording.version) {
                return Err(format!(
                    "runs of {} and of {} are no ensemble; give those of one code",
                    earlier.code, recording.code
                ));
            }
        }
    }
    Ok(())
}

/// Checks that a run has all frames that the scene measures, and lists the missing frames.
fn whole(scene: &plan::MeasuredScene, run: &recording::Recording) -> Result<(), String> {
    if !scene.stage.is_empty() {
        return Err(format!("{} has stages; compare it with the command, `makadam compare`", scene.name));
    }
    let (seed, interval, slack) = (run.seed, scene.measure.interval, scene.measure.slack() + run.time_step);
    let last = run.frames.last().map_or(f64::NEG_INFINITY, |frame| frame.time);
    if (last - scene.duration).abs() > slack {
        return Err(format!(
            "the run of seed {seed} has its last frame at {last} s, and {} ends at {} s; give runs of the whole duration",
            scene.name, scene.duration
        ));
    }
    let Some(from) = scene.measure.from else { return Ok(()) };
    let mut before = from;
    let measured = run.frames.iter().filter(|frame| scene.covers(frame.time, frame.stage));
    for time in measured.map(|frame| frame.time) {
        if time - before > interval + slack {
            return Err(format!(
                "the run of seed {seed} has no frames between {before} s and {time} s, and {} measures one every {interval} s from \
                 {from} s on; keep them all, as record() does",
                scene.name
            ));
        }
        before = time;
    }
    Ok(())
}

/// Compares local runs with the recorded results of the reference codes.
#[pyfunction]
#[pyo3(name = "_compare_runs")]
pub fn compare_runs<'py>(
    scene: &Bound<'py, PyAny>,
    runs: Vec<PyRef<'py, Recording>>,
    codes: Option<Vec<String>>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = scene.py();
    let scene = Scene::of(scene)?;
    if scene.plan.compare.is_empty() {
        let message = format!("{} names nothing to compare; add observables under [[compare]]", scene.plan.name);
        return Err(exception(py, "JudgeError", &message));
    }
    let found = Reference::of_scene(&scene.file).map_err(|error| exception(py, "JudgeError", &error.to_string()))?;
    check_runs(&scene, &runs).map_err(|problem| exception(py, "JudgeError", &problem))?;
    let recordings: Vec<_> = runs.iter().map(|run| run.recording.clone()).collect();
    let harvests = py.detach(|| {
        recordings.iter().map(|run| Harvest::of(&scene.plan, run, "", utc(SystemTime::now()))).collect::<Vec<_>>()
    });
    let name = recordings.first().map_or("Makadam", |run| run.code.as_str());
    let mut notes = noticed(name, &harvests);
    let mut measured =
        vec![CodeRuns { provenance: "runs that the caller made".into(), ..CodeRuns::live(name, 1, harvests) }];
    let codes = asked_or_usual(py, codes, &scene, false)?;
    for code in codes.into_iter().filter(|code| *code != CodeName::Makadam) {
        let code = code.code().name();
        let Some(recorded) = found.as_ref().and_then(|reference| reference.code_on(code, &scene.plan)) else {
            let message = format!("nothing is recorded of {code} on the scene {}; leave it out", scene.plan.name);
            return Err(exception(py, "JudgeError", &message));
        };
        notes.push(format!("{code} was not run: its numbers are the recorded references ({})", recorded.provenance));
        notes.extend(recorded.discarded.clone());
        measured.push(recorded);
    }
    document(
        py,
        &Qualification {
            title: format!("Comparison of codes on the scene {}", scene.plan.name),
            tier: "compare".into(),
            comparisons: vec![comparison(&scene.plan, &measured, notes)],
            ..Qualification::default()
        },
    )
}
