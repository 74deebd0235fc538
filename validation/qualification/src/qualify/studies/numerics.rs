//! Studies of the numerics: contact problems by several solvers, convergence of methods, accuracy against time.

use super::{Job, Named, Part, Place, QualifyError, named, unless_fatal, weight};
use crate::report::{StudyOutcome, StudySection, StudyTest};
use makadam::{BUILD, Simulation};
use makadam_compare::codes::{Code, Makadam};
pub use makadam_compare::compare::{FEW_SEEDS, MeasuredRun, Runs};
use makadam_compare::prepared::{Start, StartError, start};
use makadam_compare::study::{Document, File, Key, RunCache, RunError};
use makadam_frames::execution::Execution;
use makadam_frames::output::WriteError;
use makadam_frames::plan::Scene;
use makadam_frames::provenance::{Provenance, account, machine};
use makadam_frames::stepping::{Stepping, steps_in};
use makadam_measure::statistics::Ensemble;
use makadam_studies::convergence::{self, Curve, Effort, TOLERANCES};
use makadam_studies::problem::{
    self, AGREEMENT, Answer, Check, FromSiconos, Method, ProblemFile, RECORDED, Recorded, SICONOS, pose,
    siconos_version,
};
use makadam_studies::tradeoff::{self, Bound, Campaign, Outcome, Plan, QUICK_TIME_LIMIT, Terms};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::numbers::Rounding;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// Seed of the scenes whose contact problems are posed.
const SEED: u64 = 1;

const PROBLEMS: &str = "contact-problems";

/// The contact problem of one step by Makadam's sweeps, by two solvers apart from them, and by Siconos, a code of contact dynamics that shares
/// no line with them.
///
/// The problem is posed by this build. Siconos solves it where it is run; its recorded answers are to recorded problems, which Makadam's
/// solvers then solve too.
pub(super) struct ContactProblems<'a> {
    place: Place<'a>,
    cache: RunCache,
    /// Version of Siconos, or the reason for which it is not run.
    siconos: Result<String, String>,
}

/// Stored result of one problem or one scene.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Solved {
    contacts: usize,
    runs: usize,
    wall_seconds: f64,
    tests: Vec<StudyTest>,
    notes: Vec<String>,
    figures: Vec<Figure>,
    files: Vec<File>,
}

/// Adds stored results to a section.
fn gathered(mut section: StudySection, solved: Vec<Solved>) -> StudySection {
    for solved in solved {
        section.runs += solved.runs;
        section.wall_seconds += solved.wall_seconds;
        section.tests.extend(solved.tests);
        section.notes.extend(solved.notes);
        section.figures.extend(solved.figures);
        section.files.extend(solved.files);
    }
    section
}

