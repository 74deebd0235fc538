//! Findings, tables and files of a trade-off.

use super::figures::figures;
use super::rows::{Bound, Fastest, Point, Reference};
use super::study::Study;
use makadam_compare::study::{
    Answer, Cell, Document, DocumentError, File, Medium, Report, Section, Table, cells, json, table as csv,
};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::names::{code_style, observable, with_unit};
use makadam_view::draw::numbers::{Rounding, compact, count, plural, two_digits};
use serde::Serialize;
use serde_json::{Map, Value};

/// Observables in the terminal's table; the page and `points.csv` have them all.
const SHOWN: usize = 2;

impl Document for Study {
    const NAME: &'static str = "tradeoff";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![
            point_rows(&self.points).csv("points")?,
            reference_rows(&self.references).csv("references")?,
            csv("fastest", &self.fastest)?,
            json("provenance", &self.terms.provenance)?,
        ])
    }

    fn figures(&self) -> Vec<Figure> {
        figures(self)
    }

    fn report(&self) -> Report {
        let bounds = self.terms.bounds.iter().map(bound_text).collect::<Vec<_>>().join(", ");
        let provenance = |key: &str| self.terms.provenance.get(key).cloned();
        let facts = [
            Some(format!("{} grains", count(self.particles))),
            Some(plural(self.terms.seeds as usize, "seed")),
            (!bounds.is_empty()).then(|| bounds.clone()),
            provenance("processor"),
            provenance("version").map(|version| format!("version {version}")),
            provenance("date"),
        ];
        Report {
            kind: "Makadam, error against wall time",
            title: format!("What accuracy costs in time: the scene {}", self.scene),
            facts: facts.into_iter().flatten().collect(),
            answer: self.answer(),
            findings: self.findings.clone(),
            sections: vec![
                Section::new(
                    "Settings (* on the Pareto front of its code; errors ± standard error over seeds)",
                    "",
                    self.settings(SHOWN),
                )
                .only(Medium::Terminal),
                Section::new(
                    "Fastest settings within the bounds",
                    format!(
                        "Bounds on the mean deviation from the converged reference at the same stiffness: {bounds}. Seconds of one core \
                         per simulated second, and their ratio to Makadam's. The 90% interval of the ratio is that of other samples of \
                         the seeds, drawn with replacement; each sample has its own fastest settings."
                    ),
                    self.fastest_settings(),
                ),
                Section::new(
                    "All settings",
                    "Errors are mean deviations from the reference, seed by seed, with their standard error; those in bold are on the \
                     Pareto front of their code. Wall times are medians over seeds, with their range. A cross marks another method, \
                     precision or stopping rule than the scene's.",
                    self.settings(usize::MAX),
                )
                .only(Medium::Page),
                Section::new(
                    "Converged references",
                    "Makadam at its smallest step with the most sweeps, over the same seeds. The three grids differ by their step alone, \
                     each half the one before. The index is a band about the mean: safety factor 1.25 where a credible order (0.5 to 2) \
                     was observed above the spread over seeds, else 3 with order one.",
                    self.converged(),
                )
                .only(Medium::Page),
            ],
            notes: self.notes.clone(),
            limits: vec![
                "The error is a deviation from Makadam's own limit at the same stiffness, not from nature: where codes differ in their \
                 model, a reference code keeps a deviation however small its step."
                    .into(),
                "Errors below the noise of the seeds cannot be distinguished from zero. A front counts them as equal: the cheapest of \
                 them ends it."
                    .into(),
                "A mean within a bound may be there by luck; only an interval within it is evidence. More seeds make it narrower.".into(),
                "A time is the processor time of the stepping on one core, without set-up and output, for every code. Reference codes run \
                 from the inputs from which they are fastest with the same physics (validation/docs/timing.md). Other load on caches and \
                 memory shows in the range over seeds."
                    .into(),
            ],
            provenance: self.terms.provenance.clone().into_iter().collect(),
            files: "tradeoff.json, points.csv, references.csv and fastest.csv, and every run in a file of the folder runs,",
        }
    }
}

