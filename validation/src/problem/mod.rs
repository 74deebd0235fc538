//! Contact problems in files, solved again by every solver that there is.
//!
//! ```text
//! Simulation ─> ContactProblem ─> write ─> file.hdf5 ─> read ─> solve, check ─> answers side by side
//! ```
//!
//! The layout of files is told in `solver/docs/problem.md`.

mod check;
mod dataset;
mod pose;
mod read;
mod recorded;
mod siconos;
mod words;
mod write;

pub use check::{AGREEMENT, Answer, Check, FromSiconos, Method, Settings, check, solve};
pub use pose::{Posed, pose};
pub use read::{ProblemFileError, parse, read, solution};
pub use recorded::{RECORDED, Recorded, SICONOS};
pub use siconos::{SiconosError, version as siconos_version};
pub use words::{table, words};
pub use write::{bytes, write};

use makadam::problem::{ContactProblem, LocalProblem};
use nalgebra::Vector3;

/// What a file holds of one contact problem.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProblemFile {
    /// What it is, in a line.
    pub title: String,
    /// The problem with its bodies; absent in files of others, which have the reduced problem alone.
    pub contact: Option<ContactProblem>,
    /// The problem reduced to its contacts; absent where contacts bear torques, which it has no place for.
    pub local: Option<LocalProblem>,
    /// What the simulation's own sweeps over lanes come to.
    pub lanes: Option<BodyVelocities>,
}

/// Velocities of all bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyVelocities {
    /// Of their centres, m/s.
    pub velocities: Vec<Vector3<f64>>,
    /// Angular, rad/s.
    pub spins: Vec<Vector3<f64>>,
}

impl ProblemFile {
    /// The file of a problem.
    pub fn new(title: &str, contact: ContactProblem, lanes: Option<BodyVelocities>) -> ProblemFile {
        let local = (!contact.resists_turning()).then(|| contact.local());
        ProblemFile { title: title.into(), contact: Some(contact), local, lanes }
    }

    /// Number of contacts that may bear something.
    pub fn contacts(&self) -> usize {
        match (&self.contact, &self.local) {
            (Some(contact), _) => contact.contacts.iter().filter(|contact| contact.bears()).count(),
            (None, Some(local)) => local.offset.len(),
            (None, None) => 0,
        }
    }
}
