//! What a trade-off found, in sentences: every number is computed from its rows.

use super::rows::{Fastest, Point, Reference, Varied};
use super::study::Study;
use super::words::{self, modulus};
use crate::draw::names::observable;
use crate::draw::numbers::two_digits;

/// Share of a core below which a run was disturbed.
const QUIET: f64 = 0.9;

impl Study {
    /// The same study, which says what was found.
    pub fn with_findings(mut self) -> Study {
        self.findings = findings(&self);
        self
    }
}

/// The sentences, the answer first.
fn findings(study: &Study) -> Vec<String> {
    let mut sentences: Vec<String> = study.fastest.iter().map(|row| fastest(study, row)).collect();
    sentences.extend(study.stiffness_factors().into_iter().filter_map(|factor| ratios(study, factor)));
    sentences.extend(study.variations.iter().filter_map(|row| varied(study, row)));
    let bounded = |row: &&Reference| study.bounds.iter().any(|bound| bound.observable == row.observable);
    sentences.extend(study.references.iter().filter(bounded).filter_map(|row| trust(study, row)));
    sentences.extend(study.references.iter().filter(bounded).filter_map(shift));
    sentences.extend(extrapolated(study));
    sentences.extend(neighbours(study));
    if study.bounds.is_empty() {
        sentences.push(
            "No observable of this scene has a bound, so there is no fastest setting; give one with --bound.".into(),
        );
    }
    sentences
}

/// Whether a point is one of those that a row chose from.
fn is_of(point: &Point, row: &Fastest) -> bool {
    point.code == row.code && point.stiffness_factor == row.stiffness_factor
}

fn fastest(study: &Study, row: &Fastest) -> String {
    let bounds = study.bounds.iter().map(words::bound).collect::<Vec<_>>().join(" and ");
    let stiffness = modulus(row.youngs_modulus);
    let Some((setting, wall)) = row.setting.as_ref().zip(row.wall_seconds_per_simulated_second) else {
        let mut own = study.points.iter().filter(|point| is_of(point, row));
        return match own.any(|point| !point.extrapolated) {
            true => format!("At {stiffness} no setting of {} that ran to its end keeps the {bounds}.", row.code),
            false => format!(
                "At {stiffness} every run of {} was cut short, so there is no error: raise --time-limit for one.",
                row.code
            ),
        };
    };
    if study.points.iter().any(|point| is_of(point, row) && point.reference && point.setting == *setting) {
        return format!(
            "At {stiffness} no setting of {} keeps the {bounds} but the reference itself, {setting}: {} s a simulated second.",
            row.code,
            two_digits(wall)
        );
    }
    let interval = match row.intervals_within_bounds {
        Some(true) => "; the 90% interval lies within too",
        Some(false) => "; the 90% interval reaches beyond, more seeds would tell",
        None => "",
    };
    format!(
        "At {stiffness} the fastest setting of {} that keeps the {bounds} is {setting}: {} s a simulated second{interval}.",
        row.code,
        two_digits(wall)
    )
}

/// Wall times of the fastest settings of all codes at one stiffness.
fn ratios(study: &Study, factor: f64) -> Option<String> {
    let rows: Vec<(&Fastest, f64)> = study
        .fastest
        .iter()
        .filter(|row| row.stiffness_factor == factor)
        .filter_map(|row| Some((row, row.ratio_to_makadam?)))
        .collect();
    let (first, _) = rows.first()?;
    let names: Vec<&str> = rows.iter().map(|(row, _)| row.code.as_str()).collect();
    let ratios: Vec<String> = rows.iter().map(|(_, ratio)| two_digits(*ratio)).collect();
    (rows.len() > 1).then(|| {
        format!(
            "Wall times {} within the bounds at {}: {}.",
            names.join(" : "),
            modulus(first.youngs_modulus),
            ratios.join(" : ")
        )
    })
}

/// What a variation of the solver is good for; nothing can be said without bounds.
fn varied(study: &Study, row: &Varied) -> Option<String> {
    let Varied { variation, settings, setting, .. } = row;
    if study.bounds.is_empty() {
        return None;
    }
    let bounds = study.bounds.iter().map(words::bound).collect::<Vec<_>>().join(" and ");
    Some(match (setting, row.wall_seconds_per_simulated_second, row.ratio_to_plain) {
        (Some(setting), Some(wall), Some(ratio)) => format!(
            "With {variation} the {bounds} takes {} s a simulated second ({setting}), {} times the fastest setting that varies \
             step and sweeps alone.",
            two_digits(wall),
            two_digits(ratio)
        ),
        (Some(setting), Some(wall), None) => format!(
            "With {variation} the {bounds} takes {} s a simulated second ({setting}); step and sweeps alone do not reach it.",
            two_digits(wall)
        ),
        _ if *settings == 1 => format!("With {variation} the one setting that was run does not keep the {bounds}."),
        _ => format!("With {variation} none of {settings} settings keeps the {bounds}."),
    })
}

/// How near a reference is to its limit.
fn trust(study: &Study, row: &Reference) -> Option<String> {
    let convergence = row.convergence?;
    let bound = study.bounds.iter().find(|bound| bound.observable == row.observable)?;
    let order = match convergence.observed_order {
        Some(order) => format!("observed order {}", two_digits(order)),
        None => "no order observed above the spread over seeds".into(),
    };
    let index = convergence.grid_convergence_index;
    let verdict =
        if index <= bound.value { "below the bound" } else { "above the bound, so the reference itself is in doubt" };
    Some(format!(
        "Reference at {}: {} {} over {} seeds; {order}; grid convergence index {} (safety factor {}), {verdict}.",
        modulus(row.youngs_modulus),
        observable(&row.observable),
        words::measured(row.mean, row.standard_error),
        row.seeds,
        two_digits(index),
        convergence.safety_factor,
    ))
}

fn shift(row: &Reference) -> Option<String> {
    let shift = row.shift?;
    Some(format!(
        "Grains of {} instead of the scene's shift the {} by {}.",
        modulus(row.youngs_modulus),
        observable(&row.observable),
        words::signed(shift, row.shift_standard_error)
    ))
}

fn extrapolated(study: &Study) -> Option<String> {
    let count = study.points.iter().filter(|point| point.extrapolated).count();
    (count > 0).then(|| {
        format!(
            "{count} configuration{} expected to take more than {} s a run: the wall time is extrapolated from the first \
             part, in which grains still fall and a step costs less, and there is no error.",
            if count == 1 { " was" } else { "s were" },
            two_digits(study.time_limit)
        )
    })
}

/// How busy the machine was.
fn neighbours(study: &Study) -> Option<String> {
    // Engines, which have neither sweeps nor a Rayleigh step, were run elsewhere.
    let run_here = |point: &&Point| point.sweeps.is_some() || point.rayleigh_fraction.is_some();
    let share = study.points.iter().filter(run_here).filter_map(|point| point.core_share_least).reduce(f64::min)?;
    (share < QUIET).then(|| {
        format!(
            "Other programs were running: a run got as little as {:.0}% of a core. Wall times are those of a core of its own, \
             by processor time; what shared caches and memory cost is not taken out.",
            100.0 * share
        )
    })
}
