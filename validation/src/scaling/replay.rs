//! The replay: what a traced step would take on P workers, by simulating who takes which task when.
//!
//! ```text
//! region  |--wake--| worker 0: pop task     pop task          |  a region ends when its last task does,
//!                    worker 1: .... pop task            pop ...|  and the next one begins
//!                              (waits for the lock)
//! ```
//!
//! - A region of one task is serial work: it runs on one worker that has its core to itself, and costs nothing besides.
//! - One worker does every task in turn; only the central queue costs it something, a pop a task.
//! - Several workers pay [`Costs::region`] for a region of several tasks. They come to it by stealing, so worker i begins
//!   after log2(i + 1) steals, rounded up. Workers beyond the number of tasks stay idle and leave their core to others.
//! - **Central queue:** a free worker takes the lock, first come first served, for one pop, and runs what it popped.
//! - **Work stealing:** the tasks are split among the workers as stretches, down to single tasks. A worker with nothing left
//!   steals the later half of what the fullest has.
//! - **Memory:** running tasks ask for bytes at a fixed rate. Where all of them ask for more than the memory delivers, all
//!   are slowed alike (processor sharing). As the slow-down is common, the ends of running tasks stay in order, and one
//!   clock of work done, that runs slower than time, says when they come.
//!
//! The worker that the fullest is found by is an ideal thief, and no task disturbs another's cache: a replay is a bound of
//! what the scheduler can do, not a forecast of noise.

use super::costs::Costs;
use super::machine::Machine;
use makadam::schedule::{Phase, Region, Scheduler};
use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, VecDeque};

/// Memory traffic of a running task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traffic {
    /// Bytes/s that a task of a sweep asks for on a thread that has its core to itself, on the machine of the replay.
    pub bytes_per_second: f64,
    /// Bytes/s that the memory delivers.
    pub ceiling: f64,
}

/// What a replay gives.
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
            let mut floor = Floor::new(region, scheduler, machine, traffic, &speeds);
            let seconds = floor.run();
            done.waiting += floor.waiting;
            seconds
        };
        done.seconds += seconds;
        if region.phase == Phase::Sweep {
            done.sweep_seconds += seconds;
        }
    }
    done
}

/// A time that heaps can order.
#[derive(Clone, Copy, PartialEq)]
struct Moment(f64);

impl Eq for Moment {}

impl PartialOrd for Moment {
    fn partial_cmp(&self, other: &Moment) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Moment {
    fn cmp(&self, other: &Moment) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// What a worker does next, without using memory: ask for work, or begin a task.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Next {
    Ask,
    Begin(usize),
}

/// One region while it is worked on.
struct Floor<'a> {
    tasks: &'a [f64],
    costs: Costs,
    factor: f64,
    speeds: &'a [f64],
    traffic: Option<Traffic>,
    work: Work,
    time: f64,
    /// Clock of work done: what a worker of speed 1 has done since the region began, s.
    done: f64,
    /// Speeds of the running workers, summed.
    running: f64,
    /// What workers do next, by time.
    soon: BinaryHeap<Reverse<(Moment, usize, Next)>>,
    /// Ends of running tasks, by the clock of work done.
    ends: BinaryHeap<Reverse<(Moment, usize)>>,
    waiting: f64,
}

/// Where tasks wait.
enum Work {
    Queue {
        next: usize,
        free_at: f64,
    },
    /// One a worker, and how many tasks they hold together.
    Deques(Vec<VecDeque<usize>>, usize),
}

impl<'a> Floor<'a> {
    fn new(
        region: &'a Region,
        scheduler: Scheduler,
        machine: &Machine,
        traffic: Option<Traffic>,
        speeds: &'a [f64],
    ) -> Floor<'a> {
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
            soon.push(Reverse((Moment(costs.region + late), worker, Next::Ask)));
        }
        Floor {
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

    /// Works until every task is done; returns the time of the last end.
    fn run(&mut self) -> f64 {
        let mut left = self.tasks.len();
        while left > 0 {
            let rate = self.rate();
            let end = self.ends.peek().map(|Reverse((end, _))| self.time + (end.0 - self.done).max(0.0) / rate);
            let next = self.soon.peek().map(|Reverse((moment, ..))| moment.0);
            // An end goes first: the worker that it frees asks before one that comes at the same time.
            if end.is_some_and(|end| next.is_none_or(|next| end <= next)) {
                let Some(Reverse((at, worker))) = self.ends.pop() else { break };
                self.advance(end.unwrap_or(self.time), rate);
                self.done = self.done.max(at.0);
                self.running -= self.speeds[worker];
                left -= 1;
                self.ask(worker);
            } else {
                let Some(Reverse((moment, worker, what))) = self.soon.pop() else { break };
                self.advance(moment.0, rate);
                match what {
                    Next::Ask => self.ask(worker),
                    Next::Begin(task) => self.begin(worker, task),
                }
            }
        }
        self.time
    }

    /// How fast the clock of work done runs: 1, or less where the running tasks ask for more than the memory delivers.
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
        self.ends.push(Reverse((Moment(self.done + self.factor * self.tasks[task] / speed), worker)));
    }

    /// A free worker looks for a task; it leaves the region if there is none.
    fn ask(&mut self, worker: usize) {
        let (now, costs) = (self.time, self.costs);
        match &mut self.work {
            Work::Queue { next, free_at } => {
                if *next < self.tasks.len() {
                    let locked = free_at.max(now);
                    self.waiting += locked - now;
                    *free_at = locked + costs.pop_contended;
                    self.soon.push(Reverse((Moment(*free_at), worker, Next::Begin(*next))));
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
                    self.soon.push(Reverse((Moment(now + cost), worker, Next::Begin(task))));
                }
            }
        }
    }
}
