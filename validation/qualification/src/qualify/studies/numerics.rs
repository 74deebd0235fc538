//! Studies of the numerics: contact problems by several solvers, convergence of methods, accuracy of settings.

use super::{Item, Job, Named, Part, Place, QualifyError, Solved, named, unless_fatal, weight};
use crate::report::{StudyOutcome, StudyTest};
use makadam::{BUILD, Simulation};
use makadam_compare::codes::Makadam;
pub use makadam_compare::compare::{MeasuredRun, Runs};
use makadam_compare::prepared::{Start, StartError, start};
use makadam_compare::study::{Document, Key, RunError};
use makadam_frames::execution::Execution;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::{Provenance, machine};
use makadam_frames::stepping::{Stepping, steps_in};
use makadam_measure::statistics::Ensemble;
use makadam_studies::convergence::{Curve, Effort, TOLERANCES, measure, methods};
use makadam_studies::problem::{
    self, AGREEMENT, Answer, Check, FromSiconos, Method, ProblemFile, RECORDED, Recorded, SICONOS, pose,
};
use makadam_studies::tradeoff::{Bound, Plan};
use makadam_view::draw::numbers::Rounding;
use std::sync::Arc;
use std::time::Instant;

/// Seed of the scenes of the contact problems.
const SEED: u64 = 1;

const PROBLEMS: &str = "contact-problems";

/// Contact problem of one step, solved by Makadam's sweeps, by two independent solvers, and by Siconos, a code of contact dynamics that shares
/// no line with them.
///
/// This build poses the problem. The recorded answers of Siconos belong to recorded problems, which Makadam's solvers then solve too.
pub(super) fn contact_problems(place: Place<'_>) -> Result<Part<'_>, QualifyError> {
    let cache = Arc::new(place.open(PROBLEMS)?);
    let item = |recorded: &'static Recorded| {
        let weight = recorded.scene().map_or(0.0, |scene| weight(&scene));
        let cache = cache.clone();
        Item::of(format!("contact problem {}", recorded.name), weight, false, move || {
            let key = Key::new(recorded.name.into(), &[recorded.name, BUILD, makadam_compare::BUILD]);
            cache.take(&key, || solve_problem(recorded, place))
        })
    };
    let scope = format!(
        "The contact problem of one step of {}, by the sweeps of the simulation, by Newton's method, by projected Gauss-Seidel on plain data, \
         which is the reference, and by Siconos {SICONOS}, whose answers are recorded: velocities side by side.",
        RECORDED.each_ref().map(|recorded| recorded.name).join(", ")
    );
    Ok(Part::new(PROBLEMS, "Contact problems", scope, RECORDED.iter().map(item).collect()))
}

/// Poses the problem of a scene, and solves it and the recorded one by every available solver.
fn solve_problem(recorded: &Recorded, place: Place<'_>) -> Result<Solved, RunError> {
    let clock = Instant::now();
    let share = (place.settings.announce)(&format!("{} contact problem", recorded.name));
    let scene = recorded.scene().map_err(|error| no_problem(error.to_string()))?;
    let mut simulation = Simulation::new(&scene, SEED).map_err(|error| no_problem(error.to_string()))?;
    let steps = steps_in(recorded.time, simulation.time_step());
    let settled = Stepping::new(steps, &*share).carry_out(&mut simulation, |_, _| {});
    settled.map_err(|_| RunError::Interrupted)?;
    let title = format!("{}, seed {SEED}, t = {} s", scene.name, simulation.time());
    let own = check(&pose(&simulation, &title), &FromSiconos::Nothing)?;
    let answers = FromSiconos::Recorded(recorded.siconos().map_err(no_problem)?);
    let with_siconos = check(&recorded.problem().map_err(no_problem)?, &answers)?;
    let tests = [(&own, Method::Direct), (&own, Method::Lanes), (&with_siconos, Method::Siconos)];
    Ok(Solved {
        runs: 1,
        wall_seconds: clock.elapsed().as_secs_f64(),
        tests: tests.map(|(check, method)| problem_test(recorded, check, method)).into(),
        ..Solved::default()
    })
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

/// Root mean square residual required of every method, in the unit of the study: a hundredth of the velocity that gravity adds in a step.
const REACHED: f64 = TOLERANCES[1];

/// Scene and method that are known not to reach it, with the reason.
const KNOWN_EXCEPTIONS: [(&str, &str, &str); 1] = [(
    "drum",
    "projected-conjugate-gradients",
    "a historical baseline, which goes astray where contacts slide (validation/docs/accuracy.md)",
)];

/// Convergence of each method on the problem of one step, alone on the machine, since each iteration is timed.
pub(super) fn convergence<'a>(names: &[&'static str], place: Place<'a>) -> Result<Part<'a>, QualifyError> {
    let cache = Arc::new(place.open("convergence")?);
    let item = |name: &&'static str| {
        let (named, cache) = (Named::open(name, place)?, cache.clone());
        Ok(Item::of(format!("convergence {name}"), 0.0, true, move || {
            let key = Key::of_run(named.name.into(), &named.scene, named.scene.seed, &[&machine()]);
            cache.take(&key, || solve_step(&named, place))
        }))
    };
    let scope = format!(
        "The contact problem of one step, solved by every method that suits the scene: {} iterations, {} times in turn, on one core, alone on \
         the machine.",
        EFFORT.iterations, EFFORT.repetitions
    );
    let items = names.iter().map(item).collect::<Result<_, QualifyError>>()?;
    Ok(Part::new("convergence", "Convergence of methods", scope, items))
}

