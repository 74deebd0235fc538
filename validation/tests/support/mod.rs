//! Common parts of tests.

pub mod beds;
pub mod sample;
pub mod scaling_sample;
pub mod schema;
pub mod turn;