impl Study {
    fn answer(&self) -> Answer {
        let (word, class) = match (self.complete, self.reaches_bounds("Makadam")) {
            (false, _) => ("Not finished.", "undecided"),
            (true, Some(true)) => ("Within the bounds.", "agree"),
            (true, Some(false)) => ("Beyond the bounds.", "disagree"),
            (true, None) => ("No bounds.", "undecided"),
        };
        let own = self.fastest.iter().find(|row| row.code == "Makadam" && row.stiffness_factor == 1.0);
        let sentence = match own.and_then(|row| row.setting.as_ref().zip(row.wall_seconds_per_simulated_second)) {
            Some((setting, wall)) => format!(
                "The fastest setting of Makadam that keeps them is {setting}: {} s per simulated second.",
                two_digits(wall)
            ),
            None => self.findings.first().cloned().unwrap_or_default(),
        };
        Answer { class, word: word.into(), sentence }
    }

    fn is_shifted(&self) -> bool {
        self.references.iter().any(|row| row.shift.is_some())
    }

    fn fastest_settings(&self) -> Table {
        let table = Table::new(&["stiffness", "code", "setting"], &["s per simulated s", "over Makadam's"]);
        table.with_words("its 90% interval").with_words("90% interval of errors").of(&self.fastest, |row| {
            let code = Cell::from(&row.code).marked(code_style(&row.code).class);
            let sureness = match row.intervals_within_bounds {
                Some(true) => "interval within too",
                Some(false) => "interval reaches beyond",
                None => "interval not known",
            };
            let range = match [row.ratio_low, row.ratio_high] {
                [Some(low), Some(high)] => format!("{} to {}", two_digits(low), two_digits(high)),
                [Some(low), None] => format!("at least {}", two_digits(low)),
                [None, _] => String::new(),
            };
            cells![
                modulus(row.youngs_modulus),
                code,
                row.setting.as_deref().unwrap_or("none that was measured"),
                row.wall_seconds_per_simulated_second.map(two_digits),
                row.ratio_to_makadam.map(two_digits),
                range,
                row.setting.as_ref().map(|_| sureness),
            ]
        })
    }

    /// Points by stiffness, code and wall time, with the errors of a number of observables, bounded ones first.
    fn settings(&self, observables: usize) -> Table {
        let names: Vec<&str> = self.observables().into_iter().take(observables).collect();
        let unit = |name: &str| self.references.iter().find(|row| row.observable == name).map_or("", |row| &row.unit);
        let mut table = Table::new(&["stiffness", "code", "setting"], &["seeds", "s per simulated s"])
            .with_numbers(names.iter().map(|name| with_unit(name, unit(name), Rounding::Decimals(0))))
            .with_words("bounds");
        let rank = |code: &str| self.points.iter().position(|point| point.code == code);
        let mut points: Vec<&Point> = self.points.iter().collect();
        points.sort_by(|a, b| {
            let wall = |point: &Point| point.wall_seconds_per_simulated_second;
            let by_stiffness = a.stiffness_factor.total_cmp(&b.stiffness_factor);
            by_stiffness.then(rank(&a.code).cmp(&rank(&b.code))).then(wall(a).total_cmp(&wall(b)))
        });
        let mut last = None;
        for point in points {
            let pace = two_digits(point.wall_seconds_per_simulated_second);
            let mut cells = cells![
                modulus(point.youngs_modulus),
                Cell::from(&point.code).marked(mark(point.variation.as_deref(), &point.code)),
                &point.setting,
                point.seeds.len(),
                Cell::from(pace).above(range(point)),
            ];
            cells.extend(names.iter().map(|name| error(point, name)));
            let verdict = match (point.reference, point.within_bounds, point.intervals_within_bounds) {
                _ if point.failed => "failed with a seed",
                _ if self.terms.bounds.is_empty() => "",
                (true, ..) => "reference",
                (_, Some(true), Some(true)) => "within, interval too",
                (_, Some(true), _) => "within",
                (_, Some(false), _) => "beyond",
                (_, None, _) => "",
            };
            cells.push(verdict.into());
            let group = (point.code.as_str(), point.stiffness_factor);
            match last.replace(group) == Some(group) {
                true => table.row(cells),
                false => table.first_row(cells),
            }
        }
        table
    }

