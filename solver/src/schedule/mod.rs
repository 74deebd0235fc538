//! Scheduling of tasks: serial, a central queue, or work stealing. This module is independent of physics.
//!
//! A region is a set of tasks that may run concurrently and in any order; all are complete when the region returns. The
//! division into tasks depends on the scene alone, so that the scheduler never changes a bit of the result.

mod shares;

pub(crate) use shares::{Disjoint, Each, Runs, Shares};

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Instant;

/// Rule for the assignment of tasks to threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheduler {
    /// One thread, task after task.
    Serial,
    /// All threads take tasks from one queue with a lock: the initial version of Rönnbäck's thesis.
    CentralQueue,
    /// Each thread has a queue, and steals from others if its own is empty: the improved version of the thesis.
    #[default]
    WorkStealing,
}

impl Scheduler {
    /// All schedulers.
    pub const ALL: [Scheduler; 3] = [Scheduler::Serial, Scheduler::CentralQueue, Scheduler::WorkStealing];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Scheduler::Serial => "serial",
            Scheduler::CentralQueue => "central-queue",
            Scheduler::WorkStealing => "work-stealing",
        }
    }
}

/// Threads and their scheduler.
#[derive(Clone, Debug, Default)]
pub struct Team {
    scheduler: Scheduler,
    /// Thread pool; absent for one thread.
    pool: Option<Arc<Pool>>,
    /// Record of the durations of tasks; absent unless the team traces.
    tracer: Option<Arc<Mutex<StepTrace>>>,
}

/// Threads of the process that started them; a forked process has none of these threads.
#[derive(Debug)]
struct Pool {
    /// Absent during drop.
    threads: Option<ThreadPool>,
    process: u32,
}

impl Pool {
    fn is_here(&self) -> bool {
        self.process == std::process::id()
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        // A join of threads that do not exist in this process may never return.
        if !self.is_here() {
            std::mem::forget(self.threads.take());
        }
    }
}

impl Team {
    /// Creates a team of n threads, at least one. One thread works serially under any scheduler except the central
    /// queue, which has a measurable cost even for one thread.
    ///
    /// # Errors
    /// The system cannot start more threads.
    pub fn new(scheduler: Scheduler, threads: usize) -> Result<Team, ThreadPoolBuildError> {
        let pool = match (scheduler, threads) {
            (Scheduler::Serial, _) | (_, 0 | 1) => None,
            _ => {
                let threads = Some(ThreadPoolBuilder::new().num_threads(threads).build()?);
                Some(Arc::new(Pool { threads, process: std::process::id() }))
            }
        };
        Ok(Team { scheduler, pool, tracer: None })
    }

    /// Returns a team for this process: with new threads in a forked process, or with one thread if the system provides
    /// none. The bits of results are the same.
    pub(crate) fn here(&self) -> Team {
        match &self.pool {
            Some(pool) if !pool.is_here() => Team::new(self.scheduler, self.threads()).unwrap_or_default(),
            _ => self.clone(),
        }
    }

    fn pool(&self) -> Option<&ThreadPool> {
        self.pool.as_ref()?.threads.as_ref()
    }

    crate::getters! {
        /// Returns the number of threads.
        pub threads: usize = |team| team.pool().map_or(1, ThreadPool::current_num_threads);
        /// Returns the scheduler.
        pub scheduler: Scheduler = |team| team.scheduler;
    }

