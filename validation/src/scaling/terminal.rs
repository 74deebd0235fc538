//! A study as plain text for a terminal.

use super::page::{checks, measured};
use super::study::Study;

/// Measured configurations, what the replay says of them, and the sentences below.
pub fn table(study: &Study) -> String {
    let mut text = format!(
        "{}: {} grains, {:.0} contacts\n\n{}\n{}\n",
        study.scene,
        study.particles,
        study.contacts,
        measured(study).text(),
        checks(study).text()
    );
    for sentence in &study.findings {
        text += &format!("{sentence}\n");
    }
    text
}
