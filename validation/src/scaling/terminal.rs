//! A study as plain text for a terminal.

use super::findings::time;
use super::page::signed_percent;
use super::study::Study;
use crate::draw::numbers::two_digits;
use crate::study::Table;

/// Measured configurations, each with what the replay says of it, and the sentences below.
pub fn table(study: &Study) -> String {
    let numbers = ["threads", "a step", "speed-up", "sweeps", "speed-up", "ns", "replayed", "deviation"];
    let mut configurations = Table::new(&["set", "scheduler", "given"], &numbers);
    for row in &study.measured {
        let check = study.checks.iter().find(|check| {
            check.instruction_set == row.instruction_set
                && check.scheduler == row.scheduler
                && check.threads == row.threads
                && check.portion == row.portion
        });
        configurations.row([
            row.instruction_set.name().into(),
            row.scheduler.name().into(),
            row.portion.name().into(),
            row.threads.into(),
            time(row.step_seconds).into(),
            format!("{:.2}", row.speedup).into(),
            time(row.sweep_seconds).into(),
            format!("{:.2}", row.sweep_speedup).into(),
            row.nanoseconds_per_contact_sweep.map(two_digits).into(),
            check.map(|check| time(check.replayed_seconds)).into(),
            check.map(|check| signed_percent(check.deviation_percent)).into(),
        ]);
    }
    let mut text = format!("{}: {} grains, {:.0} contacts\n\n", study.scene, study.particles, study.contacts);
    text += &configurations.text();
    text.push('\n');
    for sentence in &study.findings {
        text += &format!("{sentence}\n");
    }
    text
}
