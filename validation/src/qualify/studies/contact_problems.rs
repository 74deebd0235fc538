//! The contact problem of one step by Makadam's sweeps, by two solvers apart from them, and by Siconos, a code of contact dynamics
//! that shares no line with them.
//!
//! A problem is posed anew, by this build. Siconos solves that one where it is run; its answers on record are to problems on record,
//! which Makadam's solvers then solve too.

use super::{Job, Part, Place, QualifyError, test};
use crate::output::write_whole;
use crate::problem::{
    self, AGREEMENT, Answer, Check, FromSiconos, Method, ProblemFile, RECORDED, Recorded, SICONOS, Settings,
    SiconosError, pose, siconos_version,
};
use crate::provenance::JUDGE;
use crate::qualify::jobs::weight;
use crate::report::{StudyOutcome, StudySection, StudyTest};
use crate::stepping::{Stepping, steps_in};
use crate::study::{Key, RunCache};
use makadam::{BUILD, Simulation};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Instant;

/// Seed of the scenes.
const SEED: u64 = 1;

const STUDY: &str = "contact-problems";

pub(super) struct ContactProblems<'a> {
    place: Place<'a>,
    folder: PathBuf,
    kept: RunCache,
    /// Version of Siconos where it is run, or why it is not.
    siconos: Result<String, String>,
    solved: Mutex<Vec<Solved>>,
}

/// What is kept of a problem.
#[derive(Clone, Serialize, Deserialize)]
struct Solved {
    name: String,
    contacts: usize,
    wall_seconds: f64,
    tests: Vec<StudyTest>,
}

