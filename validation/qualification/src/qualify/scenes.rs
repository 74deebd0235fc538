//! Scenes of a qualification: recorded runs, parallel jobs, live runs of the reference codes, the comparison.

use super::{LIVE_SEED, QualifyError, Settings};
use crate::report::Qualification;
use makadam::scene::{SceneFileError, Stop};
use makadam_compare::codes::{Code, Makadam};
use makadam_compare::compare::{
    CodeRuns, CodeSummary, Comparison, Harvest, LIVE_FRACTION, Reference, Runs, comparison, live_checks,
};
use makadam_compare::scenes::{self, SceneError};
use makadam_compare::study::{RunCache, RunError, run_jobs};
use makadam_frames::plan::MeasuredScene;
use std::path::PathBuf;
use std::sync::Mutex;

/// Assumed number of sweeps of a solve that stops by itself.
const GUESSED_SWEEPS: u32 = 20;

/// Run on one core that stores its result.
pub(super) struct Job<'a> {
    /// Name of the result: of jobs of the same name the first computes it, and the others find it stored.
    pub(super) identity: String,
    /// Amount of work, in a unit common to all jobs.
    pub(super) weight: f64,
    /// True if the job is timed and needs the machine to itself.
    pub(super) alone: bool,
    /// Computes and stores the result.
    pub(super) work: Box<dyn Fn() -> Result<(), RunError> + Send + Sync + 'a>,
}

/// Runs all jobs: first those that need the machine to themselves, then as many at a time as there are threads, none twice.
pub(super) fn run(jobs: Vec<Job<'_>>) -> Result<(), RunError> {
    let (alone, others): (Vec<_>, Vec<_>) = jobs.into_iter().partition(|job| job.alone);
    alone.iter().try_for_each(|job| (job.work)())?;
    let mut tasks: Vec<Vec<Job<'_>>> = Vec::new();
    for job in others {
        match tasks.iter_mut().find(|task| task[0].identity == job.identity) {
            Some(task) => task.push(job),
            None => tasks.push(vec![job]),
        }
    }
    let in_turn = |task: &Vec<Job<'_>>| task.iter().try_for_each(|job| (job.work)());
    run_jobs(&tasks, |task| task[0].weight, &|_| {}, |task, _| in_turn(task)).map(|_| ())
}

/// Returns the amount of work of a run: grains times steps times sweeps.
pub(super) fn weight(scene: &MeasuredScene) -> f64 {
    let sweeps = match scene.solver.stop {
        Stop::Sweeps { sweeps } => sweeps,
        _ => GUESSED_SWEEPS,
    };
    scene.grain_count() as f64 * scene.duration / scene.solver.step * f64::from(sweeps)
}

/// Scene with its recorded runs.
pub(super) struct Case {
    /// Folder under `reference-scenes`.
    pub name: &'static str,
    pub scene: MeasuredScene,
    file: PathBuf,
    recorded: Vec<CodeRuns>,
    seeds: u64,
    notes: Vec<String>,
    timings: Vec<CodeSummary>,
    /// Runs of Makadam.
    harvests: Mutex<Vec<Harvest>>,
}

impl Case {
    /// Opens a scene with the given minimum of seeds of Makadam. Recorded runs of `reference codes` are required, those of `further` codes optional.
    pub(super) fn open(
        name: &'static str,
        fewest_seeds: u64,
        settings: &Settings<'_>,
        reference_codes: &[Box<dyn Code>],
        further: &[Box<dyn Code>],
    ) -> Result<Case, QualifyError> {
        let file = scenes::find(name, &settings.roots)?;
        let scene = scenes::load(&file)?;
        // Without a margin the scene would have no test, and no count of the others would show it.
        if scene.compare.iter().all(|expectation| expectation.margin.is_none()) {
            let problem = "no observable has a margin, so that there is nothing to judge".into();
            let remedy = "give a margin under [[compare]]".into();
            return Err(SceneError::from(SceneFileError::Invalid { file, line: None, problem, remedy }).into());
        }
        let reference = Reference::of_scene(&file)?.unwrap_or_default();
        let seeds = scene.measure.seeds.unwrap_or_else(|| reference.seeds()).max(fewest_seeds);
        let mut case = Case {
            name,
            seeds,
            file,
            scene,
            recorded: Vec::new(),
            notes: Vec::new(),
            timings: Vec::new(),
            harvests: Mutex::default(),
        };
        let needed = reference_codes.iter().map(|reference_code| (reference_code, true));
        for (reference_code, is_needed) in needed.chain(further.iter().map(|reference_code| (reference_code, false))) {
            let code = reference_code.name();
            let recorded = match reference.code_on(code, &case.scene) {
                Some(recorded) => recorded,
                None if is_needed => return Err(QualifyError::NotRecorded { code, scene: name.into() }),
                None => continue,
            };
            case.recorded.push(recorded);
            case.notes.extend(reference.out_of_date(code, reference_code.contact_law(), &case.scene));
        }
        Ok(case)
    }

