//! What a scaling study answers: how many times as fast threads make a step, and whether they change a bit.

use super::findings::{curve_rows, time};
use super::rows::MeasuredRow;
use super::study::Study;
use crate::draw::numbers::two_digits;
use crate::study::Answer;
use makadam::partition::Portion;
use makadam::schedule::Scheduler;

/// The largest measured speed-up of a step with the widest instruction set, what replays of this machine say of more cores, and the bits.
pub(super) fn answer(study: &Study) -> Answer {
    let own = || study.measured.iter().filter(|row| Some(row.instruction_set) == study.widest());
    let parallel = own().filter(|row| row.threads > 1);
    let best = parallel.max_by(|one, other| one.speedup.total_cmp(&other.speedup));
    let bits = study.findings.first().cloned().unwrap_or_default();
    let (word, measured) = match best {
        Some(best) => {
            let serial = own().find(|row| row.scheduler == Scheduler::Serial && row.portion == best.portion);
            let faster = format!("{} times as fast on {} threads.", two_digits(best.speedup), best.threads);
            (if gains(best) { faster } else { format!("Nothing gained: {faster}") }, step(best, serial))
        }
        None => {
            let step = own().next().map_or(String::new(), |row| format!("A step takes {}. ", time(row.step_seconds)));
            ("Measured on one thread alone.".into(), step)
        }
    };
    let class = match (study.same_bits, best) {
        (false, _) => "disagree",
        (true, Some(best)) if gains(best) => "agree",
        (true, _) => "undecided",
    };
    Answer { class, word, sentence: format!("{measured}{}{bits}", with_more_cores(study)) }
}

/// Whether threads make a step faster.
fn gains(row: &MeasuredRow) -> bool {
    row.speedup > 1.0
}

/// A step of a row and of the serial one.
fn step(best: &MeasuredRow, serial: Option<&MeasuredRow>) -> String {
    let instead = serial.map_or(String::new(), |serial| format!(" instead of {}", time(serial.step_seconds)));
    format!(
        "A step takes {}{instead} ({}, {}); its sweeps are {} times as fast. ",
        time(best.step_seconds),
        best.scheduler.name().replace('-', " "),
        best.instruction_set.name(),
        two_digits(best.sweep_speedup),
    )
}

/// Where the replay of work stealing on this machine with more cores comes near its end.
fn with_more_cores(study: &Study) -> String {
    let Some(here) = study.machines.first() else { return String::new() };
    let rows: Vec<_> = curve_rows(study, here, Scheduler::WorkStealing, Portion::Batches).collect();
    let most = rows.iter().map(|row| row.speedup).fold(0.0, f64::max);
    let near = rows.iter().find(|row| row.workers > study.cores && row.speedup >= 0.95 * most);
    near.map_or(String::new(), |row| {
        format!(
            "Replayed on more cores like these it would be {} times as fast with {} threads, and hardly faster with more. ",
            two_digits(row.speedup),
            row.workers
        )
    })
}
