//! The problem of the next step of a simulation, with the answer of its own sweeps.

use super::{BodyVelocities, ProblemFile};
use makadam::Simulation;
use makadam::scene::Stop;
use makadam::solve::StopReason;

/// Sweeps over lanes end at this residual, over g h.
const LANES: Stop = Stop::Residual { tolerance: 1e-11, max_sweeps: 200_000 };

/// A problem that was posed.
pub struct Posed {
    /// The problem, with the answer of the sweeps over lanes where they converged.
    pub file: ProblemFile,
    /// Whether they did.
    pub lanes_converged: bool,
}

/// The problem of the next step, which is not taken.
pub fn pose(simulation: &Simulation, title: &str) -> Posed {
    let (state, report) = simulation.solution_in_lanes(LANES);
    let lanes_converged = report.reason == StopReason::Residual;
    let lanes = lanes_converged.then_some(BodyVelocities { velocities: state.velocities, spins: state.spins });
    Posed { file: ProblemFile::new(title, simulation.contact_problem(), lanes), lanes_converged }
}
