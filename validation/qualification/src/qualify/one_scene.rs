//! One scene in several codes, compared.

use super::QualifyError;
use crate::report::Qualification;
use makadam_compare::codes::{Code, CodeError, CodeName};
pub use makadam_compare::compare::{
    Announce, CodeRuns, Comparison, FEW_SEEDS, Reference, Runs, Simulated, comparison, noticed,
};
use makadam_compare::scenes::Change;
use makadam_frames::plan::{Expectation, MeasuredScene};
use makadam_frames::provenance::account;
use rayon::prelude::*;
use std::path::Path;
use std::time::{Duration, Instant};

/// Codes of a comparison on a scene.
pub struct OneScene<'a> {
    /// Scene.
    pub scene: &'a MeasuredScene,
    /// File.
    pub scene_file: &'a Path,
    /// Changes to the scene of the file, which the report lists.
    pub changes: &'a [Change],
    /// Codes, the code under test first.
    pub codes: Vec<Box<dyn Code>>,
    /// Name of the code under test, which is always run.
    pub judged: &'a str,
    /// True if codes other than Makadam are run instead of taking their recorded references.
    pub live: bool,
    /// Number of seeds, counted from 1; absent, those that the scene registers, else as many as are recorded, or `FEW_SEEDS`.
    pub seeds: Option<u64>,
    /// Time step of explicit codes over the Rayleigh step.
    pub rayleigh_fraction: f64,
    /// Wall time after which a run is stopped.
    pub time_limit: Duration,
    /// Opens progress displays.
    pub announce: Announce<'a>,
}

/// Returns the default codes of a comparison: Makadam, and for live runs its reference codes; else all codes with a recorded table next to the
/// scene. Without such tables and without published numbers the reference codes are returned, so that the error names the missing ones.
pub fn usual_codes(scene_file: &Path, live: bool) -> Vec<CodeName> {
    let mut codes = codes_against(scene_file, live);
    if codes.len() == 1 && !Reference::is_published(scene_file) {
        codes.extend(CodeName::REFEREES);
    }
    codes
}

/// Returns the default codes for a comparison with a user's own code: Makadam, and for live runs its reference codes; else all codes
/// recorded on the scene, if any.
pub fn codes_against(scene_file: &Path, live: bool) -> Vec<CodeName> {
    let counts = |name: &CodeName| Reference::is_left(scene_file, name.code().name());
    let further = CodeName::REFEREES.into_iter().chain(CodeName::FURTHER_REFEREES);
    let mut codes = vec![CodeName::Makadam];
    match live {
        true => codes.extend(CodeName::REFEREES),
        false => codes.extend(further.filter(counts)),
    }
    codes
}

/// Comparison of one scene with its verdict.
pub struct Judged {
    /// Content of the report.
    pub qualification: Qualification,
    /// Interruption by the user, else the first failure of a run; tests without its values are not made.
    pub failure: Option<CodeError>,
}

