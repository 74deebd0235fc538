//! Tables of a report: values and differences, settings of each code, speeds, tests of studies.

use super::qualification::StudySection;
use makadam_compare::compare::{CodeSummary, Comparison, Row, Source, Timing, distinct};
use makadam_compare::study::{Cell, Table, cells};
use makadam_measure::statistics::Outcome;
use makadam_view::draw::numbers::{Rounding, compact, duration, plural, two_digits};
use makadam_view::draw::{columns, names};

pub(super) fn source_word(source: Source) -> &'static str {
    match source {
        Source::Live => "live",
        Source::Recorded => "recorded",
        Source::Published => "published",
    }
}

/// Returns the rounding of the rows of one observable, by their margins, spreads and means.
pub(super) fn rounding<'a>(rows: impl Iterator<Item = &'a Row> + Clone) -> Rounding {
    let largest = |value: fn(&Row) -> f64| {
        rows.clone().map(value).filter(|v| v.is_finite()).fold(0.0, |a: f64, b| a.max(b.abs()))
    };
    let margin = largest(|row| row.margin.unwrap_or(0.0));
    let spread = largest(|row| row.standard_deviation.filter(|_| row.seeds > 1).unwrap_or(0.0));
    Rounding::for_values(margin, spread, largest(|row| row.mean.unwrap_or(0.0)))
}

/// Column of differences: the first code minus the second.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Pair {
    code: String,
    reference: String,
    /// Difference between two references: the lower limit.
    floor: bool,
}

impl Pair {
    /// Head and style class of its column.
    fn head(&self) -> (Cell, &'static str) {
        let head = Cell::from(format!("{} − {}", self.code, self.reference));
        match self.floor {
            true => (head.above(Some("floor".into())), "floor"),
            false => (head, ""),
        }
    }
}

/// Returns the codes of a comparison: as listed, then any that only its rows name.
fn codes(comparison: &Comparison) -> Vec<&str> {
    distinct(comparison.codes.iter().map(|code| code.code.as_str()).chain(
        comparison.rows.iter().flat_map(|row| std::iter::once(row.code.as_str()).chain(row.reference_code.as_deref())),
    ))
}

/// Returns the pairs of codes that the rows compare, those of the code under test first.
fn pairs(comparison: &Comparison) -> Vec<Pair> {
    let mut pairs: Vec<Pair> = Vec::new();
    for row in &comparison.rows {
        let Some(reference) = &row.reference_code else { continue };
        let pair = Pair { code: row.code.clone(), reference: reference.clone(), floor: row.code != comparison.judged };
        if !pairs.contains(&pair) {
            pairs.push(pair);
        }
    }
    pairs.sort_by_key(|pair| pair.floor);
    pairs
}

/// Returns a code behind its mark.
fn code(name: &str) -> Cell {
    Cell::from(name).marked(names::code_style(name).class)
}

/// Values and differences of a scene; none where no observable was measured.
pub(super) fn results(comparison: &Comparison) -> Option<Table> {
    let names = codes(comparison);
    let pairs = pairs(comparison);
    let source =
        |name: &str| comparison.codes.iter().find(|code| code.code == name).map(|code| source_word(code.source));
    let heads = names.iter().map(|&name| (code(name).above(source(name).map(String::from)), ""));
    let table = Table::new(&["observable"], &[]).styled("results").with_columns(heads).with_numbers(["margin"]);
    let observables = distinct(comparison.rows.iter().map(|row| row.observable.as_str()));
    let table = table.with_columns(pairs.iter().map(Pair::head)).of(observables, |observable| {
        let line = Line::of(comparison, observable);
        let exceeded = line.rows.iter().any(|row| comparison.references_at_odds(row));
        let warning = exceeded.then(|| "references differ by more than the margin".into());
        let values = names.iter().map(|code| line.value(code));
        let differences = pairs.iter().map(|pair| line.difference(pair, true));
        let name = Cell::from(line.name()).above(warning);
        [name].into_iter().chain(values).chain([line.margin()]).chain(differences).collect()
    });
    (!table.is_empty()).then_some(table)
}

/// Returns every observable with a margin, of every scene, over common columns of the pairs with the code under test; none without
/// tests.
pub(super) fn summary(comparisons: &[Comparison]) -> Option<Table> {
    let mut columns: Vec<Pair> = Vec::new();
    for pair in comparisons.iter().flat_map(pairs).filter(|pair| !pair.floor) {
        if !columns.contains(&pair) {
            columns.push(pair);
        }
    }
    let table = Table::new(&["scene", "observable"], &["margin"]).styled("summary");
    let mut table = table.with_columns(columns.iter().map(Pair::head));
    for comparison in comparisons {
        let tested = |row: &&Row| row.outcome.is_some() && row.code == comparison.judged;
        let observables = distinct(comparison.rows.iter().filter(tested).map(|row| row.observable.as_str()));
        table.group(&comparison.scene.name, observables, |observable| {
            let line = Line::of(comparison, observable);
            let differences = columns.iter().map(|pair| line.difference(pair, false));
            [line.name().into(), line.margin()].into_iter().chain(differences).collect()
        });
    }
    (!table.is_empty()).then_some(table)
}

