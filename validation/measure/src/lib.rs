//! Observables of recordings, and the statistics for their validation.

pub mod observables;
pub mod statistics;
