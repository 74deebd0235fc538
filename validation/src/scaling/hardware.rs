//! What this machine's memory, caches and cores give a replay: measured, or told by the system.

use super::costs::{PAUSE, fastest, pool};
use crate::execution::MeasureError;
use rayon::prelude::*;
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

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

/// How often a triad is run; the fastest counts.
const TRIADS: usize = 12;
/// Doubles in each of three arrays; well beyond the last-level cache of most machines.
const TRIAD_LENGTH: usize = 16 << 20;

impl Bandwidth {
    /// Measures with a triad, a = b + s c, counted as three arrays (what is fetched before it is overwritten is left out).
    ///
    /// # Errors
    /// [`MeasureError`] if the system starts no threads.
    pub fn measure(threads: usize) -> Result<Bandwidth, MeasureError> {
        let (b, c) = (vec![1.0; TRIAD_LENGTH], vec![2.0; TRIAD_LENGTH]);
        let mut a = vec![0.0; TRIAD_LENGTH];
        let mut best = |threads: usize| -> Result<f64, MeasureError> {
            let pool = pool(threads)?;
            let piece = TRIAD_LENGTH / threads;
            let mut shortest = f64::INFINITY;
            for _ in 0..TRIADS {
                std::thread::sleep(PAUSE);
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

/// Multiplications of one trial of the clock, and cycles of each where it waits for the one before: those of 64-bit integers on
/// Intel's processors since Nehalem and on AMD's since Zen (A. Fog, *Instruction tables*).
const MULTIPLICATIONS: u32 = 100_000;
const MULTIPLICATION_CYCLES: f64 = 3.0;

/// Clock at which this machine's cores work, Hz, by a chain of multiplications. What the system tells is the clock of its time stamps on
/// many virtual machines.
pub fn clock() -> f64 {
    let seconds = fastest(|| {
        let mut number = black_box(3_u64);
        for _ in 0..MULTIPLICATIONS {
            number = number.wrapping_mul(number);
        }
        black_box(number);
    });
    f64::from(MULTIPLICATIONS) * MULTIPLICATION_CYCLES / seconds
}
