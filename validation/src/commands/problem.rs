//! `makadam lab problem`: contact problems in files.

use super::arguments::{SceneArguments, positive};
use super::beforehand::begin;
use super::{Console, Failure, within_tolerance};
use clap::{Args, Subcommand};
use makadam_frames::execution::Execution;
use makadam_frames::output::{HDF5, JSON_VERSION};
use makadam_frames::stepping::{Halt, Stepping, steps_in};
use makadam_studies::problem::{self, AGREEMENT, Check, FromSiconos, Method, Settings};
use serde_json::json;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct ProblemArguments {
    /// Command to run.
    #[command(subcommand)]
    command: ProblemCommand,
}

#[derive(Debug, Subcommand)]
enum ProblemCommand {
    /// Write the contact problem of one step of a scene to a file, in FCLIB's layout (HDF5).
    Export(ExportArguments),
    /// Solve the problems in files with every available solver, and compare the answers.
    Check(CheckArguments),
}

#[derive(Debug, Args)]
struct ExportArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Simulated time of the step, s; the scene's duration, if absent.
    #[arg(long, value_parser = positive)]
    time: Option<f64>,
    /// Number of steps before the problem, instead of a time.
    #[arg(long, conflicts_with = "time")]
    steps: Option<u64>,
    /// Also solve with Siconos, which must be installed (Debian's python3-siconos), and write its solution in FCLIB's group.
    #[arg(long)]
    siconos: bool,
    /// File to write.
    #[arg(short, long)]
    output: PathBuf,
}

#[derive(Debug, Args)]
struct CheckArguments {
    /// Files from `makadam lab problem export`, or FCLIB files with local problems.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Stop when the largest change in a sweep is below this value, in units of g h (1 m/s without gravity).
    #[arg(long, default_value_t = Settings::DEFAULT.tolerance, value_parser = positive)]
    tolerance: f64,
    /// Largest number of sweeps.
    #[arg(long, default_value_t = Settings::DEFAULT.most_sweeps, value_parser = clap::value_parser!(u32).range(1..))]
    sweeps: u32,
    /// Largest velocity difference at which answers agree, in the same units.
    #[arg(long, default_value_t = AGREEMENT, value_parser = positive)]
    agreement: f64,
    /// Also solve with Siconos, which must be installed (Debian's python3-siconos).
    #[arg(long)]
    siconos: bool,
    /// Print the answers as JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn problem(arguments: &ProblemArguments, console: &Console) -> Result<ExitCode, Failure> {
    match &arguments.command {
        ProblemCommand::Export(export) => self::export(export, console),
        ProblemCommand::Check(check) => self::check(check, console),
    }
}

/// Writes the contact problem of a step of a scene.
fn export(arguments: &ExportArguments, console: &Console) -> Result<ExitCode, Failure> {
    refuse_to_replace(&arguments.output)?;
    if arguments.siconos {
        problem::siconos_version()?;
    }
    let (file, scene, seed) = arguments.scene.load()?;
    let (mut simulation, _) = begin(&scene, seed, &file, &Execution::serial(), console)?;
    let by_time = arguments.time.map(|time| steps_in((time - simulation.time()).max(0.0), simulation.time_step()));
    let steps = arguments.steps.or(by_time).unwrap_or_else(|| steps_in(scene.duration, simulation.time_step()));
    let bar = console.bar(&scene.name);
    let stepped = Stepping::new(steps, &|fraction| bar.set(fraction)).carry_out(&mut simulation, |_, _| {});
    drop(bar);
    stepped.map_err(|_: Halt| Failure::interrupted("none, the problem was not reached"))?;
    let title = format!("{}, seed {seed}, t = {} s", scene.name, simulation.time());
    let posed = problem::pose(&simulation, &title);
    if posed.contacts() == 0 {
        return Err(Failure::Usage(format!(
            "{} has no contacts at {} s, so there is no problem to export; give another time with --time",
            scene.name,
            simulation.time()
        )));
    }
    if posed.lanes.is_none() {
        console.warn("the sweeps over lanes did not converge; the file is written without their answer");
    }
    // A written answer is compared with others at the default tolerance, and is more accurate.
    let settings = Settings { tolerance: 0.1 * Settings::DEFAULT.tolerance, ..Settings::DEFAULT };
    let solved = arguments.siconos.then(|| problem::solve(&posed, Method::Siconos, &settings)).transpose();
    let answer = solved
        .map_err(|why| Failure::Running(format!("siconos: {why}; without --siconos the problem alone is written")))?;
    problem::write(&arguments.output, &posed, answer.as_ref().map(|answer| answer.impulses.as_slice()))?;
    console.result(&format!("{title}: {} contacts, {}", posed.contacts(), arguments.output.display()))?;
    Ok(ExitCode::SUCCESS)
}

/// Refuses to replace a file of another kind, such as the scene itself.
fn refuse_to_replace(output: &Path) -> Result<(), Failure> {
    let Ok(there) = output.metadata() else { return Ok(()) };
    let mut head = Vec::new();
    // A pipe is not read: reading might block forever.
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

/// Solves the problems of files with every solver and compares the answers.
fn check(arguments: &CheckArguments, console: &Console) -> Result<ExitCode, Failure> {
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
    let document = json!({ "version": JSON_VERSION, "command": "problem check", "problems": checks });
    console.document(&document, arguments.json, || checks.iter().map(problem::table).collect::<Vec<_>>().join("\n"))?;
    // Siconos was requested by name; the other solvers take part if applicable.
    let without = |check: &Check| {
        let why = check.why_left_out(Method::Siconos)?;
        Some(format!("{}: {why}; without --siconos the other solvers are compared", check.title))
    };
    let without: Vec<String> = checks.iter().filter_map(without).collect();
    if !without.is_empty() {
        return Err(Failure::Running(without.join("; ")));
    }
    Ok(within_tolerance(checks.iter().all(|check| check.agrees(arguments.agreement))))
}
