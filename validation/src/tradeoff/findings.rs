//! What a trade-off found that no table says, in sentences: every number is computed from its rows.

use super::rows::{Fastest, Point, Reference};
use super::study::Study;
use super::words::modulus;
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

fn findings(study: &Study) -> Vec<String> {
    let mut sentences: Vec<String> = study.fastest.iter().filter_map(|row| none_within(study, row)).collect();
    sentences.extend(study.references.iter().filter_map(|row| in_doubt(study, row)));
    sentences.extend(extrapolated(study));
    sentences.extend(neighbours(study));
    if study.bounds.is_empty() {
        sentences.push(
            "No observable of this scene has a bound, so there is no fastest setting; give one with --bound.".into(),
        );
    }
    sentences
}

/// Why a code has no fastest setting, or none but the reference itself.
fn none_within(study: &Study, row: &Fastest) -> Option<String> {
    let is_own = |point: &&Point| point.code == row.code && point.stiffness_factor == row.stiffness_factor;
    let mut own = study.points.iter().filter(is_own);
    let (code, stiffness) = (&row.code, modulus(row.youngs_modulus));
    match &row.setting {
        Some(setting) => own
            .any(|point| point.reference && point.setting == *setting)
            .then(|| format!("At {stiffness} no setting of {code} keeps the bounds but the reference itself.")),
        None if own.any(|point| !point.extrapolated) => {
            Some(format!("At {stiffness} no setting of {code} that ran to its end keeps the bounds."))
        }
        None => Some(format!(
            "At {stiffness} every run of {code} was cut short, so there is no error: raise --time-limit for one."
        )),
    }
}

/// A reference that may be farther from its limit than the bound.
fn in_doubt(study: &Study, row: &Reference) -> Option<String> {
    let index = row.convergence.as_ref()?.grid_convergence_index;
    let bound = study.bounds.iter().find(|bound| bound.observable == row.observable)?.value;
    (index > bound).then(|| {
        format!(
            "The reference at {} is itself in doubt: the grid convergence index of its {}, {}, lies above the bound.",
            modulus(row.youngs_modulus),
            observable(&row.observable),
            two_digits(index)
        )
    })
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
    let share = study.points.iter().filter_map(|point| point.core_share_least).reduce(f64::min)?;
    (share < QUIET).then(|| {
        format!(
            "Other programs were running: a run got as little as {:.0}% of a core. Wall times are those of a core of its own, \
             by processor time; what shared caches and memory cost is not taken out.",
            100.0 * share
        )
    })
}
