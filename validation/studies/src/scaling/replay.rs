//! Replay: duration of traced steps on P cores of a modelled machine, from the assignment of tasks to workers over time. The costs of
//! scheduling are measured apart from the solver, so that a replay predicts a measurement and is not fitted to it.
//!
//! ```text
//! region  |--wake--| worker 0: pop task     pop task          |  a region ends with its last task,
//!                    worker 1: .... pop task            pop ...|  and the next one begins
//!                              (waits for the lock)
//! ```
//!
//! - A region of one task is serial work: it runs on one worker alone on its core, at no further cost.
//! - One worker runs all tasks in turn; only the central queue costs time, one pop per task.
//! - Several workers pay [`Costs::region`] for a region of several tasks. Workers arrive by stealing, so worker i begins
//!   after log2(i + 1) steals, rounded up. Workers beyond the number of tasks stay idle and leave their core to others.
//! - **Central queue:** a free worker takes the lock, first come first served, for one pop, and runs the task.
//! - **Work stealing:** the tasks are split among the workers as ranges, down to single tasks. A worker without tasks
//!   steals the later half of the fullest deque.
//! - **Memory:** a region of a sweep takes no less time than the memory needs for its bytes.
//!
//! A thief finds the fullest deque at once, and no task disturbs another's cache: a replay is a bound of the scheduler, without
//! noise.

use super::{Measurement, Traces};
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::{CentralQueue, Phase, Region, Scheduler};
use makadam_frames::execution::MeasureError;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::hint::{black_box, spin_loop};
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Largest number of workers of a replay.
const MOST_WORKERS: usize = 256;

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
    /// Sources of its constants, as sentences.
    pub description: String,
    /// Number of cores; workers are distributed evenly over them.
    pub cores: usize,
    /// Total throughput of 1, 2, ... threads of one core, in units of one thread alone on the core.
    pub core_throughput: Vec<f64>,
    /// Duration of a task, on a thread alone on its core, over its traced duration.
    pub duration_factor: f64,
    /// Costs of scheduling.
    pub costs: Costs,
    /// Memory bandwidth, bytes/s.
    pub memory_bytes_per_second: f64,
    /// Threads that share this memory; further threads add memory in proportion.
    pub threads_a_memory: usize,
    /// Last-level cache, bytes; memory does not limit sweeps whose data fit.
    pub cache_bytes: u64,
}

/// Clock of the Xeon Phi 3120, Hz.
const PHI_CLOCK: f64 = 1.1e9;
/// Cycles that a cache line takes from one core of the Xeon Phi to another over its ring.
const PHI_LINE_CYCLES: f64 = 250.0;
/// Cache lines transferred when a contended lock and the head of its queue change owner: the lock is released, fetched
/// and taken, and the queue is read.
const LINES_A_HAND_OVER: f64 = 4.0;

impl Machine {
    /// Name of the machine of the measurement.
    pub const HERE: &str = "here";
    /// Name of the thesis's machine.
    pub const XEON_PHI: &str = "xeon-phi-3120";

