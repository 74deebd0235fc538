//! What several tests of the judge start from.

pub mod beds;
pub mod sample;
pub mod scaling_sample;
pub mod turn;
