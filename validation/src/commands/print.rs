//! `makadam print`: scenes, observables, schemas, completions and manual pages.

use super::arguments::{
    Arguments, CompletionsArguments, ManualArguments, ObservablesArguments, SceneListArguments, SchemaArguments,
};
use super::{Console, Failure, json};
use crate::draw::wrapped;
use crate::observables::catalogue::{Definition, definitions, known, page};
use crate::output::{WriteError, create_folder};
use crate::{report, scenes};
use makadam::scene::suggestion;
use serde::Serialize;
use std::fmt::Write;
use std::process::ExitCode;

/// A scene that can be named.
#[derive(Serialize)]
struct Named {
    name: String,
    description: String,
    grains: usize,
    file: String,
}

/// Lists the scenes that can be given by name, with their descriptions.
pub(super) fn scenes(arguments: &SceneListArguments, console: &Console) -> Result<ExitCode, Failure> {
    let roots = scenes::roots();
    let mut named = Vec::new();
    for name in scenes::known(&roots) {
        let file = scenes::find(&name, &roots)?;
        let scene = scenes::load(&file)?;
        let grains = scene.grain_count();
        let (description, file) = (scene.description.clone(), file.display().to_string());
        named.push(Named { name, description, grains, file });
    }
    if arguments.json {
        console.result(&json(&named))?;
        return Ok(ExitCode::SUCCESS);
    }
    let rows: Vec<Vec<String>> = named.into_iter().map(|named| vec![named.name, named.description]).collect();
    console.result(&format!("{}\n\n`makadam new` writes a scene to start from to a file.", wrapped(&rows)))?;
    Ok(ExitCode::SUCCESS)
}

/// A number and its group.
#[derive(Serialize)]
struct Defined {
    group: &'static str,
    #[serde(flatten)]
    definition: &'static Definition,
}

/// Defines the numbers that were asked for.
pub(super) fn observables(arguments: &ObservablesArguments, console: &Console) -> Result<ExitCode, Failure> {
    let plain = |name: &str| name.replace('-', "_").to_lowercase();
    let is_named = |name: &str, defined: &Defined| {
        [defined.group, defined.definition.name].iter().any(|known| plain(known) == plain(name))
    };
    let all = || definitions().map(|(group, definition)| Defined { group, definition });
    for name in &arguments.names {
        if !all().any(|defined| is_named(name, &defined)) {
            let remedy = suggestion(name, known(), "`makadam print observables` lists all names");
            return Err(Failure::Usage(format!("nothing measures '{name}'; {remedy}")));
        }
    }
    let asked =
        |defined: &Defined| arguments.names.is_empty() || arguments.names.iter().any(|name| is_named(name, defined));
    let wanted: Vec<Defined> = all().filter(asked).collect();
    if arguments.markdown {
        console.page(page().trim_end())?;
        return Ok(ExitCode::SUCCESS);
    }
    console.result(&if arguments.json { json(&wanted) } else { text(&wanted) })?;
    Ok(ExitCode::SUCCESS)
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

/// Prints the JSON Schema of a scene or of a report, or the page.
pub(super) fn schema(arguments: &SchemaArguments, console: &Console) -> Result<ExitCode, Failure> {
    console.page(&match (arguments.markdown, arguments.report) {
        (true, _) => scenes::page().trim_end().to_string(),
        (false, true) => json(&report::schema()),
        (false, false) => json(&scenes::schema()),
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Prints the completion script of a shell.
pub(super) fn completions(arguments: &CompletionsArguments, console: &Console) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::definition(), "makadam", &mut script);
    console.page(String::from_utf8_lossy(&script).trim_end())?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the pages of all commands, or prints that of the program.
pub(super) fn manual(arguments: &ManualArguments, console: &Console) -> Result<ExitCode, Failure> {
    match &arguments.output {
        Some(folder) => {
            create_folder(folder)?;
            clap_mangen::generate_to(Arguments::definition(), folder)
                .map_err(|error| WriteError::new(folder, error))?;
            console.result(&format!("manual pages: {}", folder.display()))?;
        }
        None => {
            let mut page = Vec::new();
            let rendered = clap_mangen::Man::new(Arguments::definition()).render(&mut page);
            rendered.map_err(|error| Failure::Running(format!("the manual page: {error}")))?;
            console.page(String::from_utf8_lossy(&page).trim_end())?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
