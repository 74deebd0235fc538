//! The tables of a scene: values and differences, how each code was run, the bias of soft grains.

use super::qualification::{JUDGED, floor_exceeds_margin, join, plural};
use super::{speed, words};
use crate::compare::{CodeSummary, Comparison, Row};
use crate::draw::names;
use crate::draw::numbers::{Rounding, compact};
use crate::statistics::Outcome;
use serde::Serialize;

/// A column of differences: the first code minus the second.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Pair {
    pub(super) code: String,
    pub(super) reference: String,
    /// Whether it is the floor: a difference between two references.
    pub(super) floor: bool,
}

#[derive(Serialize)]
pub(super) struct Value {
    mean: String,
    spread: Option<String>,
    seeds: usize,
}

#[derive(Serialize)]
pub(super) struct Difference {
    difference: Option<String>,
    interval: Option<String>,
    verdict_interval: Option<String>,
    outcome: Option<&'static str>,
    /// Style class of the outcome.
    class: Option<&'static str>,
    missing: Option<String>,
    seeds_needed: Option<usize>,
    floor: bool,
}

/// One observable: a line of the table.
#[derive(Serialize)]
pub(super) struct Line {
    name: String,
    values: Vec<Option<Value>>,
    margin: Option<String>,
    differences: Vec<Option<Difference>>,
    floor_exceeds_margin: bool,
}

/// Values and differences of a scene.
#[derive(Serialize)]
pub(super) struct Results {
    codes: Vec<Code>,
    pub(super) pairs: Vec<Pair>,
    pub(super) lines: Vec<Line>,
}

#[derive(Serialize)]
struct Code {
    name: String,
    class: &'static str,
    source: Option<&'static str>,
}

