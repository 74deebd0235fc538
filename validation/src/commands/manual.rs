//! `makadam completions` and `makadam manual`: what shells and `man` want of the command line.

use super::arguments::{Arguments, CompletionsArguments, ManualArguments};
use super::{Console, Failure};
use crate::output::{WriteError, create_folder};
use clap::CommandFactory;
use std::process::ExitCode;

/// Prints the script.
pub(super) fn completions(arguments: &CompletionsArguments, console: &Console) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "makadam", &mut script);
    console.page(String::from_utf8_lossy(&script).trim_end())?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the pages of all commands, or prints that of the program.
pub(super) fn manual(arguments: &ManualArguments, console: &Console) -> Result<ExitCode, Failure> {
    match &arguments.output {
        Some(folder) => {
            create_folder(folder)?;
            clap_mangen::generate_to(Arguments::command(), folder).map_err(|error| WriteError::new(folder, error))?;
            console.result(&format!("manual pages: {}", folder.display()))?;
        }
        None => {
            let mut page = Vec::new();
            let rendered = clap_mangen::Man::new(Arguments::command()).render(&mut page);
            rendered.map_err(|error| Failure::Running(format!("the manual page: {error}")))?;
            console.page(String::from_utf8_lossy(&page).trim_end())?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
