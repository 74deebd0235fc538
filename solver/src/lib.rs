//! Makadam: granular matter by non-smooth contact dynamics, solved by projected Gauss-Seidel.
//!
//! ```text
//! scene.toml -- scene --> World --+
//!                                 v
//!        +------------------ step ------------------------------+
//!        | detect -> constrain -> partition -> solve -> move    | --> Snapshot, StepReport
//!        |                          sweep, schedule             |
//!        +------------------------------------------------------+
//! ```
//!
//! **Same bits.** A scene and a seed give the same bits on any number of threads, with any scheduler and on any instruction
//! set: boxes, stages and lane groups depend on the scene alone, the lane width of eight is a part of the algorithm, and
//! every lane does the same IEEE operations, without fused multiply-add and without approximate division or roots.

pub mod checkpoint;
pub mod constrain;
mod convergence;
pub mod detect;
pub mod direct;
pub mod effects;
mod energy;
pub mod groups;
pub mod lanes;
mod ledger;
pub mod methods;
pub mod partition;
pub mod probe;
pub mod scene;
pub mod schedule;
mod simulation;
pub mod snapshot;
mod solution_error;
pub mod solve;
pub mod sweep;
pub mod watch;
pub mod world;

pub use convergence::{ConvergencePoint, UnsuitableMethod};
pub use energy::Energy;
pub use ledger::Balance;
pub use simulation::{PhaseSeconds, Simulation, StepReport};
pub use solution_error::SolutionError;