/// Rows of one observable.
struct Line<'a> {
    rows: Vec<&'a Row>,
    rounding: Rounding,
}

impl<'a> Line<'a> {
    fn of(comparison: &'a Comparison, observable: &str) -> Line<'a> {
        let rows: Vec<&Row> = comparison.rows.iter().filter(|row| row.observable == observable).collect();
        Line { rounding: rounding(rows.iter().copied()), rows }
    }

    fn name(&self) -> String {
        self.rows.first().map_or(String::new(), |row| names::with_unit(&row.observable, &row.unit, self.rounding))
    }

    fn margin(&self) -> Cell {
        self.rows.iter().find_map(|row| row.margin).map(|margin| self.rounding.margin(margin)).into()
    }

    /// Value of a code: from a row of its own, or else from a row that has it as the reference.
    fn value(&self, code: &str) -> Cell {
        let value = |value: Option<f64>| value.map(|value| self.rounding.value(value));
        if let Some(row) = self.rows.iter().find(|row| row.code == code) {
            let Some(mean) = value(row.mean) else { return Cell::default() };
            let spread = value(row.standard_deviation.filter(|_| row.seeds > 1)).map(|spread| format!("± {spread}"));
            return Cell::from(mean).above(spread).above((row.seeds > 0).then(|| plural(row.seeds, "seed")));
        }
        let row = self.rows.iter().find(|row| row.reference_code.as_deref() == Some(code));
        row.and_then(|row| value(Some(row.mean? - row.difference?))).into()
    }

    /// Row of a pair of codes.
    fn row(&self, pair: &Pair) -> Option<&'a Row> {
        let is = |row: &&&Row| row.code == pair.code && row.reference_code.as_deref() == Some(pair.reference.as_str());
        self.rows.iter().find(is).copied()
    }

    /// Difference and outcome; `fully`: with the interval, and the seeds needed or the missing values.
    fn difference(&self, pair: &Pair, fully: bool) -> Cell {
        let Some(row) = self.row(pair) else { return Cell::default() };
        let undecided = row.outcome == Some(Outcome::Undecided);
        let needed = row.seeds_needed.filter(|_| fully && undecided);
        Cell::from(row.difference.map(|difference| self.rounding.signed(difference)))
            .above(row.shown_interval().filter(|_| fully).map(|interval| self.rounding.interval(interval)))
            .outcome(row.outcome.map(|outcome| (outcome.class(), outcome.words())))
            .above(row.missing.clone().filter(|_| fully))
            .above(needed.map(|seeds| format!("register {seeds} seeds")))
    }
}

/// Returns the settings of the codes of a scene, and their speed; `None` where no code is known.
pub(super) fn runs(comparison: &Comparison) -> Option<Table> {
    let numbers = ["time step", "of the Rayleigh step", "time per simulated second", "ratio"];
    let table = Table::new(&["code", "version", "source", "seeds"], &numbers).with_words("origin");
    let table = table.of_class("wide").of(&comparison.codes, |run| {
        let from = [run.provenance.as_str(), run.processor.as_str()].into_iter().filter(|text| !text.is_empty());
        cells![
            code(&run.code),
            &run.version,
            source_word(run.source),
            seeds(&run.seeds),
            run.time_step.map(|step| format!("{} s", compact(step))),
            run.rayleigh_fraction.map(|fraction| format!("{}%", compact(100.0 * fraction))),
            time(run).unwrap_or("not timed".into()),
            ratio(comparison, run),
            from.collect::<Vec<_>>().join("; "),
        ]
    });
    (!table.is_empty()).then_some(table)
}

/// Returns the time per simulated second; `None` for parallel runs, which share memory and caches, and for runs for measuring, whose inputs may
/// slow a code down.
pub(super) fn time(code: &CodeSummary) -> Option<String> {
    let is_timed = matches!(code.timing, Timing::Alone | Timing::Recorded);
    is_timed.then(|| duration(code.wall_seconds_per_simulated_second))
}