    fn converged(&self) -> Table {
        let numbers = [
            "mean",
            "spread over seeds",
            "three grids, coarse to fine",
            "observed order",
            "Richardson's estimate",
            "grid convergence index (factor)",
        ];
        let shifted = self.is_shifted();
        Table::new(&["stiffness", "observable", "setting"], &numbers)
            .with_numbers(shifted.then_some("shift from the scene's stiffness"))
            .of(&self.references, |row| {
                let convergence = row.convergence.as_ref();
                let mean = |value: f64| measured(value, row.standard_error.map(|error| error.max(1e-9)));
                // Grids share the reference's digits; its error appears next to its own mean alone.
                let plain = |value: f64| mean(value).split(" ± ").next().unwrap_or_default().to_string();
                let index =
                    convergence.map(|c| format!("{} ({})", two_digits(c.grid_convergence_index), c.safety_factor));
                let mut cells = cells![
                    modulus(row.youngs_modulus),
                    observable(&row.observable),
                    row.setting.as_str(),
                    mean(row.mean),
                    row.standard_deviation.ne(&0.0).then(|| two_digits(row.standard_deviation)),
                    row.grid_means.map(|means| means.map(plain).join(" · ")),
                    convergence.and_then(|c| c.observed_order).map(two_digits),
                    convergence.and_then(|c| c.richardson).map(plain),
                    index,
                ];
                let shift = row.shift.map(|shift| signed(shift, row.shift_standard_error));
                cells.extend(shifted.then(|| shift.into()));
                cells
            })
    }
}

/// Style classes of the mark of a point; variations of Makadam's solver have a cross, as in figures.
fn mark(variation: Option<&str>, code: &str) -> String {
    let class = code_style(code).class;
    if variation.is_some() { format!("{class} cross") } else { class.into() }
}

/// Range of the wall times of several seeds.
fn range(point: &Point) -> Option<String> {
    let ends = [point.wall_seconds_per_simulated_second_least, point.wall_seconds_per_simulated_second_most];
    (point.seeds.len() > 1).then(|| ends.map(two_digits).join(" to "))
}

/// A deviation with its sign and its standard error; that of a reference is zero by definition.
fn error(point: &Point, name: &str) -> Cell {
    let Some(found) = point.deviation(name) else { return Cell::default() };
    let text = match found.deviation == 0.0 && found.interval90.is_none() {
        true => "0".into(),
        false => signed(found.deviation, found.deviation_standard_error),
    };
    Cell::from(text).strong(found.on_front)
}

/// Derives the findings of a study from its rows, one sentence each.
pub(super) fn findings(study: &Study) -> Vec<String> {
    let mut sentences: Vec<String> = study.fastest.iter().filter_map(|row| none_within(study, row)).collect();
    sentences.extend(study.references.iter().filter_map(|row| in_doubt(study, row)));
    if study.terms.bounds.is_empty() {
        sentences.push(
            "No observable of this scene has a bound, so there is no fastest setting; give one with --bound.".into(),
        );
    }
    sentences
}

/// Statement that a code has no setting within the bounds other than the reference itself.
fn none_within(study: &Study, row: &Fastest) -> Option<String> {
    let is_other = |point: &&Point| point.is_of(&row.code, row.stiffness_factor) && !point.reference;
    let any = study.points.iter().filter(is_other).any(|point| point.within_bounds == Some(true));
    let (code, stiffness) = (&row.code, modulus(row.youngs_modulus));
    (!any).then(|| format!("At {stiffness} no setting of {code} keeps the bounds, a reference apart."))
}

