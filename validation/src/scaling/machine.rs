//! Machines that a schedule is replayed on: what handing out a task costs there, what threads of one core share, how
//! much the memory delivers.

use super::costs::Costs;
use serde::Serialize;

/// Most workers that a schedule is replayed on.
pub const MOST_WORKERS: usize = 256;

/// A machine, as far as the replay knows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// Short name.
    pub name: String,
    /// Where its constants come from, in sentences.
    pub description: String,
    /// Number of cores; workers are dealt out to them evenly.
    pub cores: usize,
    /// What 1, 2, ... threads of one core get done together, in units of one thread that has the core to itself.
    pub core_throughput: Vec<f64>,
    /// How many times longer a task takes here, on a thread that has a core to itself, than where it was traced.
    pub duration_factor: f64,
    /// What handing out work costs.
    pub costs: Costs,
    /// What the memory delivers, bytes/s.
    pub memory_bytes_per_second: f64,
    /// Threads that share this memory; more of them bring as much more.
    pub threads_a_memory: usize,
    /// Last-level cache, bytes; sweeps that find all that they touch in it are not held up by memory.
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

    /// As many cores as one asks for, each like those of this machine. `memory` is what the cores at hand get and their
    /// number: further cores are taken to bring memory of their own, as further sockets do.
    pub fn here(costs: Costs, memory: (f64, usize), cache_bytes: u64) -> Machine {
        let (bytes, threads) = memory;
        let beyond = match threads < MOST_WORKERS {
            true => format!("; every {threads} more are taken to bring as much memory of their own"),
            false => String::new(),
        };
        Machine {
            name: Machine::HERE.into(),
            description: format!(
                "The machine of the measurement with as many cores as workers, all alike. What handing out a task costs \
                 was measured on the cores at hand. {threads} threads share {:.0} GB/s of memory{beyond}.",
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
    /// and more than two add nothing (they hide latency in truth; that is left out). A task takes longer by the ratio of
    /// the clocks, and twice for the missing cycles. Nothing is charged for in-order stalls, so the model is a fast Phi.
    pub fn xeon_phi_3120(here: &Costs, clock_here: f64) -> Machine {
        let slower = 2.0 * clock_here / PHI_CLOCK;
        let hand_over = LINES_A_HAND_OVER * PHI_LINE_CYCLES / PHI_CLOCK;
        Machine {
            name: Machine::XEON_PHI.into(),
            description: format!(
                "A model of the Xeon Phi 3120: 57 cores of four threads at 1.1 GHz. Assumptions: a task takes {slower:.1} \
                 times longer than where it was traced (the ratio of the clocks, and twice because one thread issues only \
                 every other cycle); two threads of a core do twice the work of one, three and four no more; a lock \
                 changes hands in {:.2} µs ({LINES_A_HAND_OVER} cache lines of {PHI_LINE_CYCLES} cycles over the ring), \
                 and so does a stolen task; the memory delivers 150 of its nominal 240 GB/s.",
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
                met_share: here.met_share,
            },
            memory_bytes_per_second: 150e9,
            threads_a_memory: 57 * 4,
            cache_bytes: 57 * 512 * 1024,
        }
    }

    /// What the memory delivers to a number of workers, bytes/s.
    pub(super) fn ceiling(&self, workers: usize) -> f64 {
        self.memory_bytes_per_second * (workers as f64 / self.threads_a_memory as f64).max(1.0)
    }

    /// Most workers: every thread of every core, but no more than [`MOST_WORKERS`].
    pub fn most_workers(&self) -> usize {
        (self.cores * self.core_throughput.len()).min(MOST_WORKERS)
    }

    /// Speed of each of a number of workers while all of them work, in units of a thread that has a core to itself.
    pub(super) fn speeds(&self, workers: usize) -> Vec<f64> {
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
pub fn worker_counts(most: usize, besides: &[usize]) -> Vec<usize> {
    let usual =
        [1, 2, 3, 4, 6, 8, 10, 12, 14, 16, 20, 25, 28, 32, 40, 48, 57, 64, 80, 96, 114, 128, 160, 192, 228, 256];
    let mut counts: Vec<usize> = usual.into_iter().chain(besides.iter().copied()).filter(|&p| p <= most).collect();
    counts.sort_unstable();
    counts.dedup();
    counts
}
