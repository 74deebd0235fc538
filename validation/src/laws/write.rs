//! The files of a law: rows as CSV, the study as JSON, figures as SVG, scenes as TOML.

use super::{Case, Law, Row, Study};
use crate::output::{WriteError, create_folder, write_whole};
use crate::study::{DocumentError, Table, cells, drawn, json, write_together};
use std::collections::BTreeSet;
use std::path::Path;

/// Writes the scene of each case to `scenes/CASE.toml`, to be run by hand.
///
/// # Errors
/// [`WriteError`] if the system refuses.
pub(crate) fn write_scenes(cases: &[Case], folder: &Path) -> Result<(), WriteError> {
    create_folder(&folder.join("scenes"))?;
    for case in cases {
        let text = toml::to_string(&case.scene).expect("a scene is made of plain tables");
        write_whole(&folder.join("scenes").join(format!("{}.toml", case.name)), text.as_bytes())?;
    }
    Ok(())
}

/// Writes `laws.json`, `rows.csv` and the figures of the one law of a study.
///
/// # Errors
/// [`DocumentError`] if the system refuses.
pub(crate) fn write(law: &dyn Law, study: &Study, folder: &Path) -> Result<(), DocumentError> {
    let mut files = vec![json("laws", study)?];
    for result in &study.laws {
        files.push(runs(&result.rows).csv("rows")?);
        files.extend(law.figures(&result.means).iter().map(drawn));
    }
    write_together(folder, &files)
}

/// Columns before the values.
pub(super) const LEADING: [&str; 7] = ["case", "seed", "grains", "steps", "wall_seconds", "scene_hash", "makadam"];

/// One row a run; the values of all cases by name.
pub(crate) fn runs(rows: &[Row]) -> Table {
    let names: BTreeSet<&str> = rows.iter().flat_map(|row| row.values.keys().map(String::as_str)).collect();
    Table::new(&[], &LEADING).with_numbers(&names).of(rows, |row| {
        let Row { case, seed, grains, steps, wall_seconds, scene_hash, makadam, .. } = row;
        let leading = cells![case, *seed, *grains, *steps, *wall_seconds, scene_hash, makadam];
        leading.into_iter().chain(names.iter().map(|name| row.values.get(*name).copied().into())).collect()
    })
}
