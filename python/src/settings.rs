//! Settings that the caller gives in place of those of the scene and the machine.

use crate::errors::{exception, setting_error};
use crate::scene::Scene;
use makadam::{Execution, InstructionSet, Precision, Scheduler, SolverMethod};
use pyo3::prelude::*;

/// How a simulation is carried out.
pub fn execution(
    py: Python<'_>,
    threads: usize,
    scheduler: Option<&str>,
    instruction_set: Option<&str>,
) -> PyResult<Execution> {
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
    if threads == 0 {
        return Err(exception(py, "SettingError", "0 threads cannot step; give 1 or more"));
    }
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
