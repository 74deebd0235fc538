//! Arguments of `makadam lab problem`.

use super::shared::SceneArguments;
use super::values::positive;
use crate::problem::{AGREEMENT, Method, Settings};
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Arguments of `makadam lab problem`.
#[derive(Debug, Args)]
pub struct ProblemArguments {
    /// The command to run.
    #[command(subcommand)]
    pub command: ProblemCommand,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum ProblemCommand {
    /// Write the contact problem of one step of a scene to a file, in FCLIB's layout (HDF5).
    Export(ProblemExportArguments),
    /// Solve the problem in a file.
    Solve(ProblemSolveArguments),
    /// Solve the problems in files with every available solver, and compare the answers.
    Check(ProblemCheckArguments),
}

/// Arguments of `makadam lab problem export`.
#[derive(Debug, Args)]
pub struct ProblemExportArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Simulated time of the step, s; the scene's duration, if absent.
    #[arg(long, value_parser = positive)]
    pub time: Option<f64>,
    /// Number of steps before it, instead of a time.
    #[arg(long, conflicts_with = "time")]
    pub steps: Option<u64>,
    /// File to write.
    #[arg(short, long)]
    pub output: PathBuf,
}

/// Arguments of `makadam lab problem solve`.
#[derive(Debug, Args)]
pub struct ProblemSolveArguments {
    /// File from `makadam lab problem export`, or FCLIB file with a local problem.
    pub file: PathBuf,
    /// Solver.
    #[arg(long, value_enum, default_value_t = MethodName::Reference)]
    pub method: MethodName,
    /// Stop when the largest change in a sweep is below this, in units of g h (1 m/s without gravity).
    #[arg(long, default_value_t = Settings::DEFAULT.tolerance, value_parser = positive)]
    pub tolerance: f64,
    /// Largest number of sweeps.
    #[arg(long, default_value_t = Settings::DEFAULT.most_sweeps, value_parser = clap::value_parser!(u32).range(1..))]
    pub sweeps: u32,
    /// Also write the problem to this file, with the solution in FCLIB's group.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `makadam lab problem check`.
#[derive(Debug, Args)]
pub struct ProblemCheckArguments {
    /// Files from `makadam lab problem export`, or FCLIB files with local problems.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Stop when the largest change in a sweep is below this, in units of g h (1 m/s without gravity).
    #[arg(long, default_value_t = Settings::DEFAULT.tolerance, value_parser = positive)]
    pub tolerance: f64,
    /// Largest number of sweeps.
    #[arg(long, default_value_t = Settings::DEFAULT.most_sweeps, value_parser = clap::value_parser!(u32).range(1..))]
    pub sweeps: u32,
    /// Largest velocity difference at which answers agree, in the same units.
    #[arg(long, default_value_t = AGREEMENT, value_parser = positive)]
    pub agreement: f64,
    /// Also solve with Siconos, which must be installed (Debian's python3-siconos).
    #[arg(long)]
    pub siconos: bool,
    /// Print the answers as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Solvers by their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodName {
    /// Projected Gauss-Seidel, one contact after another.
    Reference,
    /// Newton's method with dense matrices, up to 500 contacts.
    Direct,
    /// The simulation's own sweeps: their result when the file was written.
    Lanes,
    /// Siconos' projected Gauss-Seidel.
    Siconos,
}

impl From<MethodName> for Method {
    fn from(name: MethodName) -> Method {
        match name {
            MethodName::Reference => Method::Reference,
            MethodName::Direct => Method::Direct,
            MethodName::Lanes => Method::Lanes,
            MethodName::Siconos => Method::Siconos,
        }
    }
}