impl<'a> ContactProblems<'a> {
    pub(super) fn open(place: Place<'a>) -> Result<ContactProblems<'a>, WriteError> {
        let siconos = match place.settings.live {
            true => siconos_version().map_err(|error| format!("Siconos was not run: {error}.")),
            false => Err("Siconos was not run: its answers are the recorded ones.".into()),
        };
        Ok(ContactProblems { place, cache: place.open(PROBLEMS)?, siconos })
    }

    fn solved(&self, recorded: &Recorded) -> Result<Solved, RunError> {
        let siconos = self.siconos.as_deref().unwrap_or("recorded");
        let key = Key::new(recorded.name.into(), &[recorded.name, siconos, BUILD, makadam_compare::BUILD]);
        self.cache.take(&key, || self.solve(recorded))
    }

    /// Poses the problem of a scene, and has it solved by every solver there is.
    fn solve(&self, recorded: &Recorded) -> Result<Solved, RunError> {
        let clock = Instant::now();
        let share = (self.place.settings.announce)(&format!("{} contact problem", recorded.name));
        let scene = recorded.scene().map_err(|error| no_problem(error.to_string()))?;
        let mut simulation = Simulation::new(&scene, SEED).map_err(|error| no_problem(error.to_string()))?;
        let steps = steps_in(recorded.time, simulation.time_step());
        let settled = Stepping::new(steps, &*share).carry_out(&mut simulation, |_, _| {});
        settled.map_err(|_| RunError::Interrupted)?;
        let title = format!("{}, seed {SEED}, t = {} s", scene.name, simulation.time());
        let posed = pose(&simulation, &title);
        let (own, with_siconos, origin) = match &self.siconos {
            Ok(version) => (check(&posed, &FromSiconos::Run)?, None, format!("Siconos {version}, run live")),
            Err(_) => {
                let answers = FromSiconos::Recorded(recorded.siconos().map_err(no_problem)?);
                let with_siconos = check(&recorded.problem().map_err(no_problem)?, &answers)?;
                (check(&posed, &FromSiconos::Nothing)?, Some(with_siconos), format!("Siconos {SICONOS}, recorded"))
            }
        };
        let mut tests = [Method::Direct, Method::Lanes].map(|method| problem_test(recorded, &own, method)).to_vec();
        let with_siconos = problem_test(recorded, with_siconos.as_ref().unwrap_or(&own), Method::Siconos);
        tests.push(StudyTest { remark: Some(origin), ..with_siconos });
        Ok(Solved {
            contacts: own.contacts,
            runs: 1,
            wall_seconds: clock.elapsed().as_secs_f64(),
            tests,
            ..Solved::default()
        })
    }
}

impl Part for ContactProblems<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let job = |recorded: &'static Recorded| Job {
            identity: format!("contact problem {}", recorded.name),
            weight: recorded.scene().map_or(0.0, |scene| weight(&scene)),
            alone: false,
            work: Box::new(move || self.solved(recorded).map(|_| ())),
        };
        RECORDED.iter().map(job).collect()
    }

    fn section(&self) -> Result<StudySection, RunError> {
        let solved = RECORDED.iter().map(|recorded| self.solved(recorded)).collect::<Result<Vec<_>, RunError>>()?;
        let contacts = RECORDED.iter().zip(&solved);
        let contacts: Vec<String> =
            contacts.map(|(recorded, solved)| format!("{} ({} contacts)", recorded.name, solved.contacts)).collect();
        let section = StudySection {
            name: PROBLEMS.into(),
            title: "Contact problems".into(),
            scope: format!(
                "The contact problem of one step of {}, by the sweeps of the simulation, by Newton's method, by projected \
                 Gauss-Seidel on plain data, which is the reference, and by Siconos: velocities side by side.",
                contacts.join(", ")
            ),
            notes: self.siconos.as_ref().err().cloned().into_iter().collect(),
            ..StudySection::default()
        };
        Ok(gathered(section, solved))
    }
}

fn no_problem(problem: String) -> RunError {
    RunError::Failed(format!("{PROBLEMS}: {problem}"))
}

fn check(file: &ProblemFile, siconos: &FromSiconos) -> Result<Check, RunError> {
    problem::check(file, &problem::Settings::DEFAULT, siconos).map_err(|error| no_problem(error.to_string()))
}

/// Tests that the velocities of a solver are those of the reference.
fn problem_test(recorded: &Recorded, check: &Check, method: Method) -> StudyTest {
    let name = format!("{}: {}", recorded.name, method.name());
    let right = format!("velocities within {AGREEMENT:e} g h of those of the reference");
    let of = |method: Method| check.answers.iter().find(|answer| answer.method == method);
    let is_converged = |answer: &&Answer| answer.converged;
    let found = of(method).filter(is_converged).and_then(|answer| answer.velocity_difference);
    match (of(Method::Reference).filter(is_converged), found) {
        (Some(_), Some(difference)) => {
            let difference = difference / check.unit;
            StudyTest::of(name, format!("within {difference:.1e} g h"), right, difference <= AGREEMENT)
        }
        _ => {
            let why = check.why_left_out(method);
            let outcome = if why.is_some() { StudyOutcome::NotMeasured } else { StudyOutcome::Failed };
            let remark = Some(why.unwrap_or("a solver did not converge").to_string());
            StudyTest { name, measured: String::new(), right, outcome, remark }
        }
    }
}

/// Effort of each method: that of `makadam lab convergence`.
const EFFORT: Effort = Effort { iterations: 200, repetitions: 3 };

/// Root mean square residual that every method has to reach, in the unit of the study: a hundredth of what gravity does in a step.
const REACHED: f64 = TOLERANCES[1];

