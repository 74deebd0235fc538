//! Runs that a reference lacks.

use super::{MeasuredRun, Reference};

/// Runs of one code that a reference should hold.
#[derive(Clone, Debug)]
pub struct Wanted<'a> {
    pub code: &'a str,
    /// Its version, if it is installed; if not, what is recorded may be of any one version.
    pub version: Option<&'a str>,
    pub contact_law: &'a str,
    /// Hash of the scene as it is now ([`physics_hash`](makadam_frames::plan::physics_hash)).
    pub scene_hash: &'a str,
    /// Time step over the Rayleigh step.
    pub rayleigh_fraction: f64,
    /// Seeds of the initial positions.
    pub seeds: &'a [u64],
}

/// Runs that a reference lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// Seeds to measure or run.
    pub seeds: Vec<u64>,
    /// Reason for which they replace the recorded runs; `None` where these stay.
    pub replaces: Option<String>,
}

impl Reference {
    /// The wanted seeds that are not recorded yet. They are all wanted seeds if any recorded run of the code
    /// was made otherwise: such runs are not mixed, and their pooled forces cannot be taken apart again.
    pub fn missing(&self, wanted: &Wanted<'_>) -> Missing {
        let recorded: Vec<&MeasuredRun> = self.of(wanted.code).collect();
        let version = wanted.version.or_else(|| recorded.first().map(|run| run.version.as_str())).unwrap_or_default();
        let replaces = recorded.iter().find_map(|run| made_otherwise(run, wanted, version));
        let is_missing = |seed: &u64| replaces.is_some() || recorded.iter().all(|run| run.seed != *seed);
        Missing { seeds: wanted.seeds.iter().copied().filter(is_missing).collect(), replaces }
    }
}

/// In what a recorded run differs from the wanted ones, seeds aside.
fn made_otherwise(run: &MeasuredRun, wanted: &Wanted<'_>, version: &str) -> Option<String> {
    if run.scene_hash != wanted.scene_hash {
        return Some("the scene has changed since".into());
    }
    if run.version != version {
        return Some(format!("they are of version {}, not {version}", run.version));
    }
    if run.contact_law != wanted.contact_law {
        return Some(format!("they are of the contact law '{}', not '{}'", run.contact_law, wanted.contact_law));
    }
    if run.rayleigh_fraction != Some(wanted.rayleigh_fraction) {
        let recorded = run.rayleigh_fraction.map_or("another share".into(), percent);
        let asked = percent(wanted.rayleigh_fraction);
        return Some(format!("they are at {recorded} of the Rayleigh step, and {asked} is asked for"));
    }
    None
}

/// A fraction in percent, without digits that say nothing.
fn percent(fraction: f64) -> String {
    format!("{}%", (fraction * 1e8).round() / 1e6)
}

#[cfg(test)]
#[path = "../../../tests/unit/compare_reference_missing.rs"]
mod tests;
