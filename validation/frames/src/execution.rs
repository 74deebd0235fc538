//! Execution options of the command line: see [`Execution`].

pub use makadam::Execution;

/// Reason for which nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// The machine cannot step as asked.
    #[error(transparent)]
    Execution(#[from] makadam::SettingError),
    /// The system starts no threads to measure with.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The user asked to stop.
    #[error("interrupted while measuring")]
    Interrupted,
}

/// Number of cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Grains below which another thread costs more than it brings: its share of a step is over before the threads have met.
const GRAINS_OF_A_THREAD: usize = 1000;

/// Number of threads for so many grains: as many as there are cores, as long as each has enough to do.
pub fn threads_for(grains: usize) -> usize {
    cores().min(grains / GRAINS_OF_A_THREAD).max(1)
}
