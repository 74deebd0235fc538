//! Measurement: one scene, the same state, the same steps, by every scheduler on every number of threads with every
//! instruction set, in turn and several times over, so that whatever else the machine does hits all of them alike.

use crate::execution::{Execution, MeasureError};
use crate::statistics::median;
use crate::stepping::{Stepping, Taken};
use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::{Region, Scheduler, StepTrace};
use makadam::sweep::SweepBytes;
use std::time::Instant;

/// Steps that are taken before any is timed: they fill caches and buffers.
pub const WARM_UP: u64 = 3;

/// What is measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Instruction sets, narrowest first.
    pub instruction_sets: Vec<InstructionSet>,
    /// Numbers of threads of the parallel schedulers.
    pub threads: Vec<usize>,
    /// Timed steps.
    pub steps: u64,
    /// The first so many of them are traced too.
    pub traced_steps: u64,
    /// How often everything is done.
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

/// What was measured of one configuration.
#[derive(Clone, Debug)]
pub struct Timing {
    /// The configuration.
    pub configuration: Execution,
    /// By repetition.
    pub repetitions: Vec<Times>,
    /// Hash of the state at the end, by repetition.
    pub hashes: Vec<u64>,
}

/// Traced steps of one configuration, typical of the repetitions.
pub struct Traces {
    /// The configuration.
    pub configuration: Execution,
    /// The steps.
    pub steps: Vec<StepTrace>,
    /// Sweeps of each step.
    pub sweeps: Vec<u32>,
    /// Time of all tasks over that in the serial trace of the same round, instruction set and portion; median over the rounds.
    pub task_time_ratio: f64,
}

/// All that was measured.
pub struct Measurement {
    /// Grains.
    pub particles: usize,
    /// Contacts of a step, mean over the timed steps.
    pub contacts: f64,
    /// Contact sweeps of a step, mean over the timed steps.
    pub contact_sweeps: f64,
    /// Memory that the simulation holds, bytes.
    pub simulation_bytes: usize,
    /// Bytes of a sweep over all contacts.
    pub sweep_bytes: SweepBytes,
    /// Timed runs, serial first for each instruction set.
    pub timings: Vec<Timing>,
    /// Traced runs, in the order of `timings`.
    pub traces: Vec<Traces>,
    /// Whether tracing gave the same bits as stepping.
    pub traces_same_bits: bool,
}

impl Plan {
    /// All configurations: for each instruction set serial first, then the parallel schedulers by number of threads; in the end
    /// the same once more for the widest, a box at a time.
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

    /// Measures from a state; `progress` is told the share that is done.
    ///
    /// # Errors
    /// [`MeasureError`].
    pub fn measure(&self, start: &Simulation, progress: &dyn Fn(f64)) -> Result<Measurement, MeasureError> {
        let configurations = self.configurations();
        let mut timings: Vec<Timing> = configurations
            .iter()
            .map(|&configuration| Timing { configuration, repetitions: Vec::new(), hashes: Vec::new() })
            .collect();
        let mut traced: Vec<Vec<TracedRun>> = configurations.iter().map(|_| Vec::new()).collect();
        let (mut facts, mut hash_when_traced) = (Facts::default(), None);
        let jobs = configurations.len();
        for repetition in 0..self.repetitions {
            for place in 0..jobs {
                // Each round begins with another configuration, so that none always follows the same one.
                let job = (place + repetition) % jobs;
                let run = self.timed(start, configurations[job], &mut facts)?;
                hash_when_traced.get_or_insert(run.hash_when_traced);
                timings[job].repetitions.push(run.times);
                timings[job].hashes.push(run.hash);
                traced[job].push(self.traced(start, configurations[job])?);
                progress((repetition * jobs + place + 1) as f64 / (self.repetitions * jobs) as f64);
            }
        }
        let traces_same_bits = traced.iter().flatten().all(|run| Some(run.hash) == hash_when_traced);
        Ok(Measurement {
            particles: start.snapshot().particles.len(),
            contacts: facts.contacts,
            contact_sweeps: facts.contact_sweeps,
            simulation_bytes: facts.simulation_bytes,
            sweep_bytes: facts.sweep_bytes,
            timings,
            traces: typical(&configurations, &traced),
            traces_same_bits,
        })
    }

    fn timed(&self, start: &Simulation, configuration: Execution, facts: &mut Facts) -> Result<TimedRun, MeasureError> {
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
            contacts += taken.report.contacts;
            if taken.number == self.traced_steps {
                hash_when_traced = simulation.state_hash();
            }
        };
        // Without a watchdog nothing but an interruption ends it.
        Stepping::new(self.steps, &|_| {}).carry_out(&mut simulation, each).map_err(|_| MeasureError::Interrupted)?;
        *facts = Facts {
            contacts: contacts as f64 / self.steps as f64,
            contact_sweeps: (simulation.contact_sweeps() - before) as f64 / self.steps as f64,
            simulation_bytes: simulation.memory_bytes(),
            sweep_bytes: simulation.sweep_bytes(),
        };
        Ok(TimedRun { times, hash: simulation.state_hash(), hash_when_traced })
    }

    fn traced(&self, start: &Simulation, configuration: Execution) -> Result<TracedRun, MeasureError> {
        let mut simulation = warmed_up(start, configuration)?;
        let (mut steps, mut sweeps) = (Vec::new(), Vec::new());
        for _ in 0..self.traced_steps {
            let (report, trace) = simulation.trace_step();
            steps.push(trace);
            sweeps.push(report.solve.sweeps);
            if crate::interrupt::requested() {
                return Err(MeasureError::Interrupted);
            }
        }
        Ok(TracedRun { steps, sweeps, hash: simulation.state_hash() })
    }
}

