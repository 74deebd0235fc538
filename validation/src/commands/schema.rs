//! `makadam schema`: the language of scenes, and the layout of reports.

use super::arguments::SchemaArguments;
use super::{Console, Failure, json};
use crate::{report, scenes};
use std::process::ExitCode;

/// Prints the JSON Schema of a scene or of a report, or the page.
pub(super) fn schema(arguments: &SchemaArguments, console: &Console) -> Result<ExitCode, Failure> {
    console.page(&match (arguments.markdown, arguments.report) {
        (true, _) => scenes::page().trim_end().to_string(),
        (false, true) => json(&report::schema()),
        (false, false) => json(&scenes::schema()),
    })?;
    Ok(ExitCode::SUCCESS)
}
