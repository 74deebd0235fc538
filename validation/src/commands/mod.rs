//! The commands of `makadam`: arguments, exit codes, what is printed.

mod arguments;
mod beforehand;
mod check;
mod compare;
mod console;
mod convergence;
mod effects;
mod export;
mod failure;
mod laws;
mod measure;
mod new;
mod picture;
mod print;
mod problem;
mod qualify;
mod record;
mod run;
mod scaling;
mod stability;
mod sweep;
mod tradeoff;
mod view;

pub use console::Console;
pub use failure::{Failure, OUTSIDE_TOLERANCE};

use crate::compare::Share;
use crate::execution::Execution;
use crate::output::cache_folder;
use crate::peers::{Code, CodeName, absent, codes_of};
use crate::plan::Scene;
use crate::prepared::{Start, is_ready, start};
use crate::qualify::usual_codes;
use crate::scenes;
use crate::stepping::{Stepping, steps_in};
use crate::study::Document;
use arguments::{Arguments, Command, Lab, Print, with_new_name};
use makadam::Simulation;
use makadam::scene::Stop;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs the program on the arguments of the process.
pub fn main() -> ExitCode {
    run_program(std::env::args_os().collect())
}

/// Runs the program on arguments, the first of which is its name.
pub fn run_program(arguments: Vec<OsString>) -> ExitCode {
    crate::provenance::set_command_line(&arguments);
    let arguments = match Arguments::read(&arguments) {
        Ok(arguments) => arguments,
        Err(words) => return tell(&with_new_name(words, &arguments)),
    };
    let console = Console::new(arguments.quiet, arguments.verbose);
    crate::interrupt::listen();
    let done = match &arguments.command {
        Command::New(new) => new::new(new, &console),
        Command::Check(check) => check::check(check, &console),
        Command::Run(run) => run::run(run, &console),
        Command::Sweep(sweep) => sweep::sweep(sweep, &console),
        Command::View(view) => view::view(view, &console),
        Command::Picture(picture) => picture::picture(picture, &console),
        Command::Measure(measure) => measure::measure(measure, &console),
        Command::Export(export) => export::export(export, &console),
        Command::Compare(compare) => compare::compare(compare, &console),
        Command::Qualify(qualify) => qualify::qualify(qualify, &console),
        Command::Laws(laws) => laws::laws(laws, &console),
        Command::Stability(stability) => stability::stability(stability, &console),
        Command::Effects(effects) => effects::effects(effects, &console),
        Command::Tradeoff(tradeoff) => tradeoff::tradeoff(tradeoff, &console),
        Command::Lab(lab) => match &lab.study {
            Lab::Convergence(convergence) => convergence::convergence(convergence, &console),
            Lab::Scaling(scaling) => scaling::scaling(scaling, &console),
            Lab::Problem(problem) => problem::problem(problem, &console),
        },
        Command::Print(print) => match &print.text {
            Print::Scenes(list) => print::scenes(list, &console),
            Print::Observables(observables) => print::observables(observables, &console),
            Print::Schema(schema) => print::schema(schema, &console),
            Print::Completions(completions) => print::completions(completions, &console),
            Print::Manual(manual) => print::manual(manual, &console),
        },
    };
    match done {
        Ok(code) => code,
        Err(Failure::ClosedOutput) => ExitCode::from(1),
        Err(failure) => {
            console.error(&failure.to_string());
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Prints what was asked for in place of a command, such as its help, or what is wrong with the arguments.
fn tell(words: &clap::Error) -> ExitCode {
    if words.use_stderr() {
        words.exit();
    }
    let console = Console::new(false, false);
    let styled = words.render();
    let text = if console.colour() { styled.ansi().to_string() } else { styled.to_string() };
    match console.page(text.trim_end()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::ClosedOutput) => ExitCode::from(1),
        Err(failure) => {
            console.error(&failure.to_string());
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Refuses to record beside a scene that lies in no folder.
fn can_record(file: &Path) -> Result<(), Failure> {
    let what = match (scenes::is_built_in(file), scenes::is_given(file)) {
        (_, true) => "was given on the command line or on standard input",
        (true, false) => "is a scene built into the program",
        (false, false) => return Ok(()),
    };
    Err(Failure::Usage(format!(
        "{} {what}, so there is no folder to record into; run where a folder reference-scenes contains it, or give the path to a file",
        file.display()
    )))
}

/// The simulation at the start of its run, with a progress bar while a flowing state is prepared.
fn begin(
    scene: &Scene,
    seed: u64,
    file: &Path,
    execution: &Execution,
    console: &Console,
) -> Result<(Simulation, Start), Failure> {
    if let Some(prepare) = scene.prepare.as_ref().filter(|_| !is_ready(scene, seed)) {
        console.note(&format!(
            "{} starts from a flowing state, which is prepared first: {} steps of {:e} s, {} s of simulated time, in addition to \
             the run's own steps; it is stored under {} for later runs",
            scene.name,
            steps_in(prepare.duration, prepare.step),
            prepare.step,
            prepare.duration,
            prepared_folder()?.display(),
        ));
    }
    let bar = console.bar("preparing the flow");
    let (simulation, start) = start(scene, seed, file, execution, &|share| bar.set(share))?;
    match &start {
        Start::Fresh => {}
        Start::Prepared(file) => console.note(&format!("starting from the flowing state {}", file.display())),
        Start::Remade(file, reason) => {
            console.warn(&format!("{} {reason}; it was made anew, and the run starts from it", file.display()));
        }
    }
    Ok((simulation, start))
}

/// Folder in which flowing states are kept.
fn prepared_folder() -> Result<PathBuf, Failure> {
    Ok(cache_folder()?.join("prepared"))
}

/// Simulates for a time, s.
fn settle(simulation: &mut Simulation, seconds: f64, console: &Console) -> Result<(), Failure> {
    let bar = console.bar("settling");
    let steps = steps_in(seconds, simulation.time_step());
    let settled = Stepping::new(steps, &|share| bar.set(share)).carry_out(simulation, |_, _| {});
    settled.map(|_| ()).map_err(|_| Failure::Interrupted("none, the flowing state was not finished".into()))
}

/// The simulation at the start of its run, settled for a time (s) where no flowing state was prepared: grains that have just been
/// placed have hardly a contact.
fn flowing(
    scene: &Scene,
    seed: u64,
    file: &Path,
    execution: &Execution,
    seconds: f64,
    console: &Console,
) -> Result<Simulation, Failure> {
    let (mut simulation, start) = begin(scene, seed, file, execution, console)?;
    if start == Start::Fresh {
        settle(&mut simulation, seconds, console)?;
    }
    Ok(simulation)
}

/// Refuses solves that stop when their wall time is spent.
fn refuse_time_budget(scene: &Scene) -> Result<(), Failure> {
    match scene.solver.stop {
        Stop::TimeBudget { .. } => Err(Failure::Usage(format!(
            "the solves of {} stop after a wall time, so no two runs do the same work; set solver.stop to sweeps or \
             residual",
            scene.name
        ))),
        _ => Ok(()),
    }
}

/// Writes a study into a folder, and prints it: all of it, or its table and where its page is.
fn publish(study: &impl Document, folder: &Path, as_json: bool, console: &Console) -> Result<(), Failure> {
    let page = study.write(folder)?;
    console.result(&match as_json {
        true => json(study),
        false => format!("{}\npage: {}", study.report().text(), page.display()),
    })
}

/// A value as indented JSON.
fn json(value: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(value).expect("results hold only numbers, plain text and lists")
}

/// The codes that are asked for, all of which are installed.
fn installed(names: &[CodeName]) -> Result<Vec<Box<dyn Code>>, Failure> {
    let codes = codes_of(names);
    match codes.iter().find(|code| code.version().is_none()) {
        None => Ok(codes),
        Some(missing) => Err(Failure::MissingCode(format!("{}, or leave it out with --codes", absent(missing.name())))),
    }
}

/// The codes that are asked for, or those in which a scene is compared where nobody says which.
fn codes_or_usual(names: Option<&[CodeName]>, scene_file: &Path, live: bool) -> Vec<Box<dyn Code>> {
    names.map_or_else(|| codes_of(&usual_codes(scene_file, live)), codes_of)
}

/// Opens progress bars on the console.
fn announce(console: &Console) -> impl Fn(&str) -> Share + Sync {
    |label| {
        let bar = console.bar(label);
        Box::new(move |share| bar.set(share))
    }
}