struct TimedRun {
    times: Times,
    hash: u64,
    hash_when_traced: u64,
}

struct TracedRun {
    steps: Vec<StepTrace>,
    sweeps: Vec<u32>,
    hash: u64,
}

impl TracedRun {
    /// Time of all tasks of all its steps, s.
    fn seconds(&self, clock: f64) -> f64 {
        self.steps.iter().map(|step| total_seconds(step, clock)).sum()
    }
}

/// What is the same for every configuration.
#[derive(Default)]
struct Facts {
    contacts: f64,
    contact_sweeps: f64,
    simulation_bytes: usize,
    sweep_bytes: SweepBytes,
}

fn warmed_up(start: &Simulation, configuration: Execution) -> Result<Simulation, MeasureError> {
    let mut simulation = start.clone();
    configuration.apply(&mut simulation)?;
    for _ in 0..WARM_UP {
        simulation.step();
    }
    Ok(simulation)
}

/// What reading the clock adds to the traced duration of a task, s.
fn clock_seconds() -> f64 {
    median((0..1001).map(|_| Instant::now().elapsed().as_secs_f64()))
}

/// What is typical of the traced runs of each configuration.
fn typical(configurations: &[Execution], traced: &[Vec<TracedRun>]) -> Vec<Traces> {
    let clock = clock_seconds();
    let serial = |own: Execution| {
        let place = configurations.iter().position(|other| other.is_serial_of(&own));
        place.map_or(&[][..], |place| &traced[place])
    };
    let all = configurations.iter().zip(traced).map(|(&configuration, runs)| {
        let rounds = serial(configuration).iter().zip(runs);
        let task_time_ratio = median(rounds.map(|(serial, own)| own.seconds(clock) / serial.seconds(clock)));
        let sweeps = runs.first().map_or(Vec::new(), |run| run.sweeps.clone());
        Traces { configuration, steps: medians(runs, clock), sweeps, task_time_ratio }
    });
    all.collect()
}

/// The traced steps, each with the median of its total over the repetitions, shared out among its tasks as the medians of their own
/// durations are. Reading the clock is left out. The tasks depend on the scene alone, so they are the same ones each time.
///
/// Whatever else the machine does lengthens a few tasks of every repetition, and other ones each time. The medians of single tasks
/// leave that out, but a measured step contains it, so the totals have to as well.
fn medians(runs: &[TracedRun], clock: f64) -> Vec<StepTrace> {
    let Some(first) = runs.first() else { return Vec::new() };
    let median_of = |step: usize, region: usize, task: usize| {
        let durations = runs.iter().filter_map(|run| run.steps.get(step)?.regions.get(region)?.tasks.get(task));
        (median(durations.copied()) - clock).max(0.0)
    };
    let steps = first.steps.iter().enumerate().map(|(step, trace)| {
        let regions = trace.regions.iter().enumerate().map(|(place, region)| Region {
            phase: region.phase,
            tasks: (0..region.tasks.len()).map(|task| median_of(step, place, task)).collect(),
        });
        let mut typical = StepTrace { regions: regions.collect() };
        let total = median(runs.iter().filter_map(|run| run.steps.get(step)).map(|run| total_seconds(run, clock)));
        let factor = total / total_seconds(&typical, 0.0);
        if factor.is_finite() {
            typical.regions.iter_mut().flat_map(|region| &mut region.tasks).for_each(|task| *task *= factor);
        }
        typical
    });
    steps.collect()
}

/// Time of all tasks of a step, less what reading the clock added to each, s.
fn total_seconds(step: &StepTrace, clock: f64) -> f64 {
    step.regions.iter().flat_map(|region| &region.tasks).map(|task| (task - clock).max(0.0)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use makadam::schedule::Phase;

    fn run(durations: &[f64]) -> TracedRun {
        let regions = vec![Region { phase: Phase::Sweep, tasks: durations.to_vec() }];
        TracedRun { steps: vec![StepTrace { regions }], sweeps: vec![1], hash: 0 }
    }

    #[test]
    fn disturbances_stay_in_the_total_and_leave_the_shares() {
        // Another task is hit each time: 10 s of work, 2 s of something else.
        let runs = [&[6.0, 2.0, 4.0], &[4.0, 4.0, 4.0], &[4.0, 2.0, 6.0]].map(|durations| run(durations));
        let steps = medians(&runs, clock_seconds());
        let tasks = &steps[0].regions[0].tasks;
        let total: f64 = tasks.iter().sum();
        assert!((total - 12.0).abs() < 1e-4, "the median of the totals, less the clock: {total}");
        assert!((tasks[0] / tasks[1] - 2.0).abs() < 1e-4, "{tasks:?}");
        assert!((tasks[2] / tasks[1] - 2.0).abs() < 1e-4, "{tasks:?}");
    }
}
