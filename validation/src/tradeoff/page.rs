//! The files of a trade-off: its rows, its figures, and a page with tables and what they say.

use super::figures::figures;
use super::flat;
use super::rows::{Fastest, Point, Reference, Varied};
use super::study::Study;
use super::terminal::{ordered, verdict};
use super::variations::Variation;
use super::words::{self, modulus, titled};
use crate::draw::figure::Figure;
use crate::draw::names::{CodeStyle, Marker, code_style, observable};
use crate::draw::numbers::{count, duration, two_digits};
use crate::study::{Cell, Document, DocumentError, File, Table, json, page, table};
use minijinja::{Value, context};

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
            standing => standing(self),
            particles => count(self.particles),
            limit => duration(self.time_limit),
            bounds => self.bounds.iter().map(words::bound).collect::<Vec<_>>().join(", "),
            fastest => fastest(&self.fastest),
            variations => variations(&self.variations),
            points => points(self).html(),
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

/// Word, style and sentence at the head.
fn standing(study: &Study) -> Value {
    let (word, class) = match (study.complete, study.reaches_bounds("Makadam")) {
        (false, _) => ("Not finished.", "undecided"),
        (true, Some(true)) => ("Within the bounds.", "agree"),
        (true, Some(false)) => ("Beyond the bounds.", "disagree"),
        (true, None) => ("No bounds.", "undecided"),
    };
    let makadam = study.findings.iter().find(|sentence| sentence.contains("Makadam"));
    context! { word => word, class => class, sentence => makadam.or(study.findings.first()) }
}

/// The fastest settings; nothing where there are none.
fn fastest(rows: &[Fastest]) -> Option<String> {
    let table = Table::new(&["stiffness", "code", "setting"], &["s a simulated s", "over Makadam's"]);
    let table = table.with_words("90% interval").of(rows, |row| {
        let code = Cell::from(row.code.as_str()).marked(code_style(&row.code).class);
        let mut cells = vec![modulus(row.youngs_modulus).into(), code];
        let seconds = [row.wall_seconds_per_simulated_second, row.ratio_to_makadam];
        cells.extend(choice(row.setting.as_deref(), seconds, row.intervals_within_bounds));
        cells
    });
    (!table.is_empty()).then(|| table.html())
}

/// What other methods do; nothing where there are none.
fn variations(rows: &[Varied]) -> Option<String> {
    let table = Table::new(&["varied"], &["settings"]).with_words("fastest within the bounds");
    let table =
        table.with_numbers(["s a simulated s", "over sweeps alone"]).with_words("90% interval").of(rows, |row| {
            let variation = Cell::from(row.variation.as_str()).marked(mark(Some(&row.variation), "Makadam"));
            let mut cells = vec![variation, row.settings.into()];
            let seconds = [row.wall_seconds_per_simulated_second, row.ratio_to_plain];
            cells.extend(choice(row.setting.as_deref(), seconds, row.intervals_within_bounds));
            cells
        });
    (!table.is_empty()).then(|| table.html())
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

fn points(study: &Study) -> Table {
    let names = study.observables();
    let unit = |name: &str| study.references.iter().find(|row| row.observable == name).map_or("", |row| &row.unit);
    let mut table = Table::new(&["stiffness", "code", "setting"], &["seeds", "s a simulated s"])
        .with_numbers(names.iter().map(|name| titled(name, unit(name))))
        .with_words("bounds");
    let mut last = None;
    for point in ordered(study) {
        let about = if point.extrapolated { "~" } else { "" };
        let pace = format!("{about}{}", two_digits(point.wall_seconds_per_simulated_second));
        let mut cells = vec![
            modulus(point.youngs_modulus).into(),
            Cell::from(point.code.as_str()).marked(mark(point.variation.as_deref(), &point.code)),
            point.setting.as_str().into(),
            point.seeds.len().into(),
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
