//! The tables of a scene: values and differences, how each code was run, the bias of soft grains.

use super::qualification::join;
use super::{speed, words};
use crate::compare::{Comparison, Row};
use crate::draw::names;
use crate::draw::numbers::{Rounding, compact, plural};
use crate::statistics::Outcome;
use crate::study::{Cell, Table, cells};

/// A column of differences: the first code minus the second.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pair {
    pub(super) code: String,
    pub(super) reference: String,
    /// Whether it is the floor: a difference between two references.
    pub(super) floor: bool,
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

/// Pairs of codes that rows compare, those of the judged code first.
pub(super) fn pairs(comparison: &Comparison, rows: &[Row]) -> Vec<Pair> {
    let mut pairs: Vec<Pair> = Vec::new();
    for row in rows {
        let Some(reference) = &row.reference_code else { continue };
        let pair = Pair { code: row.code.clone(), reference: reference.clone(), floor: row.code != comparison.judged };
        if !pairs.contains(&pair) {
            pairs.push(pair);
        }
    }
    pairs.sort_by_key(|pair| pair.floor);
    pairs
}

/// A code behind its mark.
pub(super) fn code(name: &str) -> Cell {
    Cell::from(name).marked(names::code_style(name).class)
}

/// Values and differences of a scene; nothing where no observable was measured.
pub(super) fn results(comparison: &Comparison) -> Option<Table> {
    let names = codes(comparison);
    let pairs = pairs(comparison, &comparison.rows);
    let source =
        |name: &str| comparison.codes.iter().find(|code| code.code == name).map(|code| words::source(code.source));
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

/// Every observable with a margin, of every scene, over common columns of pairs; nothing where nothing was tested.
pub(super) fn summary(comparisons: &[Comparison]) -> Option<Table> {
    let mut columns: Vec<Pair> = Vec::new();
    for comparison in comparisons {
        columns.extend(
            pairs(comparison, &comparison.rows).into_iter().filter(|pair| !columns.contains(pair)).collect::<Vec<_>>(),
        );
    }
    let (floors, columns): (Vec<Pair>, Vec<Pair>) = columns.into_iter().partition(|pair| pair.floor);
    let floor_head = match floors.as_slice() {
        [] => None,
        [only] => Some(only.head()),
        _ => Some((Cell::from("widest between the others").above(Some("floor".into())), "floor")),
    };
    let table = Table::new(&["scene", "observable"], &["margin"]).styled("summary");
    let mut table = table.with_columns(columns.iter().map(Pair::head).chain(floor_head));
    for comparison in comparisons {
        let tested = |row: &&Row| row.outcome.is_some() && row.code == comparison.judged;
        let observables = distinct(comparison.rows.iter().filter(tested).map(|row| row.observable.as_str()));
        table.group(&comparison.scene.name, observables, |observable| {
            let line = Line::of(comparison, observable);
            let differences = columns.iter().map(|pair| line.difference(pair, false));
            let floor = (!floors.is_empty()).then(|| line.floor(&floors));
            [line.name().into(), line.margin()].into_iter().chain(differences).chain(floor).collect()
        });
    }
    (!table.is_empty()).then_some(table)
}

/// The rows of one observable.
struct Line<'a> {
    rows: Vec<&'a Row>,
    rounding: Rounding,
}

impl<'a> Line<'a> {
    fn of(comparison: &'a Comparison, observable: &str) -> Line<'a> {
        let rows: Vec<&Row> = comparison.rows.iter().filter(|row| row.observable == observable).collect();
        Line { rounding: words::rounding(rows.iter().copied()), rows }
    }

    fn name(&self) -> String {
        self.rows.first().map_or(String::new(), |row| names::with_unit(&row.observable, &row.unit, self.rounding))
    }

    fn margin(&self) -> Cell {
        self.rows.iter().find_map(|row| row.margin).map(|margin| self.rounding.margin(margin)).into()
    }

    /// The value of a code: from a row of its own, or else from a row that has it as the reference.
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

    /// The row of a pair of codes.
    fn row(&self, pair: &Pair) -> Option<&'a Row> {
        let is = |row: &&&Row| row.code == pair.code && row.reference_code.as_deref() == Some(pair.reference.as_str());
        self.rows.iter().find(is).copied()
    }

    /// The widest difference between references, with its pair where there are several.
    fn floor(&self, floors: &[Pair]) -> Cell {
        let width = |pair: &Pair| Some(self.row(pair)?.difference?.abs());
        let known = floors.iter().filter_map(|pair| Some((pair, width(pair)?)));
        let Some((widest, _)) = known.max_by(|(_, one), (_, other)| one.total_cmp(other)) else {
            return Cell::default();
        };
        let pair = (floors.len() > 1).then(|| format!("{} − {}", widest.code, widest.reference));
        self.difference(widest, false).above(pair)
    }

    /// A difference and its outcome; `fully`: with its interval, and what would decide or is missing.
    fn difference(&self, pair: &Pair, fully: bool) -> Cell {
        let Some(row) = self.row(pair) else { return Cell::default() };
        let undecided = row.outcome == Some(Outcome::Undecided);
        let needed = row.seeds_needed.filter(|_| fully && undecided);
        Cell::from(row.difference.map(|difference| self.rounding.signed(difference)))
            .above(row.shown_interval().filter(|_| fully).map(|interval| self.rounding.interval(interval)))
            .outcome(row.outcome.map(|outcome| (words::outcome_class(outcome), words::outcome(outcome))))
            .above(row.missing.clone().filter(|_| fully))
            .above(needed.map(|seeds| format!("register {seeds} seeds")))
    }
}

/// How the codes of a scene were run; nothing where none is known.
pub(super) fn runs(comparison: &Comparison) -> Option<Table> {
    let numbers = ["time step", "of the Rayleigh step", "wall time per simulated second"];
    let table = Table::new(&["code", "version", "source", "seeds"], &numbers).with_words("where the numbers are from");
    let table = table.of_class("wide").of(&comparison.codes, |run| {
        let from = [run.provenance.as_str(), run.processor.as_str()].into_iter().filter(|text| !text.is_empty());
        cells![
            code(&run.code),
            &run.version,
            words::source(run.source),
            seeds(&run.seeds),
            run.time_step.map(|step| format!("{} s", compact(step))),
            run.rayleigh_fraction.map(|fraction| format!("{}%", compact(100.0 * fraction))),
            speed::time(run),
            from.collect::<Vec<_>>().join("; "),
        ]
    });
    (!table.is_empty()).then_some(table)
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

/// What the data of a scene forbid to conclude from it.
pub(super) fn limits(comparison: &Comparison) -> Vec<String> {
    let mut limits = Vec::new();
    let exceeded = distinct(
        comparison
            .rows
            .iter()
            .filter(|row| row.code == comparison.judged && comparison.references_at_odds(row))
            .map(|row| row.observable.as_str()),
    );
    for observable in exceeded {
        limits.push(format!(
            "{}: the means of the references differ by more than the margin, so agreement with one of them proves nothing.",
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
    let missing = comparison
        .rows
        .iter()
        .filter(|row| row.outcome == Some(Outcome::Undecided) && row.code == comparison.judged)
        .filter(|row| !comparison.references_at_odds(row))
        .count();
    if missing > 0 {
        limits.push(format!("{} undecided: too few seeds for the spread.", plural(missing, "test")));
    }
    if comparison.rows.iter().any(|row| row.outcome == Some(Outcome::Exploratory)) {
        limits.extend(comparison.unregistered().map(|words| format!("Exploratory, no agreement: {words}.")));
    }
    let lacking = comparison.rows.iter().filter(|row| row.missing.is_some());
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
