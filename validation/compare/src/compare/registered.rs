//! Seeds that a scene registers before they are run, and runs that count.
//!
//! An interval of the difference errs with the probability that it states for one look at the runs. Who adds seeds until it lies inside the
//! margin errs more often: with looks at 8, 12, 16, 24, 32 and 48 seeds, 8% of differences as large as the margin pass a test of 2.5%. So
//! the number of seeds is part of the scene (`measure.seeds`), and runs of any other number are exploratory.

use super::{Comparison, MeasuredRun};
use makadam_frames::plan::Scene;
use makadam_view::draw::numbers::plural;

/// Largest fraction of the runs of a code that may be left out because they are not at rest.
const MOST_MOVING: f64 = 0.2;

/// Reason for which runs of these seeds are none that the scene has registered, as a clause; `None` for seeds 1 to the registered number.
pub(super) fn unregistered(scene: &Scene, seeds: impl Iterator<Item = u64>) -> Option<String> {
    let mut seeds: Vec<u64> = seeds.collect();
    seeds.sort_unstable();
    let made = plural(seeds.len(), "seed");
    match scene.measure.seeds {
        None => Some(format!(
            "{} registers no seeds, and {made} were run; give measure.seeds in its file before the runs",
            scene.name
        )),
        Some(registered) if seeds.iter().copied().eq(1..=registered) => None,
        Some(registered) if seeds.len() as u64 == registered => {
            Some(format!("{} registers seeds 1 to {registered} (measure.seeds), and others were run", scene.name))
        }
        Some(registered) => {
            Some(format!("{} registers {registered} seeds (measure.seeds), and {made} were run", scene.name))
        }
    }
}

impl Comparison {
    /// Reason for which the runs of the code under test are none that the scene has registered, as a clause; `None` where they are.
    pub fn unregistered(&self) -> Option<String> {
        let judged = self.codes.iter().find(|code| code.code == self.judged)?;
        unregistered(&self.scene, judged.seeds.iter().copied())
    }
}

/// Runs of a code by whether they are at rest at their end.
pub(super) struct Settled<'a> {
    /// Runs that count.
    pub at_rest: Vec<&'a MeasuredRun>,
    /// Seeds of the others.
    pub moving: Vec<u64>,
}

impl<'a> Settled<'a> {
    /// Tells runs at rest from others by their kinetic energy per grain; where a scene states no largest one, all runs count. A run without
    /// a kinetic energy is not known to be at rest.
    pub fn of(scene: &Scene, runs: &'a [MeasuredRun]) -> Settled<'a> {
        let largest = scene.measure.rest_energy.map(|energy| energy * scene.grain_count() as f64);
        let is_at_rest = |run: &&MeasuredRun| match (largest, run.value("kinetic_energy")) {
            (None, _) => true,
            (Some(largest), Some(energy)) => energy <= largest,
            (Some(_), None) => false,
        };
        let (at_rest, moving): (Vec<_>, Vec<_>) = runs.iter().partition(is_at_rest);
        Settled { at_rest, moving: moving.into_iter().map(|run| run.seed).collect() }
    }

    /// Reason for which none of the runs counts: more of them move than may be left out.
    pub fn refusal(&self, code: &str) -> Option<String> {
        let all = self.at_rest.len() + self.moving.len();
        let too_many = self.moving.len() as f64 > MOST_MOVING * all as f64;
        too_many.then(|| {
            format!("{} of {all} runs of {code} are not known to be at rest (measure.rest_energy)", self.moving.len())
        })
    }

    /// Seeds that are left out, in a sentence; `None` where there are none.
    pub fn note(&self, code: &str) -> Option<String> {
        let seeds: Vec<String> = self.moving.iter().map(u64::to_string).collect();
        (!seeds.is_empty()).then(|| {
            let all = self.at_rest.len() + seeds.len();
            format!(
                "{code}: {} of {all} runs are not at rest at their end and are left out (measure.rest_energy): seeds {}",
                seeds.len(),
                seeds.join(", ")
            )
        })
    }
}

#[cfg(test)]
#[path = "../../tests/unit/compare_registered.rs"]
mod tests;
