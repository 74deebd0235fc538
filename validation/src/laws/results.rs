//! The results of laws: rows, means over seeds, findings; their tables, files and pages, and those of the recorded rows.

use super::{Case, Law, Values};
use crate::draw::numbers::bounds;
use crate::output::{WriteError, create_folder, write_whole};
use crate::study::{Cell, DocumentError, Finding, Table, cells, drawn, json, write_together};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What one run measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    /// Name of the case.
    pub(crate) case: String,
    /// Seed of the initial positions.
    pub(crate) seed: u64,
    /// What was chosen and what was measured, by name.
    pub(crate) values: Values,
    /// Hash of the scene, 16 hexadecimal digits.
    pub(crate) scene_hash: String,
    /// Version of Makadam.
    pub(crate) makadam: String,
    /// Number of grains.
    pub(crate) grains: usize,
    /// Steps taken.
    pub(crate) steps: u64,
    /// Wall time, s.
    pub(crate) wall_seconds: f64,
}

/// A case over its seeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Mean {
    /// Name of the case.
    pub(crate) case: String,
    /// Number of seeds.
    pub(crate) seeds: usize,
    /// Means, by name.
    pub(crate) values: Values,
    /// Standard deviations over seeds, by name; empty for a single seed.
    pub(crate) deviations: Values,
}

impl Mean {
    /// Cases in their order, each over its seeds.
    pub(crate) fn of(rows: &[Row]) -> Vec<Mean> {
        let mut names: Vec<&str> = rows.iter().map(|row| row.case.as_str()).collect();
        names.dedup();
        names.into_iter().map(|name| Mean::of_case(name, rows)).collect()
    }

    fn of_case(name: &str, rows: &[Row]) -> Mean {
        let own: Vec<&Row> = rows.iter().filter(|row| row.case == name).collect();
        let (mut values, mut deviations) = (Values::new(), Values::new());
        for key in own.iter().flat_map(|row| row.values.keys()) {
            if values.contains_key(key) {
                continue;
            }
            let each: Vec<f64> = own.iter().map(|row| row.values.get(key).copied().unwrap_or(f64::NAN)).collect();
            let mean = each.iter().sum::<f64>() / each.len() as f64;
            values.insert(key.clone(), mean);
            if each.len() > 1 {
                let square: f64 = each.iter().map(|value| (value - mean).powi(2)).sum();
                deviations.insert(key.clone(), (square / (each.len() - 1) as f64).sqrt());
            }
        }
        Mean { case: name.into(), seeds: own.len(), values, deviations }
    }

    /// A mean; not a number where it was not measured.
    pub(crate) fn of_value(&self, name: &str) -> f64 {
        self.values.get(name).copied().unwrap_or(f64::NAN)
    }
}

/// One law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LawResult {
    /// Its name.
    pub(crate) name: &'static str,
    /// What it says.
    pub(crate) statement: &'static str,
    /// Where it was published.
    pub(crate) source: &'static str,
    /// Whether every figure keeps its bounds.
    pub(crate) holds: bool,
    /// Figures and their bounds.
    pub(crate) findings: Vec<Finding>,
    /// Cases over their seeds.
    pub(crate) means: Vec<Mean>,
    /// One a run.
    pub(crate) rows: Vec<Row>,
}

impl LawResult {
    /// A law judged by its rows.
    pub(crate) fn new(law: &dyn Law, rows: Vec<Row>) -> LawResult {
        let means = Mean::of(&rows);
        let findings = law.judge(&means);
        LawResult {
            name: law.name(),
            statement: law.statement(),
            source: law.source(),
            holds: findings.iter().all(Finding::holds),
            findings,
            means,
            rows,
        }
    }
}

/// Everything that a run of `makadam laws` found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Study {
    /// Version of this document.
    pub(crate) version: u32,
    /// Always "laws".
    pub(crate) command: &'static str,
    /// Whether all laws hold.
    pub(crate) hold: bool,
    /// Whether fewer and smaller cases were run.
    pub(crate) quick: bool,
    /// Seeds of each case.
    pub(crate) seeds: Vec<u64>,
    /// The laws.
    pub(crate) laws: Vec<LawResult>,
    /// Where the numbers came from, by name.
    pub(crate) provenance: BTreeMap<String, String>,
}

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

/// Each law with its figures and bounds.
pub(crate) fn table(study: &Study) -> String {
    study.laws.iter().map(law).collect::<Vec<_>>().join("\n\n")
}

fn law(result: &LawResult) -> String {
    let verdict = if result.holds { "within tolerance" } else { "outside tolerance" };
    let runs = result.rows.len();
    let seconds: f64 = result.rows.iter().map(|row| row.wall_seconds).sum();
    let head = format!("{}: {verdict}\n{}\n{}\n", result.name, result.statement, result.source);
    format!("{head}\n{}{runs} runs, {seconds:.0} s of wall time", findings(result).text())
}

/// A figure with its unit, and its bounds.
pub(crate) fn in_words(finding: &Finding) -> [String; 2] {
    let value = format!("{} {}", number(finding.value), finding.unit);
    [value.trim().into(), bounds(finding.bounds(), number)]
}

/// Returns the findings of a law as a table.
fn findings(result: &LawResult) -> Table {
    Table::new(&["figure", "value", "bounds", "verdict"], &[]).of(&result.findings, |finding| {
        let [value, bounds] = in_words(finding);
        let verdict = match (finding.bounds(), finding.holds()) {
            ([None, None], _) => "",
            (_, true) => "within",
            (_, false) => "OUTSIDE",
        };
        [finding.what.clone(), value, bounds, verdict.into()].map(Cell::from).into()
    })
}

/// Four digits.
fn number(value: f64) -> String {
    let size = value.abs();
    match size == 0.0 || (1e-2..1e4).contains(&size) {
        true => format!(
            "{value:.*}",
            if size >= 100.0 {
                1
            } else if size >= 10.0 {
                2
            } else {
                3
            }
        ),
        false => format!("{value:.3e}"),
    }
}
