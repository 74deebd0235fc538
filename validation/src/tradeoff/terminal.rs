//! A trade-off as plain text for a terminal.

use super::page::{fastest, points, variations};
use super::study::Study;

/// Observables that a terminal has room for, bounded ones first.
const SHOWN: usize = 2;

/// Points, the fastest of them, and the sentences below.
pub fn table(study: &Study) -> String {
    let mut text = format!(
        "{}: {} grains, {} seeds\n\n{}\n* on the Pareto front of its code; ~ extrapolated; errors ± standard error over seeds\n\n",
        study.scene,
        study.particles,
        study.seeds,
        points(study, SHOWN).text()
    );
    for table in [fastest(study), variations(study)].into_iter().flatten() {
        text += &format!("{}\n", table.text());
    }
    for sentence in study.findings.iter().chain(&study.notes) {
        text += &format!("{sentence}\n");
    }
    text
}
