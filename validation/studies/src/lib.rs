//! Studies of the solver for its developers: accuracy over time, convergence, scaling, effects, single contact problems.

pub mod convergence;
pub mod effects;
pub mod parameter_study;
pub mod problem;
pub mod scaling;
pub mod tradeoff;
