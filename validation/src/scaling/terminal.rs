//! A study as plain text for a terminal.

use super::findings::time;
use super::page::signed_percent;
use super::study::Study;
use crate::draw::columns;
use crate::draw::numbers::two_digits;

/// Measured configurations, each with what the replay says of it, and the sentences below.
pub fn table(study: &Study) -> String {
    let mut rows = vec![
        [
            "set",
            "scheduler",
            "given",
            "threads",
            "a step",
            "speed-up",
            "sweeps",
            "speed-up",
            "ns",
            "replayed",
            "deviation",
        ]
        .map(String::from),
    ];
    for row in &study.measured {
        let check = study.checks.iter().find(|check| {
            check.instruction_set == row.instruction_set
                && check.scheduler == row.scheduler
                && check.threads == row.threads
                && check.portion == row.portion
        });
        rows.push([
            row.instruction_set.name().into(),
            row.scheduler.name().into(),
            row.portion.name().into(),
            row.threads.to_string(),
            time(row.step_seconds),
            format!("{:.2}", row.speedup),
            time(row.sweep_seconds),
            format!("{:.2}", row.sweep_speedup),
            row.nanoseconds_per_contact_sweep.map_or("-".into(), two_digits),
            check.map_or("-".into(), |check| time(check.replayed_seconds)),
            check.map_or("-".into(), |check| signed_percent(check.deviation_percent)),
        ]);
    }
    let mut text = format!("{}: {} grains, {:.0} contacts\n\n", study.scene, study.particles, study.contacts);
    text += &columns(&rows, |column| column < 3);
    text.push('\n');
    for sentence in &study.findings {
        text += &format!("{sentence}\n");
    }
    text
}