/// Scene and method that are known not to reach it, with the reason.
const KNOWN_EXCEPTIONS: [(&str, &str, &str); 1] = [(
    "drum",
    "projected-conjugate-gradients",
    "a historical baseline, which goes astray where contacts slide (validation/docs/accuracy.md)",
)];

/// Convergence of each method on the problem of one step, alone on the machine, since each iteration is timed.
pub(super) struct Convergence<'a> {
    place: Place<'a>,
    cache: RunCache,
    scenes: Vec<Named>,
}

impl<'a> Convergence<'a> {
    pub(super) fn open(names: &[&'static str], place: Place<'a>) -> Result<Convergence<'a>, QualifyError> {
        let scenes = names.iter().map(|name| Named::open(name, place)).collect::<Result<_, _>>()?;
        Ok(Convergence { place, cache: place.open("convergence")?, scenes })
    }

    fn solved(&self, named: &Named) -> Result<Solved, RunError> {
        let key = Key::of_run(named.name.into(), &named.scene, named.scene.seed, &[&machine()]);
        self.cache.take(&key, || self.solve(named))
    }

    /// Solves the problem of a scene by every method that suits it.
    fn solve(&self, Named { name, file, scene }: &Named) -> Result<Solved, RunError> {
        let clock = Instant::now();
        let share = (self.place.settings.announce)(&format!("{name} convergence"));
        let execution = Execution::serial();
        let provenance = Provenance::of_run(scene, file, scene.seed, &execution);
        let fails = |error: StartError| match error {
            StartError::Interrupted => RunError::Interrupted,
            other => RunError::Failed(format!("convergence: {other}")),
        };
        let (mut simulation, started) = start(scene, scene.seed, file, &execution, &*share).map_err(fails)?;
        if started == Start::Fresh {
            let steps = steps_in(scene.measure.from.unwrap_or(scene.duration), simulation.time_step());
            let settled = Stepping::new(steps, &*share).carry_out(&mut simulation, |_, _| {});
            settled.map_err(|_| RunError::Interrupted)?;
        }
        let methods = convergence::methods(scene, None);
        let study = convergence::measure(scene, &simulation, methods, EFFORT, provenance, &|_, done| share(done));
        let study = study.map_err(|_| RunError::Interrupted)?;
        let unit = &study.problem.residual_unit_name;
        Ok(Solved {
            contacts: study.problem.contacts,
            runs: study.methods.len(),
            wall_seconds: clock.elapsed().as_secs_f64(),
            tests: study.methods.iter().map(|curve| method_test(name, curve, unit)).collect(),
            notes: study.findings.iter().map(|finding| format!("{name}: {finding}")).collect(),
            figures: study.figures(),
            files: named("convergence", name, study.tables()?),
        })
    }
}

impl Part for Convergence<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let job = |place: usize| Job {
            identity: format!("convergence {}", self.scenes[place].name),
            weight: 0.0,
            alone: true,
            work: Box::new(move || self.solved(&self.scenes[place]).map(|_| ())),
        };
        (0..self.scenes.len()).map(job).collect()
    }

    fn section(&self) -> Result<StudySection, RunError> {
        let section = StudySection {
            name: "convergence".into(),
            title: "Convergence of methods".into(),
            scope: format!(
                "The contact problem of one step, solved by every method that suits the scene: {} iterations, {} times in turn, on one \
                 core, alone on the machine.",
                EFFORT.iterations, EFFORT.repetitions
            ),
            ..StudySection::default()
        };
        let solved = self.scenes.iter().map(|named| self.solved(named)).collect::<Result<Vec<_>, RunError>>()?;
        Ok(gathered(section, solved))
    }
}

/// Tests that a method reaches the residual that it has to.
fn method_test(scene: &str, curve: &Curve, unit: &str) -> StudyTest {
    let reached =
        curve.reached.iter().find(|reached| reached.tolerance == REACHED).expect("it is one of the tolerances");
    let measured = match reached.iterations {
        Some(iterations) => format!("{REACHED} {unit} after {iterations} iterations"),
        None => format!("not {REACHED} {unit}"),
    };
    let right = format!("a residual of {REACHED} {unit} within {} iterations", EFFORT.iterations);
    let method = curve.method.name();
    let known = KNOWN_EXCEPTIONS.iter().find(|(of_scene, of_method, _)| (*of_scene, *of_method) == (scene, method));
    let test = StudyTest::of(format!("{scene}: {method}"), measured, right, reached.iterations.is_some());
    test.with_exception(known.map(|(.., reason)| *reason))
}

