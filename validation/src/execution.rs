//! What the command line says of how a simulation is carried out: see [`Execution`].

pub use makadam::Execution;

/// Why nothing was measured.
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
