//! Measurement of one state over the same steps: every scheduler, number of threads and instruction set, in turn and several times
//! over, so that other load on the machine affects all of them alike. Scheduling costs, memory bandwidth and clock are measured apart
//! from the solver, so that a replay predicts a measurement and is not fitted to it.

use super::replay::Costs;
use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::{CentralQueue, Region, Scheduler, StepTrace};
use makadam::sweep::SweepBytes;
use makadam_frames::execution::{Execution, MeasureError};
use makadam_frames::stepping::{Stepping, Taken};
use makadam_measure::statistics::median;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;
use std::hint::{black_box, spin_loop};
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Steps before the timed ones: they fill caches and buffers.
pub(super) const WARM_UP: u64 = 3;

/// Configurations, steps and repetitions of a measurement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Instruction sets, narrowest first.
    pub instruction_sets: Vec<InstructionSet>,
    /// Numbers of threads of the parallel schedulers.
    pub threads: Vec<usize>,
    /// Timed steps.
    pub steps: u64,
    /// Number of these steps, from the first, that are traced and replayed.
    pub traced_steps: u64,
    /// Repetitions of all measurements.
    pub repetitions: usize,
}

/// Wall time of each step of one repetition, s.
#[derive(Clone, Debug, Default)]
pub struct Times {
    /// Whole steps.
    pub steps: Vec<f64>,
    /// Their sweeps.
    pub sweeps: Vec<f64>,
}

/// Timed steps of one configuration.
#[derive(Clone, Debug)]
pub struct Timing {
    /// The configuration.
    pub configuration: Execution,
    /// Times of each repetition.
    pub repetitions: Vec<Times>,
    /// Hash of the final state of each repetition.
    pub hashes: Vec<u64>,
}

/// Traced steps of one serial configuration, medians over the repetitions.
pub struct Traces {
    /// The configuration.
    pub configuration: Execution,
    /// The steps.
    pub steps: Vec<StepTrace>,
    /// Sweeps of each step.
    pub sweeps: Vec<u32>,
}

/// Result of a measurement.
pub struct Measurement {
    /// Number of grains.
    pub particles: usize,
    /// Contacts per step, mean over the timed steps.
    pub contacts: f64,
    /// Contact sweeps per step, mean over the timed steps.
    pub contact_sweeps: f64,
    /// Memory of the simulation, bytes.
    pub simulation_bytes: usize,
    /// Bytes of a sweep over all contacts.
    pub sweep_bytes: SweepBytes,
    /// Timed runs; the serial one first for each instruction set and portion.
    pub timings: Vec<Timing>,
    /// Traces of the serial configurations, in the order of `timings`.
    pub traces: Vec<Traces>,
    /// True if traced and untraced steps gave the same bits.
    pub traces_same_bits: bool,
}

impl Plan {
    /// Lists all configurations: for each instruction set serial first, then the parallel schedulers by number of threads; at the
    /// end the widest set again, box by box.
    pub fn configurations(&self) -> Vec<Execution> {
        let batches = self.instruction_sets.iter().map(|&set| (set, Portion::Batches));
        let boxes = self.instruction_sets.last().map(|&set| (set, Portion::Boxes));
        let mut all = Vec::new();
        for (instruction_set, portion) in batches.chain(boxes) {
            let serial = Execution { instruction_set, portion, ..Execution::serial() };
            all.push(serial);
            for scheduler in [Scheduler::CentralQueue, Scheduler::WorkStealing] {
                all.extend(self.threads.iter().map(|&threads| Execution { scheduler, threads, ..serial }));
            }
        }
        all
    }

