//! Commands of `makadam`: each file holds the arguments of a command, its call of the library, and its output.

mod arguments;
mod beforehand;
mod check;
mod compare;
mod console;
mod export;
mod failure;
mod lab;
mod laws;
mod measure;
mod new;
mod picture;
mod print;
mod problem;
mod qualify;
mod ranks;
mod renamed;
mod run;
mod stability;
mod studies;
mod view;

pub use console::Console;
pub use failure::{Failure, OUTSIDE_TOLERANCE};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;
use std::fmt::Write;
use std::process::ExitCode;

const EXIT_CODES: &str = "Exit codes: 0 pass, 1 failure while running, 2 usage, 3 invalid scene, problem or frame file, \
    4 outside tolerance, undecided or not measured, 5 a reference code is missing.";

/// Defines the commands, in the groups of the help: help, name, arguments, and the function that runs the command.
macro_rules! commands {
    ($($group:literal { $(#[doc = $help:literal] $name:ident($arguments:ty) => $run:path,)+ })+) => {
        #[derive(Debug, Subcommand)]
        enum Command {
            $($(#[doc = $help] $name($arguments),)+)+
        }

        /// Groups of the help, with the names of their commands.
        const GROUPS: &[(&str, &[&str])] = &[$(($group, &[$(stringify!($name)),+])),+];

        impl Command {
            fn run(&self, console: &Console) -> Result<ExitCode, Failure> {
                match self {
                    $($(Command::$name(arguments) => $run(arguments, console),)+)+
                }
            }
        }
    };
}

commands! {
    "Simulate" {
        /// Write a commented scene to start from to a file.
        New(new::NewArguments) => new::new,
        /// Describe a run before it starts: grains, scales, settings, memory, time.
        Check(check::CheckArguments) => check::check,
        /// Simulate a scene: frames, observables as CSV, provenance as JSON.
        Run(run::RunArguments) => run::run,
        /// Run a scene over values of its keys, several seeds each; write one table.
        Sweep(studies::SweepArguments) => studies::sweep,
    }
    "Look" {
        /// Write a run as one HTML file to turn, cut and play in a browser.
        View(view::ViewArguments) => view::view,
        /// Draw a frame of a run as PNG, or all frames as animated GIF.
        Picture(picture::PictureArguments) => picture::picture,
        /// Measure the output files of any code: dumps, VTK, CSV, VTKHDF.
        Measure(measure::MeasureArguments) => measure::measure,
        /// Write a run for ParaView or OVITO, or a scene for another code.
        Export(export::ExportArguments) => export::export,
    }
    "Compare" {
        /// Compare codes on one scene: Makadam, YADE, LIGGGHTS, LAMMPS, MigFlow, or your own.
        Compare(compare::CompareArguments) => compare::compare,
        /// Validate Makadam on the reference scenes and write one report.
        Qualify(qualify::QualifyArguments) => qualify::qualify,
    }
    "Study" {
        /// Measure published laws of granular matter and compare with their values.
        Laws(laws::LawsArguments) => laws::laws,
        /// Run stress tests: pathological scenes, each with its expected outcome.
        Stability(stability::StabilityArguments) => stability::stability,
        /// List the active physical effects of a scene, their costs and influence.
        Effects(studies::EffectsArguments) => studies::effects,
        /// Measure error against wall time over the settings of each code.
        Tradeoff(studies::TradeoffArguments) => studies::tradeoff,
        /// Study the solver: convergence, scaling, single contact problems.
        Lab(lab::LabArguments) => lab::lab,
    }
    "Manage" {
        /// Print references: scenes, observables, schemas, completions, manual.
        Print(print::PrintArguments) => print::print,
    }
}

/// Simulates grains in contact by non-smooth contact dynamics, measures and shows the results, and compares them with YADE, LIGGGHTS and LAMMPS.
#[derive(Debug, Parser)]
#[command(name = "makadam", version, after_help = EXIT_CODES, max_term_width = 100)]
struct Arguments {
    /// Command to run.
    #[command(subcommand)]
    command: Command,
    /// Print only results and errors.
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Print more messages.
    #[arg(short, long, global = true)]
    verbose: bool,
}

impl Arguments {
    /// Returns the definition of the command line; its help lists the commands by group.
    fn definition() -> clap::Command {
        let command = Arguments::command();
        let mut listing = String::new();
        for (title, names) in GROUPS {
            let _ = writeln!(listing, "{title}:");
            for name in names.iter().map(|name| name.to_lowercase()) {
                let about = command.find_subcommand(&name).and_then(clap::Command::get_about);
                let about = about.expect("a command has help");
                let _ = writeln!(listing, "  {name:<10} {about}");
            }
            listing.push('\n');
        }
        let template = format!(
            "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{listing}Options:\n{{options}}{{after-help}}"
        );
        command.help_template(template)
    }

    /// Reads a command line.
    ///
    /// # Errors
    /// [`clap::Error`] for an invalid command line, or for a request of the help or the version.
    fn read(words: &[OsString]) -> Result<Arguments, clap::Error> {
        let matches = Arguments::definition().try_get_matches_from(words)?;
        Arguments::from_arg_matches(&matches)
    }
}

/// Runs the program on the arguments of the process.
pub fn main() -> ExitCode {
    run_program(std::env::args_os().collect())
}

/// Runs the program on arguments, the first being its name.
pub fn run_program(arguments: Vec<OsString>) -> ExitCode {
    crate::state_commit();
    makadam_frames::provenance::set_command_line(&arguments);
    let arguments = match Arguments::read(&arguments) {
        Ok(arguments) => arguments,
        Err(message) => return print_clap(&renamed::with_new_name(message, &arguments)),
    };
    let console = Console::new(arguments.quiet, arguments.verbose);
    makadam_frames::interrupt::listen();
    let done = match ranks::join(matches!(arguments.command, Command::Run(_))) {
        Ok(true) => Ok(ExitCode::SUCCESS),
        Ok(false) => arguments.command.run(&console),
        Err(failure) => Err(failure),
    };
    let code = exit_code(done, &console);
    ranks::leave();
    code
}

/// Prints the help, the version, or an error of the command line.
fn print_clap(message: &clap::Error) -> ExitCode {
    if message.use_stderr() {
        message.exit();
    }
    let console = Console::new(false, false);
    let styled = message.render();
    let text = if console.colour() { styled.ansi().to_string() } else { styled.to_string() };
    exit_code(console.page(text.trim_end()).map(|()| ExitCode::SUCCESS), &console)
}

/// Reports a failure, unless standard output is closed.
fn exit_code(done: Result<ExitCode, Failure>, console: &Console) -> ExitCode {
    done.unwrap_or_else(|failure| {
        if !matches!(failure, Failure::ClosedOutput) {
            console.error(&failure.to_string());
        }
        ExitCode::from(failure.exit_code())
    })
}

/// Returns success, or the exit code of results outside their tolerance.
fn within_tolerance(within: bool) -> ExitCode {
    if within { ExitCode::SUCCESS } else { ExitCode::from(OUTSIDE_TOLERANCE) }
}

fn json(value: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(value).expect("results hold only numbers, plain text and lists")
}
