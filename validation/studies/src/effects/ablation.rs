//! Ablation: the scene with each effect off or on, over several seeds, compared by the equivalence test.

use makadam::effects::CATALOGUE;
use makadam_compare::codes::Makadam;
use makadam_compare::compare::{Announce, MeasuredRun, Runs};
use makadam_compare::study::{RunCache, RunError, run_jobs};
use makadam_frames::plan::{Expectation, MeasuredScene};
use makadam_measure::statistics::{Ensemble, Equivalence, Outcome, equivalence};
use serde::Serialize;
use std::path::Path;
use std::time::Duration;

/// Runs of an ablation.
pub struct Plan<'a> {
    /// Scene.
    pub scene: &'a MeasuredScene,
    /// File.
    pub scene_file: &'a Path,
    /// Seeds of each variation.
    pub seeds: &'a [u64],
    /// Wall time after which a run is stopped.
    pub time_limit: Duration,
    /// Stored runs.
    pub cache: &'a RunCache,
    /// Opens progress displays.
    pub announce: Announce<'a>,
}

/// Verdict on the need for an effect, by one observable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Need {
    /// The observable moves beyond its margin without the effect (or with it, where the scene has none).
    Needed,
    /// The observable stays within its margin.
    NotNeeded,
    /// Too few seeds for a verdict.
    Undecided,
    /// Not every seed has a value: the observable cannot be measured after the change, or could not before.
    NotMeasurable,
}

impl Need {
    /// Returns the name of the verdict.
    pub fn words(self) -> &'static str {
        match self {
            Need::Needed => "needed",
            Need::NotNeeded => "not needed",
            Need::Undecided => "undecided",
            Need::NotMeasurable => "not measurable",
        }
    }
}

/// One observable under one variation.
#[derive(Clone, Debug, Serialize)]
pub struct Ablated {
    /// Effect.
    pub effect: &'static str,
    /// Change of the scene.
    pub change: String,
    /// Observable.
    pub observable: String,
    /// Mean with the unchanged scene; absent where not every seed has a value.
    pub mean: Option<f64>,
    /// Mean with the change; absent where it cannot be measured.
    pub changed_mean: Option<f64>,
    /// 90% interval of the difference.
    pub interval90: Option<[f64; 2]>,
    /// Margin of the scene.
    pub margin: f64,
    /// Verdict.
    pub need: Need,
}

/// Variations of a scene over seeds.
#[derive(Clone, Debug, Serialize)]
pub struct Ablation {
    /// Seeds of each.
    pub seeds: Vec<u64>,
    /// Rows by variation and observable.
    pub rows: Vec<Ablated>,
    /// Number of runs that ended.
    #[serde(skip)]
    pub runs: usize,
    /// Their wall time, s.
    #[serde(skip)]
    pub wall_seconds: f64,
}

impl Ablation {
    /// Runs the scene and its variations over the seeds, and compares each observable that has a margin.
    ///
    /// # Errors
    /// [`RunError`] if the scene itself cannot be run; a variation that cannot is not measurable.
    pub fn run(plan: &Plan<'_>) -> Result<Ablation, RunError> {
        let versions = plan.versions();
        let numbered = versions.iter().enumerate();
        let jobs: Vec<(usize, &Variation, u64)> = numbered
            .flat_map(|(number, version)| plan.seeds.iter().map(move |&seed| (number, version, seed)))
            .collect();
        let work = |(_, version, _): &(usize, &Variation, u64)| version.scene.duration / version.scene.solver.step;
        let runs = run_jobs(&jobs, work, &|_| {}, |&(number, version, seed), _| match plan.take(version, seed) {
            Ok(run) => Ok(Some(run)),
            // The first version is the scene itself.
            Err(error) if error.ends_all() || number == 0 => Err(error),
            Err(_) => Ok(None),
        })?;
        let mut of_versions = runs.chunks(plan.seeds.len());
        let base = of_versions.next().unwrap_or_default();
        let compared =
            versions[1..].iter().zip(of_versions).flat_map(|(version, runs)| plan.compared(version, base, runs));
        Ok(Ablation {
            seeds: plan.seeds.to_vec(),
            rows: compared.collect(),
            runs: runs.iter().flatten().count(),
            wall_seconds: runs.iter().flatten().map(|run| run.wall_seconds).sum(),
        })
    }
}

