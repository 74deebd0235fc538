//! What a study says, in sentences.

use super::figures::title;
use super::study::{Curve, Reached, Study};
use crate::draw::numbers::{compact, two_digits};

impl Study {
    /// The same study, which says what was found.
    pub fn with_findings(mut self) -> Study {
        self.findings = findings(&self);
        self
    }
}

/// Which method reaches each tolerance first, and which never arrive.
fn findings(study: &Study) -> Vec<String> {
    let mut sentences = Vec::new();
    let unit = &study.problem.residual_unit_name;
    for (place, &tolerance) in study.tolerances.iter().enumerate() {
        let reached = |curve: &Curve| curve.reached.get(place).and_then(when);
        let mut arrived: Vec<(&Curve, (u32, f64))> =
            study.methods.iter().filter_map(|curve| Some((curve, reached(curve)?))).collect();
        arrived.sort_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let tolerance = power(tolerance);
        let Some((first, (iterations, seconds))) = arrived.first() else {
            sentences.push(format!("No method reaches {tolerance} {unit} in {} iterations.", study.iterations));
            // None reaches a lower one.
            break;
        };
        if *iterations == 0 {
            sentences.push(format!("The state that the solve starts from is below {tolerance} {unit} already."));
            continue;
        }
        let mut sentence =
            format!("To {tolerance} {unit} {} is the first, {}", title(first.method), cost(*iterations, *seconds));
        if let Some((next, (iterations, seconds))) = arrived.get(1) {
            sentence += &format!(", {} the next, {}", title(next.method), cost(*iterations, *seconds));
        }
        sentences.push(sentence + ".");
    }
    let not_run = study.left_out.iter();
    sentences.extend(not_run.map(|one| format!("Not run: {}.", one.reason)));
    sentences
}

fn when(reached: &Reached) -> Option<(u32, f64)> {
    Some((reached.iterations?, reached.seconds?))
}

fn cost(iterations: u32, seconds: f64) -> String {
    let plural = if iterations == 1 { "" } else { "s" };
    format!("with {iterations} iteration{plural} in {} ms", two_digits(1e3 * seconds))
}

/// A tolerance, such as 0.01 or 10⁻⁶.
pub(super) fn power(tolerance: f64) -> String {
    compact(tolerance).trim_start_matches("1×").into()
}
