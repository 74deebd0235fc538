//! The replay: duration of a traced step on P cores of a modelled machine, from who takes which task when.
//!
//! ```text
//! region  |--wake--| worker 0: pop task     pop task          |  a region ends with its last task,
//!                    worker 1: .... pop task            pop ...|  and the next one begins
//!                              (waits for the lock)
//! ```
//!
//! - A region of one task is serial work: it runs on one worker that has its core to itself, at no further cost.
//! - One worker runs all tasks in turn; only the central queue costs it something, a pop per task.
//! - Several workers pay [`Costs::region`] for a region of several tasks. They arrive by stealing, so worker i begins
//!   after log2(i + 1) steals, rounded up. Workers beyond the number of tasks stay idle and leave their core to others.
//! - **Central queue:** a free worker takes the lock, first come first served, for one pop, and runs the task.
//! - **Work stealing:** the tasks are split among the workers as stretches, down to single tasks. A worker without tasks
//!   steals the later half of the fullest deque.
//! - **Memory:** running tasks request bytes at a fixed rate. Where all of them request more than the memory delivers, all
//!   are slowed alike (processor sharing). As the slow-down is common, the ends of running tasks stay in order, and one
//!   clock of work done, which runs slower than time, gives them.
//!
//! A thief finds the fullest deque at once, and no task disturbs another's cache: a replay is a bound of the scheduler, not a
//! forecast with noise.

use super::ReplayedRow;
use super::measure::{Measurement, Traces};
use makadam::schedule::{Phase, Region, Scheduler};
use rayon::prelude::*;
use serde::Serialize;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// Largest number of workers of a replay.
pub(super) const MOST_WORKERS: usize = 256;

/// Costs of scheduling, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Costs {
    /// Pop from the central queue by the only worker.
    pub pop_alone: f64,
    /// Pop while other workers want the lock: time between two changes of its owner.
    pub pop_contended: f64,
    /// Start of a task from the worker's own deque.
    pub task_start: f64,
    /// Steal of tasks from another worker.
    pub steal: f64,
    /// Start and end of a region.
    pub region: f64,
}

/// Model of a machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// Short name.
    pub name: String,
    /// Sources of its constants, in sentences.
    pub description: String,
    /// Number of cores; workers are dealt out to them evenly.
    pub cores: usize,
    /// Throughput of 1, 2, ... threads of one core together, in units of one thread alone on the core.
    pub core_throughput: Vec<f64>,
    /// Duration of a task, on a thread alone on its core, over its traced duration.
    pub duration_factor: f64,
    /// Costs of scheduling.
    pub costs: Costs,
    /// Memory bandwidth, bytes/s.
    pub memory_bytes_per_second: f64,
    /// Threads that share this memory; more of them bring as much more.
    pub threads_a_memory: usize,
    /// Last-level cache, bytes; memory does not limit sweeps whose data fit.
    pub cache_bytes: u64,
}

/// Clock of the Xeon Phi 3120, Hz.
const PHI_CLOCK: f64 = 1.1e9;
/// Cycles that a cache line takes from one core of the Xeon Phi to another over its ring.
const PHI_LINE_CYCLES: f64 = 250.0;
/// Cache lines that travel when a contended lock and the head of its queue change hands: the lock is released, fetched
/// and taken, and the queue is read.
const LINES_A_HAND_OVER: f64 = 4.0;

impl Machine {
    /// Name of the machine of the measurement.
    pub const HERE: &str = "here";
    /// Name of the thesis's machine.
    pub const XEON_PHI: &str = "xeon-phi-3120";

    /// Any number of cores like those of this machine. `memory` is the bandwidth of the available cores and their number; further
    /// cores bring memory of their own, as further sockets do.
    pub fn here(costs: Costs, memory: (f64, usize), cache_bytes: u64) -> Machine {
        let (bytes, threads) = memory;
        let beyond = match threads < MOST_WORKERS {
            true => format!("; every {threads} more bring as much memory of their own"),
            false => String::new(),
        };
        Machine {
            name: Machine::HERE.into(),
            description: format!(
                "The machine of the measurement with as many cores as workers, all alike; costs of scheduling as measured on the \
                 available cores; {threads} threads share {:.0} GB/s of memory{beyond}.",
                bytes / 1e9
            ),
            cores: MOST_WORKERS,
            core_throughput: vec![1.0],
            duration_factor: 1.0,
            costs,
            memory_bytes_per_second: bytes,
            threads_a_memory: threads,
            cache_bytes,
        }
    }

