//! `makadam observables`: what each measured number is.

use super::arguments::ObservablesArguments;
use super::{Console, Failure, json};
use crate::observables::catalogue::{Definition, definitions, known, page};
use makadam::scene::suggestion;
use serde::Serialize;
use std::fmt::Write;
use std::process::ExitCode;

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
            let remedy = suggestion(name, known(), "`makadam observables` lists all names");
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
