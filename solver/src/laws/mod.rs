//! Laws for the checks of scenes and for the steps: pure functions of numbers.

pub mod cohesion;
pub mod compliance;
pub mod period;