/// Statement on a reference that may be farther from its limit than the bound.
fn in_doubt(study: &Study, row: &Reference) -> Option<String> {
    let bound = study.terms.bound(&row.observable)?;
    let index = row.convergence.map(|convergence| convergence.grid_convergence_index).filter(|index| *index > bound)?;
    let (stiffness, observable, index) = (modulus(row.youngs_modulus), observable(&row.observable), two_digits(index));
    Some(format!(
        "The reference at {stiffness} is itself in doubt: the grid convergence index of its {observable}, {index}, lies above the bound."
    ))
}

/// Value to the second digit of its error; to four digits if the error is not known.
fn measured(value: f64, error: Option<f64>) -> String {
    let scale = error.filter(|error| *error > 0.0).unwrap_or(1e-2 * value.abs());
    let decimals = (1.0 - scale.max(1e-12).log10().floor()).clamp(0.0, 8.0) as usize;
    let error = error.map_or(String::new(), |error| format!(" ± {error:.decimals$}"));
    format!("{value:.decimals$}{error}").replace('-', "−")
}

fn signed(value: f64, error: Option<f64>) -> String {
    let text = measured(value, error);
    if value > 0.0 { format!("+{text}") } else { text }
}

/// A bound as text: "dynamic angle of repose within 0.5°".
fn bound_text(bound: &Bound) -> String {
    let degrees = if bound.observable.contains("angle") { "°" } else { "" };
    format!("{} within {}{degrees}", observable(&bound.observable), compact(bound.value))
}

/// Young's modulus (Pa) with its prefix.
pub(super) fn modulus(pascal: f64) -> String {
    match pascal {
        p if p >= 1e9 => format!("{} GPa", compact(1e-9 * p)),
        p => format!("{} MPa", compact(1e-6 * p)),
    }
}

/// Rows of `points.csv`, one per point and observable; a point without deviations has one row.
fn point_rows(points: &[Point]) -> Table {
    let rows = points.iter().flat_map(|point| {
        let none = point.deviations.is_empty().then_some(None);
        none.into_iter().chain(point.deviations.iter().map(Some)).map(move |deviation| {
            let mut fields = fields_of(point);
            fields.insert("seeds".into(), point.seeds.len().into());
            if let Some(deviation) = deviation {
                fields.extend(fields_of(deviation).into_iter().filter(|(name, _)| name != "seeds"));
                spread(&mut fields, deviation.interval90, ["interval90_low", "interval90_high"]);
            }
            fields
        })
    });
    Table::named(
        "code version setting stiffness_factor youngs_modulus time_step rayleigh_fraction sweeps variation seeds \
         wall_seconds_per_simulated_second wall_seconds_per_simulated_second_least wall_seconds_per_simulated_second_most \
         simulated_seconds failed reference within_bounds intervals_within_bounds \
         observable unit mean standard_error deviation deviation_standard_error interval90_low interval90_high \
         bound within interval_within on_front",
    )
    .of_fields(rows)
}

/// Rows of `references.csv`, one per stiffness and observable.
fn reference_rows(references: &[Reference]) -> Table {
    let rows = references.iter().map(|reference| {
        let mut fields = fields_of(reference);
        spread(&mut fields, Some(reference.steps), ["coarse_step", "middle_step", "fine_step"]);
        spread(&mut fields, reference.grid_means, ["coarse_mean", "middle_mean", "fine_mean"]);
        fields.extend(reference.convergence.iter().flat_map(fields_of));
        fields
    });
    Table::named(
        "stiffness_factor youngs_modulus setting observable unit seeds mean standard_deviation standard_error \
         coarse_step middle_step fine_step coarse_mean middle_mean fine_mean \
         observed_order richardson safety_factor grid_convergence_index shift shift_standard_error",
    )
    .of_fields(rows)
}

fn fields_of(row: &impl Serialize) -> Map<String, Value> {
    match serde_json::to_value(row) {
        Ok(Value::Object(fields)) => fields,
        _ => unreachable!("a row has named fields"),
    }
}

/// Adds the numbers of an array under names of their own.
fn spread<const N: usize>(fields: &mut Map<String, Value>, numbers: Option<[f64; N]>, names: [&str; N]) {
    for (name, number) in names.into_iter().zip(numbers.into_iter().flatten()) {
        fields.insert(name.into(), number.into());
    }
}
