//! Steps without the interpreter's lock, interruptible by a signal or another thread.

use crate::crowd::crowd;
use crate::errors::{exception, warn};
use crate::shared::Shared;
use makadam::StopReason;
use makadam::scene::Reaction;
use makadam::watch::{Alarm, Trouble};
use makadam_frames::interrupt;
use pyo3::prelude::*;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Wall time of steps between two checks for signals.
const SLICE: Duration = Duration::from_millis(20);

/// Interval of polls for signals during a long step.
const LOOK: Duration = Duration::from_millis(50);

/// Result of a slice of steps.
struct Slice {
    /// Steps taken.
    taken: u64,
    /// Violations found by the watchdogs.
    alarms: Vec<Alarm>,
    /// True if a stop was requested.
    stopped: bool,
}

/// Takes the given number of steps; returns the warnings of the watchdog.
pub fn steps(py: Python<'_>, shared: &Shared, mut left: u64) -> PyResult<Vec<String>> {
    let _right = shared.begin(py)?;
    let mut warnings = Vec::new();
    let (not_finite, crowded, long) = shared.with(py, |simulation| {
        let written = shared.may_be_written();
        // After a refusal, the next call checks the writes again.
        shared.taken_to_write.store(written, Ordering::SeqCst);
        let not_finite = written.then(|| simulation.not_finite()).flatten();
        let crowded = written.then(|| crowd(simulation.arrays().0)).flatten();
        (not_finite, crowded, simulation.polls_interrupt())
    })?;
    if let Some(grain) = not_finite {
        let what = format!(
            "grain {grain} has a position, velocity or spin that is not finite; write finite numbers to the views"
        );
        return Err(exception(py, "InterventionError", &what));
    }
    if let Some(count) = crowded {
        let what = format!(
            "{count} grains lie in one place, within a diameter: each touches each other, and a step takes time and memory for every \
             pair of them"
        );
        warn(py, &what)?;
    }
    while left > 0 {
        // The thread that has started Python handles signals, and the step does not poll for them.
        let slice = match long {
            true => py.detach(|| watched_from_beside(shared, left))?,
            false => py.detach(|| slice(shared, left)),
        };
        left -= slice.taken;
        for alarm in slice.alarms {
            match alarm.reaction {
                Reaction::Stop => {
                    let class = match alarm.trouble {
                        Trouble::Overdue { .. } => "StageError",
                        _ => "InvalidStateError",
                    };
                    return Err(exception(py, class, &alarm.to_string()));
                }
                _ => warnings.push(alarm.to_string()),
            }
        }
        py.check_signals()?;
        if slice.stopped {
            return Err(exception(py, "Interrupted", "interrupted; the state is that after the last whole step"));
        }
        py.detach(|| shared.let_in());
    }
    Ok(warnings)
}

/// Runs the watchdog check on the state after the last step; returns its warnings.
pub fn look(py: Python<'_>, shared: &Shared) -> PyResult<Vec<String>> {
    let alarms = shared.with(py, |simulation| {
        let mut watchdog = shared.watchdog.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        watchdog.as_mut().map_or_else(Vec::new, |watchdog| watchdog.look(simulation))
    })?;
    match alarms.iter().find(|alarm| alarm.reaction == Reaction::Stop) {
        Some(alarm) => Err(exception(py, "InvalidStateError", &alarm.to_string())),
        None => Ok(alarms.iter().map(ToString::to_string).collect()),
    }
}

/// Takes steps until the slice is over.
fn slice(shared: &Shared, most: u64) -> Slice {
    let begun = Instant::now();
    let mut slice = Slice { taken: 0, alarms: Vec::new(), stopped: false };
    let mut simulation = shared.lock_detached();
    // Views may have been created since the last slice.
    shared.release_pairs(&mut simulation);
    if shared.may_be_written() {
        simulation.states_written();
    }
    let mut watchdog = shared.watchdog.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    while slice.taken < most {
        if shared.interrupt.is_requested() {
            slice.stopped = true;
            break;
        }
        let report = simulation.step();
        if report.solve.reason == StopReason::Interrupted {
            slice.stopped = true;
            break;
        }
        slice.taken += 1;
        if let Some(watchdog) = watchdog.as_mut() {
            slice.alarms.extend(watchdog.observe(&simulation, &report));
        }
        if slice.alarms.iter().any(|alarm| alarm.reaction == Reaction::Stop)
            || begun.elapsed() > SLICE
            || shared.is_awaited()
        {
            break;
        }
    }
    slice
}

/// Takes steps on another thread, while this one polls for signals.
fn watched_from_beside(shared: &Shared, most: u64) -> PyResult<Slice> {
    std::thread::scope(|scope| {
        let (done, wait) = channel();
        scope.spawn(move || done.send(slice(shared, most)));
        let mut signal = Ok(());
        loop {
            match wait.recv_timeout(LOOK) {
                Ok(slice) => return signal.map(|()| slice),
                Err(RecvTimeoutError::Timeout) => {
                    if signal.is_ok() {
                        signal = Python::attach(|py| py.check_signals());
                        if signal.is_err() {
                            shared.interrupt.request();
                        }
                    }
                }
                Err(RecvTimeoutError::Disconnected) => panic!("the thread that takes the steps has ended in a panic"),
            }
        }
    })
}

/// Refuses an invalid number of steps.
pub fn count(py: Python<'_>, steps: i64) -> PyResult<u64> {
    u64::try_from(steps)
        .map_err(|_| exception(py, "SettingError", &format!("cannot take {steps} steps; give 0 or more")))
}

/// Runs a long function on another thread, and requests a stop after a signal.
pub fn beside<R: Send>(py: Python<'_>, work: impl FnOnce() -> R + Send) -> PyResult<R> {
    py.detach(|| {
        std::thread::scope(|scope| {
            let worker = scope.spawn(work);
            let mut signal = Ok(());
            while !worker.is_finished() {
                std::thread::sleep(Duration::from_millis(5));
                if signal.is_ok() {
                    signal = Python::attach(|py| py.check_signals());
                    if signal.is_err() {
                        interrupt::handle().request();
                    }
                }
            }
            let result = worker.join();
            if signal.is_err() {
                interrupt::handle().clear();
            }
            signal?;
            match result {
                Ok(result) => Ok(result),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    })
}