    /// Returns a machine with any number of cores like those of this one. `memory` is the bandwidth of the available cores and their number;
    /// further cores have memory of their own, as further sockets do.
    pub fn here(costs: Costs, memory: (f64, usize), cache_bytes: u64) -> Machine {
        let (bytes, threads) = memory;
        Machine {
            name: Machine::HERE.into(),
            description: format!(
                "The machine of the measurement with as many cores as workers, all alike; costs of scheduling as measured on the \
                 available cores; {threads} threads share {:.0} GB/s of memory; every {threads} more bring as much memory of their own.",
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

    /// Returns the coprocessor of the thesis, 57 cores of four threads, from costs and clock of the machine of the trace.
    ///
    /// The core issues in order, and one thread can issue only every other cycle. Two threads do twice the work of one
    /// and more than two add nothing (the latency that they hide is ignored). A task takes longer by the ratio of
    /// the clocks, and twice as long for the missing cycles. In-order stalls cost nothing, so the model is a fast Phi.
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

    /// Largest number of workers: every thread of every core, but no more than `MOST_WORKERS`.
    pub fn most_workers(&self) -> usize {
        (self.cores * self.core_throughput.len()).min(MOST_WORKERS)
    }

    /// Speed of each of a number of workers while all of them work, in units of a thread alone on its core.
    fn speeds(&self, workers: usize) -> Vec<f64> {
        let on_core = |core: usize| workers / self.cores + usize::from(core < workers % self.cores);
        (0..workers)
            .map(|worker| {
                let threads = on_core(worker % self.cores);
                self.core_throughput[threads.min(self.core_throughput.len()) - 1] / threads as f64
            })
            .collect()
    }
    /// Time in which several workers run several tasks, and the workers' total waiting time for the lock, s.
    fn share(&self, tasks: &[f64], scheduler: Scheduler, workers: usize) -> [f64; 2] {
        let (costs, workers) = (self.costs, workers.min(tasks.len()));
        let speeds = self.speeds(workers);
        let mut queue = 0..tasks.len();
        let stretch = |worker: usize| (worker * tasks.len() / workers..(worker + 1) * tasks.len() / workers).collect();
        let mut deques: Vec<VecDeque<usize>> = (0..workers).map(stretch).collect();
        // Free workers by the time of their next request. Times are not negative, so their bits have the same order.
        let arrival = |worker: usize| costs.region + ((worker + 1) as f64).log2().ceil() * costs.steal;
        let mut free: BinaryHeap<_> = (0..workers).map(|worker| Reverse((arrival(worker).to_bits(), worker))).collect();
        let (mut end, mut waiting, mut unlocked) = (0.0_f64, 0.0, 0.0_f64);
        while let Some(Reverse((at, worker))) = free.pop() {
            let now = f64::from_bits(at);
            let (task, begin) = if scheduler == Scheduler::CentralQueue {
                let Some(task) = queue.next() else { break };
                let locked = unlocked.max(now);
                waiting += locked - now;
                unlocked = locked + costs.pop_contended;
                (task, unlocked)
            } else {
                let mut cost = costs.task_start;
                if deques[worker].is_empty() {
                    let fullest = (0..workers).max_by_key(|&other| (deques[other].len(), Reverse(other)));
                    let fullest = &mut deques[fullest.unwrap_or(worker)];
                    let stolen = fullest.split_off(fullest.len() / 2);
                    deques[worker] = stolen;
                    cost += costs.steal;
                }
                // A worker that finds no task leaves the region.
                let Some(task) = deques[worker].pop_front() else { continue };
                (task, now + cost)
            };
            let own_end = begin + self.duration_factor * tasks[task] / speeds[worker];
            free.push(Reverse((own_end.to_bits(), worker)));
            end = end.max(own_end);
        }
        [end, waiting]
    }
}

/// One replayed configuration.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct ReplayedRow {
    /// Always "replayed".
    pub source: String,
    pub machine: String,
    pub instruction_set: InstructionSet,
    pub scheduler: Scheduler,
    pub workers: usize,
    pub portion: Portion,
    pub step_seconds: f64,
    pub sweep_seconds: f64,
    /// Speed-up of whole steps over the serial replay on the same machine.
    pub speedup: f64,
    pub sweep_speedup: f64,
    /// Fraction of the workers' time spent waiting for the queue's lock.
    pub waiting_share: f64,
}

/// Numbers of workers of a replayed curve, in addition to the measured ones: all up to four, then steps of about a fifth, and the
/// ends of the ranges in the thesis.
const WORKERS: [usize; 26] =
    [1, 2, 3, 4, 6, 8, 10, 12, 14, 16, 20, 25, 28, 32, 40, 48, 57, 64, 80, 96, 114, 128, 160, 192, 228, 256];

/// Replays traces on a machine, by scheduler and number of workers; the serial replay comes first.
pub(super) fn curves(
    machine: &Machine,
    traces: &Traces,
    measurement: &Measurement,
    threads: &[usize],
) -> Vec<ReplayedRow> {
    let most = machine.most_workers();
    let mut counts: Vec<usize> = WORKERS.iter().chain(threads).copied().filter(|&workers| workers <= most).collect();
    counts.sort_unstable();
    counts.dedup();
    let parallel = [Scheduler::CentralQueue, Scheduler::WorkStealing].into_iter();
    let parallel = parallel.flat_map(|scheduler| counts.iter().map(move |&workers| (scheduler, workers)));
    let jobs: Vec<(Scheduler, usize)> = [(Scheduler::Serial, 1)].into_iter().chain(parallel).collect();
    let one = |&(scheduler, workers): &(Scheduler, usize)| {
        replay(traces.regions(), scheduler, machine, memory_share(machine, traces, measurement, workers), workers)
    };
    let replays: Vec<Replayed> = jobs.par_iter().map(one).collect();
    let (serial, steps) = (replays[0], traces.steps.len().max(1) as f64);
    let rows = jobs.iter().zip(&replays).map(|(&(scheduler, workers), own)| ReplayedRow {
        source: "replayed".into(),
        machine: machine.name.clone(),
        instruction_set: traces.configuration.instruction_set,
        scheduler,
        workers,
        portion: traces.configuration.portion,
        step_seconds: own.seconds / steps,
        sweep_seconds: own.sweep_seconds / steps,
        speedup: serial.seconds / own.seconds,
        sweep_speedup: serial.sweep_seconds / own.sweep_seconds,
        waiting_share: own.waiting / (own.seconds * workers as f64),
    });
    rows.collect()
}

/// Time that the memory needs for the bytes of a sweep, over its traced time. The result is 0 where all data of a sweep fit into the last-level
/// cache: the next sweep finds them there.
fn memory_share(machine: &Machine, traces: &Traces, measurement: &Measurement, workers: usize) -> f64 {
    let memories = (workers as f64 / machine.threads_a_memory as f64).max(1.0);
    let sweeps = traces.regions().filter(|region| region.phase == Phase::Sweep);
    let traced_seconds: f64 = sweeps.flat_map(|region| &region.tasks).sum();
    let bytes = f64::from(traces.sweeps.iter().sum::<u32>()) * measurement.sweep_bytes.moved as f64;
    let is_limited = measurement.sweep_bytes.touched as u64 > machine.cache_bytes && traced_seconds > 0.0;
    if is_limited { bytes / (machine.memory_bytes_per_second * memories) / traced_seconds } else { 0.0 }
}

/// Result of a replay.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Replayed {
    /// Time of all regions, s.
    pub seconds: f64,
    /// Time of the regions of sweeps, s.
    pub sweep_seconds: f64,
    /// Total time that workers waited for the queue's lock, s.
    pub waiting: f64,
}

/// Replays regions, one after the other, on a number of workers. `memory` is the time that the memory needs for the bytes of a sweep, over
/// its traced time.
///
/// # Panics
/// If there is no worker.
pub fn replay<'a>(
    regions: impl IntoIterator<Item = &'a Region>,
    scheduler: Scheduler,
    machine: &Machine,
    memory: f64,
    workers: usize,
) -> Replayed {
    assert!(workers > 0, "a replay needs a worker");
    let mut done = Replayed::default();
    for Region { phase, tasks } in regions {
        let traced: f64 = tasks.iter().sum();
        let [seconds, waiting] = if tasks.len() < 2 || workers == 1 || scheduler == Scheduler::Serial {
            let queued = scheduler == Scheduler::CentralQueue && tasks.len() > 1;
            let pops = if queued { tasks.len() as f64 } else { 0.0 };
            [machine.duration_factor * traced + pops * machine.costs.pop_alone, 0.0]
        } else {
            let [seconds, waiting] = machine.share(tasks, scheduler, workers);
            let least = if *phase == Phase::Sweep { memory * traced } else { 0.0 };
            [seconds.max(least), waiting]
        };
        done.seconds += seconds;
        done.waiting += waiting;
        if *phase == Phase::Sweep {
            done.sweep_seconds += seconds;
        }
    }
    done
}

