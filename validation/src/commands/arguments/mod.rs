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

pub use frames::{JudgeArguments, MeasureArguments};
pub use learn::{
    CheckArguments, CompletionsArguments, ManualArguments, NewArguments, ObservablesArguments, SceneListArguments,
    SchemaArguments, SweepArguments,
};
pub use pictures::{AnimateArguments, ExportArguments, ExportFormat, PictureArguments, ViewArguments};
pub use problem::{
    ProblemArguments, ProblemCheckArguments, ProblemCommand, ProblemExportArguments, ProblemSolveArguments,
};
pub use renamed::with_new_name;
pub use runs::{CompareArguments, QualifyArguments, RunArguments};
pub use shared::{CodeRunArguments, load};
pub use studies::{
    ConvergenceArguments, EffectsArguments, LawsArguments, ScalingArguments, StabilityArguments, TradeoffArguments,
};
pub use values::BoundArgument;

use clap::{Parser, Subcommand};

const EXIT_CODES: &str = "Exit codes: 0 pass, 1 failure while running, 2 usage, 3 invalid scene, problem or frame file, \
    4 outside tolerance, undecided or not measured, 5 a reference code is missing.";

/// Simulates grains in contact by non-smooth contact dynamics, measures and shows what comes out, and judges it against YADE, LIGGGHTS and LAMMPS.
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

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a commented scene to start from to a file.
    New(NewArguments),
    /// List the scenes that can be given by name.
    Scenes(SceneListArguments),
    /// Describe what will run: grains, scales, settings and why, memory, time.
    Check(CheckArguments),
    /// Define the numbers that can be measured.
    Observables(ObservablesArguments),
    /// Print the scene language, as a JSON Schema or as a page; or the JSON Schema of reports.
    Schema(SchemaArguments),
    /// Simulate a scene: frames for ParaView, observables as CSV, provenance as JSON.
    Run(RunArguments),
    /// Run a scene over values of some of its keys, several seeds each; write one table of means.
    Sweep(SweepArguments),
    /// Measure frames that any code has left, as Makadam's own are measured: dumps, VTK, CSV, VTKHDF.
    Measure(MeasureArguments),
    /// Compare Makadam with YADE, LIGGGHTS and LAMMPS on one scene.
    Compare(CompareArguments),
    /// Judge a code of your own on one scene, as Makadam and its peers are judged.
    Judge(JudgeArguments),
    /// Judge Makadam on the reference scenes and write one report.
    Qualify(QualifyArguments),
    /// Measure how a scene's step scales with threads, and replay it on more cores than this machine has.
    Scaling(ScalingArguments),
    /// Measure how each method converges on the problem of one step: residual against iterations and wall time.
    Convergence(ConvergenceArguments),
    /// Measure what accuracy costs in time: error against wall time over the settings of each code.
    Tradeoff(TradeoffArguments),
    /// Run stress tests: pathological scenes, the expected outcome of each, pass or fail per code.
    Stability(StabilityArguments),
    /// List the active physical effects of a scene and their cost; with --ablate, test whether they change the results.
    Effects(EffectsArguments),
    /// Measure published laws of granular matter and compare them with the published values.
    Laws(LawsArguments),
    /// Draw a frame of a run as a PNG file; needs no screen.
    Picture(PictureArguments),
    /// Draw the frames of a run as an animated GIF or PNG file; needs no screen.
    Animate(AnimateArguments),
    /// Write a run as one HTML file to turn, cut and play in a browser; needs no network.
    View(ViewArguments),
    /// Write the frames of a run for other programs (VTKHDF for ParaView, GSD for OVITO), or a scene for another code.
    Export(ExportArguments),
    /// Write the contact problem of one step to a file, and solve it with every available solver.
    Problem(ProblemArguments),
    /// Print a completion script for a shell.
    Completions(CompletionsArguments),
    /// Write manual pages.
    Manual(ManualArguments),
}
