//! Recorded references: measurements of other codes on a scene, stored as CSV next to the scene.
//!
//! | file | holds |
//! | --- | --- |
//! | `runs.csv` | one line per run: code, version, contact law, seed, time step, wall time, processor, date, hash of the scene |
//! | `measurements.csv` | one line per run and observable |
//! | `forces.csv` | distribution of normal forces over their mean, all seeds of a code pooled |
//! | `series.csv` | observables over time, of each code's first seed |
//! | `final-state-CODE.csv` | grains at the end, of each code's first seed, to six significant digits |
//! | `published.csv` | numbers of a publication: one line per code, observable and time |

mod files;
mod published;

use super::{CodeRuns, FinalState, MeasuredRun, Source, Timing, distinct};
use crate::scenes;
pub use files::ReferenceError;
use makadam_frames::plan::{MeasuredScene, physics_hash};
use makadam_measure::observables::{ForceDistribution, Series};
use published::PublishedLine;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Recorded references of one scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reference {
    /// All runs, by code and seed.
    pub runs: Vec<MeasuredRun>,
    /// Distributions of normal forces, one per code.
    pub forces: Vec<ForceDistribution>,
    /// Observables over time, of the first seed of each code.
    pub series: Vec<Series>,
    /// Grains at the end, of the first seed of each code.
    pub final_states: Vec<FinalState>,
    /// Published numbers.
    published: Vec<PublishedLine>,
}

impl Reference {
    /// Returns the folder of a scene's references: `reference` next to a `scene.toml`, `NAME-reference` next to any other file.
    pub fn folder(scene_file: &Path) -> PathBuf {
        match scene_file.file_stem().and_then(|stem| stem.to_str()) {
            Some("scene") | None => scene_file.with_file_name("reference"),
            Some(stem) => scene_file.with_file_name(format!("{stem}-reference")),
        }
    }

    /// Returns true if a code has a line in the list of runs or a final state next to a scene, on a disk or in the program.
    pub fn is_left(scene_file: &Path, code: &str) -> bool {
        let folder = Reference::folder(&scenes::origin(scene_file));
        let runs = scenes::read(&folder.join("runs.csv")).unwrap_or_default();
        let is_of_code = |line: &str| line.split(',').next() == Some(code);
        String::from_utf8_lossy(&runs).lines().any(is_of_code)
            || scenes::read(&folder.join(final_state_file(code))).is_ok()
    }

    /// Codes that have runs.
    pub fn codes(&self) -> Vec<String> {
        distinct(self.runs.iter().map(|run| run.code.as_str())).into_iter().map(String::from).collect()
    }

    /// Largest number of seeds of any code.
    pub fn seeds(&self) -> u64 {
        let of = |code: &String| self.of(code).count() as u64;
        self.codes().iter().map(of).max().unwrap_or(0)
    }

    /// Returns the recorded runs of a code on the present scene, if there are any. Runs of the scene before a change are discarded, and
    /// missing seeds below the last one have failed.
    pub fn code_on(&self, code: &str, scene: &MeasuredScene) -> Option<CodeRuns> {
        let recorded = self.code(code)?;
        if self.is_current(code, scene) == Some(false) {
            let discarded =
                format!("{code} was recorded on another scene than this one, so record it anew with --record");
            let (discarded, runs, series) = (Some(discarded), Vec::new(), Vec::new());
            return Some(CodeRuns { discarded, runs, series, forces: None, final_state: None, ..recorded });
        }
        let last = recorded.runs.iter().map(|run| run.seed).max().unwrap_or(0);
        let failed = (1..=last).filter(|seed| recorded.runs.iter().all(|run| run.seed != *seed)).collect();
        Some(CodeRuns { failed, ..recorded })
    }

    /// Returns the recorded runs of a code, if there are any.
    pub fn code(&self, code: &str) -> Option<CodeRuns> {
        let runs: Vec<MeasuredRun> = self.of(code).cloned().collect();
        let first = runs.first()?;
        let fraction =
            first.rayleigh_fraction.map_or(String::new(), |f| format!(" at {:.0}% of the Rayleigh step", 100.0 * f));
        let provenance = format!(
            "recorded {} on {} with {} {} ({}): {} seeds{fraction}",
            days(&runs),
            distinct(runs.iter().map(|run| run.processor.as_str())).join(", "),
            first.code,
            first.version,
            first.contact_law,
            runs.len()
        );
        Some(CodeRuns {
            code: code.into(),
            source: Source::Recorded,
            timing: Timing::Recorded,
            provenance,
            forces: self.forces.iter().find(|forces| forces.code == code).cloned(),
            series: self.series.iter().filter(|series| series.code == code).cloned().collect(),
            final_state: self.final_states.iter().find(|state| state.code == code).cloned(),
            failed: Vec::new(),
            discarded: None,
            runs,
        })
    }

