//! Findings, tables and files of a trade-off.

use super::figures::figures;
use super::rows::{Bound, Fastest, Point, Reference};
use super::study::Study;
use makadam_compare::study::{
    Answer, Cell, Document, DocumentError, File, Medium, Report, Section, Table, cells, json, table as csv,
};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::names::{code_style, observable, with_unit};
use makadam_view::draw::numbers::{Rounding, compact, count, duration, plural, two_digits};
use serde::Serialize;
use serde_json::{Map, Value};

/// Share of a core below which a run was disturbed.
const QUIET: f64 = 0.9;

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
        let shifted = if self.is_shifted() {
            " In grey: the deviation from the reference at the scene's own stiffness, softening included."
        } else {
            ""
        };
        Report {
            kind: "Makadam, error against wall time",
            title: format!("What accuracy costs in time: the scene {}", self.scene),
            facts: facts.into_iter().flatten().collect(),
            answer: self.answer(),
            findings: self.findings.clone(),
            sections: vec![
                Section::new(
                    "Settings (* on the Pareto front of its code; ~ extrapolated; errors ± standard error over seeds)",
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
                    "Methods, precision, warm start",
                    "Variations of Makadam's solver at the scene's stiffness: the fastest setting of each within the bounds, and its wall \
                     time over that of the fastest setting that varies step and sweeps alone.",
                    self.varied_settings(),
                ),
                Section::new(
                    "All settings",
                    format!(
                        "Errors are mean deviations from the reference, seed by seed, with their standard error; those in bold are on the \
                         Pareto front of their code. Wall times are medians over seeds, with their range; ~ marks extrapolated \
                         ones.{shifted}"
                    ),
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
            let seconds = [row.wall_seconds_per_simulated_second, row.ratio_to_makadam];
            let [setting, pace, ratio, sureness] = choice(row.setting.as_deref(), seconds, row.intervals_within_bounds);
            let range = match [row.ratio_low, row.ratio_high] {
                [Some(low), Some(high)] => format!("{} to {}", two_digits(low), two_digits(high)),
                [Some(low), None] => format!("at least {}", two_digits(low)),
                [None, _] => String::new(),
            };
            vec![modulus(row.youngs_modulus).into(), code, setting, pace, ratio, range.into(), sureness]
        })
    }

    fn varied_settings(&self) -> Table {
        let table = Table::new(&["varied"], &["settings"]).with_words("fastest within the bounds");
        let table = table.with_numbers(["s per simulated s", "over sweeps alone"]).with_words("90% interval");
        table.of(&self.variations, |row| {
            let variation = Cell::from(&row.variation).marked(mark(Some(&row.variation), "Makadam"));
            let seconds = [row.wall_seconds_per_simulated_second, row.ratio_to_plain];
            let chosen = choice(row.setting.as_deref(), seconds, row.intervals_within_bounds);
            cells![variation, row.settings].into_iter().chain(chosen).collect()
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
            let about = if point.extrapolated { "~" } else { "" };
            let pace = format!("{about}{}", two_digits(point.wall_seconds_per_simulated_second));
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
                // Grids share the reference's digits; its error stands next to its own mean alone.
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

/// A selected setting, its wall time and the ratio of that to another's, and the position of its 90% intervals.
fn choice(setting: Option<&str>, seconds: [Option<f64>; 2], intervals: Option<bool>) -> [Cell; 4] {
    let [pace, ratio] = seconds.map(|seconds| seconds.map(two_digits).into());
    let sureness = match intervals {
        Some(true) => "interval within too",
        Some(false) => "interval reaches beyond",
        None => "interval not known",
    };
    [setting.unwrap_or("none that was measured").into(), pace, ratio, setting.map(|_| sureness).into()]
}

/// Style classes of the mark of a point; variations of Makadam's solver have a cross, as in figures.
fn mark(variation: Option<&str>, code: &str) -> String {
    let class = code_style(code).class;
    if variation.is_some() { format!("{class} cross") } else { class.into() }
}

/// Range of the wall times of several seeds, or the stretch that a wall time was extrapolated from.
fn range(point: &Point) -> Option<String> {
    if point.extrapolated {
        return Some(format!("from {} s simulated", two_digits(point.simulated_seconds)));
    }
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
    Cell::from(text).above(found.deviation_from_scene.map(|shift| signed(shift, None))).strong(found.on_front)
}

/// Derives the findings of a study from its rows, one sentence each.
pub(super) fn findings(study: &Study) -> Vec<String> {
    let mut sentences: Vec<String> = study.fastest.iter().filter_map(|row| none_within(study, row)).collect();
    sentences.extend(study.references.iter().filter_map(|row| in_doubt(study, row)));
    let cut = study.points.iter().filter(|point| point.extrapolated).count();
    if cut > 0 {
        let (limit, are) = (duration(study.terms.time_limit), if cut == 1 { "is" } else { "are" });
        sentences.push(format!(
            "{} {are} cut short, expected to take more than {limit} per run: wall times come from the beginning of the run, with few \
             contacts, and are too small; there is no error.",
            plural(cut, "configuration")
        ));
    }
    let share = study.points.iter().filter_map(|point| point.core_share_least).reduce(f64::min);
    if let Some(share) = share.filter(|share| *share < QUIET) {
        sentences.push(format!(
            "Other programs were running: a run got as little as {:.0}% of a core. Wall times are those of a core of its own, by \
             processor time; what shared caches and memory cost is not taken out.",
            100.0 * share
        ));
    }
    if study.terms.bounds.is_empty() {
        sentences.push(
            "No observable of this scene has a bound, so there is no fastest setting; give one with --bound.".into(),
        );
    }
    sentences
}

/// The reason for a code without a fastest setting other than the reference itself.
fn none_within(study: &Study, row: &Fastest) -> Option<String> {
    let mut own = study.points.iter().filter(|point| point.is_of(&row.code, row.stiffness_factor));
    let (code, stiffness) = (&row.code, modulus(row.youngs_modulus));
    let reason = match &row.setting {
        Some(setting) if own.any(|point| point.reference && point.setting == *setting) => {
            format!("no setting of {code} keeps the bounds but the reference itself.")
        }
        Some(_) => return None,
        None if own.any(|point| !point.extrapolated) => {
            format!("no setting of {code} that ran to its end keeps the bounds.")
        }
        None => format!("every run of {code} was cut short, so there is no error: raise --time-limit for one."),
    };
    Some(format!("At {stiffness} {reason}"))
}

/// A reference that may be farther from its limit than the bound.
fn in_doubt(study: &Study, row: &Reference) -> Option<String> {
    let bound = study.terms.bound(&row.observable)?;
    let index = row.convergence.map(|convergence| convergence.grid_convergence_index).filter(|index| *index > bound)?;
    let (stiffness, observable, index) = (modulus(row.youngs_modulus), observable(&row.observable), two_digits(index));
    Some(format!(
        "The reference at {stiffness} is itself in doubt: the grid convergence index of its {observable}, {index}, lies above the bound."
    ))
}

/// A value to the second digit of its error; to four digits if the error is not known.
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
         core_share_least simulated_seconds extrapolated failed reference within_bounds intervals_within_bounds \
         observable unit mean standard_error deviation deviation_standard_error interval90_low interval90_high \
         deviation_from_scene bound within interval_within on_front",
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
