//! Execution options of the command line: see [`Execution`].

pub use makadam::Execution;

/// Reason for a missing measurement.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// Execution unsupported by the machine.
    #[error(transparent)]
    Execution(#[from] makadam::SettingError),
    /// Error of the system at the start of threads.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// Stop request of the user.
    #[error("interrupted while measuring")]
    Interrupted,
}

/// Returns the number of cores available to this process.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Smallest number of grains per thread: with fewer, synchronization costs more time than the thread saves.
const GRAINS_OF_A_THREAD: usize = 1000;

/// Returns the number of threads for a number of grains: all cores, if each has enough work.
pub fn threads_for(grains: usize) -> usize {
    cores().min(grains / GRAINS_OF_A_THREAD).max(1)
}
