//! CSV with the state of the grains: a file per frame, which `[start]` of a scene reads.

use super::{ExportError, Written, for_each};
use crate::output::{create_folder, write_whole};
use crate::run_frames::RunFrames;
use std::path::Path;

/// Folder of the files inside the output folder.
const FOLDER: &str = "csv";

/// Names of the columns of numbers.
pub const COLUMNS: [&str; 10] = ["x", "y", "z", "radius", "vx", "vy", "vz", "wx", "wy", "wz"];

/// Formats a line of the file.
pub fn line(cells: impl Iterator<Item = String>) -> String {
    cells.collect::<Vec<_>>().join(",") + "\n"
}

/// Writes `csv/grains-NUMBER.csv` into a folder.
pub(super) fn write(run: &RunFrames, folder: &Path, progress: &dyn Fn(f64)) -> Result<Vec<Written>, ExportError> {
    let folder = folder.join(FOLDER);
    create_folder(&folder)?;
    let names = run.materials();
    for_each(0..run.count(), progress, |number| {
        let frame = run.snapshot(number)?;
        let materials = run.read(number)?.column("material").map(|column| column.values).unwrap_or_default();
        let mut text = line(COLUMNS.map(str::to_string).into_iter().chain(["material".into()]));
        for (grain, material) in frame.particles.iter().zip(materials) {
            let numbers = grain.position.into_iter().chain([grain.radius]).chain(grain.velocity).chain(grain.spin);
            text += &line(numbers.map(|number| number.to_string()).chain([names[material as usize].clone()]));
        }
        Ok(write_whole(&folder.join(format!("grains-{number:05}.csv")), text.as_bytes())?)
    })?;
    Ok(vec![Written { path: folder, frames: run.count() }])
}
