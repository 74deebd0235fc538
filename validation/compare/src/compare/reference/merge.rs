//! Merging of new runs of a code into recorded references: next to its recorded runs, or instead of them.

use super::{MeasuredRun, Reference};
use crate::compare::CodeRuns;

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
    /// Runs of another scene, version, contact law, time step or bins of forces, or of a recorded seed; nothing is changed then.
    pub fn add(&mut self, mut code: CodeRuns, scene_hash: &str) -> Result<(), String> {
        let name = code.code.clone();
        let recorded: Vec<&MeasuredRun> = self.of(&name).collect();
        let goes_with = |new: &MeasuredRun, old: &&MeasuredRun| {
            let made = |run: &MeasuredRun| (run.version.clone(), run.contact_law.clone(), run.rayleigh_fraction);
            old.scene_hash == scene_hash && made(old) == made(new) && old.seed != new.seed
        };
        let unlike = code.runs.iter().find(|new| !recorded.iter().all(|old| goes_with(new, old)));
        if let Some(new) = unlike {
            return Err(format!(
                "the run of {name}, seed {}, does not go with the recorded ones (scene, version, contact law and time step must be the \
                 same, and the seed a new one); record all anew with --record --restart",
                new.seed
            ));
        }
        let first_seed = |runs: &mut dyn Iterator<Item = u64>| runs.min().unwrap_or(u64::MAX);
        let is_first = first_seed(&mut code.runs.iter().map(|run| run.seed))
            < first_seed(&mut recorded.iter().map(|run| run.seed));
        let before = self.forces.iter_mut().find(|forces| forces.code == name);
        match (before, code.forces.take()) {
            (Some(before), Some(more)) => {
                let problem = || {
                    format!(
                        "the recorded forces of {name} are counted in other bins; record all anew with --record --restart"
                    )
                };
                *before = before.pooled(&more).ok_or_else(problem)?;
            }
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
#[path = "../../../tests/unit/compare_reference_merge.rs"]
mod tests;
