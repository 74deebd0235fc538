//! What handing out work costs on this machine: measured apart from the solver, so that a replay predicts a measurement and is
//! not fitted to it.

use crate::execution::MeasureError;
use crate::statistics::median;
use makadam::schedule::CentralQueue;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;
use std::hint::{black_box, spin_loop};
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering};
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
    /// Share of trials in which a second thread took its task, 0 to 1; low where the machine is busy.
    pub met_share: f64,
}

/// How often each of these measurements is taken: batches, and trials of one batch. Batches lie apart in time, so that
/// another program that holds a core spoils some and not all. Of the trials the fastest tenth counts: what a cost is, not
/// what else the machine does.
const BATCHES: usize = 30;
const TRIALS: usize = 10;
/// Pause before a batch.
pub(super) const PAUSE: Duration = Duration::from_millis(10);
/// How often threads that do not meet are tried again.
const ATTEMPTS: usize = 6;
/// What stands in where no second thread runs, s: the order of what servers take.
const USUAL_CONTENDED_POP: f64 = 25e-9;
const USUAL_STEAL: f64 = 1.5e-6;
/// Pops of one trial.
const POPS: usize = 2_000;
/// Tasks of a region of many.
const MANY: usize = 1_000;
/// A task long enough to be stolen, s.
const LONG_TASK: f64 = 50e-6;

impl Costs {
    /// Measures on up to `threads` threads; about two seconds.
    ///
    /// # Errors
    /// [`MeasureError`] if the system starts no threads.
    pub fn measure(threads: usize) -> Result<Costs, MeasureError> {
        let empty = |count: usize| {
            (0..count).into_par_iter().with_max_len(1).for_each(|task| {
                black_box(task);
            });
        };
        let alone = pool(1)?;
        let region = alone.install(|| fastest(|| empty(2)));
        let many = alone.install(|| fastest(|| empty(MANY)));
        let pop_alone = tenth(trials(|| pop_seconds(1)).into_iter().flatten().collect()).unwrap_or_default();
        let mut costs = Costs {
            pop_alone,
            pop_contended: USUAL_CONTENDED_POP,
            task_start: ((many - region) / (MANY - 2) as f64).max(0.0),
            steal: USUAL_STEAL,
            region,
            met_share: 0.0,
        };
        if threads > 1 {
            let pops = || trials(|| pop_seconds(threads.min(4)));
            if let (_, Some(contended)) = until_met(pops, |pops| median(pops.iter().copied())) {
                costs.pop_contended = contended.max(pop_alone);
            }
            // Two long tasks on two threads take as long as one, and what it costs to call the other thread and to steal.
            let two = pool(2)?;
            let (share, seconds) = two.install(|| until_met(|| trials(pair_seconds), |two| tenth(two.to_vec())));
            costs.met_share = share;
            costs.steal = seconds.flatten().map_or(USUAL_STEAL, |two| (two - LONG_TASK - region).max(0.0));
        }
        Ok(costs)
    }

    /// Whether a second thread mostly took part in a short region: otherwise it is slow to wake, or the cores are busy.
    pub fn threads_met(&self) -> bool {
        self.met_share > 0.5
    }
}

/// Takes a measurement often.
fn trials<T>(mut trial: impl FnMut() -> T) -> Vec<T> {
    let mut all = Vec::with_capacity(BATCHES * TRIALS);
    for _ in 0..BATCHES {
        std::thread::sleep(PAUSE);
        // The first trials wake the threads.
        for _ in 0..2 {
            trial();
        }
        all.extend((0..TRIALS).map(|_| trial()));
    }
    all
}

/// Measures on several threads, again if they hardly met: another program may hold a core for a while. Gives the share of
/// trials in which they met, and what is made of those trials, if there are any.
fn until_met<T>(mut measure: impl FnMut() -> Vec<Option<f64>>, make: impl Fn(&[f64]) -> T) -> (f64, Option<T>) {
    let (mut met, mut all) = (Vec::new(), 0);
    for _ in 0..ATTEMPTS {
        let trials = measure();
        all += trials.len();
        met.extend(trials.into_iter().flatten());
        if 10 * met.len() >= all {
            break;
        }
    }
    (met.len() as f64 / all as f64, (!met.is_empty()).then(|| make(&met)))
}

/// Where the fastest tenth ends; none without trials.
fn tenth(mut times: Vec<f64>) -> Option<f64> {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 10).copied()
}

/// What a call takes, s: the fastest tenth of many.
pub(super) fn fastest(call: impl Fn()) -> f64 {
    tenth(trials(|| seconds_of(&call))).unwrap_or_default()
}

pub(super) fn pool(threads: usize) -> Result<ThreadPool, MeasureError> {
    Ok(ThreadPoolBuilder::new().num_threads(threads).build()?)
}

fn seconds_of(call: impl Fn()) -> f64 {
    let clock = Instant::now();
    call();
    clock.elapsed().as_secs_f64()
}

fn spin(seconds: f64) {
    let (clock, length) = (Instant::now(), Duration::from_secs_f64(seconds));
    while clock.elapsed() < length {
        spin_loop();
    }
}

/// Time of two long tasks on two threads, s. None if one thread did both.
fn pair_seconds() -> Option<f64> {
    let done_by = [const { AtomicUsize::new(0) }; 2];
    let seconds = seconds_of(|| {
        (0..2).into_par_iter().with_max_len(1).for_each(|task: usize| {
            done_by[task].store(rayon::current_thread_index().unwrap_or_default(), Ordering::Relaxed);
            spin(LONG_TASK);
        });
    });
    let [first, second] = done_by.map(AtomicUsize::into_inner);
    (first != second).then_some(seconds)
}

/// Time between two pops of the solver's queue that a number of threads empty, s. None if one of the threads got hardly
/// anything: then it did not run at the same time.
fn pop_seconds(threads: usize) -> Option<f64> {
    let queue = CentralQueue::new(POPS);
    let barrier = Barrier::new(threads);
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
