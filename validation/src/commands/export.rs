//! `makadam export`: the frames of a run for other programs.

use super::arguments::{ExportArguments, ExportFormat};
use super::{Console, Failure};
use crate::export::{ExportError, Kind, write_gsd, write_vtkhdf};
use crate::output::create_folder;
use crate::run_frames::RunFrames;
use std::process::ExitCode;

/// Writes the files and says which.
pub(super) fn export(arguments: &ExportArguments, console: &Console) -> Result<ExitCode, Failure> {
    let run = RunFrames::open(&arguments.frames.run)?;
    let folder = arguments.output.clone().unwrap_or_else(|| run.folder().to_path_buf());
    create_folder(&folder)?;
    let bar = console.bar("exporting");
    let mut said = Vec::new();
    match arguments.format {
        ExportFormat::Vtkhdf => {
            for kind in Kind::ALL {
                let path = folder.join(format!("{}.vtkhdf", kind.name()));
                match write_vtkhdf(&path, &run, kind, &|share| bar.set(share))? {
                    0 => console.note(&format!("the run has no frames of {}", kind.name())),
                    frames => said.push(format!("{}: {frames} frames", path.display())),
                }
            }
        }
        ExportFormat::Gsd => {
            let path = folder.join("grains.gsd");
            let frames = write_gsd(&path, &run, &|share| bar.set(share))?;
            said.push(format!("{}: {frames} frames", path.display()));
        }
    }
    drop(bar);
    console.result(&said.join("\n"))?;
    Ok(ExitCode::SUCCESS)
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Failure {
        match error {
            ExportError::Frames(error) => error.into(),
            ExportError::Write(error) => error.into(),
            ExportError::Interrupted => Failure::Interrupted("nothing: the file was not finished".into()),
            ExportError::Format { .. } => Failure::Running(error.to_string()),
        }
    }
}