    fn runs<'s>(&'s self, settings: &'s Settings<'_>, seed: u64) -> Runs<'s> {
        settings.measuring(&self.scene, &self.file, seed)
    }

    /// Returns the runs of Makadam.
    pub(super) fn jobs<'s>(&'s self, settings: &'s Settings<'_>, cache: &'s RunCache) -> Vec<Job<'s>> {
        let job = move |seed| Job {
            identity: self.runs(settings, seed).key(&Makadam, seed, false).name().into(),
            weight: weight(&self.scene),
            alone: false,
            work: Box::new(move || {
                let harvest = self.runs(settings, seed).take(cache, &Makadam, seed)?;
                self.harvests.lock().expect("nothing panics while it holds the lock").push(harvest);
                Ok(())
            }),
        };
        (1..=self.seeds).map(job).collect()
    }

    /// Compares all runs with all recorded ones, run by `threads` threads.
    pub(super) fn compared(self, threads: usize) -> Comparison {
        let mut harvests = self.harvests.into_inner().expect("nothing panics while it holds the lock");
        harvests.sort_by_key(|harvest| harvest.run.seed);
        let own = CodeRuns::live("Makadam", threads, harvests);
        let codes: Vec<CodeRuns> = std::iter::once(own).chain(self.recorded).collect();
        // A qualification registers the table of tiers. The scene of the runs remains that of its file, which identifies them in the cache.
        let mut registered = self.scene;
        registered.measure.seeds = Some(self.seeds);
        let mut comparison = comparison(&registered, &codes, self.notes);
        comparison.codes.extend(self.timings);
        comparison
    }

    /// Times a code, alone on the machine; stored runs are not repeated.
    pub(super) fn time(
        &mut self,
        settings: &Settings<'_>,
        cache: &RunCache,
        code: &dyn Code,
    ) -> Result<Harvest, RunError> {
        let (summary, harvest) = self.runs(settings, LIVE_SEED).time(cache, code, LIVE_SEED)?;
        self.timings.push(summary);
        Ok(harvest)
    }

    /// Returns the number of observables that have a margin.
    pub(super) fn margins(&self) -> usize {
        self.scene.compare.iter().filter(|expectation| expectation.margin.is_some()).count()
    }

    /// Compares a live run of a reference code with the spread of its recorded runs, each value with `confidence`.
    pub(super) fn check(&self, harvest: &Harvest, confidence: f64, found: &mut Qualification) {
        let run = &harvest.run;
        let recorded = self.recorded.iter().find(|recorded| recorded.code == run.code);
        let recorded = recorded.expect("a case is opened with what is recorded of every reference_code");
        let head = format!(
            "{}: live {} (seed {}, {:.0}% of the Rayleigh step)",
            self.scene.name,
            run.code,
            run.seed,
            100.0 * LIVE_FRACTION
        );
        for check in live_checks(&self.scene, run, recorded, confidence) {
            let name = &check.observable;
            match (check.value, check.interval) {
                (Some(_), Some(_)) if check.inside() == Some(true) => {}
                (Some(value), Some([low, high])) => found.outside_spread.push(format!(
                    "{head} lies outside the interval that the recorded seeds predict: {name} {value:.4} ({low:.4} to {high:.4})"
                )),
                (None, _) => found.unchecked.push(format!("{head} has no value of {name}")),
                (Some(_), None) => found.unchecked.push(format!("{head} has no recorded spread of {name}")),
            }
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/qualify_scenes.rs"]
mod tests;