    /// Runs `work` on a thread of the team, so that its regions start without waking a pool.
    pub(crate) fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match self.pool() {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Runs `task` concurrently for each number below `count`, in any order.
    pub(crate) fn each(&self, phase: Phase, count: usize, task: impl Fn(usize) + Sync) {
        self.trace_each(phase, count, &task);
    }

    /// Distributes tasks, and records their durations if the team traces. Tasks are called by reference, so that Rayon is compiled once.
    fn trace_each(&self, phase: Phase, count: usize, task: &(dyn Fn(usize) + Sync)) {
        let Some(tracer) = &self.tracer else { return self.hand_out(count, task) };
        let seconds: Vec<AtomicU64> = (0..count).map(|_| AtomicU64::new(0)).collect();
        self.hand_out(count, &|number| {
            let clock = Instant::now();
            task(number);
            seconds[number].store(clock.elapsed().as_secs_f64().to_bits(), Ordering::Relaxed);
        });
        let seconds = seconds.into_iter().map(|bits| f64::from_bits(bits.into_inner())).collect();
        record(tracer).regions.push(Region { phase, tasks: seconds });
    }

    /// Runs `task` concurrently for each number below `count`, in any order, each with its part of the memory.
    pub(crate) fn each_with<S: Shares>(
        &self,
        phase: Phase,
        count: usize,
        shares: S,
        task: impl Fn(usize, S::Share) + Sync,
    ) {
        // SAFETY: each number occurs once.
        self.each(phase, count, |number| task(number, unsafe { shares.share(number) }));
    }

    fn hand_out(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        match (self.pool(), self.scheduler) {
            _ if count <= 1 => (0..count).for_each(task),
            (None, Scheduler::CentralQueue) => CentralQueue::new(count).drain(task),
            (None, _) => (0..count).for_each(task),
            (Some(pool), Scheduler::CentralQueue) => {
                let queue = CentralQueue::new(count);
                let workers = pool.current_num_threads().min(count);
                (0..workers).into_par_iter().with_max_len(1).for_each(|_| queue.drain(task));
            }
            (Some(_), _) => (0..count).into_par_iter().with_max_len(1).for_each(task),
        }
    }

    /// Runs work that is not divided into tasks.
    pub(crate) fn alone<R>(&self, phase: Phase, work: impl FnOnce() -> R) -> R {
        let Some(tracer) = &self.tracer else { return work() };
        let clock = Instant::now();
        let result = work();
        record(tracer).regions.push(Region { phase, tasks: vec![clock.elapsed().as_secs_f64()] });
        result
    }

    /// Returns a copy of the team that records the duration of each task.
    pub(crate) fn traced(&self) -> Team {
        Team { tracer: Some(Arc::default()), ..self.clone() }
    }

    /// Returns the records since the last call; empty if the team does not trace.
    pub(crate) fn take_trace(&self) -> StepTrace {
        self.tracer.as_deref().map(|tracer| std::mem::take(&mut *record(tracer))).unwrap_or_default()
    }
}

/// Numbers of the tasks that are not yet assigned.
#[derive(Debug)]
pub struct CentralQueue {
    next: Mutex<usize>,
    count: usize,
}

impl CentralQueue {
    /// Creates a queue of the tasks below `count`.
    pub fn new(count: usize) -> CentralQueue {
        CentralQueue { next: Mutex::new(0), count }
    }

    /// Takes the next task; `None` if the queue is empty.
    pub fn pop(&self) -> Option<usize> {
        let mut next = self.next.lock().expect("nothing panics while it holds the lock");
        let task = *next;
        (task < self.count).then(|| {
            *next += 1;
            task
        })
    }

    /// Takes and runs tasks until the queue is empty.
    pub fn drain(&self, task: &dyn Fn(usize)) {
        while let Some(number) = self.pop() {
            task(number);
        }
    }
}

/// Phase of a time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Candidate list.
    Detect,
    /// Gaps, normals, constraint data, lane groups, warm start.
    Constrain,
    /// Sweeps.
    Sweep,
    /// Forces, motion, storage of impulses.
    Integrate,
}

/// Tasks that may run concurrently; the next region starts when all are complete.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Phase of the region.
    pub phase: Phase,
    /// Duration of each task, s. Undivided work is a region of one task.
    pub tasks: Vec<f64>,
}

/// Regions of a step, in their order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepTrace {
    /// Regions.
    pub regions: Vec<Region>,
}

/// Returns the record of a running step.
fn record(tracer: &Mutex<StepTrace>) -> MutexGuard<'_, StepTrace> {
    tracer.lock().expect("no task panics while it traces")
}