/// Accuracy against time: few settings of Makadam, timed one after the other, alone on the machine; and the settings of the scenes against
/// their converged references, side by side.
pub(super) struct Tradeoff<'a> {
    place: Place<'a>,
    scenes: Vec<OwnSettings<'a>>,
}

impl<'a> Tradeoff<'a> {
    pub(super) fn open(scenes: &[(&'static str, u64)], place: Place<'a>) -> Result<Tradeoff<'a>, QualifyError> {
        let open = |&(name, seeds): &(&'static str, u64)| Ok(OwnSettings::new(Named::open(name, place)?, seeds, place));
        Ok(Tradeoff { place, scenes: scenes.iter().map(open).collect::<Result<_, QualifyError>>()? })
    }

    fn plan(scene: &Scene) -> Plan {
        Plan::new(scene, true, &["Makadam"], &[1.0])
    }

    /// Times few settings of Makadam on a scene.
    fn time(&self, own: &OwnSettings<'_>) -> Result<(), RunError> {
        let Named { name, file, scene } = &own.named;
        let codes: [Box<dyn Code>; 1] = [Box::new(Makadam)];
        let campaign = Campaign {
            scene,
            scene_file: file,
            plan: &Self::plan(scene),
            seeds: FEW_SEEDS,
            codes: &codes,
            time_limit: QUICK_TIME_LIMIT,
            cache: &self.place.open(&format!("tradeoff/{name}"))?,
            progress: Arc::new(|_, _| {}),
        };
        let outcome = campaign.carry_out()?;
        if outcome.interrupted {
            return Err(RunError::Interrupted);
        }
        own.timed.get_or_init(|| outcome);
        Ok(())
    }
}

impl Part for Tradeoff<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let timed = |place: usize| Job {
            identity: format!("tradeoff {}", self.scenes[place].named.name),
            weight: 0.0,
            alone: true,
            work: Box::new(move || self.time(&self.scenes[place])),
        };
        let own = self.scenes.iter().flat_map(OwnSettings::jobs);
        (0..self.scenes.len()).map(timed).chain(own).collect()
    }

    fn section(&self) -> Result<StudySection, RunError> {
        let mut section = StudySection {
            name: "tradeoff".into(),
            title: "What accuracy costs".into(),
            scope: format!(
                "Makadam at few settings, {FEW_SEEDS} seeds each, against its own converged reference: timed one after the other on one \
                 core, alone on the machine. The settings that the scenes come with are judged with as many seeds as it takes to tell."
            ),
            ..StudySection::default()
        };
        for own in &self.scenes {
            let Named { name, scene, .. } = &own.named;
            let outcome = own.timed.get().expect("it was run alone on the machine");
            let terms = Terms {
                quick: true,
                seeds: FEW_SEEDS,
                bounds: Bound::usual(),
                time_limit: QUICK_TIME_LIMIT,
                provenance: account(1, &[scene]),
            };
            let study = tradeoff::Study::new(scene, &Self::plan(scene), outcome, terms);
            section.notes.extend(study.findings.iter().map(|finding| format!("{name}: {finding}")));
            section.runs += outcome.runs.iter().flatten().count();
            section.wall_seconds += outcome.runs.iter().flatten().map(|kept| kept.run.wall_seconds).sum::<f64>();
            section.figures.extend(study.figures());
            section.files.extend(named("tradeoff", name, study.tables()?));
            section.tests.extend(own.tests()?);
        }
        Ok(section)
    }
}

/// A scene with the settings of its file, and with those of its converged reference, over as many seeds as it takes to tell.
struct OwnSettings<'a> {
    place: Place<'a>,
    named: Named,
    /// The scene, and its reference.
    versions: [Scene; 2],
    /// The reference's settings in words.
    reference: String,
    seeds: u64,
    /// Few settings of Makadam, timed alone on the machine.
    timed: OnceLock<Outcome>,
}

