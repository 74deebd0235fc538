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
pub mod interrupt;
pub mod lanes;
mod ledger;
pub mod methods;
pub mod partition;
pub mod probe;
pub mod scene;
pub mod schedule;
mod setting_error;
mod simulation;
pub mod snapshot;
mod solution_error;
pub mod solve;
pub mod sweep;
mod swept;
pub mod watch;
pub mod world;

pub use convergence::{ConvergencePoint, UnsuitableMethod};
pub use energy::Energy;
pub use interrupt::Interrupt;
pub use ledger::Balance;
pub use setting_error::{Obstacle, SettingError};
pub use simulation::{PhaseSeconds, Simulation, StepReport};
pub use solution_error::SolutionError;
pub use swept::Crossing;

/// What tells this build from every other one whose bits may be others: the version and, behind a dash, 16 hexadecimal digits of a
/// hash over the sources of the solver and the packages that compute. Builds of the same sources have the same, wherever and
/// however they are made, and give the same bits; whatever keeps states or results to go on from keeps this with them.
pub const BUILD: &str = concat!(env!("CARGO_PKG_VERSION"), "-", env!("MAKADAM_BUILD_KEY"));
