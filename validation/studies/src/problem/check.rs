//! One problem solved by every available solver, and the differences of their answers.

use super::siconos::{self, SiconosError};
use super::{BodyVelocities, ProblemFile};
use makadam::direct::DirectError;
use makadam::problem::{ContactProblem, ContactState, LocalProblem, Reference};
use nalgebra::Vector3;
use serde::Serialize;
use std::time::Instant;

/// Solver of problems from files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Projected Gauss-Seidel, one contact after another.
    #[default]
    Reference,
    /// Newton's method with dense matrices, up to 500 contacts.
    Direct,
    /// Sweeps of the simulation itself: their result when the file was written.
    Lanes,
    /// Siconos' projected Gauss-Seidel.
    Siconos,
}

/// Settings of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Largest change of a sweep at which the reference stops, over the problem's unit of velocity.
    pub tolerance: f64,
    /// Most sweeps of the reference.
    pub most_sweeps: u32,
}

impl Settings {
    /// Defaults of `makadam lab problem check`.
    pub const DEFAULT: Settings = Settings { tolerance: 1e-10, most_sweeps: 100_000 };
}

/// Largest difference of velocities between solvers that agree, over the problem's unit of velocity.
pub const AGREEMENT: f64 = 1e-5;

/// Answer of a solver.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Answer {
    pub method: Method,
    /// Sweeps, iterations or Newton steps; unknown for a recorded answer.
    pub iterations: Option<u32>,
    pub converged: bool,
    pub seconds: Option<f64>,
    /// Largest residual of any contact, m/s: the natural map. Unknown without impulses.
    pub residual: Option<f64>,
    /// Largest difference of a velocity from the first answer's, m/s.
    pub velocity_difference: Option<f64>,
    /// Velocities at the contacts in their frames, m/s.
    #[serde(skip)]
    pub contact_velocities: Vec<Vector3<f64>>,
    #[serde(skip)]
    pub bodies: Option<BodyVelocities>,
    /// Impulses in the frames of the contacts that may be active, N s.
    #[serde(skip)]
    pub impulses: Vec<Vector3<f64>>,
}

/// Problem solved by several solvers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Check {
    pub title: String,
    /// Contacts that may be active.
    pub contacts: usize,
    /// Bodies; unknown in a file of FCLIB's local problem alone.
    pub bodies: Option<usize>,
    /// Velocity scale of residuals and differences, m/s.
    pub unit: f64,
    pub answers: Vec<Answer>,
    pub left_out: Vec<String>,
}

impl Check {
    /// Largest difference of velocities, over the unit.
    pub fn difference(&self) -> f64 {
        let differences = self.answers.iter().filter_map(|answer| answer.velocity_difference);
        differences.fold(0.0, f64::max) / self.unit
    }

    /// Returns the reason why a requested solver was omitted, behind its name.
    pub fn why_left_out(&self, method: Method) -> Option<&str> {
        self.left_out.iter().map(String::as_str).find(|why| why.starts_with(method.name()))
    }

    /// Returns true if all answers have converged and their velocities agree within a tolerance over the unit.
    pub fn agrees(&self, tolerance: f64) -> bool {
        self.answers.iter().all(|answer| answer.converged) && self.difference() <= tolerance
    }
}

/// Solves a problem by one solver.
pub fn solve(file: &ProblemFile, method: Method, settings: &Settings) -> Result<Answer, String> {
    let torques = || "contacts bear torques, which it leaves out".to_string();
    let no_bodies = || "the file has FCLIB's local problem alone, without bodies".to_string();
    let start = Instant::now();
    let mut answer = match method {
        Method::Reference => by_reference(file.contact.as_ref().ok_or_else(no_bodies)?, settings),
        Method::Direct => {
            let local = file.local.as_ref().ok_or_else(torques)?;
            let direct = local.direct_solution().map_err(|error: DirectError| error.to_string())?;
            let iterations = Some(direct.newton_steps as u32);
            of_impulses(file, local, direct.impulses, Method::Direct, iterations, Some(direct.residual))
        }
        Method::Lanes => {
            let lanes = file.lanes.clone().ok_or("the file carries no answer of them")?;
            return Ok(Answer { bodies: Some(lanes), ..Answer::of(Method::Lanes) });
        }
        Method::Siconos => {
            let local = file.local.as_ref().ok_or_else(torques)?;
            let found = siconos::solve(local, settings).map_err(|error: SiconosError| error.to_string())?;
            let mut answer = of_impulses(file, local, found.impulses(), Method::Siconos, Some(found.iterations), None);
            answer.converged = found.converged;
            answer.seconds = Some(found.seconds);
            answer
        }
    };
    answer.seconds = answer.seconds.or(Some(start.elapsed().as_secs_f64()));
    Ok(answer)
}

/// Source of the answer of Siconos.
#[derive(Clone, Debug, PartialEq)]
pub enum FromSiconos {
    /// Siconos is omitted.
    Nothing,
    /// Siconos is run.
    Run,
    /// Recorded impulses of Siconos, in the frames of the contacts that may be active, N s.
    Recorded(Vec<Vector3<f64>>),
}

