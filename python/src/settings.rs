//! Settings that the caller gives in place of those of the scene and the machine.

use crate::errors::{exception, setting_error};
use crate::scene::Scene;
use makadam::{Execution, InstructionSet, Precision, Scheduler, SolverMethod};
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;

/// Most threads: as many as the command takes.
const MOST_THREADS: u64 = 1024;

/// A whole number as Python has it, of any size: what does not fit is told in the words of a setting.
#[derive(Clone, Copy)]
pub struct Whole(Option<i128>);

impl Whole {
    pub const ONE: Whole = Whole(Some(1));

    /// The number, if it lies in a range.
    fn within(self, py: Python<'_>, what: &str, range: std::ops::RangeInclusive<u64>) -> PyResult<u64> {
        let number = self.0.and_then(|number| u64::try_from(number).ok()).filter(|number| range.contains(number));
        number.ok_or_else(|| {
            let given = self.0.map_or("a number beyond 2^64".into(), |number| number.to_string());
            let (least, most) = (range.start(), range.end());
            exception(py, "SettingError", &format!("{what}: {given} is not possible; give {least} to {most}"))
        })
    }
}

impl FromPyObject<'_, '_> for Whole {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, '_, PyAny>) -> PyResult<Whole> {
        match value.extract::<i128>() {
            Ok(number) => Ok(Whole(Some(number))),
            Err(error) if error.is_instance_of::<PyOverflowError>(value.py()) => Ok(Whole(None)),
            Err(error) => Err(error),
        }
    }
}

/// A seed that was given.
pub fn seed_of(py: Python<'_>, seed: Option<Whole>) -> PyResult<Option<u64>> {
    seed.map(|seed| seed.within(py, "seed", 0..=u64::MAX)).transpose()
}

/// How a simulation is carried out.
pub fn execution(
    py: Python<'_>,
    threads: Whole,
    scheduler: Option<&str>,
    instruction_set: Option<&str>,
) -> PyResult<Execution> {
    let threads = threads.within(py, "threads", 1..=MOST_THREADS)? as usize;
    let unknown = |what: &str, given: &str, known: Vec<&str>| {
        exception(py, "SettingError", &format!("no {what} '{given}': give one of {}", known.join(", ")))
    };
    let scheduler = match scheduler {
        None if threads == 1 => Scheduler::Serial,
        None => Scheduler::WorkStealing,
        Some(name) => Scheduler::ALL
            .into_iter()
            .find(|scheduler| scheduler.name() == name.replace('_', "-"))
            .ok_or_else(|| unknown("scheduler", name, Scheduler::ALL.map(Scheduler::name).to_vec()))?,
    };
    let instruction_set = match instruction_set {
        None => InstructionSet::detect(),
        Some(name) => InstructionSet::ALL
            .into_iter()
            .find(|set| set.name() == name)
            .ok_or_else(|| unknown("instruction set", name, InstructionSet::ALL.map(InstructionSet::name).to_vec()))?,
    };
    Ok(Execution { scheduler, threads, instruction_set, ..Execution::serial() })
}

/// The scene with settings in place of its own.
pub fn adapted(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    time_step: Option<f64>,
    precision: Option<&str>,
    method: Option<&str>,
) -> PyResult<Scene> {
    let mut scene = Scene::of(scene)?;
    if let Some(step) = time_step {
        scene.plan.solver.step = step;
    }
    if let Some(name) = precision {
        scene.plan.solver.precision = match name {
            "double" => Precision::Double,
            "single" => Precision::Single,
            _ => return Err(exception(py, "SettingError", &format!("no precision '{name}': give double or single"))),
        };
    }
    if let Some(name) = method {
        let name = name.replace('_', "-");
        let found = SolverMethod::ALL.into_iter().find(|method| method.name() == name);
        scene.plan.solver.method = found.ok_or_else(|| {
            let known = SolverMethod::ALL.map(SolverMethod::name).join(", ");
            exception(py, "SettingError", &format!("no method '{name}': give one of {known}"))
        })?;
    }
    let solver = &scene.plan.solver;
    scene.plan.goes_with(solver.method, solver.precision).map_err(|error| setting_error(py, &error))?;
    scene.plan.check().map_err(|error| match time_step {
        Some(step) => exception(py, "SettingError", &format!("time_step {step}: {error}")),
        None => crate::errors::scene_error(py, &error, scene.origin()),
    })?;
    Ok(scene)
}
