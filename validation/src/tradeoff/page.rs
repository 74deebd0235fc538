//! The files of a trade-off: its rows, its figures, and a page with tables and what they say.

use super::figures::figures;
use super::flat;
use super::rows::{Point, Reference};
use super::study::Study;
use super::variations::Variation;
use super::words::{self, modulus, titled};
use crate::draw::figure::Figure;
use crate::draw::names::{CodeStyle, Marker, code_style, observable};
use crate::draw::numbers::{count, duration, two_digits};
use crate::study::{Answer, Cell, Document, DocumentError, File, Table, cells, json, page, table};
use minijinja::context;

impl Document for Study {
    const NAME: &'static str = "tradeoff";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![
            flat::points(&self.points).csv("points")?,
            flat::references(&self.references).csv("references")?,
            table("fastest", &self.fastest)?,
            json("provenance", &self.provenance)?,
        ])
    }

    fn figures(&self) -> Vec<Figure> {
        figures(self)
    }

    fn page(&self, figures: &[Figure]) -> Result<String, minijinja::Error> {
        let others = context! {
            study => self,
            answer => answer(self),
            particles => count(self.particles),
            limit => duration(self.time_limit),
            bounds => self.bounds.iter().map(words::bound).collect::<Vec<_>>().join(", "),
            fastest => fastest(self).map(|table| table.html()),
            variations => variations(self).map(|table| table.html()),
            points => points(self, usize::MAX).html(),
            references => references(self).html(),
            shifted => is_shifted(self),
        };
        let title = format!("What accuracy costs in time: the scene {}", self.scene);
        page(include_str!("page.html"), &title, figures, self.provenance.clone(), others)
    }
}

fn is_shifted(study: &Study) -> bool {
    study.references.iter().any(|row| row.shift.is_some())
}

/// What stands at the head.
fn answer(study: &Study) -> Answer {
    let (word, class) = match (study.complete, study.reaches_bounds("Makadam")) {
        (false, _) => ("Not finished.", "undecided"),
        (true, Some(true)) => ("Within the bounds.", "agree"),
        (true, Some(false)) => ("Beyond the bounds.", "disagree"),
        (true, None) => ("No bounds.", "undecided"),
    };
    let own = study.fastest.iter().find(|row| row.code == "Makadam" && row.stiffness_factor == 1.0);
    let sentence = own.and_then(|row| row.setting.as_ref().zip(row.wall_seconds_per_simulated_second));
    let sentence = sentence.map(|(setting, wall)| {
        format!(
            "The fastest setting of Makadam that keeps them is {setting}: {} s per simulated second.",
            two_digits(wall)
        )
    });
    let sentence = sentence.or_else(|| study.findings.first().cloned()).unwrap_or_default();
    Answer { class, word: word.into(), sentence }
}

/// The fastest settings; nothing where there are none.
pub(super) fn fastest(study: &Study) -> Option<Table> {
    let table = Table::new(&["stiffness", "code", "setting"], &["s a simulated s", "over Makadam's"]);
    let table = table.with_words("its 90% interval").with_words("90% interval of errors").of(&study.fastest, |row| {
        let code = Cell::from(&row.code).marked(code_style(&row.code).class);
        let seconds = [row.wall_seconds_per_simulated_second, row.ratio_to_makadam];
        let [setting, pace, ratio, sureness] = choice(row.setting.as_deref(), seconds, row.intervals_within_bounds);
        let range = words::range([row.ratio_low, row.ratio_high]);
        vec![modulus(row.youngs_modulus).into(), code, setting, pace, ratio, range.into(), sureness]
    });
    (!table.is_empty()).then_some(table)
}

/// What other methods do; nothing where there are none.
pub(super) fn variations(study: &Study) -> Option<Table> {
    let table = Table::new(&["varied"], &["settings"]).with_words("fastest within the bounds");
    let table = table.with_numbers(["s a simulated s", "over sweeps alone"]).with_words("90% interval");
    let table = table.of(&study.variations, |row| {
        let variation = Cell::from(&row.variation).marked(mark(Some(&row.variation), "Makadam"));
        let seconds = [row.wall_seconds_per_simulated_second, row.ratio_to_plain];
        let chosen = choice(row.setting.as_deref(), seconds, row.intervals_within_bounds);
        cells![variation, row.settings].into_iter().chain(chosen).collect()
    });
    (!table.is_empty()).then_some(table)
}

/// A setting that was chosen, its wall time and the ratio of that to another's, and how sure the choice is.
fn choice(setting: Option<&str>, seconds: [Option<f64>; 2], intervals: Option<bool>) -> [Cell; 4] {
    let [pace, ratio] = seconds.map(|seconds| seconds.map(two_digits).into());
    [
        setting.unwrap_or("none that was measured").into(),
        pace,
        ratio,
        setting.map(|_| words::sureness(intervals)).into(),
    ]
}

