//! A study as plain text for a terminal.

use super::answer::answer;
use super::page::{checks, measured};
use super::study::Study;

/// The answer, measured configurations, what the replay says of them, and the sentences below.
pub fn table(study: &Study) -> String {
    let mut text = format!(
        "{}: {} grains, {:.0} contacts\n{}\n\n{}\n{}\n",
        study.scene,
        study.particles,
        study.contacts,
        answer(study).text(),
        measured(study).text(),
        checks(study).text()
    );
    // The first is part of the answer.
    for sentence in study.findings.iter().skip(1) {
        text += &format!("{sentence}\n");
    }
    text
}
