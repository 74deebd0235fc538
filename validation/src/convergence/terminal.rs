//! A study as plain text for a terminal.

use super::answer::answer;
use super::page::methods;
use super::study::Study;
use crate::draw::numbers::compact;

/// The answer, methods, each with what it took to each tolerance, and the sentences below.
pub fn table(study: &Study) -> String {
    let problem = &study.problem;
    let mut text = format!(
        "{}: {} grains, {} contacts, step {} ms\n{}\n\n{}\nIterations and milliseconds to a root mean square residual of so many \
         {}; - if not reached.\n\n",
        problem.scene,
        problem.particles,
        problem.contacts,
        compact(1e3 * problem.time_step),
        answer(study).text(),
        methods(study).text(),
        problem.residual_unit_name
    );
    for sentence in &study.findings {
        text += &format!("{sentence}\n");
    }
    text
}