/// Solves the problem of one step of a scene by every method that suits it.
fn solve_step(Named { name, file, scene }: &Named, place: Place<'_>) -> Result<Solved, RunError> {
    let clock = Instant::now();
    let share = (place.settings.announce)(&format!("{name} convergence"));
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
    let methods = methods(scene, None);
    let study = measure(scene, &simulation, methods, EFFORT, provenance, &|_, done| share(done));
    let study = study.map_err(|_| RunError::Interrupted)?;
    let unit = &study.problem.residual_unit_name;
    Ok(Solved {
        runs: study.methods.len(),
        wall_seconds: clock.elapsed().as_secs_f64(),
        tests: study.methods.iter().map(|curve| method_test(name, curve, unit)).collect(),
        notes: study.findings.iter().map(|finding| format!("{name}: {finding}")).collect(),
        figures: study.figures(),
        files: named("convergence", name, study.tables()?),
    })
}

/// Tests that a method reaches the required residual.
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

/// Settings of the scenes compared with their converged references, over the number of seeds needed for a verdict.
pub(super) fn tradeoff<'a>(scenes: &[(&'static str, u64)], place: Place<'a>) -> Result<Part<'a>, QualifyError> {
    let item = |&(name, seeds): &(&'static str, u64)| {
        let own = Arc::new(OwnSettings::new(Named::open(name, place)?, seeds, place));
        Ok(Item { jobs: OwnSettings::jobs(&own), solved: Box::new(move || own.solved()) })
    };
    let scope = "The settings that the scenes come with, against the converged reference of `makadam tradeoff`, with as many seeds as it takes \
                 to tell.";
    let items = scenes.iter().map(item).collect::<Result<_, QualifyError>>()?;
    Ok(Part::new("tradeoff", "Accuracy of the settings of scenes", scope, items))
}

/// Scene with the settings of its file, and with those of its converged reference.
struct OwnSettings<'a> {
    place: Place<'a>,
    named: Named,
    /// Scene and its reference.
    versions: [MeasuredScene; 2],
    /// Settings of the reference as text.
    reference: String,
    seeds: u64,
}

impl<'a> OwnSettings<'a> {
    fn new(named: Named, seeds: u64, place: Place<'a>) -> OwnSettings<'a> {
        let plan = Plan::new(&named.scene, &["Makadam"], &[1.0]);
        let finest = plan.refinement(1.0).map(|refinement| &plan.configurations[refinement.grids[2]]);
        let finest = finest.expect("a plan has a reference at the scene's stiffness");
        let (versions, reference) = ([named.scene.clone(), finest.scene(&named.scene)], finest.setting());
        OwnSettings { place, named, versions, reference, seeds }
    }

    fn jobs(own: &Arc<OwnSettings<'a>>) -> Vec<Job<'a>> {
        let runs = [0, 1].into_iter().flat_map(|version| (1..=own.seeds).map(move |seed| (version, seed)));
        let job = |(version, seed): (usize, u64)| {
            let (scene, own) = (&own.versions[version], own.clone());
            Job {
                identity: own.runs(scene, seed).key(&Makadam, seed, false).name().into(),
                weight: weight(scene),
                alone: false,
                work: Box::new(move || unless_fatal(own.take(&own.versions[version], seed))),
            }
        };
        runs.map(job).collect()
    }

    /// Returns a test for each bounded observable of the scene, from finished runs.
    fn solved(&self) -> Result<Solved, RunError> {
        let (mut pairs, mut failure) = (Vec::new(), None);
        for seed in 1..=self.seeds {
            let mut of = |version: &MeasuredScene| match self.take(version, seed) {
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
        let ended = || pairs.iter().flatten().flatten();
        Ok(Solved {
            runs: ended().count(),
            wall_seconds: ended().map(|run| run.wall_seconds).sum(),
            tests: bounds.map(|bound| self.test(&bound, &pairs, failure.clone())).collect(),
            ..Solved::default()
        })
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

    fn take(&self, version: &MeasuredScene, seed: u64) -> Result<MeasuredRun, RunError> {
        Ok(self.runs(version, seed).take(self.place.cache, &Makadam, seed)?.run)
    }

    fn runs<'s>(&'s self, version: &'s MeasuredScene, seed: u64) -> Runs<'s> {
        self.place.settings.measuring(version, &self.named.file, seed)
    }
}

/// Verdict on a deviation from the reference, which is absent where a seed has no value.
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
