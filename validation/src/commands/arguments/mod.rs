//! The command line: every command's arguments, and the words that they take.

mod frames;
mod learn;
mod pictures;
mod problem;
mod renamed;
mod runs;
mod shared;
mod studies;
mod values;

pub use frames::MeasureArguments;
pub use learn::{
    CheckArguments, CompletionsArguments, ManualArguments, NewArguments, ObservablesArguments, SceneListArguments,
    SchemaArguments, SweepArguments,
};
pub use pictures::{ExportArguments, PictureArguments, ViewArguments};
pub use problem::{
    ProblemArguments, ProblemCheckArguments, ProblemCommand, ProblemExportArguments, ProblemSolveArguments,
};
pub use renamed::with_new_name;
pub use runs::{CompareArguments, QualifyArguments, RunArguments};
pub use shared::load;
pub use studies::{
    ConvergenceArguments, EffectsArguments, LawsArguments, ScalingArguments, StabilityArguments, TradeoffArguments,
};
pub use values::BoundArgument;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;
use std::fmt::Write;

const EXIT_CODES: &str = "Exit codes: 0 pass, 1 failure while running, 2 usage, 3 invalid scene, problem or frame file, \
    4 outside tolerance, undecided or not measured, 5 a reference code is missing.";

/// Groups of commands in the help, in the order of their listing.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Simulate", &["new", "check", "run", "sweep"]),
    ("Look", &["view", "picture", "measure", "export"]),
    ("Compare", &["compare", "qualify"]),
    ("Study", &["laws", "stability", "effects", "tradeoff", "lab"]),
    ("Manage", &["print"]),
];

/// Simulates grains in contact by non-smooth contact dynamics, measures and shows the results, and compares them with YADE, LIGGGHTS and LAMMPS.
#[derive(Debug, Parser)]
#[command(name = "makadam", version, after_help = EXIT_CODES, max_term_width = 100)]
pub struct Arguments {
    /// The command to run.
    #[command(subcommand)]
    pub command: Command,
    /// Print only results and errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Print more messages.
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

impl Arguments {
    /// Returns the definition of the command line; its help lists the commands by group.
    pub fn definition() -> clap::Command {
        let command = Arguments::command();
        let mut listing = String::new();
        for (title, names) in GROUPS {
            let _ = writeln!(listing, "{title}:");
            for name in names {
                let about =
                    command.find_subcommand(name).and_then(clap::Command::get_about).expect("a command has help");
                let _ = writeln!(listing, "  {name:<10} {about}");
            }
            listing.push('\n');
        }
        let template = format!(
            "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{listing}Options:\n{{options}}{{after-help}}"
        );
        command.help_template(template)
    }

    /// Reads the words of a command line.
    ///
    /// # Errors
    /// [`clap::Error`] if they are wrong, or request the help or the version.
    pub fn read(words: &[OsString]) -> Result<Arguments, clap::Error> {
        let matches = Arguments::definition().try_get_matches_from(words)?;
        Arguments::from_arg_matches(&matches)
    }
}

/// The commands, in the groups of the help.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a commented scene to start from to a file.
    New(NewArguments),
    /// Describe a run before it starts: grains, scales, settings, memory, time.
    Check(CheckArguments),
    /// Simulate a scene: frames, observables as CSV, provenance as JSON.
    Run(RunArguments),
    /// Run a scene over values of its keys, several seeds each; write one table.
    Sweep(SweepArguments),
    /// Write a run as one HTML file to turn, cut and play in a browser.
    View(ViewArguments),
    /// Draw a frame of a run as PNG, or all frames as animated GIF or APNG.
    Picture(PictureArguments),
    /// Measure the output files of any code: dumps, VTK, CSV, VTKHDF.
    Measure(MeasureArguments),
    /// Write a run for ParaView or OVITO, or a scene for another code.
    Export(ExportArguments),
    /// Compare codes on one scene: Makadam, YADE, LIGGGHTS, LAMMPS, or your own.
    Compare(CompareArguments),
    /// Validate Makadam on the reference scenes and write one report.
    Qualify(QualifyArguments),
    /// Measure published laws of granular matter and compare with their values.
    Laws(LawsArguments),
    /// Run stress tests: pathological scenes, each with its expected outcome.
    Stability(StabilityArguments),
    /// List the active physical effects of a scene, their costs and influence.
    Effects(EffectsArguments),
    /// Measure error against wall time over the settings of each code.
    Tradeoff(TradeoffArguments),
    /// Study the solver: convergence, scaling, single contact problems.
    Lab(LabArguments),
    /// Print references: scenes, observables, schemas, completions, manual.
    Print(PrintArguments),
}

/// Arguments of `makadam lab`.
#[derive(Debug, Args)]
pub struct LabArguments {
    /// The study.
    #[command(subcommand)]
    pub study: Lab,
}

/// Studies of the solver itself.
#[derive(Debug, Subcommand)]
pub enum Lab {
    /// Measure how each method converges on the problem of one step: residual against iterations and wall time.
    Convergence(ConvergenceArguments),
    /// Measure how a scene's step scales with threads, and replay it on more cores than this machine has.
    Scaling(ScalingArguments),
    /// Write the contact problem of one step to a file, and solve it with every available solver.
    Problem(ProblemArguments),
}

/// Arguments of `makadam print`.
#[derive(Debug, Args)]
pub struct PrintArguments {
    /// The text to print.
    #[command(subcommand)]
    pub text: Print,
}

/// Texts about the program.
#[derive(Debug, Subcommand)]
pub enum Print {
    /// List the scenes that can be given by name.
    Scenes(SceneListArguments),
    /// Define the observables.
    Observables(ObservablesArguments),
    /// Print the scene language, as a JSON Schema or as a page; or the JSON Schema of reports.
    Schema(SchemaArguments),
    /// Print a completion script for a shell.
    Completions(CompletionsArguments),
    /// Write manual pages.
    Manual(ManualArguments),
}
