//! Why a simulation cannot be carried out, or solved, as was asked.

use super::{Precision, SolverMethod};
use crate::lanes::InstructionSet;

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
    #[error("contacts that bear torques against rolling or twisting")]
    Torques,
    /// A force or a torque drives a wall.
    #[error("driven walls")]
    DrivenWalls,
    /// Contacts that stick have a tangential spring.
    #[error("tangential springs")]
    TangentialSpring,
    /// The solves go by another method.
    #[error("methods other than gauss-seidel")]
    Method,
    /// The sweeps are in single precision.
    #[error("single precision")]
    SinglePrecision,
}

impl Obstacle {
    /// What goes with Gauss-Seidel in double precision alone, of what a scene has.
    pub(crate) fn of_scene(torques: bool, driven_walls: bool, spring: bool) -> Option<Obstacle> {
        let torques = torques.then_some(Obstacle::Torques);
        torques.or(driven_walls.then_some(Obstacle::DrivenWalls)).or(spring.then_some(Obstacle::TangentialSpring))
    }
}

/// Whether a method goes with a precision and with what a scene has: Gauss-Seidel does with all of it. Methods that combine states
/// need them in double precision, and only sweeps in double precision relax torques and driven walls.
pub(crate) fn method_goes_with(
    method: SolverMethod,
    precision: Precision,
    of_scene: impl FnOnce() -> Option<Obstacle>,
) -> Result<(), SettingError> {
    if method == SolverMethod::GaussSeidel {
        return Ok(());
    }
    let single = (precision == Precision::Single).then_some(Obstacle::SinglePrecision);
    of_scene().or(single).map_or(Ok(()), |obstacle| Err(SettingError::Method { method, obstacle }))
}

/// Whether a precision goes with a method and with what a scene has, by the same rule.
pub(crate) fn precision_goes_with(
    precision: Precision,
    method: SolverMethod,
    of_scene: impl FnOnce() -> Option<Obstacle>,
) -> Result<(), SettingError> {
    if precision == Precision::Double {
        return Ok(());
    }
    let other = (method != SolverMethod::GaussSeidel).then_some(Obstacle::Method);
    of_scene().or(other).map_or(Ok(()), |obstacle| Err(SettingError::SinglePrecision(obstacle)))
}

fn names(sets: &[InstructionSet]) -> String {
    sets.iter().map(|set| set.name()).collect::<Vec<_>>().join(", ")
}