    /// Measures from a state; `progress` receives the completed fraction.
    pub fn measure(&self, start: &Simulation, progress: &dyn Fn(f64)) -> Result<Measurement, MeasureError> {
        let mut timings: Vec<Timing> = (self.configurations().into_iter())
            .map(|configuration| Timing { configuration, repetitions: Vec::new(), hashes: Vec::new() })
            .collect();
        let jobs = timings.len();
        let mut traced: Vec<Vec<TracedRun>> = timings.iter().map(|_| Vec::new()).collect();
        let (mut last, mut hash_when_traced) = (None, None);
        for repetition in 0..self.repetitions {
            for place in 0..jobs {
                // Each round begins with another configuration, so that none always follows the same one.
                let job = (place + repetition) % jobs;
                let timing = &mut timings[job];
                let run = self.timed(start, timing.configuration)?;
                hash_when_traced.get_or_insert(run.hash_when_traced);
                timing.hashes.push(run.hash);
                timing.repetitions.push(run.times.clone());
                if timing.configuration.scheduler == Scheduler::Serial {
                    traced[job].push(self.traced(start, timing.configuration)?);
                }
                last = Some(run);
                progress((repetition * jobs + place + 1) as f64 / (self.repetitions * jobs) as f64);
            }
        }
        let traces_same_bits = traced.iter().flatten().all(|run| Some(run.hash) == hash_when_traced);
        let clock = clock_seconds();
        let traces = timings.iter().zip(&traced).filter_map(|(timing, runs)| {
            let sweeps = runs.first()?.sweeps.clone();
            Some(Traces { configuration: timing.configuration, steps: medians(runs, clock), sweeps })
        });
        let traces = traces.collect();
        // Contacts and bytes are those of any run: all have the same bits.
        let last = last.as_ref();
        let per_step = |count: fn(&TimedRun) -> u64| last.map_or(0.0, |run| count(run) as f64 / self.steps as f64);
        Ok(Measurement {
            particles: start.snapshot().particles.len(),
            contacts: per_step(|run| run.contacts),
            contact_sweeps: per_step(|run| run.contact_sweeps),
            simulation_bytes: last.map_or(0, |run| run.simulation_bytes),
            sweep_bytes: last.map_or_else(SweepBytes::default, |run| run.sweep_bytes),
            timings,
            traces,
            traces_same_bits,
        })
    }

    fn timed(&self, start: &Simulation, configuration: Execution) -> Result<TimedRun, MeasureError> {
        let mut simulation = warmed_up(start, configuration)?;
        let (mut times, mut contacts) = (Times::default(), 0);
        let before = simulation.contact_sweeps();
        let mut hash_when_traced = simulation.state_hash();
        let mut swept = simulation.phase_seconds().sweep;
        let each = |simulation: &Simulation, taken: &Taken| {
            let sweeps = simulation.phase_seconds().sweep;
            times.steps.push(taken.seconds);
            times.sweeps.push(sweeps - swept);
            swept = sweeps;
            contacts += taken.report.contacts as u64;
            if taken.number == self.traced_steps {
                hash_when_traced = simulation.state_hash();
            }
        };
        // Without a watchdog only an interruption ends the run early.
        Stepping::new(self.steps, &|_| {}).carry_out(&mut simulation, each).map_err(|_| MeasureError::Interrupted)?;
        Ok(TimedRun {
            times,
            contacts,
            contact_sweeps: simulation.contact_sweeps() - before,
            simulation_bytes: simulation.memory_bytes(),
            sweep_bytes: simulation.sweep_bytes(),
            hash_when_traced,
            hash: simulation.state_hash(),
        })
    }

    fn traced(&self, start: &Simulation, configuration: Execution) -> Result<TracedRun, MeasureError> {
        let mut simulation = warmed_up(start, configuration)?;
        let (mut steps, mut sweeps) = (Vec::new(), Vec::new());
        for _ in 0..self.traced_steps {
            let (report, trace) = simulation.trace_step();
            steps.push(trace);
            sweeps.push(report.solve.sweeps);
            if makadam_frames::interrupt::requested() {
                return Err(MeasureError::Interrupted);
            }
        }
        Ok(TracedRun { steps, sweeps, hash: simulation.state_hash() })
    }
}

struct TimedRun {
    times: Times,
    contacts: u64,
    contact_sweeps: u64,
    simulation_bytes: usize,
    sweep_bytes: SweepBytes,
    hash_when_traced: u64,
    hash: u64,
}

struct TracedRun {
    steps: Vec<StepTrace>,
    sweeps: Vec<u32>,
    hash: u64,
}

fn warmed_up(start: &Simulation, configuration: Execution) -> Result<Simulation, MeasureError> {
    let mut simulation = start.clone();
    configuration.apply(&mut simulation)?;
    (0..WARM_UP).for_each(|_| {
        simulation.step();
    });
    Ok(simulation)
}

/// Time that reading the clock adds to the traced duration of a task, s.
fn clock_seconds() -> f64 {
    median((0..1001).map(|_| Instant::now().elapsed().as_secs_f64()))
}

