//! Settings of the caller that replace those of the scene and the machine.

use crate::errors::{exception, setting_error};
use crate::scene::Scene;
use makadam::{Execution, InstructionSet, Precision, Scheduler, SolverMethod};
use makadam_frames::plan;
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;

/// Maximum number of threads, equal to that of the command.
const MOST_THREADS: u64 = 1024;

/// Python integer of any size, or the text of any other value: the setting refuses such a value by its own name.
pub struct Whole(Result<i128, String>);

impl Whole {
    pub const ONE: Whole = Whole(Ok(1));

    /// Returns the number, if it is within a range.
    fn within(self, py: Python<'_>, what: &str, range: std::ops::RangeInclusive<u64>) -> PyResult<u64> {
        let (least, most) = (range.start(), range.end());
        let problem = match self.0 {
            Ok(number) => match u64::try_from(number).ok().filter(|number| range.contains(number)) {
                Some(number) => return Ok(number),
                None => format!("{number} is not possible"),
            },
            Err(other) => other,
        };
        Err(exception(py, "SettingError", &format!("{what}: {problem}; give a whole number from {least} to {most}")))
    }
}

impl FromPyObject<'_, '_> for Whole {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, '_, PyAny>) -> PyResult<Whole> {
        Ok(Whole(match value.extract::<i128>() {
            Ok(number) => Ok(number),
            Err(error) if error.is_instance_of::<PyOverflowError>(value.py()) => {
                Err("a number beyond 2^64 is not possible".into())
            }
            Err(_) => Err(format!("{} is no whole number", value.repr()?)),
        }))
    }
}

/// Python real number, or the text of any other value.
pub struct Real(Result<f64, String>);

impl Real {
    /// Returns the number.
    pub fn number(self, py: Python<'_>, what: &str) -> PyResult<f64> {
        self.0.map_err(|problem| exception(py, "SettingError", &format!("{what}: {problem}; give a number")))
    }
}

impl FromPyObject<'_, '_> for Real {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, '_, PyAny>) -> PyResult<Real> {
        Ok(Real(match value.extract::<f64>() {
            Ok(number) => Ok(number),
            Err(_) => Err(format!("{} is no number", value.repr()?)),
        }))
    }
}

/// Returns the given seed.
pub fn seed_of(py: Python<'_>, seed: Option<Whole>) -> PyResult<Option<u64>> {
    seed.map(|seed| seed.within(py, "seed", 0..=u64::MAX)).transpose()
}

/// Builds the execution settings of a simulation.
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

/// Returns the scene with replaced settings.
pub fn adapted(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    time_step: Option<Real>,
    precision: Option<&str>,
    method: Option<&str>,
) -> PyResult<Scene> {
    let time_step = time_step.map(|step| step.number(py, "time_step")).transpose()?;
    let scene = Scene::of(scene)?;
    if time_step.is_none() && precision.is_none() && method.is_none() {
        check(py, &scene, &scene.plan, None)?;
        return Ok(scene);
    }
    let mut plan = scene.plan.clone();
    if let Some(step) = time_step {
        // An accuracy would override the method.
        plan.accuracy = None;
        plan.solver.step = step;
    }
    if let Some(name) = precision {
        plan.solver.precision = match name {
            "double" => Precision::Double,
            "single" => Precision::Single,
            _ => return Err(exception(py, "SettingError", &format!("no precision '{name}': give double or single"))),
        };
    }
    if let Some(name) = method {
        let name = name.replace('_', "-");
        let found = SolverMethod::ALL.into_iter().find(|method| method.name() == name);
        plan.solver.method = found.ok_or_else(|| {
            let known = SolverMethod::ALL.map(SolverMethod::name).join(", ");
            exception(py, "SettingError", &format!("no method '{name}': give one of {known}"))
        })?;
    }
    check(py, &scene, &plan, time_step)?;
    scene.with_plan(py, plan)
}

/// Refuses settings that the scene does not support.
fn check(py: Python<'_>, scene: &Scene, plan: &plan::MeasuredScene, time_step: Option<f64>) -> PyResult<()> {
    plan.goes_with(plan.solver.method, plan.solver.precision).map_err(|error| setting_error(py, &error))?;
    plan.check().map_err(|error| match time_step {
        Some(step) => exception(py, "SettingError", &format!("time_step {step}: {error}")),
        None => crate::errors::scene_error(py, &error, scene.origin()),
    })
}
