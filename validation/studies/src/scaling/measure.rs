//! Measurement of one state over the same steps: every scheduler, number of threads and instruction set, in turn and several times,
//! so that other load on the machine affects all of them alike.

use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::{Region, Scheduler, StepTrace};
use makadam::sweep::SweepBytes;
use makadam_frames::execution::{Execution, MeasureError};
use makadam_frames::stepping::{Stepping, Taken};
use makadam_measure::statistics::median;
use serde::Serialize;
use std::time::Instant;

/// Steps before the timed ones, which fill caches and buffers.
pub(super) const WARM_UP: u64 = 3;

/// Configurations, steps and repetitions of a measurement.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Plan {
    /// Instruction sets, narrowest first.
    #[serde(skip)]
    pub instruction_sets: Vec<InstructionSet>,
    /// Numbers of threads of the parallel schedulers.
    #[serde(skip)]
    pub threads: Vec<usize>,
    /// Timed steps.
    pub steps: u64,
    /// Number of these steps, from the first, that are traced and replayed.
    pub traced_steps: u64,
    /// Repetitions of all measurements.
    pub repetitions: usize,
}

/// Timed steps of one configuration, by repetition.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Configuration.
    pub configuration: Execution,
    /// Wall time of each step, s.
    pub steps: Vec<Vec<f64>>,
    /// Wall time of its sweeps, s.
    pub sweeps: Vec<Vec<f64>>,
    /// Hashes of the final states.
    pub hashes: Vec<u64>,
}

/// Traced steps of one serial configuration, medians over the repetitions.
pub struct Traces {
    /// Configuration.
    pub configuration: Execution,
    /// Steps.
    pub steps: Vec<StepTrace>,
    /// Sweeps of each step.
    pub sweeps: Vec<u32>,
}

impl Traces {
    pub(super) fn regions(&self) -> impl Iterator<Item = &Region> {
        self.steps.iter().flat_map(|step| &step.regions)
    }
}

/// Result of a measurement. Contacts and bytes are those of any run: all have the same bits.
#[derive(Default)]
pub struct Measurement {
    /// Simulated time of the initial state, s.
    pub start_seconds: f64,
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
        let timing =
            |configuration| Timing { configuration, steps: Vec::new(), sweeps: Vec::new(), hashes: Vec::new() };
        let mut found = Measurement {
            start_seconds: start.time(),
            particles: start.snapshot().particles.len(),
            timings: self.configurations().into_iter().map(timing).collect(),
            ..Measurement::default()
        };
        let jobs = found.timings.len();
        let mut traced = vec![Vec::new(); jobs];
        for repetition in 0..self.repetitions {
            for place in 0..jobs {
                // Each round begins with another configuration, so that none always follows the same one.
                let job = (place + repetition) % jobs;
                self.time(start, job, &mut found)?;
                if found.timings[job].configuration.scheduler == Scheduler::Serial {
                    traced[job].push(self.trace(start, &mut found.timings[job])?);
                }
                progress((repetition * jobs + place + 1) as f64 / (self.repetitions * jobs) as f64);
            }
        }
        let clock = clock_seconds();
        for (timing, runs) in found.timings.iter().zip(traced).filter(|(_, runs)| !runs.is_empty()) {
            let (runs, mut sweeps): (Vec<_>, Vec<_>) = runs.into_iter().unzip();
            let steps = medians(&runs, clock);
            found.traces.push(Traces { configuration: timing.configuration, steps, sweeps: sweeps.swap_remove(0) });
        }
        Ok(found)
    }

    /// Times the steps of a configuration.
    fn time(&self, start: &Simulation, job: usize, found: &mut Measurement) -> Result<(), MeasureError> {
        let timing = &mut found.timings[job];
        let mut simulation = warmed_up(start, timing.configuration)?;
        let (mut steps, mut sweeps, mut contacts) = (Vec::new(), Vec::new(), 0);
        let before = simulation.contact_sweeps();
        let mut swept = simulation.phase_seconds().sweep;
        let each = |simulation: &Simulation, taken: &Taken| {
            let now = simulation.phase_seconds().sweep;
            steps.push(taken.seconds);
            sweeps.push(now - swept);
            swept = now;
            contacts += taken.report.contacts;
        };
        // Without a watchdog only an interruption ends the run early.
        Stepping::new(self.steps, &|_| {}).carry_out(&mut simulation, each).map_err(|_| MeasureError::Interrupted)?;
        timing.steps.push(steps);
        timing.sweeps.push(sweeps);
        timing.hashes.push(simulation.state_hash());
        found.contacts = contacts as f64 / self.steps as f64;
        found.contact_sweeps = (simulation.contact_sweeps() - before) as f64 / self.steps as f64;
        found.simulation_bytes = simulation.memory_bytes();
        found.sweep_bytes = simulation.sweep_bytes();
        Ok(())
    }

    /// Traces the first steps of a configuration and takes the others, so that the final state equals that of the timed run bit for bit; returns
    /// traces and sweeps of the steps.
    fn trace(&self, start: &Simulation, timing: &mut Timing) -> Result<(Vec<StepTrace>, Vec<u32>), MeasureError> {
        let mut simulation = warmed_up(start, timing.configuration)?;
        let (mut steps, mut sweeps) = (Vec::new(), Vec::new());
        for number in 0..self.steps {
            if number < self.traced_steps {
                let (report, trace) = simulation.trace_step();
                steps.push(trace);
                sweeps.push(report.solve.sweeps);
            } else {
                simulation.step();
            }
            if makadam_frames::interrupt::requested() {
                return Err(MeasureError::Interrupted);
            }
        }
        timing.hashes.push(simulation.state_hash());
        Ok((steps, sweeps))
    }
}

