//! VTP files for ParaView: one file per frame of grains, contacts and walls, and a collection over time of each.

use super::{ExportError, Written};
use crate::output::{WriteError, create_folder, write_whole};
use crate::run_frames::{Kind, RunFrames};
use std::path::Path;

/// Folder of the files inside the output folder.
const FOLDER: &str = "frames";

/// Script that opens the collections in ParaView.
const SCRIPT: &str = include_str!("open-in-paraview.py");

/// Writes `frames/KIND-NUMBER.vtp`, `KIND.pvd` and `open-in-paraview.py` into a folder. Walls at rest are in the first frame alone.
///
/// # Errors
/// [`ExportError`] if a frame cannot be read, or the system refuses.
pub(super) fn write(run: &RunFrames, folder: &Path, progress: &dyn Fn(f64)) -> Result<Vec<Written>, ExportError> {
    create_folder(&folder.join(FOLDER))?;
    remove_earlier(&folder.join(FOLDER))?;
    let mut written = Vec::new();
    for (part, kind) in Kind::ALL.into_iter().enumerate() {
        let name = kind.name();
        let mut list = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for number in run.numbers(kind) {
            let file = format!("{FOLDER}/{name}-{number:05}.vtp");
            write_whole(&folder.join(&file), &run.poly_data(number, kind)?.encode())?;
            list += &format!("<DataSet timestep=\"{}\" part=\"0\" file=\"{file}\"/>\n", run.time(number));
            let share = (number + 1) as f64 / run.count() as f64;
            progress((part as f64 + share) / Kind::ALL.len() as f64);
            if crate::interrupt::requested() {
                return Err(ExportError::Interrupted);
            }
        }
        if !run.numbers(kind).is_empty() {
            let path = folder.join(format!("{name}.pvd"));
            write_whole(&path, (list + "</Collection>\n</VTKFile>\n").as_bytes())?;
            written.push(Written { path, frames: run.numbers(kind).len() });
        }
    }
    let script = folder.join("open-in-paraview.py");
    std::fs::write(&script, SCRIPT).map_err(|error| WriteError::new(&script, error))?;
    Ok(written)
}

/// Removes the frames of an earlier export, which may be more.
fn remove_earlier(folder: &Path) -> Result<(), ExportError> {
    let refused = |error| ExportError::Write(WriteError::new(folder, error));
    for entry in std::fs::read_dir(folder).map_err(refused)? {
        let path = entry.map_err(refused)?.path();
        let name = path.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_suffix(".vtp"));
        let number =
            name.and_then(|name| Kind::ALL.iter().find_map(|kind| name.strip_prefix(kind.name())?.strip_prefix('-')));
        if number.is_some_and(|number| number.len() >= 5 && number.bytes().all(|byte| byte.is_ascii_digit())) {
            std::fs::remove_file(&path).map_err(|error| WriteError::new(&path, error))?;
        }
    }
    Ok(())
}