/// The names that a field takes in rows, each once, in the order of their appearance.
fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found = Vec::new();
    for name in names {
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

/// Codes of a comparison: as listed, then any that only its rows name.
pub(super) fn codes(comparison: &Comparison) -> Vec<&str> {
    distinct(comparison.codes.iter().map(|code| code.code.as_str()).chain(
        comparison.rows.iter().flat_map(|row| std::iter::once(row.code.as_str()).chain(row.reference_code.as_deref())),
    ))
}

/// Pairs of codes that rows compare, Makadam's first.
pub(super) fn pairs(rows: &[Row]) -> Vec<Pair> {
    let mut pairs: Vec<Pair> = Vec::new();
    for row in rows {
        let Some(reference) = &row.reference_code else { continue };
        let pair = Pair { code: row.code.clone(), reference: reference.clone(), floor: row.code != JUDGED };
        if !pairs.contains(&pair) {
            pairs.push(pair);
        }
    }
    pairs.sort_by_key(|pair| pair.floor);
    pairs
}

/// Values and differences of a scene.
pub(super) fn results(comparison: &Comparison) -> Results {
    let names = codes(comparison);
    let pairs = pairs(&comparison.rows);
    let lines = distinct(comparison.rows.iter().map(|row| row.observable.as_str()))
        .into_iter()
        .map(|observable| line(comparison, observable, &names, &pairs))
        .collect();
    let codes = names
        .iter()
        .map(|&name| Code {
            name: name.into(),
            class: names::code_style(name).class,
            source: comparison.codes.iter().find(|c| c.code == name).map(|c| words::source(c.source)),
        })
        .collect();
    Results { codes, pairs, lines }
}

fn line(comparison: &Comparison, observable: &str, codes: &[&str], pairs: &[Pair]) -> Line {
    let rows: Vec<&Row> = comparison.rows.iter().filter(|row| row.observable == observable).collect();
    let rounding = words::rounding(rows.iter().copied());
    let unit = rows.first().map_or("", |row| row.unit.as_str());
    Line {
        name: names::with_unit(observable, unit, rounding),
        values: codes.iter().map(|code| value(&rows, code, rounding)).collect(),
        margin: rows.iter().find_map(|row| row.margin).map(|margin| rounding.margin(margin)),
        differences: pairs.iter().map(|pair| difference(&rows, pair, rounding)).collect(),
        floor_exceeds_margin: rows.iter().any(|row| floor_exceeds_margin(comparison, row)),
    }
}

/// The value of a code: from a row of its own, or else from a row that has it as the reference.
fn value(rows: &[&Row], code: &str, rounding: Rounding) -> Option<Value> {
    if let Some(row) = rows.iter().find(|row| row.code == code) {
        let spread = row.standard_deviation.filter(|_| row.seeds > 1).map(|spread| rounding.value(spread));
        return Some(Value { mean: rounding.value(row.mean?), spread, seeds: row.seeds });
    }
    let row = rows.iter().find(|row| row.reference_code.as_deref() == Some(code))?;
    Some(Value { mean: rounding.value(row.mean? - row.difference?), spread: None, seeds: 0 })
}

fn difference(rows: &[&Row], pair: &Pair, rounding: Rounding) -> Option<Difference> {
    let row = rows
        .iter()
        .find(|row| row.code == pair.code && row.reference_code.as_deref() == Some(pair.reference.as_str()))?;
    Some(Difference {
        difference: row.difference.map(|difference| rounding.signed(difference)),
        interval: row.interval90.map(|interval| rounding.interval(interval)),
        verdict_interval: row.interval_of_verdict.map(|interval| rounding.interval(interval)),
        outcome: row.outcome.map(words::outcome),
        class: row.outcome.map(words::outcome_class),
        missing: row.missing.clone(),
        seeds_needed: row.seeds_needed.filter(|_| row.outcome == Some(Outcome::Undecided)),
        floor: pair.floor,
    })
}

/// A test of the summary: one observable of one scene.
#[derive(Serialize)]
pub(super) struct SummaryLine {
    scene: String,
    line: Line,
    first_of_scene: Option<usize>,
}

/// The summary of all scenes over common columns of pairs.
#[derive(Serialize)]
pub(super) struct Summary {
    pairs: Vec<Pair>,
    lines: Vec<SummaryLine>,
}

/// Every observable with a margin, of every scene.
pub(super) fn summary(comparisons: &[Comparison]) -> Summary {
    let tested = |row: &&Row| row.outcome.is_some() && row.code == JUDGED;
    let mut columns: Vec<Pair> = Vec::new();
    for comparison in comparisons {
        columns.extend(pairs(&comparison.rows).into_iter().filter(|pair| !columns.contains(pair)).collect::<Vec<_>>());
    }
    columns.sort_by_key(|pair| pair.floor);
    let mut lines = Vec::new();
    for comparison in comparisons {
        let observables = distinct(comparison.rows.iter().filter(tested).map(|row| row.observable.as_str()));
        for (place, observable) in observables.iter().enumerate() {
            lines.push(SummaryLine {
                scene: comparison.scene.name.clone(),
                line: line(comparison, observable, &[], &columns),
                first_of_scene: (place == 0).then_some(observables.len()),
            });
        }
    }
    Summary { pairs: columns, lines }
}

/// How a code was run.
#[derive(Serialize)]
pub(super) struct Run {
    code: String,
    class: &'static str,
    version: String,
    source: &'static str,
    seeds: String,
    time_step: String,
    rayleigh: String,
    stiffness: String,
    wall: String,
    processor: String,
    provenance: String,
}

/// How the codes of a scene were run.
pub(super) fn runs(comparison: &Comparison) -> Vec<Run> {
    comparison.codes.iter().map(run).collect()
}

fn run(code: &CodeSummary) -> Run {
    Run {
        code: code.code.clone(),
        class: names::code_style(&code.code).class,
        version: code.version.clone(),
        source: words::source(code.source),
        seeds: seeds(&code.seeds),
        time_step: format!("{} s", compact(code.time_step)),
        rayleigh: code.rayleigh_fraction.map_or("–".into(), |f| format!("{}%", compact(100.0 * f))),
        stiffness: format!("×{}", compact(code.stiffness_factor)),
        wall: speed::time(code),
        processor: code.processor.clone(),
        provenance: code.provenance.clone(),
    }
}

/// Seeds in short: "1–5", or a list.
fn seeds(seeds: &[u64]) -> String {
    match seeds {
        [] => "none".into(),
        [only] => only.to_string(),
        [first, .., last] if seeds.windows(2).all(|pair| pair[1] == pair[0].wrapping_add(1)) => {
            format!("{first}–{last}")
        }
        _ => seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", "),
    }
}

/// The shift of one observable in one code when its grains are made ten times stiffer.
#[derive(Serialize)]
pub(super) struct Shift {
    name: String,
    code: String,
    class: &'static str,
    shift: String,
    interval: Option<String>,
    third: Option<String>,
    share: Option<String>,
    verdict: &'static str,
}