    /// The coprocessor of the thesis, 57 cores of four threads, from costs and clock of the machine of the trace.
    ///
    /// The core issues in order, and one thread can issue only every other cycle: two threads do twice the work of one
    /// and more than two add nothing (the latency that they hide is left out). A task takes longer by the ratio of
    /// the clocks, and twice for the missing cycles. In-order stalls cost nothing, so the model is a fast Phi.
    pub fn xeon_phi_3120(here: &Costs, clock_here: f64) -> Machine {
        let slower = 2.0 * clock_here / PHI_CLOCK;
        let hand_over = LINES_A_HAND_OVER * PHI_LINE_CYCLES / PHI_CLOCK;
        Machine {
            name: Machine::XEON_PHI.into(),
            description: format!(
                "A model of the Xeon Phi 3120: 57 cores of four threads at 1.1 GHz. A task takes {slower:.1} times longer than its trace \
                 (ratio of the clocks, and twice because one thread issues only every other cycle); two threads of a core do twice the \
                 work of one, three and four no more; a lock changes hands in {:.2} µs ({LINES_A_HAND_OVER} cache lines of \
                 {PHI_LINE_CYCLES} cycles over the ring), and so does a stolen task; the memory delivers 150 of its nominal 240 GB/s.",
                1e6 * hand_over
            ),
            cores: 57,
            core_throughput: vec![1.0, 2.0, 2.0, 2.0],
            duration_factor: slower,
            costs: Costs {
                pop_alone: slower * here.pop_alone,
                pop_contended: hand_over,
                task_start: slower * here.task_start,
                steal: hand_over,
                region: slower * here.region,
            },
            memory_bytes_per_second: 150e9,
            threads_a_memory: 57 * 4,
            cache_bytes: 57 * 512 * 1024,
        }
    }

    /// Memory bandwidth of a number of workers, bytes/s.
    fn ceiling(&self, workers: usize) -> f64 {
        self.memory_bytes_per_second * (workers as f64 / self.threads_a_memory as f64).max(1.0)
    }

    /// Most workers: every thread of every core, but no more than `MOST_WORKERS`.
    pub fn most_workers(&self) -> usize {
        (self.cores * self.core_throughput.len()).min(MOST_WORKERS)
    }

    /// Speed of each of a number of workers while all of them work, in units of a thread that has a core to itself.
    fn speeds(&self, workers: usize) -> Vec<f64> {
        let on_core = |core: usize| workers / self.cores + usize::from(core < workers % self.cores);
        (0..workers)
            .map(|worker| {
                let threads = on_core(worker % self.cores);
                self.core_throughput[threads.min(self.core_throughput.len()) - 1] / threads as f64
            })
            .collect()
    }
}

/// Numbers of workers that a curve is replayed at: all up to four, then steps of about a fifth, and the ends of what the
/// thesis showed.
fn worker_counts(most: usize, besides: &[usize]) -> Vec<usize> {
    let usual =
        [1, 2, 3, 4, 6, 8, 10, 12, 14, 16, 20, 25, 28, 32, 40, 48, 57, 64, 80, 96, 114, 128, 160, 192, 228, 256];
    let mut counts: Vec<usize> = usual.into_iter().chain(besides.iter().copied()).filter(|&p| p <= most).collect();
    counts.sort_unstable();
    counts.dedup();
    counts
}

