//! CSV with the state of the grains: a file per frame, which `[start]` of a scene reads.

use super::{ExportError, Written, for_each};
use crate::import::{Column, FrameTable, ImportError};
use crate::output::{create_folder, write_whole};
use crate::run_frames::RunFrames;
use std::path::Path;

/// Folder of the files inside the output folder.
const FOLDER: &str = "csv";

/// Names and meanings of the columns of numbers.
const COLUMNS: [(&str, Column); 10] = [
    ("x", Column::Position(0)),
    ("y", Column::Position(1)),
    ("z", Column::Position(2)),
    ("radius", Column::Radius),
    ("vx", Column::Velocity(0)),
    ("vy", Column::Velocity(1)),
    ("vz", Column::Velocity(2)),
    ("wx", Column::Spin(0)),
    ("wy", Column::Spin(1)),
    ("wz", Column::Spin(2)),
];

fn line(cells: impl Iterator<Item = String>) -> String {
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
        let mut text = line(COLUMNS.map(|(name, _)| name.to_string()).into_iter().chain(["material".into()]));
        for (grain, material) in frame.particles.iter().zip(materials) {
            let numbers = grain.position.into_iter().chain([grain.radius]).chain(grain.velocity).chain(grain.spin);
            text += &line(numbers.map(|number| number.to_string()).chain([names[material as usize].clone()]));
        }
        Ok(write_whole(&folder.join(format!("grains-{number:05}.csv")), text.as_bytes())?)
    })?;
    Ok(vec![Written { path: folder, frames: run.count() }])
}

/// Returns the text for a frame of another code, in the order of its numbers: the columns that it has, without materials.
///
/// # Errors
/// [`ImportError`] for a frame without coordinates or sizes.
pub fn of_table(table: &FrameTable) -> Result<String, ImportError> {
    let find = |column: Column| match (table.find(column), column) {
        (None, Column::Radius) => table.find(Column::Diameter).map(|place| (place, 0.5)),
        (place, _) => place.map(|place| (place, 1.0)),
    };
    let columns: Vec<_> = COLUMNS.iter().filter_map(|(name, column)| Some((name, find(*column)?))).collect();
    if let Some((name, _)) = COLUMNS[..4].iter().find(|(_, column)| find(*column).is_none()) {
        let problem = format!("there is no column {name}; write it, or name the columns of the file in its first line");
        return Err(ImportError { file: table.file.clone(), line: table.line, problem });
    }
    let mut rows: Vec<&[f64]> = table.rows().collect();
    if let Some(id) = table.find(Column::Id) {
        rows.sort_by(|one, other| one[id].total_cmp(&other[id]));
    }
    let mut text = line(columns.iter().map(|(name, _)| name.to_string()));
    for row in rows {
        text += &line(columns.iter().map(|(_, (place, factor))| (factor * row[*place]).to_string()));
    }
    Ok(text)
}
