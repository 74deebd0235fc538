//! Contact problems in files, solved again by every available solver.
//!
//! ```text
//! Simulation ─> ContactProblem ─> write ─> file.hdf5 ─> read ─> solve, check ─> answers of all solvers
//! ```
//!
//! The layout of files is documented in `solver/docs/problem.md`.

mod check;
mod file;
mod siconos;

pub use check::{AGREEMENT, Answer, Check, FromSiconos, Method, Settings, check, solve, table};
pub use file::{ProblemFileError, bytes, parse, read, solution, write};
pub use siconos::{RECORDED, Recorded, SICONOS, SiconosError, version as siconos_version};

use makadam::Simulation;
use makadam::problem::{ContactProblem, LocalProblem};
use makadam::scene::Stop;
use makadam::solve::StopReason;
use nalgebra::Vector3;

/// Content of a file of one contact problem.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProblemFile {
    /// Title.
    pub title: String,
    /// Problem with its bodies; absent in files of other programs, which have the reduced problem alone.
    pub contact: Option<ContactProblem>,
    /// Problem reduced to its contacts; absent where contacts transmit torques, which it cannot represent.
    pub local: Option<LocalProblem>,
    /// Answer of the simulation's own sweeps over lanes.
    pub lanes: Option<BodyVelocities>,
}

/// Velocities of all bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyVelocities {
    /// Velocities of their centres, m/s.
    pub velocities: Vec<Vector3<f64>>,
    /// Angular velocities, rad/s.
    pub spins: Vec<Vector3<f64>>,
}

impl ProblemFile {
    /// Returns the file of a problem.
    pub fn new(title: &str, contact: ContactProblem, lanes: Option<BodyVelocities>) -> ProblemFile {
        let local = (!contact.resists_turning()).then(|| contact.local());
        ProblemFile { title: title.into(), contact: Some(contact), local, lanes }
    }

    /// Number of contacts that may be active.
    pub fn contacts(&self) -> usize {
        match (&self.contact, &self.local) {
            (Some(contact), _) => contact.contacts.iter().filter(|contact| contact.bears()).count(),
            (None, Some(local)) => local.offset.len(),
            (None, None) => 0,
        }
    }
}

/// Sweeps over lanes end at this residual, over g h.
const LANES: Stop = Stop::Residual { tolerance: 1e-11, max_sweeps: 200_000 };

/// Poses the problem of the next step, with the answer of the sweeps over lanes if they converge; the step is not taken.
pub fn pose(simulation: &Simulation, title: &str) -> ProblemFile {
    let (state, report) = simulation.solution_in_lanes(LANES);
    let answer = BodyVelocities { velocities: state.velocities, spins: state.spins };
    let lanes = (report.reason == StopReason::Residual).then_some(answer);
    ProblemFile::new(title, simulation.contact_problem(), lanes)
}

/// W of a local problem in compressed columns: starts of the columns, rows, values.
fn compressed_columns(local: &LocalProblem) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let mut columns = vec![Vec::new(); 3 * local.offset.len()];
    for block in &local.blocks {
        for column in 0..3 {
            let entries = (0..3).map(|row| (3 * block.row + row, block.values[(row, column)]));
            columns[3 * block.column + column].extend(entries);
        }
    }
    let mut starts = vec![0];
    columns.iter().for_each(|column| starts.push(starts[starts.len() - 1] + column.len()));
    let (rows, values) = columns.into_iter().flatten().unzip();
    (starts, rows, values)
}