/// Traced steps with the median of their total over the repetitions, distributed over their tasks as the medians of the durations are.
/// Reading the clock is subtracted.
///
/// Other load lengthens a few tasks of every repetition, and different ones each time. Medians of single tasks exclude it, but a measured
/// step contains it, so the totals must as well.
fn medians(runs: &[TracedRun], clock: f64) -> Vec<StepTrace> {
    let total_of = |step: &StepTrace, clock: f64| -> f64 {
        step.regions.iter().flat_map(|region| &region.tasks).map(|task| (task - clock).max(0.0)).sum()
    };
    let median_of = |step: usize, region: usize, task: usize| {
        let durations = runs.iter().filter_map(|run| run.steps.get(step)?.regions.get(region)?.tasks.get(task));
        (median(durations.copied()) - clock).max(0.0)
    };
    let first = runs.first().map_or(&[][..], |run| &run.steps);
    let steps = first.iter().enumerate().map(|(step, trace)| {
        let regions = trace.regions.iter().enumerate().map(|(place, region)| Region {
            phase: region.phase,
            tasks: (0..region.tasks.len()).map(|task| median_of(step, place, task)).collect(),
        });
        let mut typical = StepTrace { regions: regions.collect() };
        let total = median(runs.iter().filter_map(|run| run.steps.get(step)).map(|run| total_of(run, clock)));
        let factor = total / total_of(&typical, 0.0);
        if factor.is_finite() {
            typical.regions.iter_mut().flat_map(|region| &mut region.tasks).for_each(|task| *task *= factor);
        }
        typical
    });
    steps.collect()
}

/// Memory bandwidth, bytes/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bandwidth {
    /// To one thread.
    pub one_thread: f64,
    /// To a thread on each core.
    pub all_threads: f64,
    /// Number of cores.
    pub threads: usize,
}

/// Triads per measurement; the fastest counts.
const TRIADS: usize = 12;
/// Doubles in each of three arrays; beyond the last-level cache of most machines.
const TRIAD_LENGTH: usize = 16 << 20;

impl Bandwidth {
    /// Measures with a triad, a = b + s c, counted as three arrays (the fetch of the overwritten array is not counted).
    pub fn measure(threads: usize) -> Result<Bandwidth, MeasureError> {
        let (b, c) = (vec![1.0; TRIAD_LENGTH], vec![2.0; TRIAD_LENGTH]);
        let mut a = vec![0.0; TRIAD_LENGTH];
        let mut best = |threads: usize| -> Result<f64, MeasureError> {
            let (pool, piece) = (pool(threads)?, TRIAD_LENGTH / threads);
            let mut shortest = f64::INFINITY;
            for _ in 0..TRIADS {
                std::thread::sleep(PAUSE);
                let parts = a.par_chunks_mut(piece).zip(b.par_chunks(piece)).zip(c.par_chunks(piece));
                let triad = |((a, b), c): ((&mut [f64], &[f64]), &[f64])| {
                    a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 3.0 * c);
                };
                shortest = shortest.min(seconds_of(|| pool.install(|| parts.for_each(triad))));
            }
            black_box(&a);
            Ok((3 * TRIAD_LENGTH * size_of::<f64>()) as f64 / shortest)
        };
        let one_thread = best(1)?;
        let all_threads = if threads > 1 { best(threads)? } else { one_thread };
        Ok(Bandwidth { one_thread, all_threads, threads })
    }
}

/// Size of the last-level cache, bytes; 0 if the system does not report it.
pub(super) fn cache_bytes() -> u64 {
    let size = |index: usize| {
        let text = std::fs::read_to_string(format!("/sys/devices/system/cpu/cpu0/cache/index{index}/size")).ok()?;
        let (number, shift) = match text.trim().strip_suffix('K') {
            Some(number) => (number, 10),
            None => (text.trim().strip_suffix('M')?, 20),
        };
        Some(number.parse::<u64>().ok()? << shift)
    };
    (0..8).filter_map(size).max().unwrap_or(0)
}

/// Multiplications of one trial of the clock, and cycles of each in a dependent chain: those of 64-bit integers on Intel's processors
/// since Nehalem and on AMD's since Zen (A. Fog, *Instruction tables*).
const MULTIPLICATIONS: u32 = 100_000;
const MULTIPLICATION_CYCLES: f64 = 3.0;

/// Clock of the cores, Hz, from a chain of multiplications. Many virtual machines report the clock of their time stamps instead.
pub(super) fn clock() -> f64 {
    let chain = || {
        let mut number = black_box(3_u64);
        (0..MULTIPLICATIONS).for_each(|_| number = number.wrapping_mul(number));
        black_box(number);
    };
    f64::from(MULTIPLICATIONS) * MULTIPLICATION_CYCLES / fastest(|| Some(seconds_of(chain))).unwrap_or(f64::NAN)
}

