//! `makadam new`: a scene to start from.

use super::{Console, Failure};
use crate::templates::{TEMPLATES, template};
use clap::Args;
use clap::builder::PossibleValuesParser;
use makadam_frames::output::WriteError;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct NewArguments {
    /// Scene to start from.
    #[arg(value_parser = PossibleValuesParser::new(TEMPLATES.iter().map(|template| template.name)))]
    pub kind: String,
    /// File to write, or - for standard output; KIND.toml, if absent. An existing file is not overwritten.
    pub file: Option<PathBuf>,
}

pub(super) fn new(arguments: &NewArguments, console: &Console) -> Result<ExitCode, Failure> {
    let template = template(&arguments.kind).expect("the parser accepts names of templates only");
    if arguments.file.as_deref() == Some(Path::new("-")) {
        console.page(template.text.trim_end())?;
        return Ok(ExitCode::SUCCESS);
    }
    let file = arguments.file.clone().unwrap_or_else(|| PathBuf::from(format!("{}.toml", template.name)));
    let shown = file.display();
    let mut opened =
        OpenOptions::new().write(true).create_new(true).open(&file).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => {
                Failure::Usage(format!("{shown} exists already and is not overwritten; give another file"))
            }
            _ => Failure::Running(format!("{shown}: {error}")),
        })?;
    if let Err(error) = opened.write_all(template.text.as_bytes()) {
        // A partial file would block the next attempt.
        let _ = std::fs::remove_file(&file);
        return Err(WriteError::new(&file, error).into());
    }
    console.result(&format!("{shown}\n\nnext: makadam check {shown}; makadam run {shown}"))?;
    Ok(ExitCode::SUCCESS)
}
