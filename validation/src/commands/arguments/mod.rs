//! The command line: every command's arguments, and the words that they take.

mod learn;
mod pictures;
mod problem;
mod runs;
mod shared;
mod studies;
mod values;

pub use learn::{
    CheckArguments, CompletionsArguments, ManualArguments, NewArguments, ObservablesArguments, SceneListArguments,
    SchemaArguments, SweepArguments,
};
pub use pictures::{AnimateArguments, ExportArguments, ExportFormat, PictureArguments, StyleArguments, ViewArguments};
pub use problem::{
    ProblemArguments, ProblemCheckArguments, ProblemCommand, ProblemExportArguments, ProblemSolveArguments,
};
pub use runs::{CompareArguments, QualifyArguments, RunArguments, Tier};
pub use shared::load;
pub use studies::{
    ConvergenceArguments, EffectsArguments, LawsArguments, RooflineArguments, ScalingArguments, StabilityArguments,
    TradeoffArguments,
};
pub use values::{BoundArgument, CodeName};

use clap::{Parser, Subcommand};

const EXIT_CODES: &str = "Exit codes: 0 pass, 1 failure while running, 2 usage, 3 invalid scene or problem file, \
    4 outside tolerance, undecided or not measured, 5 a reference code is missing.";

/// Granular matter by non-smooth contact dynamics, judged against YADE and LIGGGHTS.
#[derive(Debug, Parser)]
#[command(name = "makadam", version, about, after_help = EXIT_CODES)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Say nothing but results and errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Say more.
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a commented scene to begin with into a file.
    New(NewArguments),
    /// List the scenes that can be named.
    Scenes(SceneListArguments),
    /// Say what will run: grains, scales, settings and why, memory, time.
    Check(CheckArguments),
    /// Define the numbers that can be measured.
    Observables(ObservablesArguments),
    /// Print the language of scenes, as a JSON Schema or as a page.
    Schema(SchemaArguments),
    /// Simulate a scene; frames for ParaView, observables as CSV, provenance as JSON.
    Run(RunArguments),
    /// Run a scene over values of some of its keys, several seeds each, and put the means into one table.
    Sweep(SweepArguments),
    /// Compare Makadam with YADE and LIGGGHTS on one scene.
    Compare(CompareArguments),
    /// Judge Makadam on the reference scenes and write one report.
    Qualify(QualifyArguments),
    /// Measure how a scene's step scales with threads, and replay it beyond the cores at hand.
    Scaling(ScalingArguments),
    /// Show how each method converges on the problem of one step: residual against iterations and wall time.
    Convergence(ConvergenceArguments),
    /// Show what accuracy costs in time: error against wall time over the settings of each code.
    Tradeoff(TradeoffArguments),
    /// Measure the contact sweep against what arithmetic and memory deliver.
    Roofline(RooflineArguments),
    /// Run the hard cases: what breaks simulators, the right outcome, and who survives it.
    Stability(StabilityArguments),
    /// Tell which effects a scene calls for, what each costs, and, with --ablate, whether it matters.
    Effects(EffectsArguments),
    /// Measure published laws of granular matter and judge them against the published values.
    Laws(LawsArguments),
    /// Draw a frame of a run as a PNG file; needs no screen.
    Picture(PictureArguments),
    /// Draw the frames of a run as an animated GIF or PNG file; needs no screen.
    Animate(AnimateArguments),
    /// Write a run as one HTML file to turn, cut and play in a browser; needs no network.
    View(ViewArguments),
    /// Write the frames of a run for other programs: VTKHDF for ParaView, GSD for OVITO.
    Export(ExportArguments),
    /// Keep the contact problem of one step in a file, and solve it by every solver that there is.
    Problem(ProblemArguments),
    /// Print a script that completes the command in a shell.
    Completions(CompletionsArguments),
    /// Write manual pages.
    Manual(ManualArguments),
}