/// Batches of a cost measurement, and trials per batch. Batches lie apart in time, so that another program that holds a core spoils some
/// and not all. The fastest tenth counts: the cost itself, not the load of the machine.
const BATCHES: usize = 30;
const TRIALS: usize = 10;
/// Pause before a batch.
const PAUSE: Duration = Duration::from_millis(10);
/// Costs where no second thread runs, s: of the order of those of servers.
const USUAL_CONTENDED_POP: f64 = 25e-9;
const USUAL_STEAL: f64 = 1.5e-6;
const POPS: usize = 2_000;
/// Tasks of a large region.
const MANY: usize = 1_000;
/// Duration of a task that another thread has time to steal, s.
const LONG_TASK: f64 = 50e-6;

impl Costs {
    /// Measures on up to `threads` threads, about two seconds.
    pub fn measure(threads: usize) -> Result<Costs, MeasureError> {
        let empty = |count: usize| {
            (0..count).into_par_iter().with_max_len(1).for_each(|task| {
                black_box(task);
            });
        };
        let alone = pool(1)?;
        let of_region =
            |tasks: usize| alone.install(|| fastest(|| Some(seconds_of(|| empty(tasks))))).unwrap_or_default();
        let (region, many) = (of_region(2), of_region(MANY));
        let pop_alone = fastest(|| pop_seconds(1)).unwrap_or_default();
        let task_start = ((many - region) / (MANY - 2) as f64).max(0.0);
        let mut costs = Costs { pop_alone, pop_contended: USUAL_CONTENDED_POP, task_start, steal: USUAL_STEAL, region };
        if threads > 1 {
            let contended = trials(|| pop_seconds(threads.min(4)));
            if !contended.is_empty() {
                costs.pop_contended = median(contended).max(pop_alone);
            }
            // Two long tasks on two threads take as long as one, plus waking the other thread and stealing.
            if let Some(two) = pool(2)?.install(|| fastest(pair_seconds)) {
                costs.steal = (two - LONG_TASK - region).max(0.0);
            }
        }
        Ok(costs)
    }
}

/// Sorted results of many trials; failed ones are left out.
fn trials(trial: impl Fn() -> Option<f64>) -> Vec<f64> {
    let mut all = Vec::with_capacity(BATCHES * TRIALS);
    for _ in 0..BATCHES {
        std::thread::sleep(PAUSE);
        // The first trials wake the threads.
        (0..2).for_each(|_| {
            trial();
        });
        all.extend((0..TRIALS).filter_map(|_| trial()));
    }
    all.sort_by(f64::total_cmp);
    all
}

/// The fastest tenth of many trials; none if all failed.
fn fastest(trial: impl Fn() -> Option<f64>) -> Option<f64> {
    let all = trials(trial);
    all.get(all.len() / 10).copied()
}

fn pool(threads: usize) -> Result<ThreadPool, MeasureError> {
    Ok(ThreadPoolBuilder::new().num_threads(threads).build()?)
}

fn seconds_of(call: impl FnOnce()) -> f64 {
    let clock = Instant::now();
    call();
    clock.elapsed().as_secs_f64()
}

/// Time of two long tasks on two threads, s; none if one thread ran both.
fn pair_seconds() -> Option<f64> {
    let done_by = [const { AtomicUsize::new(0) }; 2];
    let seconds = seconds_of(|| {
        (0..2).into_par_iter().with_max_len(1).for_each(|task: usize| {
            done_by[task].store(rayon::current_thread_index().unwrap_or_default(), Ordering::Relaxed);
            let clock = Instant::now();
            while clock.elapsed().as_secs_f64() < LONG_TASK {
                spin_loop();
            }
        });
    });
    let [first, second] = done_by.map(AtomicUsize::into_inner);
    (first != second).then_some(seconds)
}

/// Time between two pops of the solver's queue that a number of threads empty, s; none if one of the threads got hardly anything, and so
/// did not run at the same time.
fn pop_seconds(threads: usize) -> Option<f64> {
    let (queue, barrier) = (CentralQueue::new(POPS), Barrier::new(threads));
    let drain = || {
        barrier.wait();
        let (clock, mut pops) = (Instant::now(), 0);
        while let Some(task) = queue.pop() {
            black_box(task);
            pops += 1;
        }
        (clock.elapsed().as_secs_f64(), pops)
    };
    let own = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(drain)).collect();
        let own = drain();
        others.into_iter().filter_map(|other| other.join().ok()).chain([own]).collect::<Vec<_>>()
    });
    let longest = own.iter().map(|(seconds, _)| *seconds).fold(0.0, f64::max);
    let together = own.iter().all(|(_, pops)| pops * 4 * threads >= POPS);
    together.then_some(longest / POPS as f64)
}

#[cfg(test)]
#[path = "../../tests/unit/scaling_measure.rs"]
mod tests;