impl<'a> OwnSettings<'a> {
    fn new(named: Named, seeds: u64, place: Place<'a>) -> OwnSettings<'a> {
        let plan = Plan::new(&named.scene, true, &[], &[1.0]);
        let finest = plan.refinement(1.0).map(|refinement| &plan.configurations[refinement.grids[2]]);
        let finest = finest.expect("a plan has a reference at the scene's stiffness");
        let versions = [named.scene.clone(), finest.scene(&named.scene)];
        OwnSettings { place, named, versions, reference: finest.setting(), seeds, timed: OnceLock::new() }
    }

    fn jobs(&self) -> Vec<Job<'_>> {
        let mut jobs = Vec::new();
        for version in &self.versions {
            jobs.extend((1..=self.seeds).map(|seed| Job {
                identity: self.runs(version, seed).key(&Makadam, seed, false).name().into(),
                weight: weight(version),
                alone: false,
                work: Box::new(move || unless_fatal(self.take(version, seed))),
            }));
        }
        jobs
    }

    /// Returns a test for each bounded observable of the scene, from finished runs.
    fn tests(&self) -> Result<Vec<StudyTest>, RunError> {
        let (mut pairs, mut failure) = (Vec::new(), None);
        for seed in 1..=self.seeds {
            let mut of = |version: &Scene| match self.take(version, seed) {
                Ok(run) => Ok(Some(run)),
                Err(error) if error.ends_all() => Err(error),
                Err(error) => {
                    failure.get_or_insert(format!("seed {seed}: {error}"));
                    Ok(None)
                }
            };
            pairs.push([of(&self.versions[0])?, of(&self.versions[1])?]);
        }
        let is_compared = |bound: &Bound| self.versions[0].compare.iter().any(|one| one.observable == bound.observable);
        let bounds = Bound::usual().into_iter().filter(is_compared);
        Ok(bounds.map(|bound| self.test(&bound, &pairs, failure.clone())).collect())
    }

    /// Tests that the 90% interval of the deviation, seed by seed, lies within the bound.
    fn test(&self, bound: &Bound, pairs: &[[Option<MeasuredRun>; 2]], failure: Option<String>) -> StudyTest {
        let difference = |[own, reference]: &[Option<MeasuredRun>; 2]| {
            let value = |run: &Option<MeasuredRun>| run.as_ref()?.value(&bound.observable);
            Some(value(own)? - value(reference)?)
        };
        let differences: Option<Vec<f64>> = pairs.iter().map(difference).collect();
        let (measured, outcome) = verdict(differences.as_deref().and_then(Ensemble::of), bound.value);
        StudyTest {
            name: format!("{}: {}", self.named.name, bound.observable),
            measured,
            right: format!(
                "the scene's settings are within {} of {}, the 90% interval too",
                bound.value, self.reference
            ),
            outcome,
            remark: failure,
        }
    }

    fn take(&self, version: &Scene, seed: u64) -> Result<MeasuredRun, RunError> {
        Ok(self.runs(version, seed).take(self.place.cache, &Makadam, seed)?.run)
    }

    fn runs<'s>(&'s self, version: &'s Scene, seed: u64) -> Runs<'s> {
        self.place.settings.measuring(version, &self.named.file, seed)
    }
}

/// Verdict on a deviation from the reference; it is absent where a seed has no value.
fn verdict(deviation: Option<Ensemble>, bound: f64) -> (String, StudyOutcome) {
    let interval = deviation.and_then(|deviation| deviation.interval90());
    let (Some(deviation), Some([low, high])) = (deviation, interval) else {
        return ("no value in some seed".into(), StudyOutcome::NotMeasured);
    };
    let rounding = Rounding::to_margin(bound);
    let [mean, least, most] = [deviation.mean, low, high].map(|value| rounding.value(value));
    let measured = format!("{mean} ({least} to {most}), {} seeds", deviation.seeds);
    let within = -bound <= low && high <= bound;
    (measured, if within { StudyOutcome::Passed } else { StudyOutcome::Failed })
}

#[cfg(test)]
#[path = "../../../tests/unit/qualify_studies_numerics.rs"]
mod tests;
