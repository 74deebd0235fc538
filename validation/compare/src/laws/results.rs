//! Results of laws: rows, means over seeds, findings; their report and files; fits by least squares.

use super::{Law, Values};
use crate::study::{Answer, Cell, Document, DocumentError, File, Finding, Medium, Report, Section, Table, cells};
use makadam_frames::provenance::facts;
use makadam_measure::statistics::{mean, standard_deviation};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::numbers::{bounds, four_digits, plural};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Measured values of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub(crate) case: String,
    pub(crate) seed: u64,
    /// Chosen and measured values, by name.
    pub(crate) values: Values,
    /// Hash of the scene, 16 hexadecimal digits.
    pub(crate) scene_hash: String,
    /// Version of Makadam.
    pub(crate) makadam: String,
    pub(crate) grains: usize,
    pub(crate) steps: u64,
    pub(crate) wall_seconds: f64,
}

/// Case averaged over its seeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mean {
    pub(crate) case: String,
    pub(crate) seeds: usize,
    /// Means, by name.
    pub(crate) values: Values,
    /// Standard deviations over seeds, by name; empty for a single seed.
    pub(crate) deviations: Values,
}

impl Mean {
    /// Averages each case over its seeds.
    pub(crate) fn of(rows: &[Row]) -> Vec<Mean> {
        let mut names: Vec<&str> = rows.iter().map(|row| row.case.as_str()).collect();
        names.dedup();
        names.into_iter().map(|name| Mean::of_case(name, rows)).collect()
    }

    fn of_case(name: &str, rows: &[Row]) -> Mean {
        let own: Vec<&Row> = rows.iter().filter(|row| row.case == name).collect();
        let (mut values, mut deviations) = (Values::new(), Values::new());
        for key in own.iter().flat_map(|row| row.values.keys()).collect::<BTreeSet<_>>() {
            let each: Vec<f64> = own.iter().map(|row| row.values.get(key).copied().unwrap_or(f64::NAN)).collect();
            values.insert(key.clone(), mean(&each));
            deviations.extend(standard_deviation(&each).map(|deviation| (key.clone(), deviation)));
        }
        Mean { case: name.into(), seeds: own.len(), values, deviations }
    }

    /// Returns a mean; NaN if it was not measured.
    pub(crate) fn of_value(&self, name: &str) -> f64 {
        self.values.get(name).copied().unwrap_or(f64::NAN)
    }
}

/// Law and the rows of its test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawResult {
    /// Name of the law.
    pub name: &'static str,
    /// Statement of the law.
    pub statement: &'static str,
    /// Publication of the law.
    pub source: &'static str,
    /// True if every figure is within its bounds.
    pub holds: bool,
    /// Comparisons with the published values.
    pub findings: Vec<Finding>,
    pub(crate) means: Vec<Mean>,
    /// Rows, one for each case and seed.
    pub rows: Vec<Row>,
    /// Figures of the report.
    #[serde(skip)]
    pub figures: Vec<Figure>,
}

impl LawResult {
    /// Tests a law by rows.
    pub fn new(law: &Law, rows: Vec<Row>) -> LawResult {
        let means = Mean::of(&rows);
        let findings = (law.judge)(&means);
        LawResult {
            name: law.name,
            statement: law.statement,
            source: law.source,
            holds: findings.iter().all(Finding::holds),
            figures: (law.figures)(&means),
            findings,
            means,
            rows,
        }
    }

    /// Returns the wall time of all runs, s.
    pub fn wall_seconds(&self) -> f64 {
        self.rows.iter().map(|row| row.wall_seconds).sum()
    }

    fn sections(&self) -> [Section; 2] {
        let verdict = if self.holds { "within tolerance" } else { "outside tolerance" };
        let table = Table::new(&["figure", "value", "bounds", "verdict"], &[]).of(&self.findings, |finding| {
            let [value, bounds] = figure_and_bounds(finding);
            let verdict = match ([finding.low, finding.high], finding.holds()) {
                ([None, None], _) => "",
                (_, true) => "within",
                (_, false) => "OUTSIDE",
            };
            cells![&finding.what, value, bounds, verdict]
        });
        let names: BTreeSet<&String> = self.means.iter().flat_map(|mean| mean.values.keys()).collect();
        let means = Table::new(&["case"], &[]).with_numbers(&names).of(&self.means, |mean| {
            let value = |name: &&String| mean.values.get(*name).map(|value| four_digits(*value));
            [Cell::from(&mean.case)].into_iter().chain(names.iter().map(|name| value(name).into())).collect()
        });
        let description = format!("{} ({}).", self.statement, self.source);
        [
            Section::new(format!("{}: {verdict}", self.name), description, table),
            Section::new(format!("{}: means over seeds", self.name), "", means).only(Medium::Page),
        ]
    }
}

