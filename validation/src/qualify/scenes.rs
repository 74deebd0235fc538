//! The scenes of a qualification: what is recorded of each, the runs of Makadam, live runs of the peers, the comparison.

use super::jobs::{Job, weight};
use super::record::fingerprint_on_record;
use super::same_runs::twins;
use super::{LIVE_SEED, QualifyError, Settings};
use crate::compare::{
    CodeRuns, CodeSummary, Comparison, Harvest, KeptError, KeptRuns, LIVE_FRACTION, Reference, Runs, Timed, comparison,
    live_checks,
};
use crate::peers::{Code, Makadam, Purpose};
use crate::plan::Scene;
use crate::scenes::{self, SceneError};
use crate::statistics::CONFIDENCE;
use makadam::scene::SceneFileError;
use std::path::PathBuf;
use std::sync::Mutex;

/// What live runs of the peers came to beside their recorded ones, in sentences.
#[derive(Default)]
pub(super) struct AgainstRecorded {
    pub(super) outside: Vec<String>,
    pub(super) unchecked: Vec<String>,
    pub(super) failed: Vec<String>,
}

/// A scene with what is recorded on it.
pub(super) struct Case {
    /// Its folder under `reference-scenes`.
    pub(super) name: &'static str,
    pub(super) scene: Scene,
    file: PathBuf,
    recorded: Vec<CodeRuns>,
    seeds: u64,
    notes: Vec<String>,
    timings: Vec<CodeSummary>,
    /// Makadam's runs.
    harvests: Mutex<Vec<Harvest>>,
}

impl Case {
    /// A scene with no fewer than so many seeds of Makadam; `on_record`: the recorded numbers have to be those on record. Of `peers`
    /// there has to be something recorded, of `further` codes what is recorded counts.
    pub(super) fn open(
        name: &'static str,
        fewest_seeds: u64,
        on_record: bool,
        settings: &Settings<'_>,
        peers: &[Box<dyn Code>],
        further: &[Box<dyn Code>],
    ) -> Result<Case, QualifyError> {
        let file = scenes::find(name, &settings.roots)?;
        let scene = scenes::load(&file)?;
        // Without a margin the scene would be judged by nothing, and no count of the others would tell.
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
        let needed = peers.iter().map(|peer| (peer, true));
        for (peer, is_needed) in needed.chain(further.iter().map(|peer| (peer, false))) {
            let code = peer.name();
            let recorded = match reference.code_on(code, &case.scene) {
                Some(recorded) => recorded,
                None if is_needed => return Err(QualifyError::NotRecorded { code: code.into(), scene: name.into() }),
                None => continue,
            };
            let is_other = on_record && fingerprint_on_record(name, code) != Some(recorded.fingerprint());
            case.recorded.push(match is_other && recorded.discarded.is_none() {
                true => recorded
                    .without_runs(format!("the recorded numbers of {code} are not those on record (references.csv)")),
                false => recorded,
            });
            case.notes.extend(reference.out_of_date(code, peer.contact_law(), &case.scene));
        }
        if !case.recorded.is_empty() {
            case.notes.extend(Reference::unvouched(&case.file, &case.scene));
        }
        Ok(case)
    }

