//! Replays of the traces on a machine, and how far they are from what was measured there.

use super::machine::{MOST_WORKERS, Machine, worker_counts};
use super::measure::{Measurement, Plan, Traces};
use super::replay::{Replayed, Traffic, replay};
use super::rows::{Check, ReplayedRow};
use super::tasks::mean;
use crate::statistics::median;
use makadam::schedule::{Phase, Region, Scheduler};
use rayon::prelude::*;

/// Replays the traces of some instruction sets on a machine, by scheduler and number of workers.
pub(super) fn curves(
    machine: &Machine,
    traces: &[&Traces],
    measurement: &Measurement,
    threads: &[usize],
) -> Vec<ReplayedRow> {
    let mut jobs = Vec::new();
    for &traces in traces {
        jobs.push((traces, Scheduler::Serial, 1));
        for scheduler in [Scheduler::CentralQueue, Scheduler::WorkStealing] {
            let counts = worker_counts(machine.most_workers(), threads);
            jobs.extend(counts.into_iter().map(|workers| (traces, scheduler, workers)));
        }
    }
    let replays: Vec<Replayed> = jobs
        .par_iter()
        .map(|&(traces, scheduler, workers)| {
            let traffic = traffic(machine, traces, measurement, workers);
            mean_replay(traces, scheduler, machine, traffic, workers)
        })
        .collect();
    let rows = jobs.iter().zip(&replays).map(|(&(traces, scheduler, workers), own)| {
        let is_serial = |job: &&(&Traces, Scheduler, usize)| {
            job.1 == Scheduler::Serial && job.0.configuration.is_serial_of(&traces.configuration)
        };
        let serial = jobs.iter().zip(&replays).find(|(job, _)| is_serial(job)).map_or(own, |(_, serial)| serial);
        ReplayedRow {
            source: "replayed".into(),
            machine: machine.name.clone(),
            instruction_set: traces.configuration.instruction_set,
            scheduler,
            workers,
            portion: traces.configuration.portion,
            step_seconds: own.seconds,
            sweep_seconds: own.sweep_seconds,
            speedup: serial.seconds / own.seconds,
            sweep_speedup: serial.sweep_seconds / own.sweep_seconds,
            waiting_share: own.waiting / (own.seconds * workers as f64),
        }
    });
    rows.collect()
}

/// Mean over the traced steps.
fn mean_replay(
    traces: &Traces,
    scheduler: Scheduler,
    machine: &Machine,
    traffic: Option<Traffic>,
    workers: usize,
) -> Replayed {
    let mut sum = Replayed::default();
    for step in &traces.steps {
        let own = replay(&step.regions, scheduler, machine, traffic, workers);
        sum.seconds += own.seconds;
        sum.sweep_seconds += own.sweep_seconds;
        sum.waiting += own.waiting;
    }
    let steps = traces.steps.len().max(1) as f64;
    Replayed { seconds: sum.seconds / steps, sweep_seconds: sum.sweep_seconds / steps, waiting: sum.waiting / steps }
}

/// The traffic of a running sweep: its bytes over its traced time. None where all that a sweep touches fits into the last-level cache:
/// then the next sweep finds it there.
fn traffic(machine: &Machine, traces: &Traces, measurement: &Measurement, workers: usize) -> Option<Traffic> {
    let ceiling = machine.ceiling(workers);
    if measurement.sweep_bytes.touched as u64 <= machine.cache_bytes {
        return None;
    }
    let sweeping = |region: &&Region| region.phase == Phase::Sweep;
    let regions = traces.steps.iter().flat_map(|step| &step.regions).filter(sweeping);
    let seconds: f64 = regions.map(|region| region.tasks.iter().sum::<f64>()).sum();
    let sweeps: u32 = traces.sweeps.iter().sum();
    let bytes = f64::from(sweeps) * measurement.sweep_bytes.moved as f64;
    (seconds > 0.0).then(|| Traffic { bytes_per_second: bytes / (seconds * machine.duration_factor), ceiling })
}