/// Content of `laws.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Study {
    /// Version of the document.
    pub version: u32,
    /// Command that wrote the document.
    pub command: &'static str,
    /// True if all laws hold.
    pub hold: bool,
    /// True if fewer and smaller cases were run.
    pub quick: bool,
    /// Seeds of the cases.
    pub seeds: Vec<u64>,
    /// Results of each law.
    pub laws: Vec<LawResult>,
    /// Provenance by name.
    pub provenance: BTreeMap<String, String>,
}

impl Document for Study {
    const NAME: &'static str = "laws";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![runs(self.laws.iter().flat_map(|law| &law.rows)).csv("rows")?])
    }

    fn figures(&self) -> Vec<Figure> {
        self.laws.iter().flat_map(|law| law.figures.iter().cloned()).collect()
    }

    fn report(&self) -> Report {
        let holding = self.laws.iter().filter(|law| law.holds).count();
        let runs = |law: &LawResult| {
            format!("{}: {}, {:.0} s of wall time", law.name, plural(law.rows.len(), "run"), law.wall_seconds())
        };
        Report {
            kind: "Makadam, published laws",
            title: "Published laws".into(),
            facts: facts(&self.provenance),
            answer: Answer::of(
                self.hold,
                format!("{holding} of {} within tolerance.", plural(self.laws.len(), "law")),
                if self.quick { "The cases are small (--quick).".into() } else { String::new() },
            ),
            findings: self.laws.iter().map(runs).collect(),
            sections: self.laws.iter().flat_map(LawResult::sections).collect(),
            notes: Vec::new(),
            limits: vec![
                "Bounds were chosen before the first measurement; figures without bounds are reported only.".into(),
            ],
            provenance: self.provenance.clone().into_iter().collect(),
            files: "laws.json and rows.csv",
        }
    }
}

/// Columns before the values.
pub(super) const LEADING: [&str; 7] = ["case", "seed", "grains", "steps", "wall_seconds", "scene_hash", "makadam"];

/// Returns a table with one row per run; the values of all cases by name.
pub fn runs<'a>(rows: impl IntoIterator<Item = &'a Row, IntoIter: Clone>) -> Table {
    let rows = rows.into_iter();
    let names: BTreeSet<&str> = rows.clone().flat_map(|row| row.values.keys().map(String::as_str)).collect();
    Table::new(&[], &LEADING).with_numbers(&names).of(rows, |row| {
        let Row { case, seed, grains, steps, wall_seconds, scene_hash, makadam, .. } = row;
        let leading = cells![case, *seed, *grains, *steps, *wall_seconds, scene_hash, makadam];
        leading.into_iter().chain(names.iter().map(|name| Cell::from(row.values.get(*name).copied()))).collect()
    })
}

/// Returns a figure with its unit, and its bounds.
pub fn figure_and_bounds(finding: &Finding) -> [String; 2] {
    let value = format!("{} {}", four_digits(finding.value), finding.unit);
    [value.trim().into(), bounds([finding.low, finding.high], four_digits)]
}

/// Slope and intercept of the least-squares line through points; NaN if they do not define one.
pub(super) fn line(points: &[[f64; 2]]) -> (f64, f64) {
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let product: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    let square: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    let slope = product / square;
    (slope, y - slope * x)
}

/// Value at zero of the least-squares line through points, and its standard error from the scatter about the line, with two degrees
/// of freedom fewer than points. `None` for fewer than three points.
pub(super) fn at_zero(points: &[[f64; 2]]) -> Option<(f64, f64)> {
    if points.len() < 3 {
        return None;
    }
    let count = points.len() as f64;
    let (slope, intercept) = line(points);
    let scatter = points.iter().map(|[x, y]| (y - intercept - slope * x).powi(2)).sum::<f64>() / (count - 2.0);
    let middle = points.iter().map(|[x, _]| x).sum::<f64>() / count;
    let square: f64 = points.iter().map(|[x, _]| (x - middle).powi(2)).sum();
    Some((intercept, (scatter * (1.0 / count + middle * middle / square)).sqrt()))
}

/// Returns the minimum of a function of one variable that decreases and then increases, between two bounds: golden section.
pub(super) fn least(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let share = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - share * (high - low), low + share * (high - low));
    let (mut at_a, mut at_b) = (function(a), function(b));
    while high - low > 1e-10 * (low.abs() + high.abs()) {
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - share * (high - low);
            at_a = function(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + share * (high - low);
            at_b = function(b);
        }
        if a >= b {
            break;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
#[path = "../../tests/unit/laws_fit.rs"]
mod tests;