    fn runs<'s>(&'s self, settings: &'s Settings<'_>, seed: u64) -> Runs<'s> {
        settings.measuring(&self.scene, &self.file, seed)
    }

    /// The runs of Makadam.
    pub(super) fn jobs<'s>(&'s self, settings: &'s Settings<'_>, kept: &'s KeptRuns) -> Vec<Job<'s>> {
        let job = move |seed| Job {
            identity: KeptRuns::identity(&self.runs(settings, seed), &Makadam, seed),
            weight: weight(&self.scene),
            work: Box::new(move || {
                let harvest = kept.take(&self.runs(settings, seed), &Makadam, seed)?;
                self.harvests.lock().expect("nothing panics while it holds the lock").push(harvest);
                Ok(())
            }),
        };
        (1..=self.seeds).map(job).collect()
    }

    /// The comparison of all that was run with all that is recorded, by so many threads.
    pub(super) fn compared(self, threads: usize) -> Comparison {
        let mut harvests = self.harvests.into_inner().expect("nothing panics while it holds the lock");
        harvests.sort_by_key(|harvest| harvest.run.seed);
        let twins = twins(&harvests);
        harvests.retain(|harvest| twins.iter().all(|[_, twin]| *twin != harvest.run.seed));
        let mut notes = self.notes;
        notes.extend(twins.iter().map(|[seed, twin]| {
            format!("Makadam: seeds {seed} and {twin} are one and the same run, of which the second counts as failed")
        }));
        let failed = twins.into_iter().map(|[_, twin]| twin).collect();
        let own = CodeRuns { failed, ..CodeRuns::live("Makadam", threads, harvests) };
        let codes: Vec<CodeRuns> = std::iter::once(own).chain(self.recorded).collect();
        // The table of tiers is what a qualification registers. The scene of the runs stays that of its file, by which they are kept.
        let mut registered = self.scene;
        registered.measure.seeds = Some(self.seeds);
        let mut comparison = comparison(&registered, &codes, notes);
        comparison.codes.extend(self.timings);
        comparison
    }

    /// Times a code, nothing else of this command running, and notes how long it took; runs that an earlier start has kept are not made
    /// again.
    pub(super) fn time(
        &mut self,
        settings: &Settings<'_>,
        kept: &KeptRuns,
        code: &dyn Code,
    ) -> Result<Harvest, KeptError> {
        let runs = self.runs(settings, LIVE_SEED);
        let Timed { summary, harvest } = runs.time(code, LIVE_SEED, |runs| match runs.purpose {
            Purpose::Timing => kept.take_alone(runs, code, LIVE_SEED),
            Purpose::Measuring => kept.take(runs, code, LIVE_SEED),
        })?;
        self.timings.push(summary);
        Ok(harvest)
    }

    /// Number of observables that have a margin.
    pub(super) fn margins(&self) -> usize {
        self.scene.compare.iter().filter(|expectation| expectation.margin.is_some()).count()
    }

    /// Holds a live run of a peer against the spread of its recorded runs, each value with `confidence`.
    pub(super) fn check(&mut self, harvest: &Harvest, confidence: f64, found: &mut AgainstRecorded) {
        let run = &harvest.run;
        let recorded = self.recorded.iter().find(|recorded| recorded.code == run.code);
        let recorded = recorded.expect("a case is opened with what is recorded of every peer");
        let percent = 100.0 * LIVE_FRACTION;
        let head = format!("live {} (seed {}, {percent:.0}% of the Rayleigh step)", run.code, run.seed);
        let (scene, mut inside) = (&self.scene.name, Vec::new());
        for check in live_checks(&self.scene, run, recorded, confidence) {
            let name = &check.observable;
            match (check.value, check.interval, check.inside) {
                (Some(value), Some([low, high]), Some(true)) => {
                    inside.push(format!("{name} {value:.4} ({low:.4} to {high:.4})"));
                }
                (Some(value), Some([low, high]), _) => found.outside.push(format!(
                    "{scene}: {head} lies outside the interval that the recorded seeds predict: {name} {value:.4} ({low:.4} to {high:.4})"
                )),
                (None, _, _) => found.unchecked.push(format!("{scene}: {head} has no value of {name}")),
                (Some(_), None, _) => found.unchecked.push(format!(
                    "{scene}: {name} of the {head} has no recorded spread to be held against"
                )),
            }
        }
        if !inside.is_empty() {
            let listed = inside.join(", ");
            self.notes.push(format!("{head} lies inside the intervals that the recorded seeds predict ({:.2}% each, {:.0}% for all live values): {listed}",
                100.0 * confidence,
                100.0 * CONFIDENCE));
        }
    }
}
