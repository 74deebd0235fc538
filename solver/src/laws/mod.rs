//! Laws that a scene is read and checked by, and steps go by too: pure functions of numbers.

pub mod cohesion;
pub mod compliance;
pub mod period;
