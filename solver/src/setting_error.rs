//! Why a simulation cannot be carried out, or solved, as was asked.

use crate::lanes::InstructionSet;
use crate::scene::SolverMethod;

/// Why a setting was refused; the simulation stays as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingError {
    /// The processor lacks an instruction set.
    #[error("this processor has no {}; it has {}", wanted.name(), names(available))]
    NoInstructionSet {
        /// What was asked for.
        wanted: InstructionSet,
        /// What there is.
        available: Vec<InstructionSet>,
    },
    /// The scene has what the method has no equations for.
    #[error("method {} does not go with {obstacle}; gauss-seidel does", method.name())]
    Method {
        /// What was asked for.
        method: SolverMethod,
        /// What it does not go with.
        obstacle: Obstacle,
    },
    /// The system gives no more threads.
    #[error("cannot start {threads} threads: {reason}")]
    NoThreads {
        /// What was asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
    /// Sweeps in single precision know nothing of what the scene or the method has.
    #[error("single precision does not go with {0}; double precision does")]
    SinglePrecision(Obstacle),
}

/// What a method, or single precision, does not go with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Obstacle {
    /// Some material has rolling or twisting friction.
    #[error("contacts that resist rolling or twisting")]
    Torques,
    /// A force or a torque drives a wall.
    #[error("driven walls")]
    DrivenWalls,
    /// The solves go by another method.
    #[error("methods other than gauss-seidel")]
    Method,
    /// The sweeps are in single precision.
    #[error("single precision")]
    SinglePrecision,
}

fn names(sets: &[InstructionSet]) -> String {
    sets.iter().map(|set| set.name()).collect::<Vec<_>>().join(", ")
}
