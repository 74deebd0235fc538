//! Bias and scatter of each observable over scenes and reference codes, and the range of conditions of the scenes.
//!
//! With the means M of the code under test and E of a reference code in a scene, after McGrattan & Toman, Metrologia 48, 173 (2011):
//!
//! ```text
//! m, s^2     mean and variance of ln(M/E) over all pairs
//! sigma_E^2  variance of ln E among the reference codes of a scene, over all scenes; at most s^2/2
//! sigma_M^2  s^2 - sigma_E^2
//! bias       exp(m + sigma_M^2/2 - sigma_E^2/2)
//! ```
//!
//! The bound of `sigma_E^2` says that a code cannot be shown to scatter less than the references that it is compared with.

use makadam::scene::{Motion, Shape};
use makadam_compare::compare::{Comparison, Row, distinct};
use makadam_compare::study::{Cell, Table, cells};
use makadam_frames::plan::MeasuredScene;
use makadam_measure::statistics::{mean, standard_deviation, standard_error};
use makadam_view::draw::names::{self, code_style};
use makadam_view::draw::numbers::two_digits;
use makadam_view::draw::plot::{Axis, Key, Plot};

/// Two codes in a scene.
struct Pair<'a> {
    scene: &'a str,
    reference: &'a str,
    /// Logarithm of the reference value.
    reference_value: f64,
    /// Logarithm of the ratio of the code under test to the reference code.
    ratio: f64,
}

/// Bias and scatter of an observable; relative values.
pub(super) struct Bias<'a> {
    observable: &'a str,
    pairs: Vec<Pair<'a>>,
    /// Mean ratio to the reference codes, minus 1.
    bias: f64,
    /// Standard error of the bias over scenes.
    error: f64,
    /// Scatter of the code under test.
    scatter: f64,
    /// Scatter of the reference codes; `None` if no scene has two of them.
    scatter_of_references: Option<f64>,
}

impl<'a> Bias<'a> {
    /// Returns the bias of an observable; `None` with fewer than two scenes, or with values that are not positive.
    fn of(comparisons: &'a [Comparison], observable: &'a str) -> Option<Bias<'a>> {
        let rows = comparisons.iter().flat_map(|comparison| {
            comparison.rows.iter().filter(move |row| row.code == comparison.judged && row.observable == observable)
        });
        let pairs: Vec<Pair<'a>> = rows.filter(|row| row.difference.is_some()).map(pair).collect::<Option<_>>()?;
        let scenes = distinct(pairs.iter().map(|pair| pair.scene));
        let of_scene = |scene: &&str, value: fn(&Pair<'_>) -> f64| -> Vec<f64> {
            pairs.iter().filter(|pair| pair.scene == *scene).map(value).collect()
        };
        let ratios: Vec<f64> = pairs.iter().map(|pair| pair.ratio).collect();
        let means: Vec<f64> = scenes.iter().map(|scene| mean(&of_scene(scene, |pair| pair.ratio))).collect();
        let (error, all) = (standard_error(&means)?, standard_deviation(&ratios)?.powi(2));
        // Variance of the reference codes about their mean in each scene, weighted by its degrees of freedom.
        let (mut squares, mut freedom) = (0.0, 0.0);
        for references in scenes.iter().map(|scene| of_scene(scene, |pair| pair.reference_value)) {
            let middle = mean(&references);
            squares += references.iter().map(|value| (value - middle).powi(2)).sum::<f64>();
            freedom += references.len() as f64 - 1.0;
        }
        let of_references = (freedom > 0.0).then(|| (squares / freedom).min(0.5 * all));
        let of_code = all - of_references.unwrap_or(0.0);
        let bias = (mean(&ratios) + 0.5 * of_code - 0.5 * of_references.unwrap_or(0.0)).exp() - 1.0;
        let (scatter, scatter_of_references) = (of_code.sqrt(), of_references.map(f64::sqrt));
        Some(Bias { observable, pairs, bias, error, scatter, scatter_of_references })
    }

    /// Pair with the largest deviation.
    fn farthest(&self) -> Option<&Pair<'a>> {
        self.pairs.iter().max_by(|one, other| one.ratio.abs().total_cmp(&other.ratio.abs()))
    }
}

