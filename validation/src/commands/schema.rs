//! `makadam schema`: the language of scenes.

use super::arguments::SchemaArguments;
use super::{Console, Failure, json};
use crate::scenes;
use std::process::ExitCode;

/// Prints the JSON Schema, or the page.
pub(super) fn schema(arguments: &SchemaArguments, console: &Console) -> Result<ExitCode, Failure> {
    console.page(&if arguments.markdown { scenes::page().trim_end().to_string() } else { json(&scenes::schema()) })?;
    Ok(ExitCode::SUCCESS)
}
