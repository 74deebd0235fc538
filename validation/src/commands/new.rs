//! `makadam new`: a scene to begin with.

use super::arguments::NewArguments;
use super::{Console, Failure};
use crate::templates::template;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Writes the scene into a new file.
pub(super) fn new(arguments: &NewArguments, console: &Console) -> Result<ExitCode, Failure> {
    let template = template(&arguments.kind).expect("arguments name one that there is");
    let file = arguments.file.clone().unwrap_or_else(|| PathBuf::from(format!("{}.toml", template.name)));
    let shown = file.display();
    let mut opened =
        OpenOptions::new().write(true).create_new(true).open(&file).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => {
                Failure::Usage(format!("{shown} exists already and is not overwritten; give another file"))
            }
            _ => Failure::Running(format!("{shown}: {error}")),
        })?;
    opened.write_all(template.text.as_bytes()).map_err(|error| Failure::Running(format!("{shown}: {error}")))?;
    console.result(&format!("{shown}\n\nnext: makadam check {shown}; makadam run {shown}"))?;
    Ok(ExitCode::SUCCESS)
}
