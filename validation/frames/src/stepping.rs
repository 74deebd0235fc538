//! Stepping loop of a simulation: watchdog, progress reports and early ends.
//!
//! ```text
//! step ─> watchdog ─> frame, if one is due ─> progress ─> interrupted? out of time?
//! ```

use makadam::watch::{Alarm, Watchdog};
use makadam::{Simulation, StepReport};
use std::time::{Duration, Instant};

/// Reason for an end before the last step.
#[derive(Debug)]
pub enum Halt {
    /// Stop request of the user.
    Interrupted,
    /// Invalid state found by the watchdog.
    InvalidState(Alarm),
    /// Exceeded time limit; the fraction of the steps done, 0 to 1.
    OutOfTime(f64),
}

/// Executed step.
pub struct Taken {
    /// Report of the step by the simulation.
    pub report: StepReport,
    /// Wall time of the step, s.
    pub seconds: f64,
    /// Number of the step, from 1.
    pub number: u64,
    /// True if a frame is due after the step; a frame is always due after the last step.
    pub framed: bool,
}

/// Stepping loop of a simulation.
pub struct Stepping<'a> {
    steps: u64,
    interval: Option<f64>,
    watchdog: Option<&'a mut Watchdog>,
    tolerated: fn(&Alarm) -> bool,
    limit: Option<Duration>,
    progress: &'a dyn Fn(f64),
}

impl<'a> Stepping<'a> {
    /// Makes a loop of at most `steps` steps, to the end of the last stage of the scene; `progress` receives the fraction done.
    pub fn new(steps: u64, progress: &'a dyn Fn(f64)) -> Stepping<'a> {
        Stepping { steps, interval: None, watchdog: None, tolerated: |_| false, limit: None, progress }
    }

    /// Requests frames at an interval, s.
    pub fn framed(self, interval: f64) -> Stepping<'a> {
        Stepping { interval: Some(interval), ..self }
    }

    /// Sets a watchdog, which checks the state at each frame.
    pub fn watched(self, watchdog: &'a mut Watchdog) -> Stepping<'a> {
        Stepping { watchdog: Some(watchdog), ..self }
    }

    /// Sets the findings of the watchdog that do not end the run.
    pub fn tolerating(self, tolerated: fn(&Alarm) -> bool) -> Stepping<'a> {
        Stepping { tolerated, ..self }
    }

    /// Sets a wall time after which the run ends.
    pub fn within(self, limit: Duration) -> Stepping<'a> {
        Stepping { limit: Some(limit), ..self }
    }

    /// Executes the steps; `each` receives every step that passes the watchdog. Returns the wall time of the stepping.
    ///
    /// # Errors
    /// [`Halt`] before the last step.
    pub fn carry_out(
        self,
        simulation: &mut Simulation,
        mut each: impl FnMut(&Simulation, &Taken),
    ) -> Result<Duration, Halt> {
        let Stepping { steps, interval, mut watchdog, tolerated, limit, progress } = self;
        let (start, mut wall) = (Instant::now(), Duration::ZERO);
        for number in 1..=steps {
            let clock = Instant::now();
            let report = simulation.step();
            let took = clock.elapsed();
            wall += took;
            let ends = number == steps || simulation.has_ended();
            let framed = ends || interval.is_some_and(|interval| due_after(simulation, number, interval));
            let alarm = watchdog.as_mut().and_then(|watchdog| watchdog.check(simulation, &report, framed).err());
            if let Some(alarm) = alarm.filter(|alarm| !tolerated(alarm)) {
                return Err(Halt::InvalidState(alarm));
            }
            each(simulation, &Taken { report, seconds: took.as_secs_f64(), number, framed });
            if framed {
                simulation.restart_wall_means();
            }
            let share = number as f64 / steps as f64;
            progress(share);
            if crate::interrupt::requested() {
                return Err(Halt::Interrupted);
            }
            if limit.is_some_and(|limit| start.elapsed() > limit) {
                return Err(Halt::OutOfTime(share));
            }
            if ends {
                break;
            }
        }
        Ok(wall)
    }
}

/// Returns the number of whole steps nearest to a duration.
pub fn steps_in(duration: f64, step: f64) -> u64 {
    (duration / step).round() as u64
}

/// Returns true if a frame is due after a step of a run, by its number: at the interval (s) from the start of the run or of its stage, and
/// at the end of a stage.
pub fn due_after(simulation: &Simulation, step: u64, interval: f64) -> bool {
    let stage = simulation.stage();
    let step = stage.map_or(step, |stage| stage.steps);
    stage.is_some_and(|stage| stage.ended) || frame_is_due(step, simulation.time_step(), interval)
}

/// Returns true if a frame is due after a step: the first one at or after each multiple of the interval.
pub fn frame_is_due(step: u64, step_seconds: f64, interval: f64) -> bool {
    // A thousandth of a step absorbs rounding where the interval is a whole number of steps.
    let intervals = |step: u64| ((step as f64 + 1e-3) * step_seconds / interval).floor();
    step > 0 && intervals(step) > intervals(step - 1)
}

#[cfg(test)]
#[path = "../tests/unit/stepping.rs"]
mod tests;
