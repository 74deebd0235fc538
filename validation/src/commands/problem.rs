//! `makadam lab problem`: contact problems in files.

use super::arguments::{
    ProblemArguments, ProblemCheckArguments, ProblemCommand, ProblemExportArguments, ProblemSolveArguments,
};
use super::{Console, Failure, OUTSIDE_TOLERANCE, begin, json};
use crate::execution::Execution;
use crate::output::HDF5;
use crate::problem::{self, Check, FromSiconos, Settings};
use crate::stepping::steps_in;
use serde::Serialize;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::process::ExitCode;

/// What `--json` prints.
#[derive(Serialize)]
struct Document<Answers> {
    version: u32,
    command: &'static str,
    problems: Answers,
}

/// Carries out one of the subcommands.
pub(super) fn problem(arguments: &ProblemArguments, console: &Console) -> Result<ExitCode, Failure> {
    match &arguments.command {
        ProblemCommand::Export(export) => self::export(export, console),
        ProblemCommand::Solve(solve) => self::solve(solve, console),
        ProblemCommand::Check(check) => self::check(check, console),
    }
}

/// Writes the problem of a step of a scene.
fn export(arguments: &ProblemExportArguments, console: &Console) -> Result<ExitCode, Failure> {
    refuse_to_replace(&arguments.output)?;
    let (file, scene, seed) = arguments.scene.load()?;
    let (mut simulation, _) = begin(&scene, seed, &file, &Execution::serial(), console)?;
    let by_time = arguments.time.map(|time| steps_in((time - simulation.time()).max(0.0), simulation.time_step()));
    let steps = arguments.steps.or(by_time).unwrap_or_else(|| steps_in(scene.duration, simulation.time_step()));
    let bar = console.bar(&scene.name);
    for step in 1..=steps {
        simulation.step();
        bar.set(step as f64 / steps as f64);
        if crate::interrupt::requested() {
            return Err(Failure::Interrupted("none, the problem was not reached".into()));
        }
    }
    drop(bar);
    let title = format!("{}, seed {seed}, t = {} s", scene.name, simulation.time());
    let posed = problem::pose(&simulation, &title);
    if posed.file.contacts() == 0 {
        return Err(Failure::Usage(format!(
            "{} has no contacts at {} s, so there is no problem to export; give another time with --time",
            scene.name,
            simulation.time()
        )));
    }
    if !posed.lanes_converged {
        console.warn("the sweeps over lanes did not converge; the file is written without their answer");
    }
    problem::write(&arguments.output, &posed.file, None)?;
    console.result(&format!("{title}: {} contacts, {}", posed.file.contacts(), arguments.output.display()))?;
    Ok(ExitCode::SUCCESS)
}

/// Solves a file's problem by one method.
fn solve(arguments: &ProblemSolveArguments, console: &Console) -> Result<ExitCode, Failure> {
    arguments.output.as_deref().map_or(Ok(()), refuse_to_replace)?;
    let file = problem::read(&arguments.file)?;
    let settings = Settings { tolerance: arguments.tolerance, most_sweeps: arguments.sweeps };
    let refused = |why: String| Failure::Running(format!("{}: {why}", arguments.file.display()));
    let method = arguments.method.into();
    if method == problem::Method::Siconos {
        problem::siconos_version()?;
    }
    let answer = problem::solve(&file, method, &settings).map_err(refused)?;
    if let Some(output) = &arguments.output {
        if file.local.is_none() {
            return Err(refused("contacts bear torques, which FCLIB's solution group cannot hold".into()));
        }
        if answer.impulses.is_empty() {
            return Err(refused("the answer of the sweeps over lanes has no impulses; take another --method".into()));
        }
        problem::write(output, &file, Some(&answer.impulses))?;
    }
    let converged = answer.converged;
    console.result(&match arguments.json {
        true => json(&Document { version: 1, command: "problem solve", problems: [&answer] }),
        false => problem::words(&answer),
    })?;
    Ok(if converged { ExitCode::SUCCESS } else { ExitCode::from(OUTSIDE_TOLERANCE) })
}

/// Refuses to write over what is no file of a problem, such as the scene itself.
fn refuse_to_replace(output: &Path) -> Result<(), Failure> {
    let Ok(there) = output.metadata() else { return Ok(()) };
    let mut head = Vec::new();
    // A pipe is not looked into: it might never answer.
    let read = there.is_file().then(|| File::open(output)?.take(HDF5.len() as u64).read_to_end(&mut head));
    match read {
        Some(Ok(0)) => Ok(()),
        Some(Ok(_)) if head == HDF5 => Ok(()),
        _ => Err(Failure::Usage(format!(
            "{} is there and is no problem file (HDF5), so it is not replaced; give another file with --output",
            output.display()
        ))),
    }
}

/// Solves files' problems by every solver and compares.
fn check(arguments: &ProblemCheckArguments, console: &Console) -> Result<ExitCode, Failure> {
    let settings = Settings { tolerance: arguments.tolerance, most_sweeps: arguments.sweeps };
    let siconos = if arguments.siconos { FromSiconos::Run } else { FromSiconos::Nothing };
    let mut checks: Vec<Check> = Vec::new();
    for path in &arguments.files {
        let file = problem::read(path)?;
        let mut check = problem::check(&file, &settings, &siconos)?;
        if check.title.is_empty() {
            check.title = path.display().to_string();
        }
        checks.push(check);
    }
    let agree = checks.iter().all(|check| check.agrees(arguments.agreement));
    console.result(&match arguments.json {
        true => json(&Document { version: 1, command: "problem check", problems: &checks }),
        false => checks.iter().map(problem::table).collect::<Vec<_>>().join("\n"),
    })?;
    // It was asked for by name; the others take part where they apply.
    let without = |check: &Check| {
        let why = check.why_left_out(problem::Method::Siconos)?;
        Some(format!("{}: {why}; without --siconos the other solvers are compared", check.title))
    };
    let without: Vec<String> = checks.iter().filter_map(without).collect();
    if !without.is_empty() {
        return Err(Failure::Running(without.join("; ")));
    }
    Ok(if agree { ExitCode::SUCCESS } else { ExitCode::from(OUTSIDE_TOLERANCE) })
}
