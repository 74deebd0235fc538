//! Arguments of `makadam problem`.

use super::shared::SceneArguments;
use super::values::positive;
use crate::problem::Method;
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Arguments of `makadam problem`.
#[derive(Debug, Args)]
pub struct ProblemArguments {
    /// What to do.
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
    /// Solve the problems in files by every solver that there is, and compare the answers.
    Check(ProblemCheckArguments),
}

/// Arguments of `makadam problem export`.
#[derive(Debug, Args)]
pub struct ProblemExportArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Simulated time of the step, s; the scene's duration, if absent.
    #[arg(long, value_parser = positive)]
    pub time: Option<f64>,
    /// The same as a number of steps.
    #[arg(long, conflicts_with = "time")]
    pub steps: Option<u64>,
    /// File to write.
    #[arg(short, long)]
    pub output: PathBuf,
}

/// Arguments of `makadam problem solve`.
#[derive(Debug, Args)]
pub struct ProblemSolveArguments {
    /// A file of `makadam problem export`, or one of FCLIB with a local problem.
    pub file: PathBuf,
    /// Solver.
    #[arg(long, value_enum, default_value_t = MethodName::Reference)]
    pub method: MethodName,
    /// Largest change of a sweep at which to stop, over g h (1 m/s without gravity).
    #[arg(long, default_value_t = 1e-10, value_parser = positive)]
    pub tolerance: f64,
    /// Most sweeps.
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub sweeps: u32,
    /// Write the problem to this file too, with the solution in FCLIB's group.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `makadam problem check`.
#[derive(Debug, Args)]
pub struct ProblemCheckArguments {
    /// Files of `makadam problem export`, or of FCLIB with local problems.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Largest change of a sweep at which to stop, over g h (1 m/s without gravity).
    #[arg(long, default_value_t = 1e-10, value_parser = positive)]
    pub tolerance: f64,
    /// Most sweeps.
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub sweeps: u32,
    /// Largest difference of velocities at which answers agree, over the same.
    #[arg(long, default_value_t = 1e-5, value_parser = positive)]
    pub agreement: f64,
    /// Solve them with Siconos too, which has to be installed (Debian's python3-siconos).
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
    /// The simulation's own sweeps: what they came to when the file was written.
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