fn pair(row: &Row) -> Option<Pair<'_>> {
    let (value, reference) = (row.mean?, row.mean? - row.difference?);
    let is_ratio = value > 0.0 && reference > 0.0;
    is_ratio.then_some(Pair {
        scene: &row.scene,
        reference: row.reference_code.as_deref()?,
        reference_value: reference.ln(),
        ratio: (value / reference).ln(),
    })
}

/// Returns the bias of each observable that at least two scenes compare.
pub(super) fn biases(comparisons: &[Comparison]) -> Vec<Bias<'_>> {
    let rows = comparisons.iter().flat_map(|comparison| &comparison.rows);
    let observables = distinct(rows.map(|row| row.observable.as_str()));
    observables.into_iter().filter_map(|observable| Bias::of(comparisons, observable)).collect()
}

/// Heads of the columns of numbers.
const COLUMNS: [&str; 5] = ["bias", "standard error", "scatter", "scatter of references", "largest deviation"];

/// Returns the table of biases.
pub(super) fn table(biases: &[Bias<'_>]) -> Table {
    let heads = COLUMNS.map(|head| format!("{head}, %"));
    let table = Table::new(&["observable"], &["scenes", "pairs"]).with_numbers(heads);
    table.of(biases.iter().enumerate(), |(place, bias)| {
        let percent = |value: f64| two_digits(100.0 * value);
        let farthest = bias.farthest();
        let worst = farthest.map(|pair| percent(pair.ratio.exp_m1()));
        let place_of_worst = farthest.map(|pair| format!("{}, {}", pair.scene, pair.reference));
        let mut row = cells![
            format!("{}: {}", place + 1, names::observable(bias.observable)),
            distinct(bias.pairs.iter().map(|pair| pair.scene)).len(),
            bias.pairs.len(),
            percent(bias.bias),
            percent(bias.error),
            percent(bias.scatter),
            bias.scatter_of_references.map(percent),
        ];
        row.push(Cell::from(worst).above(place_of_worst));
        row
    })
}

/// Returns the rows of the file of biases: one per pair.
pub(super) fn rows(comparisons: &[Comparison]) -> Vec<Vec<Cell>> {
    let biases = biases(comparisons);
    let of_one = |bias: &Bias<'_>| -> Vec<Vec<Cell>> {
        let row = |pair: &Pair<'_>| {
            let Bias { observable, bias, error, scatter, scatter_of_references, .. } = *bias;
            cells![
                observable,
                pair.scene,
                pair.reference,
                pair.ratio.exp(),
                bias,
                error,
                scatter,
                scatter_of_references
            ]
        };
        bias.pairs.iter().map(row).collect()
    };
    biases.iter().flat_map(of_one).collect()
}