/// Solves a problem by every available solver, Siconos as requested, and compares their answers with the first.
///
/// # Errors
/// [`SiconosError`] if Siconos must be run and is missing.
pub fn check(file: &ProblemFile, settings: &Settings, siconos: &FromSiconos) -> Result<Check, SiconosError> {
    if *siconos == FromSiconos::Run {
        siconos::version()?;
    }
    let (mut answers, mut left_out) = (Vec::new(), Vec::new());
    for method in [Method::Reference, Method::Direct, Method::Lanes, Method::Siconos] {
        let answer = match (method, siconos) {
            (Method::Siconos, FromSiconos::Nothing) => continue,
            (Method::Siconos, FromSiconos::Recorded(impulses)) => recorded(file, impulses),
            _ => solve(file, method, settings),
        };
        match answer {
            Ok(answer) => answers.push(answer),
            Err(why) => left_out.push(format!("{}: {why}", method.name())),
        }
    }
    if let Some((first, others)) = answers.split_first_mut() {
        for other in others {
            other.compare_with(first, file.contact.as_ref());
        }
    }
    let unit = file.contact.as_ref().map_or_else(
        || file.local.as_ref().map_or(1.0, |local| local.offset.iter().map(Vector3::amax).fold(1e-300, f64::max)),
        |contact| contact.unit,
    );
    let bodies = file.contact.as_ref().map(|contact| contact.bodies.len());
    Ok(Check { title: file.title.clone(), contacts: file.contacts(), bodies, unit, answers, left_out })
}

impl Method {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Method::Reference => "reference",
            Method::Direct => "direct",
            Method::Lanes => "lanes",
            Method::Siconos => "siconos",
        }
    }
}

impl Answer {
    fn of(method: Method) -> Answer {
        Answer { method, converged: true, ..Answer::default() }
    }

    fn compare_with(&mut self, first: &Answer, problem: Option<&ContactProblem>) {
        let largest = |one: &[Vector3<f64>], other: &[Vector3<f64>]| {
            one.iter().zip(other).map(|(one, other)| (one - other).amax()).fold(0.0, f64::max)
        };
        self.velocity_difference = match (&self.bodies, &first.bodies, problem) {
            (Some(own), Some(other), Some(problem)) => {
                let spins = largest(&own.spins, &other.spins);
                let arm = problem.contacts.iter().map(|contact| contact.arms[0].norm()).fold(0.0, f64::max);
                Some(largest(&own.velocities, &other.velocities).max(spins * arm))
            }
            _ => Some(largest(&self.contact_velocities, &first.contact_velocities)),
        };
    }
}

fn by_reference(problem: &ContactProblem, settings: &Settings) -> Answer {
    let mut state = problem.start();
    let tolerance = settings.tolerance * problem.unit;
    let reference = Reference { relaxation: 1.3, tolerance, most_sweeps: settings.most_sweeps };
    let ending = problem.solve(&mut state, &reference);
    let bearing = problem.contacts.iter().zip(&state.impulses).filter(|(contact, _)| contact.bears());
    Answer {
        iterations: Some(ending.sweeps),
        converged: ending.converged,
        residual: Some(problem.residuals(&state).max()),
        impulses: bearing.map(|(contact, impulse)| problem.in_frame(contact, impulse)).collect(),
        bodies: Some(velocities_of(state)),
        ..Answer::of(Method::Reference)
    }
}

/// Returns the answer with given impulses of the local problem.
fn of_impulses(
    file: &ProblemFile,
    local: &LocalProblem,
    impulses: Vec<Vector3<f64>>,
    method: Method,
    iterations: Option<u32>,
    residual: Option<f64>,
) -> Answer {
    let state =
        file.contact.as_ref().map(|problem| (problem, problem.state_of(&problem.impulses_of(local, &impulses))));
    let of_state = state.as_ref().map(|(problem, state)| problem.residuals(state).max());
    Answer {
        iterations,
        residual: of_state.or(residual),
        contact_velocities: local.velocities(&impulses),
        bodies: state.map(|(_, state)| velocities_of(state)),
        impulses,
        ..Answer::of(method)
    }
}

/// Returns the recorded answer of Siconos.
fn recorded(file: &ProblemFile, impulses: &[Vector3<f64>]) -> Result<Answer, String> {
    let local = file.local.as_ref().ok_or("the file has no local problem")?;
    match impulses.len() == local.offset.len() {
        true => Ok(of_impulses(file, local, impulses.to_vec(), Method::Siconos, None, None)),
        false => Err(format!("{} impulses are on record for {} contacts", impulses.len(), local.offset.len())),
    }
}

fn velocities_of(state: ContactState) -> BodyVelocities {
    BodyVelocities { velocities: state.velocities, spins: state.spins }
}

/// Formats a check as lines of text.
pub fn table(check: &Check) -> String {
    let mut lines = vec![format!("{}: {} contacts", check.title, check.contacts)];
    for answer in &check.answers {
        let mut line = format!("  {}: ", answer.method.name());
        line += if answer.converged { "converged" } else { "not converged" };
        line += &answer.iterations.map_or(String::new(), |count| format!(" after {count} iterations"));
        line += &answer.residual.map_or(String::new(), |residual| format!(", largest residual {residual:.2e} m/s"));
        line += &answer.seconds.map_or(String::new(), |seconds| format!(", {seconds:.3} s"));
        if let Some(difference) = answer.velocity_difference {
            line += &format!(", velocities {:.1e} of {:.1e} m/s from the first", difference / check.unit, check.unit);
        }
        lines.push(line);
    }
    lines.extend(check.left_out.iter().map(|why| format!("  left out: {why}")));
    lines.join("\n")
}
