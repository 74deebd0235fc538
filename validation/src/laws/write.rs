//! The files of a law: rows as CSV, the study as JSON, figures as SVG, scenes as TOML.

use super::{Case, Law, Row, Study};
use crate::draw::svg::standalone;
use crate::output::cells::without_formulas;
use crate::output::{WriteError, create_folder, write_whole};
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
/// [`WriteError`] if the system refuses.
pub(crate) fn write(law: &dyn Law, study: &Study, folder: &Path) -> Result<(), WriteError> {
    let json = serde_json::to_vec_pretty(study).expect("a study holds only numbers, plain text and lists");
    write_whole(&folder.join("laws.json"), &json)?;
    for result in &study.laws {
        write_whole(&folder.join("rows.csv"), &without_formulas(csv(&result.rows).into_bytes()))?;
        for figure in law.figures(&result.means) {
            let path = folder.join(format!("{}.svg", figure.name));
            write_whole(&path, standalone(&figure.svg).as_bytes())?;
        }
    }
    Ok(())
}

/// Columns before the values.
pub(super) const LEADING: [&str; 7] = ["case", "seed", "grains", "steps", "wall_seconds", "scene_hash", "makadam"];

/// One row a run; the values of all cases by name.
fn csv(rows: &[Row]) -> String {
    let names: BTreeSet<&str> = rows.iter().flat_map(|row| row.values.keys().map(String::as_str)).collect();
    let mut text = LEADING.join(",");
    for name in &names {
        text += &format!(",{name}");
    }
    text.push('\n');
    for row in rows {
        let Row { case, seed, grains, steps, wall_seconds, scene_hash, makadam, .. } = row;
        text += &format!("{case},{seed},{grains},{steps},{wall_seconds:?},{scene_hash},{makadam}");
        for name in &names {
            text += &row.values.get(*name).map_or(",".into(), |value| format!(",{value:?}"));
        }
        text.push('\n');
    }
    text
}