impl<'a> ContactProblems<'a> {
    pub(super) fn open(place: Place<'a>) -> Result<ContactProblems<'a>, QualifyError> {
        let folder = place.folder(STUDY);
        let siconos = match place.settings.live {
            true => siconos_version().map_err(|error| format!("Siconos was not run: {error}.")),
            false => Err("Siconos was not run: its answers are those on record.".into()),
        };
        Ok(ContactProblems {
            place,
            kept: RunCache::open(&folder.join("kept"))?,
            folder,
            siconos,
            solved: Mutex::default(),
        })
    }

    fn run(&self, recorded: &Recorded) -> Result<(), QualifyError> {
        let siconos = self.siconos.as_deref().unwrap_or("on record");
        let key = Key::new(recorded.name.into(), &[recorded.name, siconos, BUILD, JUDGE]);
        let again = self.place.settings.again || !self.file(recorded).is_file();
        let solved = self.kept.take(&key, again, || self.solve(recorded))?;
        self.solved.lock().expect("nothing panics while it holds the lock").push(solved);
        Ok(())
    }

    /// Where the problem that is posed now is written.
    fn file(&self, recorded: &Recorded) -> PathBuf {
        self.folder.join(format!("{}.hdf5", recorded.name))
    }

    /// Poses the problem of a scene, and has it solved by every solver there is.
    fn solve(&self, recorded: &Recorded) -> Result<Solved, QualifyError> {
        let clock = Instant::now();
        let posed = self.pose(recorded)?;
        let bytes = problem::bytes(&posed, None).map_err(|error| failed(error.to_string()))?;
        write_whole(&self.file(recorded), &bytes)?;
        let now = match self.siconos {
            Ok(_) => FromSiconos::Run,
            Err(_) => FromSiconos::Nothing,
        };
        let own = check(&posed, &now)?;
        let mut tests = vec![judged(recorded, &own, Method::Direct), judged(recorded, &own, Method::Lanes)];
        tests.push(match &self.siconos {
            Ok(version) => StudyTest {
                remark: Some(format!("Siconos {version}, run live")),
                ..judged(recorded, &own, Method::Siconos)
            },
            Err(_) => {
                let impulses = recorded.siconos().map_err(failed)?;
                let on_record = recorded.problem().map_err(failed)?;
                let with_siconos = check(&on_record, &FromSiconos::Recorded(impulses))?;
                StudyTest {
                    remark: Some(format!("Siconos {SICONOS}, on record")),
                    ..judged(recorded, &with_siconos, Method::Siconos)
                }
            }
        });
        Ok(Solved {
            name: recorded.name.into(),
            contacts: own.contacts,
            wall_seconds: clock.elapsed().as_secs_f64(),
            tests,
        })
    }

    fn pose(&self, recorded: &Recorded) -> Result<ProblemFile, QualifyError> {
        let share = (self.place.settings.announce)(&format!("{} contact problem", recorded.name));
        let scene = recorded.scene().map_err(|error| failed(error.to_string()))?;
        let mut simulation = Simulation::new(&scene, SEED).map_err(|error| failed(error.to_string()))?;
        let steps = steps_in(recorded.time, simulation.time_step());
        let settled = Stepping::new(steps, &*share).carry_out(&mut simulation, |_, _| {});
        settled.map_err(|_| QualifyError::Interrupted)?;
        let title = format!("{}, seed {SEED}, t = {} s", scene.name, simulation.time());
        Ok(pose(&simulation, &title).file)
    }
}

impl Part for ContactProblems<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let job = |recorded: &'static Recorded| Job {
            identity: format!("contact problem {}", recorded.name),
            weight: recorded.scene().map_or(0.0, |scene| weight(&scene)),
            work: Box::new(move || self.run(recorded)),
        };
        RECORDED.iter().map(job).collect()
    }

    fn section(&self) -> Result<StudySection, QualifyError> {
        let mut solved = self.solved.lock().expect("nothing panics while it holds the lock").clone();
        let place = |solved: &Solved| RECORDED.iter().position(|recorded| recorded.name == solved.name);
        solved.sort_by_key(place);
        let contacts: Vec<String> =
            solved.iter().map(|solved| format!("{} ({} contacts)", solved.name, solved.contacts)).collect();
        Ok(StudySection {
            name: STUDY.into(),
            title: "Contact problems".into(),
            scope: format!(
                "The contact problem of one step of {}, by the sweeps of the simulation, by Newton's method, by projected \
                 Gauss-Seidel on plain data, which is the reference, and by Siconos: velocities side by side.",
                contacts.join(", ")
            ),
            runs: solved.len(),
            wall_seconds: solved.iter().map(|solved| solved.wall_seconds).sum(),
            pages: RECORDED.iter().map(|recorded| format!("{STUDY}/{}.hdf5", recorded.name)).collect(),
            tests: solved.iter().flat_map(|solved| solved.tests.clone()).collect(),
            notes: self.siconos.as_ref().err().cloned().into_iter().collect(),
        })
    }
}

fn failed(problem: String) -> QualifyError {
    QualifyError::Study { study: STUDY, problem }
}

fn check(file: &ProblemFile, siconos: &FromSiconos) -> Result<Check, QualifyError> {
    problem::check(file, &Settings::DEFAULT, siconos).map_err(|error: SiconosError| failed(error.to_string()))
}

/// Whether a solver's velocities are those of the reference.
fn judged(recorded: &Recorded, check: &Check, method: Method) -> StudyTest {
    let name = format!("{}: {}", recorded.name, method.name());
    let right = format!("velocities within {AGREEMENT:e} g h of those of the reference");
    let of = |method: Method| check.answers.iter().find(|answer| answer.method == method);
    let converged = |answer: &&Answer| answer.converged;
    let found = of(method).filter(converged).and_then(|answer| answer.velocity_difference);
    match (of(Method::Reference).filter(converged), found) {
        (Some(_), Some(difference)) => {
            let difference = difference / check.unit;
            test(name, format!("within {difference:.1e} g h"), right, difference <= AGREEMENT)
        }
        _ => {
            let why = check.why_left_out(method);
            let outcome = if why.is_some() { StudyOutcome::NotMeasured } else { StudyOutcome::Failed };
            let remark = Some(why.unwrap_or("a solver did not converge").to_string());
            StudyTest { name, measured: String::new(), right, outcome, remark }
        }
    }
}
