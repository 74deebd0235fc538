//! The settings that a scene comes with against its converged reference, over as many seeds as it takes to tell.

use super::{Job, Place, QualifyError};
use crate::compare::{KeptError, KeptRuns, MeasuredRun, Runs};
use crate::draw::numbers::Rounding;
use crate::peers::Makadam;
use crate::plan::Scene;
use crate::qualify::jobs::weight;
use crate::report::{StudyOutcome, StudyTest};
use crate::statistics::Ensemble;
use crate::tradeoff::{Bound, Configuration, Plan, Scope};
use std::path::{Path, PathBuf};

/// A scene with the settings of its file, and with those of its reference.
pub(super) struct OwnSettings<'a> {
    place: Place<'a>,
    name: &'static str,
    file: PathBuf,
    versions: [Scene; 2],
    /// The reference's settings in words.
    reference: String,
    seeds: u64,
}

impl<'a> OwnSettings<'a> {
    /// Of a scene and its file, with so many seeds of each.
    pub(super) fn new(name: &'static str, file: &Path, scene: &Scene, seeds: u64, place: Place<'a>) -> OwnSettings<'a> {
        let plan = Plan::new(scene, Scope::Quick, &[], &[1.0]);
        let finest = plan.refinement(1.0).map(|refinement| &plan.configurations[refinement.grids[2]]);
        let finest: &Configuration = finest.expect("a plan has a reference at the scene's stiffness");
        let versions = [scene.clone(), finest.scene(scene)];
        OwnSettings { place, name, file: file.into(), versions, reference: finest.setting(), seeds }
    }

    /// All its runs, to be made side by side.
    pub(super) fn jobs<'s>(&'s self) -> Vec<Job<'s>> {
        let each = self.versions.iter().flat_map(|version| (1..=self.seeds).map(move |seed| (version, seed)));
        let job = |(version, seed): (&'s Scene, u64)| Job {
            identity: KeptRuns::identity(&self.runs(version, seed), &Makadam, seed),
            weight: weight(version),
            work: Box::new(move || match self.one(version, seed) {
                Err(error) if error.ends_all() => Err(error.into()),
                // A run that fails comes to light in the tests.
                _ => Ok(()),
            }),
        };
        each.map(job).collect()
    }

    /// A test for each bounded observable of the scene, from runs that have been made.
    ///
    /// # Errors
    /// [`QualifyError`] if a run is not there and cannot be made or kept, other than by failing.
    pub(super) fn tests(&self) -> Result<Vec<StudyTest>, QualifyError> {
        let mut pairs = Vec::new();
        let mut failure = None;
        for seed in 1..=self.seeds {
            let mut of = |version: &Scene| match self.one(version, seed) {
                Ok(run) => Ok(Some(run)),
                Err(error) if error.ends_all() => Err(error),
                Err(error) => {
                    failure.get_or_insert(format!("seed {seed}: {error}"));
                    Ok(None)
                }
            };
            pairs.push([of(&self.versions[0])?, of(&self.versions[1])?]);
        }
        let compared = |bound: &Bound| self.versions[0].compare.iter().any(|one| one.observable == bound.observable);
        let bounds = Bound::usual().into_iter().filter(compared);
        Ok(bounds.map(|bound| self.judged(&bound, &pairs, failure.clone())).collect())
    }

    /// Whether the 90% interval of the deviation, seed by seed, lies within the bound.
    fn judged(&self, bound: &Bound, pairs: &[[Option<MeasuredRun>; 2]], failure: Option<String>) -> StudyTest {
        let difference = |[own, reference]: &[Option<MeasuredRun>; 2]| {
            let value = |run: &Option<MeasuredRun>| run.as_ref()?.value(&bound.observable);
            Some(value(own)? - value(reference)?)
        };
        let differences: Option<Vec<f64>> = pairs.iter().map(difference).collect();
        let deviation = differences.as_deref().and_then(Ensemble::of);
        let (measured, outcome) = verdict(deviation, bound.value);
        StudyTest {
            name: format!("{}: {}", self.name, bound.observable),
            measured,
            right: format!(
                "the scene's settings are within {} of {}, the 90% interval too",
                bound.value, self.reference
            ),
            outcome,
            remark: failure,
        }
    }

    fn one(&self, version: &Scene, seed: u64) -> Result<MeasuredRun, KeptError> {
        Ok(self.place.kept.take(&self.runs(version, seed), &Makadam, seed)?.run)
    }

    fn runs<'s>(&'s self, version: &'s Scene, seed: u64) -> Runs<'s> {
        self.place.settings.measuring(version, &self.file, seed)
    }
}

/// What a deviation from the reference says against a bound; it is absent where a seed has no value.
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
mod tests {
    use super::*;

    #[test]
    fn the_interval_counts_and_not_the_mean_alone() {
        let of = |values: &[f64]| verdict(Ensemble::of(values), 0.5);
        assert_eq!(of(&[0.1, 0.2, 0.3]), ("0.20 (0.03 to 0.37), 3 seeds".into(), StudyOutcome::Passed));
        assert_eq!(of(&[-0.8, 0.2, 1.0]).1, StudyOutcome::Failed, "too wide");
        assert_eq!(of(&[0.41, 0.45, 0.55]).1, StudyOutcome::Failed, "too near");
        assert_eq!(of(&[-0.61, -0.6, -0.62]).1, StudyOutcome::Failed, "beyond");
        assert_eq!(of(&[0.1]).1, StudyOutcome::NotMeasured, "one seed tells no interval");
        assert_eq!(verdict(None, 0.5).1, StudyOutcome::NotMeasured);
    }
}