/// Draws the deviation of each pair in percent; bars are the bias and the scatter of the code under test. None without biases.
pub(super) fn figure(biases: &[Bias<'_>]) -> Option<String> {
    let all = || biases.iter().flat_map(|bias| &bias.pairs);
    let codes = distinct(all().map(|pair| pair.reference));
    let percent = |ratio: f64| 100.0 * ratio.exp_m1();
    let ends =
        biases.iter().flat_map(|bias| [bias.bias - bias.scatter, bias.bias + bias.scatter].map(|end| 100.0 * end));
    let values = all().map(|pair| percent(pair.ratio)).chain(ends);
    let (low, high) = values.fold((0.0_f64, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    if biases.is_empty() {
        return None;
    }
    let room = 0.08 * (high - low);
    let keys = [Key::Code("Makadam")].into_iter().chain(codes.iter().map(|code| Key::Points(code_style(code), code)));
    let mut plot = Plot::with_legend(
        Axis::linear("observable, by its number in the table", 0.0, biases.len() as f64 + 1.0),
        Axis::linear("deviation from the reference code, %", low - room, high + room),
        &keys.collect::<Vec<_>>(),
    );
    plot.curve("literature", [[0.0, 0.0], [biases.len() as f64 + 1.0, 0.0]].into_iter());
    for (place, bias) in biases.iter().enumerate() {
        let (x, own) = (place as f64 + 1.0, code_style("Makadam"));
        let [low, high] = [-1.0, 1.0].map(|sign| 100.0 * (bias.bias + sign * bias.scatter));
        plot.error_bar(&format!("{} error", own.class), x - 0.25, low, high);
        plot.marker(own, x - 0.25, 100.0 * bias.bias, 4.0);
        for pair in &bias.pairs {
            let code = codes.iter().position(|code| *code == pair.reference).unwrap_or(0);
            let beside = 0.12 * code as f64;
            plot.open_marker(code_style(pair.reference), x + beside, percent(pair.ratio), 3.0);
        }
    }
    Some(plot.finish("deviation of each observable from the reference codes"))
}

/// Dimensionless groups of a scene.
fn groups(scene: &MeasuredScene) -> Vec<(&'static str, f64)> {
    let mut groups = Vec::new();
    let populations = scene.population.iter().map(|population| (&population.material, population.radius.bounds()));
    let sources = scene.insert.iter().map(|source| (&source.material, source.radius.bounds()));
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    let gravity = scene.gravity.iter().map(|component| component * component).sum::<f64>().sqrt();
    for (name, (low, high)) in populations.chain(sources) {
        (least, most) = (least.min(low), most.max(high));
        if let Some(material) = scene.material.get(name) {
            groups.push(("friction of grains", material.friction));
            groups.push(("restitution of grains", material.restitution));
            groups.push(("rolling friction of grains", material.rolling_friction));
            let weight = material.density * gravity * (low + high);
            groups.extend((weight > 0.0).then(|| ("stiffness E/(ρ g d)", material.youngs_modulus / weight)));
        }
    }
    if most > 0.0 {
        groups.push(("largest over smallest grain", most / least));
        let widths = [0, 1, 2].map(|axis| scene.domain.max[axis] - scene.domain.min[axis]);
        groups.push((
            "narrowest width of the domain over d",
            widths.into_iter().fold(f64::INFINITY, f64::min) / (least + most),
        ));
    }
    let drum = scene.wall.iter().find_map(|wall| match (&wall.shape, &wall.motion) {
        (Shape::Cylinder { radius, .. }, Motion::Rotating { rate, .. }) => Some(rate * rate * radius / gravity),
        _ => None,
    });
    groups.extend(drum.map(|froude| ("Froude number of drums Ω² R/g", froude)));
    groups
}

/// Returns the table of the conditions that the scenes cover: the smallest and the largest value of each dimensionless group.
pub(super) fn conditions(comparisons: &[Comparison]) -> Table {
    let found: Vec<(&str, Vec<(&'static str, f64)>)> =
        comparisons.iter().map(|comparison| (comparison.scene.name.as_str(), groups(&comparison.scene))).collect();
    let all =
        || found.iter().flat_map(|(scene, groups)| groups.iter().map(move |(name, value)| (*name, *value, *scene)));
    Table::new(&["group"], &["smallest", "largest", "scenes"]).of(distinct(all().map(|(name, ..)| name)), |group| {
        let values = || all().filter(|(name, ..)| *name == group);
        let smallest = values().map(|(_, value, _)| value).fold(f64::INFINITY, f64::min);
        let largest = values().map(|(_, value, _)| value).fold(0.0, f64::max);
        let scenes = distinct(values().map(|(.., scene)| scene)).len();
        cells![group, two_digits(smallest), two_digits(largest), scenes]
    })
}

#[cfg(test)]
#[path = "../../tests/unit/report_bias.rs"]
mod tests;