/// Replays traces on a machine, by scheduler and number of workers; the serial replay comes first.
pub(super) fn curves(
    machine: &Machine,
    traces: &Traces,
    measurement: &Measurement,
    threads: &[usize],
) -> Vec<ReplayedRow> {
    let counts = worker_counts(machine.most_workers(), threads);
    let parallel = [Scheduler::CentralQueue, Scheduler::WorkStealing].into_iter();
    let parallel = parallel.flat_map(|scheduler| counts.iter().map(move |&workers| (scheduler, workers)));
    let jobs: Vec<(Scheduler, usize)> = [(Scheduler::Serial, 1)].into_iter().chain(parallel).collect();
    let replays: Vec<Replayed> = (jobs.par_iter())
        .map(|&(scheduler, workers)| {
            let traffic = traffic(machine, traces, measurement, workers);
            mean_replay(traces, scheduler, machine, traffic, workers)
        })
        .collect();
    let serial = replays[0];
    let rows = jobs.iter().zip(&replays).map(|(&(scheduler, workers), own)| ReplayedRow {
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

/// Memory traffic of a running task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traffic {
    /// Bytes/s that a task of a sweep requests on a thread alone on its core, on the machine of the replay.
    pub bytes_per_second: f64,
    /// Memory bandwidth, bytes/s.
    pub ceiling: f64,
}

/// Result of a replay.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Replayed {
    /// Time of all regions, s.
    pub seconds: f64,
    /// Time of the regions of sweeps, s.
    pub sweep_seconds: f64,
    /// Time that workers waited for the queue's lock, summed over workers, s.
    pub waiting: f64,
}

/// Replays regions, one after the other, on a number of workers.
///
/// # Panics
/// If there is no worker.
pub fn replay(
    regions: &[Region],
    scheduler: Scheduler,
    machine: &Machine,
    traffic: Option<Traffic>,
    workers: usize,
) -> Replayed {
    assert!(workers > 0, "a replay needs a worker");
    let mut done = Replayed::default();
    let mut speeds = Vec::new();
    for region in regions {
        let seconds = if region.tasks.len() < 2 || workers == 1 || scheduler == Scheduler::Serial {
            let queued = scheduler == Scheduler::CentralQueue && region.tasks.len() > 1;
            let pops = if queued { region.tasks.len() as f64 } else { 0.0 };
            machine.duration_factor * region.tasks.iter().sum::<f64>() + pops * machine.costs.pop_alone
        } else {
            let active = workers.min(region.tasks.len());
            if speeds.len() != active {
                speeds = machine.speeds(active);
            }
            let traffic = traffic.filter(|_| region.phase == Phase::Sweep);
            let mut running = Running::new(region, scheduler, machine, traffic, &speeds);
            let seconds = running.run();
            done.waiting += running.waiting;
            seconds
        };
        done.seconds += seconds;
        if region.phase == Phase::Sweep {
            done.sweep_seconds += seconds;
        }
    }
    done
}

/// A time (s, not negative) as heaps order it.
fn key(time: f64) -> u64 {
    time.to_bits()
}

/// Next action of a worker, which uses no memory.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Next {
    Ask,
    Begin(usize),
}

/// One region during its replay.
struct Running<'a> {
    tasks: &'a [f64],
    costs: Costs,
    factor: f64,
    speeds: &'a [f64],
    traffic: Option<Traffic>,
    work: Work,
    time: f64,
    /// Clock of work done: work of a worker of speed 1 since the region began, s.
    done: f64,
    /// Speeds of the running workers, summed.
    running: f64,
    /// Next actions of workers, by time.
    soon: BinaryHeap<Reverse<(u64, usize, Next)>>,
    /// Ends of running tasks, by the clock of work done.
    ends: BinaryHeap<Reverse<(u64, usize)>>,
    waiting: f64,
}

/// Waiting tasks.
enum Work {
    Queue {
        next: usize,
        free_at: f64,
    },
    /// One deque per worker, and the number of tasks in all of them.
    Deques(Vec<VecDeque<usize>>, usize),
}

