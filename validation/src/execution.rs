//! What the command line says of how a simulation is carried out: see [`Execution`].

pub use makadam::Execution;

/// Number of cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}