impl OneScene<'_> {
    /// Returns the scene; without registered seeds where its margins, observables or seeds are not those of its file.
    fn registered(&self) -> MeasuredScene {
        let mut scene = self.scene.clone();
        if self.changes.iter().any(|change| REGISTERED.iter().any(|table| change.is_of(table))) {
            scene.measure.seeds = None;
        }
        scene
    }

    /// Runs the codes, or takes their recorded runs, and compares.
    ///
    /// # Errors
    /// [`QualifyError`]; a failed run is reported in addition to the verdict on the others.
    pub fn judge(self) -> Result<Judged, QualifyError> {
        let scene = &self.registered();
        if scene.compare.is_empty() {
            return Err(QualifyError::NothingToCompare(scene.name.clone()));
        }
        let clock = Instant::now();
        let reference = Reference::of_scene(self.scene_file)?;
        let usual = self.scene.measure.seeds.or_else(|| reference.as_ref().map(Reference::seeds));
        let seeds = self.seeds.or(usual).unwrap_or(FEW_SEEDS);
        let existing = self.codes.iter().find(|code| code.name() == self.judged).and_then(|code| code.seeds());
        let runs = Runs {
            seeds: existing.unwrap_or_else(|| (1..=seeds).collect()),
            rayleigh_fraction: self.rayleigh_fraction,
            ..Runs::of_one_seed(scene, self.scene_file, 1, self.time_limit, self.announce)
        };
        let changed = |change: &Change| format!("the scene is not as its file has it, but with {change} (--set)");
        let (mut notes, mut recorded) = (self.changes.iter().map(changed).collect::<Vec<_>>(), Vec::new());
        if scene.measure.seeds != self.scene.measure.seeds {
            notes.push("seeds are registered for what a file measures and compares, and --set has changed that".into());
        }
        let mut live: Vec<Box<dyn Code>> = Vec::new();
        for code in self.codes {
            if ["Makadam", self.judged].contains(&code.name()) || self.live {
                if code.version().is_none() {
                    return Err(CodeError::Missing { code: code.name() }.into());
                }
                live.push(code);
            } else {
                recorded.push(from_reference(code.as_ref(), reference.as_ref(), scene, &mut notes)?);
            }
        }
        let judged = live.iter().find(|code| code.name() == self.judged && self.judged != "Makadam");
        let first = judged.map(|code| first_seed(code.as_ref(), &runs)).transpose()?;
        let simulate = |code: &dyn Code| match &first {
            Some(_) if code.name() == self.judged => (code.name(), runs.of_seeds(&runs.seeds[1..]).simulate(code)),
            _ => (code.name(), runs.simulate(code)),
        };
        let mut simulated: Vec<_> = live.par_iter().map(|code| simulate(code.as_ref())).collect();
        if let (Some(first), Some((_, rest))) = (first, simulated.iter_mut().find(|(code, _)| *code == self.judged)) {
            rest.harvests.splice(0..0, first.harvests);
            rest.failures.splice(0..0, first.failures);
        }
        let side_by_side = rayon::current_num_threads().min(live.len() * runs.seeds.len());
        let (mut measured, mut failures) = (Vec::new(), Vec::new());
        for (code, simulated) in simulated {
            let mut failed = Vec::new();
            for (seed, error) in simulated.failures {
                failed.push(seed);
                notes.push(format!("{code}, seed {seed}: {error}"));
                failures.push(error);
            }
            notes.extend(noticed(code, &simulated.harvests));
            measured.push(CodeRuns { failed, ..CodeRuns::live(code, side_by_side, simulated.harvests) });
        }
        let failure = CodeError::foremost(failures);
        if let Some(error @ CodeError::Scene(_)) = failure {
            return Err(error.into());
        }
        measured.extend(recorded);
        if let Some(reference) = &reference {
            measured.extend(reference.published(scene));
            notes
                .extend(reference.not_compared(scene).iter().map(|name| format!("published and not compared: {name}")));
        }
        let scene = &match self.judged {
            "Makadam" => scene.clone(),
            _ => with_all_values(scene, &measured),
        };
        let qualification = Qualification {
            // Reports of one title are compared with each other, so the title names a user's own code.
            title: match self.judged {
                "Makadam" => format!("Comparison of codes on the scene {}", scene.name),
                own => format!("{own} on the scene {}", scene.name),
            },
            tier: "compare".into(),
            comparisons: vec![Comparison { judged: self.judged.into(), ..comparison(scene, &measured, notes) }],
            wall_seconds: clock.elapsed().as_secs_f64(),
            provenance: account(rayon::current_num_threads(), &[scene]),
            ..Qualification::default()
        };
        Ok(Judged { qualification, failure })
    }
}

/// Runs the first seed of a user's own code, so that unreadable frames are reported before all seeds have run.
fn first_seed(code: &dyn Code, runs: &Runs<'_>) -> Result<Simulated, CodeError> {
    let mut simulated = runs.of_seeds(&runs.seeds[..1]).simulate(code);
    match simulated.failures.first() {
        Some((_, CodeError::Output { .. })) => Err(simulated.failures.swap_remove(0).1),
        _ => Ok(simulated),
    }
}

/// Returns the scene with all observables of which each run of each code has a value; added ones have no margin.
fn with_all_values(scene: &MeasuredScene, codes: &[CodeRuns]) -> MeasuredScene {
    let mut scene = scene.clone();
    let is_whole = |code: &&CodeRuns| code.discarded.is_none() && code.failed.is_empty();
    let has = |code: &CodeRuns, name: &str| code.runs.iter().all(|run| run.value(name).is_some());
    let first = codes.first().and_then(|code| code.runs.first());
    for measured in first.iter().flat_map(|run| &run.measurements) {
        let name = &measured.observable;
        let is_compared = scene.compare.iter().any(|expectation| expectation.observable == *name);
        if !is_compared && codes.iter().filter(is_whole).all(|code| has(code, name)) {
            scene.compare.push(Expectation { observable: name.clone(), margin: None, at: Vec::new() });
        }
    }
    scene
}

/// Tables of a scene to which its registration applies.
const REGISTERED: [&str; 2] = ["measure", "compare"];

/// Returns the recorded runs of a code, or an error with the remedy.
fn from_reference(
    code: &dyn Code,
    reference: Option<&Reference>,
    scene: &MeasuredScene,
    notes: &mut Vec<String>,
) -> Result<CodeRuns, QualifyError> {
    let (code, contact_law) = (code.name(), code.contact_law());
    let Some(runs) = reference.and_then(|reference| reference.code_on(code, scene)) else {
        return Err(QualifyError::NotRecorded { code, scene: scene.name.clone() });
    };
    notes.push(format!("{code} was not run: its numbers are the recorded references ({})", runs.provenance));
    notes.extend(reference.into_iter().flat_map(|reference| reference.out_of_date(code, contact_law, scene)));
    Ok(runs)
}

#[cfg(test)]
#[path = "../../tests/unit/qualify_one_scene.rs"]
mod tests;