impl Plan<'_> {
    /// Returns the unchanged scene, and each variation of it.
    pub fn versions(&self) -> Vec<Variation> {
        let base = Variation { effect: "as it is", change: String::new(), scene: self.scene.clone() };
        std::iter::once(base).chain(variations(self.scene)).collect()
    }

    /// Returns one run, from the cache or new.
    ///
    /// # Errors
    /// [`RunError`] if a new run is necessary and fails.
    pub fn take(&self, version: &Variation, seed: u64) -> Result<MeasuredRun, RunError> {
        Ok(self.runs(version, seed).take(self.cache, &Makadam, seed)?.run)
    }

    /// Runs of Makadam from which one is taken.
    pub fn runs<'v>(&'v self, version: &'v Variation, seed: u64) -> Runs<'v> {
        Runs::of_one_seed(&version.scene, self.scene_file, seed, self.time_limit, self.announce)
    }

    /// Observables that have a margin, under one variation.
    fn compared(
        &self,
        version: &Variation,
        base: &[Option<MeasuredRun>],
        runs: &[Option<MeasuredRun>],
    ) -> Vec<Ablated> {
        // A mean over the seeds with a value is not a mean over all of them.
        let ensemble = |runs: &[Option<MeasuredRun>], observable: &str| {
            let values = runs.iter().map(|run| run.as_ref().and_then(|run| run.value(observable)));
            Ensemble::of(&values.collect::<Option<Vec<f64>>>()?)
        };
        let row = |expectation: &Expectation| {
            let (margin, observable) = (expectation.margin?, &expectation.observable);
            let (own, other) = (ensemble(base, observable), ensemble(runs, observable));
            let test = own.zip(other).map(|(own, other)| equivalence(&own, &other, Some(margin), 2));
            Some(Ablated {
                effect: version.effect,
                change: version.change.clone(),
                observable: observable.clone(),
                mean: own.map(|own| own.mean),
                changed_mean: other.map(|other| other.mean),
                interval90: test.as_ref().and_then(|test| test.interval90),
                margin,
                need: need(test.as_ref()),
            })
        };
        self.scene.compare.iter().filter_map(row).collect()
    }
}

fn need(test: Option<&Equivalence>) -> Need {
    match test.map(|test| test.outcome) {
        Some(Some(Outcome::Agree)) => Need::NotNeeded,
        Some(Some(Outcome::Disagree)) => Need::Needed,
        Some(_) => Need::Undecided,
        None => Need::NotMeasurable,
    }
}

/// Scene with one effect changed.
#[derive(Clone, Debug)]
pub struct Variation {
    /// Effect.
    pub effect: &'static str,
    /// Change as text.
    pub change: String,
    /// Scene.
    pub scene: MeasuredScene,
}

/// Returns a variation for each effect of the scene turned off, and for each missing effect with a trial change turned on.
pub fn variations(scene: &MeasuredScene) -> Vec<Variation> {
    let mut base = scene.clone();
    // An accuracy would choose another step for another scene; here only the effect may differ.
    base.accuracy = None;
    let of_effects = CATALOGUE.iter().filter_map(|effect| {
        let tried = effect.tried.as_ref().filter(|_| effect.called_by(scene).is_err());
        let change = tried.or(effect.off.as_ref())?;
        let mut changed = base.clone();
        (change.apply)(&mut changed.simulated);
        let variation = || Variation { effect: effect.name, change: change.words.into(), scene: changed.clone() };
        (changed != base).then(variation)
    });
    of_effects.collect()
}