/// Returns the time of a code over that of the code under test; `None` unless both were timed in this command on one processor.
pub(super) fn ratio(comparison: &Comparison, code: &CodeSummary) -> Option<String> {
    let is_alone = |code: &&CodeSummary| code.source == Source::Live && code.timing == Timing::Alone;
    let judged = comparison.codes.iter().filter(is_alone).find(|judged| judged.code == comparison.judged)?;
    let is_comparable = is_alone(&code) && judged.processor == code.processor && code.code != judged.code;
    let ratio = code.wall_seconds_per_simulated_second / judged.wall_seconds_per_simulated_second;
    (is_comparable && ratio.is_finite()).then(|| format!("{} times", two_digits(ratio)))
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

/// Returns the tests of a study, one per row.
pub(super) fn study(study: &StudySection) -> Table {
    let table = Table::new(&["test", "right", "measured"], &[]).styled("results").with_words("");
    table.of(&study.tests, |test| {
        let outcome = Cell::from("").outcome(Some((test.outcome.class(), test.outcome.words())));
        cells![&test.name, &test.right, &test.measured, outcome.above(test.remark.clone())]
    })
}

/// Formats a comparison as text, in tables of at most 80 columns: for each observable the means of the codes, then their differences with the
/// outcomes; below, speed and notes. Outcomes are coloured if `colour` is set.
///
/// Columns are padded by characters, so a UTF-8 terminal is needed.
pub fn comparison_table(comparison: &Comparison, colour: bool) -> String {
    let mut text = format!("{}: {}\n", comparison.scene.name, comparison.scene.description);
    if comparison.rows.is_empty() {
        text.push_str("\nno rows\n");
    } else {
        text.push_str("mean ± spread (seeds); difference [interval of the verdict], outcome\n");
    }
    for rows in comparison.rows.chunk_by(|one, next| one.observable == next.observable) {
        text.push('\n');
        text.push_str(&block(comparison, rows, colour));
    }
    let speeds = comparison.codes.iter().filter_map(|code| {
        let ratio = ratio(comparison, code).map_or(String::new(), |ratio| format!(" ({ratio})"));
        let recorded = if code.source == Source::Recorded { ", recorded" } else { "" };
        Some(format!("{} {}{ratio}{recorded}", code.code, time(code)?))
    });
    let speeds: Vec<String> = speeds.collect();
    if !speeds.is_empty() {
        text.push_str(&format!("\ntime per simulated second: {}\n", speeds.join("; ")));
    }
    for note in &comparison.notes {
        text.push_str(&format!("note: {note}\n"));
    }
    text
}

/// Rows of one observable.
fn block(comparison: &Comparison, rows: &[Row], colour: bool) -> String {
    let rounding = rounding(rows.iter());
    let mut text = names::with_unit(&rows[0].observable, &rows[0].unit, rounding);
    if let Some(margin) = rows.iter().find_map(|row| row.margin) {
        text.push_str(&format!(", margin {}", rounding.margin(margin)));
    }
    text.push('\n');
    let mut lines: Vec<[String; 3]> = Vec::new();
    for (place, row) in rows.iter().enumerate() {
        if rows[..place].iter().any(|other| other.code == row.code) {
            continue;
        }
        let spread = row.standard_deviation.filter(|_| row.seeds > 1);
        let spread = spread.map_or(String::new(), |spread| format!(" ± {}", rounding.value(spread)));
        let mean = row.mean.map_or("–".into(), |mean| rounding.value(mean));
        let seeds = if row.seeds > 0 { format!(" ({})", row.seeds) } else { String::new() };
        lines.push([format!("  {}", row.code), format!("{mean}{spread}{seeds}"), String::new()]);
    }
    for row in rows.iter().filter(|row| row.difference.is_some() || row.outcome.is_some()) {
        let reference = row.reference_code.as_ref().map_or(String::new(), |code| format!(" − {code}"));
        let interval = row.shown_interval().map(|interval| format!(" {}", rounding.interval(interval)));
        let difference = row.difference.map(|difference| rounding.signed(difference) + &interval.unwrap_or_default());
        let at_odds = row.code == comparison.judged && comparison.references_at_odds(row);
        let outcome = row.outcome.map(|outcome| match colour {
            true => format!("\x1b[{}m{}\x1b[0m", code_of(outcome), outcome_of(row, outcome, at_odds)),
            false => outcome_of(row, outcome, at_odds),
        });
        lines.push([format!("  {}{reference}", row.code), difference.unwrap_or_default(), outcome.unwrap_or_default()]);
    }
    text.push_str(&columns(&lines, |_| true));
    let mut reasons: Vec<&str> =
        rows.iter().filter(|row| row.outcome == Some(Outcome::NotMeasured)).map(reason).collect();
    reasons.dedup();
    for reason in reasons {
        text.push_str(&format!("  not measured: {reason}\n"));
    }
    text
}

/// Reason why a row is not measured.
fn reason(row: &Row) -> &str {
    row.missing.as_deref().unwrap_or("a value is missing")
}

/// Outcome of a row as text; `at_odds`: the references differ by more than its margin.
fn outcome_of(row: &Row, outcome: Outcome, at_odds: bool) -> String {
    match (outcome, row.seeds_needed) {
        (Outcome::Undecided | Outcome::Exploratory, _) if at_odds => "undecided (references differ)".into(),
        (Outcome::Undecided, Some(seeds)) => format!("undecided, register {seeds} seeds"),
        (Outcome::Exploratory, _) => "exploratory: within the margin".into(),
        (outcome, _) => outcome.words().into(),
    }
}

/// Escape code of an outcome's colour: colour-blind readers can distinguish blue, red and yellow, too.
fn code_of(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Agree => "34",
        Outcome::Disagree => "31;1",
        Outcome::Undecided | Outcome::Exploratory | Outcome::NotMeasured => "33",
    }
}
