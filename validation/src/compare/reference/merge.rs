//! Taking new runs of a code into recorded references: beside its recorded runs, or in their place.

use super::{MeasuredRun, Reference};
use crate::compare::CodeRuns;

/// Why runs could not be put beside recorded ones. The references are then as they were.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// Runs of another scene, version, contact law or time step, or of a seed that is recorded already.
    #[error(
        "the run of {code}, seed {seed}, does not go with the recorded ones (scene, version, contact law and time step must be the \
         same, and the seed a new one); record all anew with --record --restart"
    )]
    Unlike {
        /// The code.
        code: String,
        /// Seed of the new run.
        seed: u64,
    },
    /// Forces were counted in other bins.
    #[error("the recorded forces of {code} are counted in other bins; record all anew with --record --restart")]
    Bins {
        /// The code.
        code: String,
    },
}

impl Reference {
    /// Takes in runs of one code, in place of what was recorded of it.
    pub fn replace(&mut self, mut code: CodeRuns, scene_hash: &str) {
        let name = code.code.clone();
        self.runs.retain(|run| run.code != name);
        self.take_runs(&mut code, scene_hash);
        exchange(&mut self.forces, |forces| forces.code == name, code.forces.take());
        self.take_first_seed(code);
    }

    /// Takes in runs of seeds that were not recorded yet and keeps those that were. The forces of both are pooled;
    /// series and final state stay those of the first seed.
    ///
    /// # Errors
    /// [`MergeError`]; nothing is changed then.
    pub fn add(&mut self, mut code: CodeRuns, scene_hash: &str) -> Result<(), MergeError> {
        let name = code.code.clone();
        let recorded: Vec<&MeasuredRun> = self.of(&name).collect();
        let goes_with = |new: &MeasuredRun, old: &&MeasuredRun| {
            let made = |run: &MeasuredRun| (run.version.clone(), run.contact_law.clone(), run.rayleigh_fraction);
            old.scene_hash == scene_hash && made(old) == made(new) && old.seed != new.seed
        };
        let unlike = code.runs.iter().find(|new| !recorded.iter().all(|old| goes_with(new, old)));
        if let Some(new) = unlike {
            return Err(MergeError::Unlike { code: name, seed: new.seed });
        }
        let first_seed = |runs: &mut dyn Iterator<Item = u64>| runs.min().unwrap_or(u64::MAX);
        let is_first = first_seed(&mut code.runs.iter().map(|run| run.seed))
            < first_seed(&mut recorded.iter().map(|run| run.seed));
        let before = self.forces.iter_mut().find(|forces| forces.code == name);
        match (before, code.forces.take()) {
            (Some(before), Some(more)) => *before = before.pooled(&more).ok_or(MergeError::Bins { code: name })?,
            (None, more) => self.forces.extend(more),
            (Some(_), None) => {}
        }
        self.take_runs(&mut code, scene_hash);
        if is_first {
            self.take_first_seed(code);
        }
        Ok(())
    }

    /// Takes over the runs of a code, in the order of the files.
    fn take_runs(&mut self, code: &mut CodeRuns, scene_hash: &str) {
        let stamped = code.runs.drain(..).map(|run| MeasuredRun { scene_hash: scene_hash.into(), ..run });
        self.runs.extend(stamped);
        self.runs.sort_by(|a, b| (&a.code, a.seed).cmp(&(&b.code, b.seed)));
    }

    /// Takes over series and final state, which are those of a code's first seed.
    fn take_first_seed(&mut self, code: CodeRuns) {
        let name = code.code;
        exchange(&mut self.series, |series| series.code == name, code.series);
        exchange(&mut self.final_states, |state| state.code == name, code.final_state);
    }
}

/// Puts new entries where the old ones were, or at the end, so that files change only where numbers do.
fn exchange<T>(list: &mut Vec<T>, is_old: impl Fn(&T) -> bool, new: impl IntoIterator<Item = T>) {
    let place = list.iter().position(&is_old).unwrap_or(list.len());
    list.retain(|entry| !is_old(entry));
    list.splice(place..place, new);
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample;
    use super::*;
    use crate::plan::physics_hash;

    /// The recorded runs of YADE with other seeds, for adding to a reference or for starting one.
    fn with_seeds(seeds: [u64; 2]) -> (Reference, CodeRuns, String) {
        let (scene, reference) = sample();
        let mut code = reference.code("YADE").unwrap();
        for (run, seed) in code.runs.iter_mut().zip(seeds) {
            run.seed = seed;
        }
        code.series.iter_mut().for_each(|series| series.seed = seeds[0]);
        code.final_state.as_mut().unwrap().seed = seeds[0];
        (reference, code, physics_hash(&scene))
    }

    fn seeds(reference: &Reference) -> Vec<u64> {
        reference.of("YADE").map(|run| run.seed).collect()
    }

    #[test]
    fn new_seeds_stand_beside_the_recorded_ones() {
        let (mut reference, code, hash) = with_seeds([3, 4]);
        let before = reference.clone();
        reference.add(code, &hash).unwrap();
        assert_eq!(seeds(&reference), [1, 2, 3, 4]);
        assert!(reference.of("YADE").all(|run| run.scene_hash == hash));
        let forces = |reference: &Reference, code: &str| reference.code(code).unwrap().forces.unwrap();
        assert_eq!(forces(&reference, "YADE").samples, 2 * forces(&before, "YADE").samples);
        assert_eq!(forces(&reference, "LIGGGHTS"), forces(&before, "LIGGGHTS"));
        // The first seed is still the one that was recorded.
        assert_eq!((&reference.series, &reference.final_states), (&before.series, &before.final_states));
    }

    #[test]
    fn a_new_first_seed_brings_its_series_and_its_final_state() {
        let (mut reference, code, hash) = with_seeds([3, 4]);
        reference.replace(code, &hash);
        let (_, code, _) = with_seeds([1, 2]);
        reference.add(code, &hash).unwrap();
        let code = reference.code("YADE").unwrap();
        assert_eq!(seeds(&reference), [1, 2, 3, 4]);
        assert_eq!((code.series[0].seed, code.final_state.unwrap().seed), (1, 1));
    }

    #[test]
    fn what_does_not_go_together_is_refused_and_changes_nothing() {
        let (reference, code, hash) = with_seeds([3, 4]);
        let refused = |code: CodeRuns, hash: &str| {
            let mut changed = reference.clone();
            let error = changed.add(code, hash).unwrap_err();
            assert_eq!(changed, reference);
            error
        };
        let mut version = code.clone();
        version.runs[1].version = "2.0".into();
        assert_eq!(refused(version, &hash), MergeError::Unlike { code: "YADE".into(), seed: 4 });
        assert_eq!(refused(code.clone(), "another"), MergeError::Unlike { code: "YADE".into(), seed: 3 });
        let mut seed = code.clone();
        seed.runs[0].seed = 2;
        assert_eq!(refused(seed, &hash), MergeError::Unlike { code: "YADE".into(), seed: 2 });
        let mut bins = code;
        bins.forces.as_mut().unwrap().force[0] = 0.5;
        assert_eq!(refused(bins, &hash), MergeError::Bins { code: "YADE".into() });
    }

    #[test]
    fn replacing_leaves_the_order_alone() {
        let (mut reference, _, hash) = with_seeds([1, 2]);
        let before = reference.clone();
        for code in ["LIGGGHTS", "YADE", "LIGGGHTS"] {
            reference.replace(before.code(code).unwrap(), &hash);
        }
        assert_eq!(reference, before);
    }
}