/// Classes of the mark of a point: those of its variation, or of its code.
fn mark(variation: Option<&str>, code: &str) -> String {
    let Some(variation) = variation.and_then(Variation::named) else { return code_style(code).class.into() };
    let CodeStyle { class, marker } = variation.family.style();
    let shape = match marker {
        Marker::Circle => "circle",
        Marker::Square => "square",
        Marker::Triangle => "triangle",
        Marker::Diamond => "diamond",
        Marker::Wedge => "wedge",
        Marker::Cross => "cross",
    };
    format!("{class} {shape}")
}

/// Points by stiffness, code and wall time, with the errors of so many observables, bounded ones first.
pub(super) fn points(study: &Study, most: usize) -> Table {
    let names: Vec<&str> = study.observables().into_iter().take(most).collect();
    let unit = |name: &str| study.references.iter().find(|row| row.observable == name).map_or("", |row| &row.unit);
    let mut table = Table::new(&["stiffness", "code", "setting"], &["seeds", "s a simulated s"])
        .with_numbers(names.iter().map(|name| titled(name, unit(name))))
        .with_words("bounds");
    let mut last = None;
    for point in ordered(study) {
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
        cells.push(verdict(study, point).into());
        let group = (point.code.as_str(), point.stiffness_factor);
        match last.replace(group) == Some(group) {
            true => table.row(cells),
            false => table.first_row(cells),
        }
    }
    table
}

/// Points by stiffness, code and wall time.
fn ordered(study: &Study) -> Vec<&Point> {
    let mut points: Vec<&Point> = study.points.iter().collect();
    let rank = |code: &str| study.points.iter().position(|point| point.code == code);
    points.sort_by(|a, b| {
        let wall = |point: &Point| point.wall_seconds_per_simulated_second;
        a.stiffness_factor
            .total_cmp(&b.stiffness_factor)
            .then(rank(&a.code).cmp(&rank(&b.code)))
            .then(wall(a).total_cmp(&wall(b)))
    });
    points
}

/// Whether a point keeps the bounds, in words.
fn verdict(study: &Study, point: &Point) -> &'static str {
    match (point.reference, point.within_bounds, point.intervals_within_bounds) {
        _ if point.failed => "failed with a seed",
        _ if study.bounds.is_empty() => "",
        (true, ..) => "reference",
        (_, Some(true), Some(true)) => "within, interval too",
        (_, Some(true), _) => "within",
        (_, Some(false), _) => "beyond",
        (_, None, _) => "",
    }
}

/// Range of the wall times of several seeds, or the stretch that a wall time was extrapolated from.
fn range(point: &Point) -> Option<String> {
    if point.extrapolated {
        return Some(format!("from {} s simulated", two_digits(point.simulated_seconds)));
    }
    (point.seeds.len() > 1).then(|| {
        format!(
            "{} to {}",
            two_digits(point.wall_seconds_per_simulated_second_least),
            two_digits(point.wall_seconds_per_simulated_second_most)
        )
    })
}

fn error(point: &Point, name: &str) -> Cell {
    let Some(found) = point.deviation(name) else { return Cell::default() };
    let from_scene = found.deviation_from_scene.map(|shift| words::signed(shift, None));
    Cell::from(words::deviation(found)).above(from_scene).strong(found.on_front)
}

fn references(study: &Study) -> Table {
    let shifted = is_shifted(study);
    let numbers = [
        "mean",
        "spread over seeds",
        "three grids, coarse to fine",
        "observed order",
        "Richardson's estimate",
        "grid convergence index (factor)",
    ];
    Table::new(&["stiffness", "observable", "setting"], &numbers)
        .with_numbers(shifted.then_some("shift from the scene's stiffness"))
        .of(&study.references, |row| reference(row, shifted))
}

fn reference(row: &Reference, shifted: bool) -> Vec<Cell> {
    let convergence = row.convergence.as_ref();
    let mean = |value: f64| words::measured(value, row.standard_error.map(|error| error.max(1e-9)));
    // Grids share the reference's digits; its error stands beside its own mean alone.
    let plain = |value: f64| mean(value).split(" ± ").next().unwrap_or_default().to_string();
    let index = convergence.map(|c| format!("{} ({})", two_digits(c.grid_convergence_index), c.safety_factor));
    let mut cells = vec![
        modulus(row.youngs_modulus).into(),
        observable(&row.observable).into(),
        row.setting.as_str().into(),
        mean(row.mean).into(),
        row.standard_deviation.ne(&0.0).then(|| two_digits(row.standard_deviation)).into(),
        row.grid_means.map(|means| means.map(plain).join(" · ")).into(),
        convergence.and_then(|c| c.observed_order).map(two_digits).into(),
        convergence.and_then(|c| c.richardson).map(plain).into(),
        index.into(),
    ];
    cells.extend(shifted.then(|| row.shift.map(|shift| words::signed(shift, row.shift_standard_error)).into()));
    cells
}