    /// Returns true if the runs of a code were made on the present scene; `None` without runs.
    pub fn is_current(&self, code: &str, scene: &MeasuredScene) -> Option<bool> {
        let now = physics_hash(scene);
        let mut runs = self.of(code).peekable();
        runs.peek()?;
        Some(runs.all(|run| run.scene_hash == now))
    }

    /// Lists the reasons why the recorded runs of a code are out of date, given its present contact law.
    pub fn out_of_date(&self, code: &str, contact_law: &str, scene: &MeasuredScene) -> Vec<String> {
        let mut reasons = Vec::new();
        if self.is_current(code, scene) == Some(false) {
            reasons.push(format!("the scene has changed since {code} was recorded: record anew with --record"));
        }
        let runs: Vec<&MeasuredRun> = self.of(code).collect();
        let others: Vec<&&MeasuredRun> = runs.iter().filter(|run| run.contact_law != contact_law).collect();
        if let Some(other) = others.first() {
            reasons.push(format!(
                "{} of {} recorded runs of {code} were made under the contact law '{}', and a run of today has '{contact_law}': \
                 record anew with --record",
                others.len(),
                runs.len(),
                other.contact_law
            ));
        }
        reasons
    }

    /// Runs of a code, in the order of their seeds.
    pub fn of(&self, code: &str) -> impl Iterator<Item = &MeasuredRun> {
        self.runs.iter().filter(move |run| run.code == code)
    }
}

/// Returns the day on which runs ended, or the first and the last of several.
fn days(runs: &[MeasuredRun]) -> String {
    let days = || runs.iter().map(|run| run.date.split('T').next().unwrap_or_default());
    match (days().min().unwrap_or_default(), days().max().unwrap_or_default()) {
        (first, last) if first == last => first.to_string(),
        (first, last) => format!("{first} to {last}"),
    }
}

/// A line of `measurements.csv`.
#[derive(Deserialize)]
struct MeasurementLine {
    code: String,
    seed: u64,
    observable: String,
    unit: String,
    value: f64,
    standard_error: Option<f64>,
    frames: usize,
}

/// Columns of `runs.csv`.
const RUN_COLUMNS: &str = "code version contact_law seed time_step rayleigh_fraction wall_seconds simulated_seconds processor date scene_hash";

/// Columns of `measurements.csv`.
const MEASUREMENT_COLUMNS: &str =
    "code version seed time_step rayleigh_fraction observable unit value standard_error frames";

/// Columns of `forces.csv`, and a line of it.
const FORCE_COLUMNS: &str = "code force_over_mean density samples";
type ForceLine = (String, f64, f64, usize);

/// Columns of `series.csv`, and a line of it.
const SERIES_COLUMNS: &str = "code seed observable time value";
type SeriesLine = (String, u64, String, f64, f64);

/// Columns of `final-state-CODE.csv` (m, m/s, rad/s), and a line of it.
const GRAIN_COLUMNS: &str = "id radius x y z vx vy vz wx wy wz";
type GrainLine = (u32, f64, [f64; 3], [f64; 3], [f64; 3]);

/// Name of the file with a code's final state.
fn final_state_file(code: &str) -> String {
    format!("final-state-{}.csv", code.to_lowercase())
}

impl Reference {
    /// Replaces the recorded runs of one code.
    pub fn replace(&mut self, code: CodeRuns, scene_hash: &str) {
        let name = code.code;
        let stamped = code.runs.into_iter().map(|run| MeasuredRun { scene_hash: scene_hash.into(), ..run });
        self.runs.retain(|run| run.code != name);
        self.runs.extend(stamped);
        self.runs.sort_by(|a, b| (&a.code, a.seed).cmp(&(&b.code, b.seed)));
        exchange(&mut self.forces, |forces| forces.code == name, code.forces);
        exchange(&mut self.series, |series| series.code == name, code.series);
        exchange(&mut self.final_states, |state| state.code == name, code.final_state);
    }
}

/// Puts new entries at the positions of the old ones, or at the end, so that files change only where numbers do.
fn exchange<T>(list: &mut Vec<T>, is_old: impl Fn(&T) -> bool, new: impl IntoIterator<Item = T>) {
    let place = list.iter().position(&is_old).unwrap_or(list.len());
    list.retain(|entry| !is_old(entry));
    list.splice(place..place, new);
}

#[cfg(test)]
#[path = "../../../tests/unit/compare_reference.rs"]
mod tests;
