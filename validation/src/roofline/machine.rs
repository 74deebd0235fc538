//! What the processor's arithmetic and its memories deliver, measured.

use crate::statistics::median;
use makadam::lanes::{Eight, InstructionSet};
use makadam::probe;
use serde::{Deserialize, Serialize};
use std::hint::black_box;
use std::sync::Barrier;
use std::time::Instant;

/// Rounds of each measurement; their median counts.
const ROUNDS: usize = 15;
/// What one round at least moves, bytes a thread.
const LEAST_BYTES: usize = 64 << 20;
/// Multiplications and additions of one round, times the number of chains.
const ARITHMETIC: u64 = 2_000_000;
/// Arrays in memory over the last-level cache.
const BEYOND: usize = 8;
/// Last-level cache where the system does not tell, bytes.
const USUAL_CACHE: usize = 32 << 20;

/// What a number of threads get, each on a core.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Roofs {
    /// Number of threads.
    pub threads: usize,
    /// Instruction set.
    pub instruction_set: String,
    /// Double-precision multiplications and additions a second, not fused.
    pub peak_flops_per_second: f64,
    /// Rates of each memory, innermost first.
    pub levels: Vec<Level>,
    /// Triad in memory, a = b + s c, three arrays counted as STREAM does, bytes/s.
    pub triad_bytes_per_second: f64,
    /// Copy in memory, two arrays counted, bytes/s.
    pub copy_bytes_per_second: f64,
}

/// A cache, or the memory behind all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// Its name: `L2`, `L3`, `memory`.
    pub name: String,
    /// What it holds for all threads together, bytes; nothing for the memory.
    pub holds_bytes: Option<usize>,
    /// Working set of the measurement, bytes.
    pub working_set_bytes: usize,
    /// Update in place, a = a + s b, three streams counted, all of which are moved, bytes/s.
    pub bytes_per_second: f64,
}

/// A data cache as the system tells it.
struct Cache {
    level: u32,
    bytes: usize,
    shared: bool,
}

impl Roofs {
    /// Measures; a few seconds.
    pub fn measure(set: InstructionSet, threads: usize) -> Roofs {
        let caches = caches();
        let last = caches.last().map_or(USUAL_CACHE, |cache| cache.bytes);
        // Sweeps stream lane groups, so no working set lives in a first-level cache.
        let inner = caches.iter().filter(|cache| cache.level > 1).map(|cache| {
            let holds = if cache.shared { cache.bytes } else { threads * cache.bytes };
            (format!("L{}", cache.level), Some(holds), holds / 2)
        });
        let levels = inner.chain([("memory".to_string(), None, BEYOND * last)]);
        Roofs {
            threads,
            instruction_set: set.name().into(),
            peak_flops_per_second: peak(set, threads),
            levels: levels
                .map(|(name, holds_bytes, working_set_bytes)| Level {
                    name,
                    holds_bytes,
                    working_set_bytes,
                    bytes_per_second: streams::<2>(threads, working_set_bytes, 3, |[a, b]| probe::update(set, a, b)),
                })
                .collect(),
            triad_bytes_per_second: streams::<3>(threads, BEYOND * last, 3, |[a, b, c]| probe::triad(set, a, b, c)),
            copy_bytes_per_second: streams::<2>(threads, BEYOND * last, 2, |[a, b]| a.copy_from_slice(b)),
        }
    }

    /// The memory that a working set lives in: the first that holds it.
    pub fn home_of(&self, bytes: usize) -> Option<&Level> {
        self.levels.iter().find(|level| level.holds_bytes.is_none_or(|holds| bytes <= holds))
    }
}

/// Multiplications and additions a second, with the number of chains that suits the processor best.
fn peak(set: InstructionSet, threads: usize) -> f64 {
    let with = |chains| rate(threads, || (), |()| probe::multiply_and_add(set, chains, ARITHMETIC) as f64);
    (1..=probe::MOST_CHAINS).map(with).fold(0.0, f64::max)
}

/// Bytes a second of a loop over arrays, the threads' arrays together as large as the working set; `counted` of each
/// element's arrays count.
fn streams<const ARRAYS: usize>(
    threads: usize,
    working_set: usize,
    counted: usize,
    work: impl Fn(&mut [Vec<Eight>; ARRAYS]) + Sync,
) -> f64 {
    let length = (working_set / threads / ARRAYS / size_of::<Eight>()).max(1);
    let bytes = counted * length * size_of::<Eight>();
    let times = LEAST_BYTES.div_ceil(bytes);
    let make = || std::array::from_fn(|_| vec![Eight([1.0; 8]); length]);
    rate(threads, make, |arrays| {
        for _ in 0..times {
            work(arrays);
            black_box(&mut *arrays);
        }
        (times * bytes) as f64
    })
}

/// What threads do a second together: the median over rounds. Each thread makes its own state, so that its memory is near
/// to its core, and says how much it did; a round lasts from its first start to its last end.
fn rate<S>(threads: usize, make: impl Fn() -> S + Sync, run: impl Fn(&mut S) -> f64 + Sync) -> f64 {
    let barrier = Barrier::new(threads);
    let one = || {
        let mut state = make();
        // The first round wakes caches and clocks.
        run(&mut state);
        let round = |_| {
            barrier.wait();
            let start = Instant::now();
            let amount = run(&mut state);
            (amount, start, Instant::now())
        };
        (0..ROUNDS).map(round).collect::<Vec<_>>()
    };
    let all = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(one)).collect();
        let own = one();
        others.into_iter().filter_map(|other| other.join().ok()).chain([own]).collect::<Vec<_>>()
    });
    median((0..ROUNDS).map(|round| {
        let rounds = || all.iter().map(|thread| thread[round]);
        let first = rounds().map(|(_, start, _)| start).min();
        let last = rounds().map(|(_, _, end)| end).max();
        let seconds = last.zip(first).map_or(f64::NAN, |(last, first)| (last - first).as_secs_f64());
        rounds().map(|(amount, ..)| amount).sum::<f64>() / seconds
    }))
}

/// Data caches of the first core, innermost first; empty where the system does not tell.
fn caches() -> Vec<Cache> {
    let read = |index: usize, name: &str| {
        let file = format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{name}");
        std::fs::read_to_string(file).ok().map(|text| text.trim().to_string())
    };
    let cache = |index: usize| {
        let size = read(index, "size")?;
        let kilobytes: usize = size.strip_suffix('K')?.parse().ok()?;
        let level = read(index, "level")?.parse().ok()?;
        // Hardware threads of one core share its caches too; those beyond the second level are a processor's.
        (read(index, "type")? != "Instruction").then_some(Cache { level, bytes: kilobytes << 10, shared: level > 2 })
    };
    let mut caches: Vec<Cache> = (0..8).filter_map(cache).collect();
    caches.sort_by_key(|cache| cache.level);
    caches
}
