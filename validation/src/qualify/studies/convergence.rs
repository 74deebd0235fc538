//! How each method converges on the problem of one step, alone on the machine, since each iteration is timed.

use super::{Named, Part, Place, QualifyError, scenes_named, test};
use crate::convergence::{self, Curve, Effort, Problem, Study, TOLERANCES};
use crate::execution::Execution;
use crate::plan::Scene;
use crate::prepared::{Start, StartError, start};
use crate::provenance::{JUDGE, Provenance, machine, scene_hash};
use crate::report::{StudyOutcome, StudySection, StudyTest};
use crate::stepping::{Stepping, steps_in};
use crate::study::{Document, Key, RunCache};
use makadam::BUILD;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

/// What each method is made to do: as much as `makadam convergence` does.
const EFFORT: Effort = Effort { iterations: 200, repetitions: 3 };

/// Root mean square residual that every method has to reach, in the unit of the study: a hundredth of what gravity does in a step.
const REACHED: f64 = TOLERANCES[1];

/// Scene and method that are known not to reach it, with the reason.
const KNOWN_EXCEPTIONS: [(&str, &str, &str); 1] = [(
    "drum",
    "projected-conjugate-gradients",
    "a historical baseline, which goes astray where contacts slide (validation/docs/accuracy.md)",
)];

pub(super) struct Convergence<'a> {
    place: Place<'a>,
    scenes: Vec<Named>,
    solved: Mutex<Vec<Solved>>,
}

/// What is kept of a scene once its study has been written.
#[derive(Clone, Serialize, Deserialize)]
struct Solved {
    methods: usize,
    wall_seconds: f64,
    tests: Vec<StudyTest>,
    notes: Vec<String>,
}

impl<'a> Convergence<'a> {
    pub(super) fn open(names: &[&'static str], place: Place<'a>) -> Result<Convergence<'a>, QualifyError> {
        let scenes = scenes_named(names, place)?;
        Ok(Convergence { place, scenes, solved: Mutex::default() })
    }

    /// Solves the problem of a scene by every method that suits it, and writes the study.
    fn solve(&self, name: &str, file: &Path, scene: &Scene) -> Result<Solved, QualifyError> {
        let clock = Instant::now();
        let share = (self.place.settings.announce)(&format!("{name} convergence"));
        let execution = Execution::serial();
        let provenance = Provenance::of_run(scene, file, scene.seed, &execution);
        let fails = |error: StartError| match error {
            StartError::Interrupted => QualifyError::Interrupted,
            other => QualifyError::Study { study: "convergence", problem: other.to_string() },
        };
        let (mut simulation, started) = start(scene, scene.seed, file, &execution, &*share).map_err(fails)?;
        if started == Start::Fresh {
            let steps = steps_in(scene.measure.from.unwrap_or(scene.duration), simulation.time_step());
            let settled = Stepping::new(steps, &*share).carry_out(&mut simulation, |_, _| {});
            settled.map_err(|_| QualifyError::Interrupted)?;
        }
        let (methods, left_out) = convergence::suitable(&simulation, convergence::methods(scene, None));
        let problem = Problem::next(scene, &simulation);
        let curves = convergence::solve(&simulation, &methods, EFFORT, &|_, done| share(done));
        let curves = curves.map_err(|_| QualifyError::Interrupted)?;
        let study = Study::new(problem, EFFORT, curves, left_out, provenance);
        study.write(&self.place.folder("convergence").join(name))?;
        Ok(Solved {
            methods: study.methods.len(),
            wall_seconds: clock.elapsed().as_secs_f64(),
            tests: study.methods.iter().map(|curve| judged(name, curve, &study.problem.residual_unit_name)).collect(),
            notes: study.findings.iter().map(|finding| format!("{name}: {finding}")).collect(),
        })
    }
}

impl Part for Convergence<'_> {
    fn alone(&self) -> Result<(), QualifyError> {
        let cache = RunCache::open(&self.place.folder("convergence").join("kept"))?;
        for (name, file, scene) in &self.scenes {
            (self.place.settings.say)(&format!(
                "{name}: every method on the problem of one step, alone on the machine"
            ));
            let hash = format!("{:016x}", scene_hash(scene));
            let key = Key::new((*name).into(), &[&hash, &scene.seed.to_string(), BUILD, JUDGE, &machine()]);
            let page = self.place.folder("convergence").join(name).join("convergence.html");
            let again = self.place.settings.again || !page.is_file();
            let solved = cache.take(&key, again, || self.solve(name, file, scene))?;
            self.solved.lock().expect("nothing panics while it holds the lock").push(solved);
        }
        Ok(())
    }

    fn section(&self) -> Result<StudySection, QualifyError> {
        let solved = self.solved.lock().expect("nothing panics while it holds the lock");
        let of_all = |each: fn(&Solved) -> Vec<StudyTest>| solved.iter().flat_map(each).collect::<Vec<_>>();
        Ok(StudySection {
            name: "convergence".into(),
            title: "Convergence of methods".into(),
            scope: format!(
                "The contact problem of one step, solved by every method that suits the scene: {} iterations, {} times in turn, on one \
                 core, alone on the machine.",
                EFFORT.iterations, EFFORT.repetitions
            ),
            runs: solved.iter().map(|solved| solved.methods).sum(),
            wall_seconds: solved.iter().map(|solved| solved.wall_seconds).sum(),
            pages: self.scenes.iter().map(|(name, ..)| format!("convergence/{name}/convergence.html")).collect(),
            tests: of_all(|solved| solved.tests.clone()),
            notes: solved.iter().flat_map(|solved| solved.notes.clone()).collect(),
        })
    }
}

/// Whether a method reaches the residual that it has to.
fn judged(scene: &str, curve: &Curve, unit: &str) -> StudyTest {
    let reached =
        curve.reached.iter().find(|reached| reached.tolerance == REACHED).expect("it is one of the tolerances");
    let measured = match reached.iterations {
        Some(iterations) => format!("{REACHED} {unit} after {iterations} iterations"),
        None => format!("not {REACHED} {unit}"),
    };
    let right = format!("a residual of {REACHED} {unit} within {} iterations", EFFORT.iterations);
    let name = format!("{scene}: {}", curve.method.name());
    let known =
        KNOWN_EXCEPTIONS.iter().find(|(of_scene, method, _)| (*of_scene, *method) == (scene, curve.method.name()));
    match (known, reached.iterations) {
        (None, reached) => test(name, measured, right, reached.is_some()),
        (Some((.., reason)), None) => {
            let remark = Some(reason.to_string());
            StudyTest { name, measured, right, outcome: StudyOutcome::KnownException, remark }
        }
        (Some(_), Some(_)) => {
            let remark =
                Some("it is listed as a method that does not reach it, and does: take it off the list".to_string());
            StudyTest { name, measured, right, outcome: StudyOutcome::Failed, remark }
        }
    }
}
