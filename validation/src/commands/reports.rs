//! `makadam reports`: all reports below a folder on one page.

use super::arguments::ReportsArguments;
use super::{Console, Failure, json};
use crate::draw::numbers::plural;
use crate::output::JSON_VERSION;
use crate::reports::{DEEPEST, Entry, Index, Unreadable, find};
use serde::Serialize;
use std::process::ExitCode;

/// What `makadam reports --json` prints; its documentation is `validation/docs/json.md`.
#[derive(Serialize)]
struct ReportsDocument<'a> {
    version: u32,
    command: &'static str,
    page: String,
    reports: &'a [Entry],
    unreadable: &'a [Unreadable],
}

/// Finds and reads the reports, and writes the page.
pub(super) fn reports(arguments: &ReportsArguments, console: &Console) -> Result<ExitCode, Failure> {
    let folder = &arguments.folder;
    let found = find(folder).map_err(|error| Failure::Usage(error.to_string()))?;
    if found.reports.is_empty() {
        found.unseen.iter().for_each(|(path, problem)| console.warn(&format!("{}: {problem}", path.display())));
        return Err(Failure::Usage(format!(
            "there is no report.json in {} nor in the folders below it, {DEEPEST} deep; give the folder that makadam qualify, compare \
             or judge wrote its report to (--output), or one above it",
            folder.display()
        )));
    }
    if !Index::may_write(folder) {
        return Err(Failure::Usage(format!(
            "{} is no page of reports; move it, or give another folder: the page of the reports goes there",
            folder.join("index.html").display()
        )));
    }
    let index = Index::read(folder, &found);
    index.unreadable.iter().for_each(|one| console.warn(&format!("not read: {}: {}", one.file, one.problem)));
    let page = index.write(folder)?.display().to_string();
    let Index { reports, unreadable } = &index;
    console.result(&match arguments.json {
        true => json(&ReportsDocument { version: JSON_VERSION, command: "reports", page, reports, unreadable }),
        false => format!("{}\npage: {page}", index.text()),
    })?;
    match reports.is_empty() {
        true => {
            Err(Failure::Running(format!("none of the {} found could be read", plural(found.reports.len(), "report"))))
        }
        false => Ok(ExitCode::SUCCESS),
    }
}