/// Bias of soft grains.
pub(super) fn shifts(comparison: &Comparison) -> Vec<Shift> {
    comparison
        .soft_bias
        .iter()
        .map(|row| {
            let margin = margin_of_shift(comparison, row);
            let same = comparison.soft_bias.iter().filter(|other| other.observable == row.observable);
            let rounding = match margin {
                // A third of the margin is the yardstick here.
                Some(margin) => words::rounding(std::iter::once(&Row { margin: Some(margin / 3.0), ..row.clone() })),
                None => words::rounding(same),
            };
            Shift {
                name: names::with_unit(&row.observable, &row.unit, rounding),
                code: row.code.clone(),
                class: names::code_style(&row.code).class,
                shift: row.difference.map_or("–".into(), |d| rounding.signed(d)),
                interval: row.interval90.map(|interval| rounding.interval(interval)),
                third: margin.map(|m| format!("±{}", rounding.value(m / 3.0))),
                share: margin.zip(row.difference).map(|(m, d)| format!("{:.0}%", 100.0 * d.abs() / m)),
                verdict: match shift_is_small(comparison, row) {
                    Some(true) => "small",
                    Some(false) => "too large",
                    None if row.outcome == Some(Outcome::NotMeasured) => "not measured",
                    None => "",
                },
            }
        })
        .collect()
}

fn margin_of_shift(comparison: &Comparison, row: &Row) -> Option<f64> {
    let expected = || comparison.scene.compare.iter().find(|e| e.observable == row.observable)?.margin;
    row.margin.or_else(expected)
}

/// Whether a shift is below a third of the margin; none where there is no margin or no shift.
fn shift_is_small(comparison: &Comparison, row: &Row) -> Option<bool> {
    Some(row.difference?.abs() < margin_of_shift(comparison, row)? / 3.0)
}

/// What the data of a scene forbid to conclude from it.
pub(super) fn limits(comparison: &Comparison) -> Vec<String> {
    let mut limits = Vec::new();
    for observable in distinct(comparison.soft_bias.iter().map(|row| row.observable.as_str())) {
        let soft: Vec<&str> = (comparison.soft_bias.iter())
            .filter(|row| row.observable == observable && shift_is_small(comparison, row) == Some(false))
            .map(|row| row.code.as_str())
            .collect();
        if !soft.is_empty() {
            limits.push(format!(
                "{}: in {} grains ten times stiffer shift it by more than a third of the margin; the codes share one \
                 stiffness and may be compared, but the value is not that of stiff grains.",
                names::observable(observable),
                join(&soft),
            ));
        }
    }
    let exceeded = distinct(
        comparison
            .rows
            .iter()
            .filter(|row| row.code == JUDGED && floor_exceeds_margin(comparison, row))
            .map(|row| row.observable.as_str()),
    );
    for observable in exceeded {
        limits.push(format!(
            "{}: the references differ from each other by more than the margin, so agreement with one of them proves nothing.",
            names::observable(observable),
        ));
    }
    // By what is compared: runs that are only timed have one seed beside any number of others.
    let most_seeds = |code: &str| comparison.rows.iter().filter(|row| row.code == code).map(|row| row.seeds).max();
    let single =
        distinct(comparison.rows.iter().map(|row| row.code.as_str()).filter(|code| most_seeds(code) == Some(1)));
    if !single.is_empty() {
        limits.push(format!("{} ran with one seed: a spread over seeds is not known.", join(&single)));
    }
    let missing =
        comparison.rows.iter().filter(|row| row.outcome == Some(Outcome::Undecided) && row.code == JUDGED).count();
    if missing > 0 {
        limits.push(format!("{} undecided: too few seeds for the spread.", plural(missing, "test")));
    }
    let lacking = comparison.rows.iter().chain(&comparison.soft_bias).filter(|row| row.missing.is_some());
    let mut said: Vec<String> = Vec::new();
    for row in lacking {
        let words = format!("{}: {}.", names::observable(&row.observable), row.missing.as_deref().unwrap_or_default());
        if !said.contains(&words) {
            said.push(words);
        }
    }
    limits.extend(said.into_iter().map(|words| format!("Not measured, so that there is no test: {words}")));
    if !comparison.rows.iter().any(|row| row.reference_code.is_some()) {
        limits.push("No reference code took part: the values stand alone.".into());
    }
    limits
}
