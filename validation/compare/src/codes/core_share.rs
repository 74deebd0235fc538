//! Fraction of a core that a run got: on a busy machine wall time depends on other processes.
//!
//! The time of a run is the processor time of its stepping on one core, for every code: the wall time of the stepping, without set-up and
//! output, times the share of a core that the run got.

use std::time::{Duration, Instant};

/// Clock ticks a second in the files of `/proc`: Linux shows 100 on every machine, whatever it counts in.
const TICKS: f64 = 100.0;

/// Watches the calling thread and the child processes that it waits for.
pub struct CoreClock {
    started: Instant,
    processor: Option<f64>,
}

impl CoreClock {
    /// Starts watching.
    pub fn start() -> CoreClock {
        CoreClock { started: Instant::now(), processor: processor_seconds() }
    }

    /// Processor time over elapsed time since the start, at most 1; absent where the system does not tell.
    pub fn share(&self) -> Option<f64> {
        let processor = processor_seconds()? - self.processor?;
        share(processor, self.started.elapsed())
    }
}

/// Processor time that a stepping takes of this thread, from its start on.
pub(super) struct ThreadClock {
    started: Instant,
    processor: f64,
}

impl ThreadClock {
    /// Starts watching.
    pub(super) fn start() -> ThreadClock {
        ThreadClock { started: Instant::now(), processor: own_seconds() }
    }

    /// Processor time of a part of what the thread has done since the start, s: its wall time times the share of a core; absent where no
    /// time has passed.
    pub(super) fn core_seconds(&self, wall: Duration) -> Option<f64> {
        Some(wall.as_secs_f64() * share(own_seconds() - self.processor, self.started.elapsed())?)
    }
}

/// Wall time below which ticks are too coarse to tell a share.
const SHORTEST: Duration = Duration::from_millis(300);

/// Share of a core that a process has got since its start, 0 to 1; absent in its first moments and where the system does not tell.
pub(super) fn share_of(process: u32, started: Instant) -> Option<f64> {
    let elapsed = started.elapsed();
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let processor = seconds_in(&text, OWN)?;
    (elapsed >= SHORTEST).then(|| share(processor, elapsed)).flatten()
}

fn share(processor: f64, elapsed: Duration) -> Option<f64> {
    let elapsed = elapsed.as_secs_f64();
    (elapsed > 0.0).then(|| (processor / elapsed).clamp(0.0, 1.0))
}

/// Processor time of this thread and of the children that it has waited for, s.
fn processor_seconds() -> Option<f64> {
    Some(own_seconds() + children_seconds()?)
}

/// Processor time of this thread, s.
fn own_seconds() -> f64 {
    // The files of /proc show a running thread as it was at its last tick, which is long for a run of milliseconds.
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Processor time of children that have ended, s.
fn children_seconds() -> Option<f64> {
    seconds_in(&std::fs::read_to_string("/proc/self/stat").ok()?, CHILDREN)
}

/// Places of user time in a line of `stat` behind the program's name; system time is the next one.
const OWN: usize = 11;
const CHILDREN: usize = 13;

/// User and system time in a line of `stat`, s.
fn seconds_in(line: &str, place: usize) -> Option<f64> {
    // The program's name, in brackets, may hold blanks.
    let fields: Vec<&str> = line.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |field: usize| fields.get(field)?.parse::<f64>().ok();
    Some((ticks(place)? + ticks(place + 1)?) / TICKS)
}

#[cfg(test)]
#[path = "../../tests/unit/codes_core_share.rs"]
mod tests;
