//! `makadam export`: the frames of a run for other programs, and scenes for other codes.

use super::arguments::{ExportArguments, load};
use super::{Console, Failure};
use crate::export::{ExportError, Format, Written};
use crate::output::file_stem;
use crate::peers::{CodeName, Job, Purpose};
use crate::run_frames::RunFrames;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Writes the files and says which.
pub(super) fn export(arguments: &ExportArguments, console: &Console) -> Result<ExitCode, Failure> {
    match (arguments.code, arguments.format) {
        (Some(code), _) => export_scene(arguments, code, console),
        (None, Some(format)) => export_run(arguments, format, console),
        (None, None) => {
            Err(Failure::Usage("give --format for the frames of a run, or --for and a code for a scene".into()))
        }
    }
}

/// Writes what a code runs the scene from.
fn export_scene(arguments: &ExportArguments, code: CodeName, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene) = load(&arguments.what, &arguments.changes)?;
    let code = code.code();
    let name = format!("{}-{}", file_stem(&scene.name), code.name().to_lowercase());
    let folder = arguments.output.clone().unwrap_or_else(|| PathBuf::from(name));
    if std::fs::read_dir(&folder).is_ok_and(|mut entries| entries.next().is_some()) {
        let problem = format!("{} is not empty; give another folder with --output, or empty it", folder.display());
        return Err(Failure::Usage(problem));
    }
    let job = Job {
        scene: &scene,
        scene_file: &file,
        purpose: Purpose::Measuring,
        seed: arguments.seed.unwrap_or(scene.seed),
        stiffness_factor: 1.0,
        rayleigh_fraction: arguments.rayleigh_fraction,
        work_folder: &folder,
        time_limit: Duration::ZERO,
        progress: &|_| {},
    };
    let command = code.write_input(&job)?;
    let manifest = folder.join("frames.toml");
    let after = match manifest.is_file() {
        true => format!("\nmeasure its frames with: makadam measure {} --scene {}", manifest.display(), arguments.what),
        false => String::new(),
    };
    console.result(&format!("{}; run it there with: {command}{after}", folder.display()))?;
    Ok(ExitCode::SUCCESS)
}

fn export_run(arguments: &ExportArguments, format: Format, console: &Console) -> Result<ExitCode, Failure> {
    let run = RunFrames::open(Path::new(&arguments.what))?;
    let folder = arguments.output.clone().unwrap_or_else(|| run.folder().to_path_buf());
    console.result(&export_frames(&run, format, &folder, console)?)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the frames of a run into a folder in a format; returns a line per file.
pub(super) fn export_frames(
    run: &RunFrames,
    format: Format,
    folder: &Path,
    console: &Console,
) -> Result<String, Failure> {
    let bar = console.bar("exporting");
    let written = format.write(run, folder, &|share| bar.set(share))?;
    let lines = written.iter().map(|Written { path, frames }| format!("{}: {frames} frames", path.display()));
    Ok(lines.collect::<Vec<_>>().join("\n"))
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
