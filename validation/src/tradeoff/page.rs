//! The page of a trade-off: figures, tables and what they say, in one file that loads nothing.

use super::rows::{Fastest, Point, Reference, Varied};
use super::study::Study;
use super::terminal::{ordered, verdict};
use super::variations::Variation;
use super::words::{self, modulus, titled};
use crate::draw::figure::Figure;
use crate::draw::names::{CodeStyle, Marker, code_style, observable};
use crate::draw::numbers::{count, duration, two_digits};
use crate::report::page::{environment, style};
use minijinja::{Value, context};

/// Renders the page.
pub(super) fn render(study: &Study, figures: &[Figure]) -> Result<String, minijinja::Error> {
    let mut environment = environment()?;
    environment.add_template("page", include_str!("page.html"))?;
    let names = study.observables();
    let unit = |name: &str| study.references.iter().find(|row| row.observable == name).map_or("", |row| &row.unit);
    environment.get_template("page")?.render(context! {
        title => format!("What accuracy costs in time: the scene {}", study.scene),
        style => style(),
        study => study,
        standing => standing(study),
        particles => count(study.particles),
        limit => duration(study.time_limit),
        bounds => study.bounds.iter().map(words::bound).collect::<Vec<_>>().join(", "),
        figures => figures,
        fastest => study.fastest.iter().map(fastest).collect::<Vec<_>>(),
        variations => study.variations.iter().map(varied).collect::<Vec<_>>(),
        observables => names.iter().map(|name| titled(name, unit(name))).collect::<Vec<_>>(),
        points => points(study, &names),
        references => study.references.iter().map(reference).collect::<Vec<_>>(),
        shifted => study.references.iter().any(|row| row.shift.is_some()),
        provenance => study.provenance.iter().map(|(key, value)| (key.replace('_', " "), value)).collect::<Vec<_>>(),
    })
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

fn fastest(row: &Fastest) -> Value {
    context! {
        stiffness => modulus(row.youngs_modulus),
        code => row.code,
        class => code_style(&row.code).class,
        setting => row.setting,
        pace => row.wall_seconds_per_simulated_second.map(two_digits),
        ratio => row.ratio_to_makadam.map(two_digits),
        interval => row.setting.as_ref().map(|_| words::sureness(row.intervals_within_bounds)),
    }
}

fn varied(row: &Varied) -> Value {
    context! {
        variation => row.variation,
        class => mark(Some(&row.variation), "Makadam"),
        settings => row.settings,
        setting => row.setting,
        pace => row.wall_seconds_per_simulated_second.map(two_digits),
        ratio => row.ratio_to_plain.map(two_digits),
        interval => row.setting.as_ref().map(|_| words::sureness(row.intervals_within_bounds)),
    }
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

fn points(study: &Study, names: &[&str]) -> Vec<Value> {
    let mut last = None;
    let rows = ordered(study).into_iter().map(|point| {
        let group = (point.code.as_str(), point.stiffness_factor);
        let first = last.replace(group) != Some(group);
        context! {
            first => first,
            stiffness => modulus(point.youngs_modulus),
            code => point.code,
            class => mark(point.variation.as_deref(), &point.code),
            setting => point.setting,
            seeds => point.seeds.len(),
            pace => format!(
                "{}{}", if point.extrapolated { "~" } else { "" }, two_digits(point.wall_seconds_per_simulated_second)
            ),
            range => range(point),
            errors => names.iter().map(|name| error(point, name)).collect::<Vec<_>>(),
            verdict => verdict(study, point),
        }
    });
    rows.collect()
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

fn error(point: &Point, name: &str) -> Value {
    let found = point.deviation(name);
    context! {
        text => found.map(words::deviation),
        front => found.is_some_and(|deviation| deviation.on_front),
        from_scene => found.and_then(|deviation| deviation.deviation_from_scene).map(|shift| words::signed(shift, None)),
    }
}

fn reference(row: &Reference) -> Value {
    let convergence = row.convergence.as_ref();
    let mean = |value: f64| words::measured(value, row.standard_error.map(|error| error.max(1e-9)));
    // Grids share the reference's digits; its error stands beside its own mean alone.
    let plain = |value: f64| mean(value).split(" ± ").next().unwrap_or_default().to_string();
    context! {
        stiffness => modulus(row.youngs_modulus),
        observable => observable(&row.observable),
        setting => row.setting,
        mean => mean(row.mean),
        deviation => row.standard_deviation.ne(&0.0).then(|| two_digits(row.standard_deviation)),
        grids => row.grid_means.map(|means| means.map(plain).join(" · ")),
        order => convergence.and_then(|c| c.observed_order).map(two_digits),
        richardson => convergence.and_then(|c| c.richardson).map(plain),
        index => convergence.map(|c| two_digits(c.grid_convergence_index)),
        factor => convergence.map(|c| c.safety_factor),
        shift => row.shift.map(|shift| words::signed(shift, row.shift_standard_error)),
    }
}
