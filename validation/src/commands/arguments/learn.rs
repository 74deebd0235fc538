//! Arguments of the commands by which the program is learnt, and of the study of parameters.

use super::shared::{JobArguments, OutputArguments, SceneArguments, SourceArguments};
use super::values::{accuracy, observable};
use crate::parameter_study::Range;
use crate::templates::TEMPLATES;
use clap::Args;
use clap::builder::PossibleValuesParser;
use clap_complete::Shell;
use makadam::scene::Accuracy;
use std::path::PathBuf;

/// Arguments of `makadam new`.
#[derive(Debug, Args)]
pub struct NewArguments {
    /// Scene to start from.
    #[arg(value_parser = PossibleValuesParser::new(TEMPLATES.iter().map(|template| template.name)))]
    pub kind: String,
    /// File to write, or - for standard output; KIND.toml, if absent. An existing file is not overwritten.
    pub file: Option<PathBuf>,
}

/// Arguments of `makadam print scenes`.
#[derive(Debug, Args)]
pub struct SceneListArguments {
    /// Print the list as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `makadam check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Target accuracy, which replaces the scene's step and stopping rule, as for `makadam run`.
    #[arg(long, value_parser = accuracy)]
    pub accuracy: Option<Accuracy>,
    /// Print the description as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `makadam print observables`.
#[derive(Debug, Args)]
pub struct ObservablesArguments {
    /// Names of observables or groups; all, if absent.
    pub names: Vec<String>,
    /// Print them as JSON.
    #[arg(long)]
    pub json: bool,
    /// Print the page of all of them, in Markdown.
    #[arg(long, conflicts_with_all = ["json", "names"])]
    pub markdown: bool,
}

/// Arguments of `makadam print schema`.
#[derive(Debug, Args)]
pub struct SchemaArguments {
    /// Print a page in Markdown instead of the JSON Schema.
    #[arg(long)]
    pub markdown: bool,
    /// Print the JSON Schema of report.json, which qualify, compare and judge write, instead of that of scenes. There is no page of it.
    #[arg(long, conflicts_with = "markdown")]
    pub report: bool,
}

/// Arguments of `makadam print completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// The shell.
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Arguments of `makadam print manual`.
#[derive(Debug, Args)]
pub struct ManualArguments {
    /// Folder for one page per command; if absent, the page of the program goes to standard output.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// Arguments of `makadam sweep`.
#[derive(Debug, Args)]
pub struct SweepArguments {
    /// The scene.
    #[command(flatten)]
    pub source: SourceArguments,
    /// A key and its values, such as material.grain.friction=0.1,0.3,0.5; if given several times, every combination is run.
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    pub over: Vec<Range>,
    /// Number of seeds of each combination, consecutive from the scene's own (--set seed=N).
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: u64,
    /// Observables to print; if absent, those that the scene compares, or all that it measures. The files contain all.
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = observable)]
    pub observables: Vec<String>,
    /// Start again: repeat runs whose results are stored, and replace the tables of another sweep in the folder.
    #[arg(long)]
    pub restart: bool,
    /// Number of runs at the same time.
    #[command(flatten)]
    pub jobs: JobArguments,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}