/// The replay on this machine beside what was measured, over the same steps: from the serial trace, and from the trace of the
/// configuration itself, whose tasks already contain what threads do to each other's caches and memory.
pub(super) fn checks(plan: &Plan, measurement: &Measurement, here: &Machine, replayed: &[ReplayedRow]) -> Vec<Check> {
    let traced = plan.traced_steps as usize;
    let checks = measurement.timings.iter().zip(&measurement.traces).filter_map(|(timing, traces)| {
        let own = timing.configuration;
        let row = replayed.iter().find(|row| {
            row.machine == here.name
                && row.instruction_set == own.instruction_set
                && row.scheduler == own.scheduler
                && row.workers == own.threads
                && row.portion == own.portion
        })?;
        let of_step =
            |step: usize| median(timing.repetitions.iter().filter_map(|times| times.steps.get(step)).copied());
        let measured_seconds = mean(&(0..traced).map(of_step).collect::<Vec<_>>());
        let deviation = |replayed: f64| 100.0 * (replayed / measured_seconds - 1.0);
        let from_own_tasks = mean_replay(traces, own.scheduler, here, None, own.threads).seconds;
        Some(Check {
            instruction_set: own.instruction_set,
            scheduler: own.scheduler,
            threads: own.threads,
            portion: own.portion,
            measured_seconds,
            replayed_seconds: row.step_seconds,
            deviation_percent: deviation(row.step_seconds),
            task_time_ratio: traces.task_time_ratio,
            replayed_from_own_tasks_seconds: from_own_tasks,
            own_tasks_deviation_percent: deviation(from_own_tasks),
        })
    });
    checks.filter(|check| check.threads <= MOST_WORKERS).collect()
}

#[cfg(test)]
mod tests {
    use super::super::costs::Costs;
    use super::*;
    use crate::execution::Execution;
    use makadam::schedule::StepTrace;
    use makadam::sweep::SweepBytes;

    /// Ten sweeps of 0.1 s that move 3 GB each.
    fn traced(touched: usize) -> (Traces, Measurement) {
        let region = Region { phase: Phase::Sweep, tasks: vec![0.05; 2] };
        let steps = vec![StepTrace { regions: vec![region; 10] }];
        let traces = Traces { configuration: Execution::serial(), steps, sweeps: vec![10], task_time_ratio: 1.0 };
        let measurement = Measurement {
            particles: 1,
            contacts: 1.0,
            contact_sweeps: 10.0,
            simulation_bytes: 10 * touched,
            sweep_bytes: SweepBytes { touched, moved: 3_000_000_000 },
            timings: Vec::new(),
            traces: Vec::new(),
            traces_same_bits: true,
        };
        (traces, measurement)
    }

    #[test]
    fn memory_holds_up_what_a_cache_does_not_hold() {
        let machine = Machine::here(Costs::default(), (10e9, 2), 32 << 20);
        let (traces, fits) = traced(32 << 20);
        assert_eq!(traffic(&machine, &traces, &fits, 2), None, "though the whole simulation is ten times as large");
        let (traces, exceeds) = traced((32 << 20) + 1);
        let traffic = traffic(&machine, &traces, &exceeds, 2).unwrap();
        assert!((traffic.bytes_per_second / 30e9 - 1.0).abs() < 1e-12 && traffic.ceiling == 10e9, "{traffic:?}");
        // Two workers ask for six times what the memory delivers.
        let [free, held] = [&fits, &exceeds].map(|measurement| {
            let rows = curves(&machine, &[&traces], measurement, &[]);
            let two = rows.iter().find(|row| row.scheduler == Scheduler::WorkStealing && row.workers == 2);
            two.unwrap().sweep_seconds
        });
        assert!((held / free - 6.0).abs() < 1e-9, "{held} and {free}");
    }
}