/// Memory bandwidth, bytes/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bandwidth {
    /// Bandwidth of one thread.
    pub one_thread: f64,
    /// Bandwidth of one thread per core.
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

/// Multiplications of one trial of the clock, and cycles of each in a dependent chain: values for 64-bit integers on Intel's processors
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
    f64::from(MULTIPLICATIONS) * MULTIPLICATION_CYCLES
        / quantile(FASTEST, || Some(seconds_of(chain))).unwrap_or(f64::NAN)
}

/// Batches of a cost measurement, and trials per batch. Batches are separated in time, so that another program on a core affects some
/// and not all.
const BATCHES: usize = 30;
const TRIALS: usize = 10;
/// Fraction of the trials that are at most as slow as the cost itself; the others contain the load of the machine.
const FASTEST: f64 = 0.1;
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
        let of_region = |tasks: usize| {
            alone.install(|| quantile(FASTEST, || Some(seconds_of(|| empty(tasks))))).unwrap_or_default()
        };
        let (region, many) = (of_region(2), of_region(MANY));
        let pop_alone = quantile(FASTEST, || pop_seconds(1)).unwrap_or_default();
        let task_start = ((many - region) / (MANY - 2) as f64).max(0.0);
        let mut costs = Costs { pop_alone, pop_contended: USUAL_CONTENDED_POP, task_start, steal: USUAL_STEAL, region };
        if threads > 1 {
            if let Some(contended) = quantile(0.5, || pop_seconds(threads.min(4))) {
                costs.pop_contended = contended.max(pop_alone);
            }
            // Two long tasks on two threads take as long as one, plus waking the other thread and stealing.
            if let Some(two) = pool(2)?.install(|| quantile(FASTEST, pair_seconds)) {
                costs.steal = (two - LONG_TASK - region).max(0.0);
            }
        }
        Ok(costs)
    }
}

/// Quantile of the results of many trials, without failed ones. None if all failed.
fn quantile(fraction: f64, trial: impl Fn() -> Option<f64>) -> Option<f64> {
    let mut all = Vec::with_capacity(BATCHES * TRIALS);
    for _ in 0..BATCHES {
        std::thread::sleep(PAUSE);
        // The first trials wake the threads.
        for _ in 0..2 {
            trial();
        }
        all.extend((0..TRIALS).filter_map(|_| trial()));
    }
    all.sort_by(f64::total_cmp);
    all.get((fraction * all.len() as f64) as usize).copied()
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

/// Time between two pops of the solver's queue by a number of threads, s; none if one of the threads got hardly any, and so
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
