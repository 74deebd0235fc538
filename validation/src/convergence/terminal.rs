//! A study as plain text for a terminal.

use super::findings::power;
use super::study::{Curve, Study};
use crate::draw::columns;
use crate::draw::numbers::{compact, two_digits};

/// Methods, each with what it took to each tolerance, and the sentences below.
pub fn table(study: &Study) -> String {
    let mut rows = vec![heads(study)];
    rows.extend(study.methods.iter().map(cells));
    let problem = &study.problem;
    let mut text = format!(
        "{}: {} grains, {} contacts, step {} ms\n\n{}\n",
        problem.scene,
        problem.particles,
        problem.contacts,
        compact(1e3 * problem.time_step),
        columns(&rows, |column| column == 0),
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

fn heads(study: &Study) -> Vec<String> {
    let tolerances = study.tolerances.iter().flat_map(|&tolerance| [power(tolerance), "ms".into()]);
    ["method".to_string(), "ms an iteration".to_string()].into_iter().chain(tolerances).collect()
}

fn cells(curve: &Curve) -> Vec<String> {
    let mut cells = vec![curve.method.name().to_string(), two_digits(1e3 * curve.seconds_per_iteration)];
    for reached in &curve.reached {
        cells.push(reached.iterations.map_or("-".into(), |iterations| iterations.to_string()));
        cells.push(reached.seconds.map_or("-".into(), |seconds| two_digits(1e3 * seconds)));
    }
    cells
}