impl<'a> Running<'a> {
    fn new(
        region: &'a Region,
        scheduler: Scheduler,
        machine: &Machine,
        traffic: Option<Traffic>,
        speeds: &'a [f64],
    ) -> Running<'a> {
        let (tasks, workers, costs) = (region.tasks.len(), speeds.len(), machine.costs);
        let mut soon = BinaryHeap::new();
        let work = match scheduler {
            Scheduler::WorkStealing => {
                let stretch = |w: usize| (w * tasks / workers..(w + 1) * tasks / workers).collect();
                Work::Deques((0..workers).map(stretch).collect(), tasks)
            }
            _ => Work::Queue { next: 0, free_at: 0.0 },
        };
        for worker in 0..workers {
            let late = ((worker + 1) as f64).log2().ceil() * costs.steal;
            soon.push(Reverse((key(costs.region + late), worker, Next::Ask)));
        }
        Running {
            tasks: &region.tasks,
            costs,
            factor: machine.duration_factor,
            speeds,
            traffic,
            work,
            time: 0.0,
            done: 0.0,
            running: 0.0,
            soon,
            ends: BinaryHeap::new(),
            waiting: 0.0,
        }
    }

    /// Runs until all tasks are done; returns the time of the last end, s.
    fn run(&mut self) -> f64 {
        let mut left = self.tasks.len();
        while left > 0 {
            let rate = self.rate();
            let end = self
                .ends
                .peek()
                .map(|Reverse((end, _))| self.time + (f64::from_bits(*end) - self.done).max(0.0) / rate);
            let next = self.soon.peek().map(|Reverse((time, ..))| f64::from_bits(*time));
            // An end goes first: the worker that it frees asks before one that comes at the same time.
            if end.is_some_and(|end| next.is_none_or(|next| end <= next)) {
                let Some(Reverse((at, worker))) = self.ends.pop() else { break };
                self.advance(end.unwrap_or(self.time), rate);
                self.done = self.done.max(f64::from_bits(at));
                self.running -= self.speeds[worker];
                left -= 1;
                self.ask(worker);
            } else {
                let Some(Reverse((at, worker, action))) = self.soon.pop() else { break };
                self.advance(f64::from_bits(at), rate);
                match action {
                    Next::Ask => self.ask(worker),
                    Next::Begin(task) => self.begin(worker, task),
                }
            }
        }
        self.time
    }

    /// Rate of the clock of work done: 1, or less where the running tasks request more than the memory delivers.
    fn rate(&self) -> f64 {
        match self.traffic {
            Some(traffic) if self.running * traffic.bytes_per_second > traffic.ceiling => {
                traffic.ceiling / (self.running * traffic.bytes_per_second)
            }
            _ => 1.0,
        }
    }

    fn advance(&mut self, to: f64, rate: f64) {
        let to = to.max(self.time);
        self.done += rate * (to - self.time);
        self.time = to;
    }

    fn begin(&mut self, worker: usize, task: usize) {
        let speed = self.speeds[worker];
        self.running += speed;
        self.ends.push(Reverse((key(self.done + self.factor * self.tasks[task] / speed), worker)));
    }

    /// Gives a free worker its next task; without one it leaves the region.
    fn ask(&mut self, worker: usize) {
        let (now, costs) = (self.time, self.costs);
        match &mut self.work {
            Work::Queue { next, free_at } => {
                if *next < self.tasks.len() {
                    let locked = free_at.max(now);
                    self.waiting += locked - now;
                    *free_at = locked + costs.pop_contended;
                    self.soon.push(Reverse((key(*free_at), worker, Next::Begin(*next))));
                    *next += 1;
                }
            }
            Work::Deques(_, 0) => {}
            Work::Deques(deques, held) => {
                let mut cost = costs.task_start;
                if deques[worker].is_empty() {
                    let fullest = (0..deques.len()).max_by_key(|&w| (deques[w].len(), Reverse(w))).unwrap_or(worker);
                    let kept = deques[fullest].len() / 2;
                    deques[worker] = deques[fullest].split_off(kept);
                    cost += costs.steal;
                }
                if let Some(task) = deques[worker].pop_front() {
                    *held -= 1;
                    self.soon.push(Reverse((key(now + cost), worker, Next::Begin(task))));
                }
            }
        }
    }
}
