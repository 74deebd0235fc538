//! Observables of recordings, and the statistics that judge them.

pub mod observables;
pub mod statistics;
