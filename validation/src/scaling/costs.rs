//! What handing out work costs on this machine, and what its memory delivers: measured apart from the solver, so that a
//! replay predicts a measurement and is not fitted to it.

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;
use std::collections::VecDeque;
use std::hint::{black_box, spin_loop};
use std::sync::{Barrier, Mutex};
use std::time::{Duration, Instant};

/// Times of handing out work, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Costs {
    /// A pop from the central queue by a worker that has it to itself.
    pub pop_alone: f64,
    /// A pop while other workers want the lock too: how often a second it can change hands.
    pub pop_contended: f64,
    /// Beginning a task of one's own.
    pub task_start: f64,
    /// Taking tasks from another worker.
    pub steal: f64,
    /// Opening and closing a region.
    pub region: f64,
}

/// How often each of these measurements is taken; the median counts.
const TRIALS: usize = 15;
/// Pops of one trial.
const POPS: usize = 20_000;
/// Regions of one trial.
const REGIONS: usize = 200;
/// A task long enough to be stolen, s.
const LONG_TASK: f64 = 50e-6;

impl Costs {
    /// Measures on up to `threads` threads; about a second.
    ///
    /// # Errors
    /// What the system said, if it starts no threads.
    pub fn measure(threads: usize) -> Result<Costs, rayon::ThreadPoolBuildError> {
        let alone = pool(1)?;
        let pop_alone = median((0..TRIALS).map(|_| pop_seconds(1)));
        let tasks = 1000;
        let empty = |count: usize| {
            (0..count).into_par_iter().with_max_len(1).for_each(|task| {
                black_box(task);
            })
        };
        let region = median((0..TRIALS).map(|_| alone.install(|| seconds_of(REGIONS, || empty(2)))));
        let many = median((0..TRIALS).map(|_| alone.install(|| seconds_of(REGIONS / 10, || empty(tasks)))));
        let task_start = ((many - region) / (tasks - 2) as f64).max(0.0);
        let mut costs = Costs { pop_alone, pop_contended: pop_alone, task_start, steal: 0.0, region };
        if threads > 1 {
            costs.pop_contended = median((0..TRIALS).map(|_| pop_seconds(threads.min(4)))).max(pop_alone);
            // Two long tasks on two threads take as long as one, and what it costs to wake the other thread and to steal.
            let pair = pool(2)?;
            let long = |count: usize| (0..count).into_par_iter().with_max_len(1).for_each(|_| spin(LONG_TASK));
            let two = median((0..TRIALS).map(|_| pair.install(|| seconds_of(REGIONS / 4, || long(2)))));
            costs.steal = (two - LONG_TASK - region).max(0.0);
        }
        Ok(costs)
    }
}

fn pool(threads: usize) -> Result<ThreadPool, rayon::ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(threads).build()
}

/// Median of a few numbers; not a number if there are none.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    match (values.len(), values.len() / 2) {
        (0, _) => f64::NAN,
        (length, middle) if length % 2 == 1 => values[middle],
        (_, middle) => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// Time of one of a number of calls, s.
fn seconds_of(calls: usize, call: impl Fn()) -> f64 {
    let clock = Instant::now();
    for _ in 0..calls {
        call();
    }
    clock.elapsed().as_secs_f64() / calls as f64
}

fn spin(seconds: f64) {
    let (clock, length) = (Instant::now(), Duration::from_secs_f64(seconds));
    while clock.elapsed() < length {
        spin_loop();
    }
}

/// Time between two pops of one locked queue that a number of threads empty, s.
fn pop_seconds(threads: usize) -> f64 {
    let queue: Mutex<VecDeque<usize>> = Mutex::new((0..POPS).collect());
    let barrier = Barrier::new(threads);
    let drain = || {
        barrier.wait();
        let clock = Instant::now();
        // A worker lets go of the lock before it works on what it popped.
        while let Some(task) = queue.lock().map_or(None, |mut queue| queue.pop_front()) {
            black_box(task);
        }
        clock.elapsed().as_secs_f64()
    };
    let longest = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(drain)).collect();
        let own = drain();
        others.into_iter().filter_map(|other| other.join().ok()).fold(own, f64::max)
    });
    longest / POPS as f64
}

/// What the memory delivers, bytes/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bandwidth {
    /// To one thread.
    pub one_thread: f64,
    /// To a thread on each core.
    pub all_threads: f64,
    /// Number of cores.
    pub threads: usize,
}

/// Doubles in each of three arrays; well beyond the last-level cache of most machines.
const TRIAD_LENGTH: usize = 16 << 20;

impl Bandwidth {
    /// Measures with a triad, a = b + s c, counted as three arrays (what is fetched before it is overwritten is left out).
    ///
    /// # Errors
    /// What the system said, if it starts no threads.
    pub fn measure(threads: usize) -> Result<Bandwidth, rayon::ThreadPoolBuildError> {
        let (b, c) = (vec![1.0; TRIAD_LENGTH], vec![2.0; TRIAD_LENGTH]);
        let mut a = vec![0.0; TRIAD_LENGTH];
        let mut best = |threads: usize| -> Result<f64, rayon::ThreadPoolBuildError> {
            let pool = pool(threads)?;
            let piece = TRIAD_LENGTH / threads;
            let mut shortest = f64::INFINITY;
            for _ in 0..6 {
                let clock = Instant::now();
                pool.install(|| {
                    (a.par_chunks_mut(piece).zip(b.par_chunks(piece)).zip(c.par_chunks(piece))).for_each(
                        |((a, b), c)| {
                            for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                                *a = b + 3.0 * c;
                            }
                        },
                    );
                });
                shortest = shortest.min(clock.elapsed().as_secs_f64());
            }
            black_box(&a);
            Ok((3 * TRIAD_LENGTH * size_of::<f64>()) as f64 / shortest)
        };
        let one_thread = best(1)?;
        let all_threads = if threads > 1 { best(threads)? } else { one_thread };
        Ok(Bandwidth { one_thread, all_threads, threads })
    }

    /// What all cores together get, if they get less than three quarters of what as many times one would: then they
    /// exhaust the memory. Otherwise its limit lies beyond them, and is not known.
    pub fn ceiling(&self) -> Option<f64> {
        (self.threads > 1 && self.all_threads < 0.75 * self.threads as f64 * self.one_thread)
            .then_some(self.all_threads)
    }
}

/// Last-level cache of this machine, bytes; 0 where the system does not tell.
pub fn cache_bytes() -> u64 {
    let size = |index: usize| {
        let text = std::fs::read_to_string(format!("/sys/devices/system/cpu/cpu0/cache/index{index}/size")).ok()?;
        let text = text.trim();
        match text.strip_suffix('K') {
            Some(kilobytes) => Some(kilobytes.parse::<u64>().ok()? << 10),
            None => Some(text.strip_suffix('M')?.parse::<u64>().ok()? << 20),
        }
    };
    (0..8).filter_map(size).max().unwrap_or(0)
}

/// Clock where the system does not tell, Hz.
const USUAL_CLOCK: f64 = 3e9;

/// Clock of this machine's cores as the system tells it, Hz.
pub fn clock() -> f64 {
    let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let clocks =
        information.lines().filter_map(|line| line.strip_prefix("cpu MHz")?.split(':').nth(1)?.trim().parse().ok());
    clocks
        .fold(None, |most: Option<f64>, megahertz: f64| Some(most.map_or(megahertz, |m| m.max(megahertz))))
        .map_or(USUAL_CLOCK, |megahertz| 1e6 * megahertz)
}