fn warmed_up(start: &Simulation, configuration: Execution) -> Result<Simulation, MeasureError> {
    let mut simulation = start.clone();
    configuration.apply(&mut simulation)?;
    for _ in 0..WARM_UP {
        simulation.step();
    }
    Ok(simulation)
}

/// Time that reading the clock adds to the traced duration of a task, s.
fn clock_seconds() -> f64 {
    median((0..1001).map(|_| Instant::now().elapsed().as_secs_f64()))
}

/// Traced steps with the median of their total over the repetitions, distributed over their tasks in proportion to the median durations.
/// Reading the clock is subtracted.
///
/// Other load lengthens a few tasks of every repetition, different ones each time. Medians of single tasks exclude it, but a measured
/// step contains it, so the totals must as well.
fn medians(runs: &[Vec<StepTrace>], clock: f64) -> Vec<StepTrace> {
    let total_of = |step: &StepTrace, clock: f64| -> f64 {
        step.regions.iter().flat_map(|region| &region.tasks).map(|task| (task - clock).max(0.0)).sum()
    };
    let median_of = |step: usize, region: usize, task: usize| {
        let durations = runs.iter().filter_map(|run| run.get(step)?.regions.get(region)?.tasks.get(task));
        (median(durations.copied()) - clock).max(0.0)
    };
    let first = runs.first().map_or(&[][..], Vec::as_slice);
    let steps = first.iter().enumerate().map(|(step, trace)| {
        let regions = trace.regions.iter().enumerate().map(|(place, region)| Region {
            phase: region.phase,
            tasks: (0..region.tasks.len()).map(|task| median_of(step, place, task)).collect(),
        });
        let mut typical = StepTrace { regions: regions.collect() };
        let total = median(runs.iter().filter_map(|run| run.get(step)).map(|step| total_of(step, clock)));
        let factor = total / total_of(&typical, 0.0);
        if factor.is_finite() {
            typical.regions.iter_mut().flat_map(|region| &mut region.tasks).for_each(|task| *task *= factor);
        }
        typical
    });
    steps.collect()
}

#[cfg(test)]
#[path = "../../tests/unit/scaling_measure.rs"]
mod tests;
