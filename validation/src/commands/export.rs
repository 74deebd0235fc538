//! `makadam export`: the frames of a run for other programs, and scenes for other codes.

use super::arguments::{ExportArguments, ExportFormat, load};
use super::{Console, Failure};
use crate::export::{ExportError, Kind, absent_from_gsd, write_gsd, write_vtkhdf};
use crate::output::{create_folder, file_stem};
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

fn export_run(arguments: &ExportArguments, format: ExportFormat, console: &Console) -> Result<ExitCode, Failure> {
    let run = RunFrames::open(Path::new(&arguments.what))?;
    let folder = arguments.output.clone().unwrap_or_else(|| run.folder().to_path_buf());
    create_folder(&folder)?;
    let bar = console.bar("exporting");
    let mut said = Vec::new();
    match format {
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
            for (name, taken) in absent_from_gsd(&run.read(run.count() - 1)?) {
                console.warn(&format!(
                    "the frames hold no {name}, nor will {}: its readers take {taken}; name {name} in [output] fields of the scene to have it",
                    path.display()
                ));
            }
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
