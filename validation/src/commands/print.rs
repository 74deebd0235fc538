//! `makadam print`: scenes, observables, schemas, completions and manual pages.

use super::arguments::nothing_measures;
use super::{Arguments, Console, Failure, json};
use clap::{Args, Subcommand};
use clap_complete::Shell;
use makadam_compare::scenes;
use makadam_frames::output::{WriteError, create_folder};
use makadam_measure::observables::catalogue::{Definition, definitions, page};
use makadam_qualification::report;
use makadam_view::draw::wrapped;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct PrintArguments {
    /// Text to print.
    #[command(subcommand)]
    text: Text,
}

#[derive(Debug, Subcommand)]
enum Text {
    /// List the scenes available by name.
    Scenes {
        /// Print the list as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Define the observables.
    Observables {
        /// Names of observables or groups; all, if absent.
        names: Vec<String>,
        /// Print the definitions as JSON.
        #[arg(long)]
        json: bool,
        /// Print the page of all definitions, in Markdown.
        #[arg(long, conflicts_with_all = ["json", "names"])]
        markdown: bool,
    },
    /// Print the scene language, as a JSON Schema or as a page; or the JSON Schema of reports.
    Schema {
        /// Print a page in Markdown instead of the JSON Schema.
        #[arg(long)]
        markdown: bool,
        /// Print the JSON Schema of report.json, which qualify and compare write, instead of the schema of scenes. It has no page.
        #[arg(long, conflicts_with = "markdown")]
        report: bool,
    },
    /// Print a completion script for a shell.
    Completions {
        /// Shell.
        #[arg(value_enum)]
        shell: Shell,
    },
    /// Write manual pages.
    Manual {
        /// Folder for one page per command; if absent, the page of the program goes to standard output.
        #[arg(short, long)]
        output: Option<PathBuf>,
    },
}

pub(super) fn print(arguments: &PrintArguments, console: &Console) -> Result<ExitCode, Failure> {
    match &arguments.text {
        Text::Scenes { json } => list_scenes(*json, console)?,
        Text::Observables { markdown: true, .. } => console.page(page().trim_end())?,
        Text::Observables { names, json, .. } => define(names, *json, console)?,
        Text::Schema { markdown: true, .. } => console.page(scenes::page().trim_end())?,
        Text::Schema { report: true, .. } => console.page(&json(&report::schema()))?,
        Text::Schema { .. } => console.page(&json(&scenes::schema()))?,
        Text::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Arguments::definition(), "makadam", &mut script);
            console.page(String::from_utf8_lossy(&script).trim_end())?;
        }
        Text::Manual { output: Some(folder) } => write_manual(folder, console)?,
        Text::Manual { output: None } => {
            let mut page = Vec::new();
            let rendered = clap_mangen::Man::new(Arguments::definition()).render(&mut page);
            rendered.map_err(|error| Failure::Running(format!("the manual page: {error}")))?;
            console.page(String::from_utf8_lossy(&page).trim_end())?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

#[derive(Serialize)]
struct Named {
    name: String,
    description: String,
    grains: usize,
    file: String,
}

fn list_scenes(as_json: bool, console: &Console) -> Result<(), Failure> {
    let roots = scenes::roots();
    let named = scenes::known(&roots).into_iter().map(|name| {
        let file = scenes::find(&name, &roots)?;
        let scene = scenes::load(&file)?;
        let grains = scene.grain_count();
        Ok(Named { name, description: scene.description.clone(), grains, file: file.display().to_string() })
    });
    let named: Vec<Named> = named.collect::<Result<_, Failure>>()?;
    console.document(&named, as_json, || {
        let rows: Vec<Vec<String>> =
            named.iter().map(|named| vec![named.name.clone(), named.description.clone()]).collect();
        format!("{}\n\n`makadam new` writes a scene to start from to a file.", wrapped(&rows))
    })
}

/// Observable and its group.
#[derive(Serialize)]
struct Defined {
    group: &'static str,
    #[serde(flatten)]
    definition: &'static Definition,
}

/// Prints the definitions of the named observables or groups, or all.
fn define(names: &[String], as_json: bool, console: &Console) -> Result<(), Failure> {
    let plain = |name: &str| name.replace('-', "_").to_lowercase();
    let is_named = |name: &String, defined: &Defined| {
        [defined.group, defined.definition.name].iter().any(|known| plain(known) == plain(name))
    };
    let all = || definitions().map(|(group, definition)| Defined { group, definition });
    if let Some(name) = names.iter().find(|name| !all().any(|defined| is_named(name, &defined))) {
        return Err(Failure::Usage(nothing_measures(name)));
    }
    let wanted: Vec<Defined> =
        all().filter(|defined| names.is_empty() || names.iter().any(|name| is_named(name, defined))).collect();
    console.document(&wanted, as_json, || text(&wanted))
}

fn text(wanted: &[Defined]) -> String {
    let mut text = String::new();
    let mut group = "";
    for Defined { group: own, definition } in wanted {
        if *own != group {
            let _ = writeln!(text, "{}{own}", if group.is_empty() { "" } else { "\n" });
            group = own;
        }
        let unit = if definition.unit.is_empty() { String::new() } else { format!(" [{}]", definition.unit) };
        let _ = writeln!(text, "  {} ({}){unit}\n      {}", definition.name, definition.symbol, definition.formula);
        if !definition.source.is_empty() {
            let _ = writeln!(text, "      {}", definition.source);
        }
    }
    text + "\nName a group under measure.observables, a number under [[compare]]; ⟨⟩ are means over contacts or grains."
}

/// Writes one manual page per command.
fn write_manual(folder: &Path, console: &Console) -> Result<(), Failure> {
    create_folder(folder)?;
    clap_mangen::generate_to(Arguments::definition(), folder).map_err(|error| WriteError::new(folder, error))?;
    console.result(&format!("manual pages: {}", folder.display()))
}
