//! A study as plain text for a terminal.

use super::findings::power;
use super::study::{Curve, Study};
use crate::draw::numbers::{compact, two_digits};
use crate::study::{Cell, Table};

/// Methods, each with what it took to each tolerance, and the sentences below.
pub fn table(study: &Study) -> String {
    let heads = study.tolerances.iter().flat_map(|&tolerance| [power(tolerance), "ms".into()]);
    let methods = Table::new(&["method"], &["ms an iteration"]).with_numbers(heads).of(&study.methods, cells);
    let problem = &study.problem;
    let mut text = format!(
        "{}: {} grains, {} contacts, step {} ms\n\n{}\n",
        problem.scene,
        problem.particles,
        problem.contacts,
        compact(1e3 * problem.time_step),
        methods.text(),
    );
    text += &format!(
        "Iterations and milliseconds to a root mean square residual of so many {}",
        problem.residual_unit_name
    );
    text += "; - if not reached.\n\n";
    for sentence in &study.findings {
        text += &format!("{sentence}\n");
    }
    text
}

fn cells(curve: &Curve) -> Vec<Cell> {
    let mut cells = vec![curve.method.name().into(), two_digits(1e3 * curve.seconds_per_iteration).into()];
    for reached in &curve.reached {
        cells.push(reached.iterations.map(|iterations| iterations.to_string()).into());
        cells.push(reached.seconds.map(|seconds| two_digits(1e3 * seconds)).into());
    }
    cells
}
