//! Measured runs: the stored result of one run, and all runs of one code on one scene.

use super::{CodeSummary, FinalState, Source, Timing};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::processor;
use makadam_frames::recording::{Content, Noticed, Recording};
use makadam_measure::observables::{
    ForceDistribution, ForcePool, Measurement, Series, measured_in, series, unmeasured,
};
use serde::{Deserialize, Serialize};

/// Measured run of one code.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredRun {
    /// Code.
    pub code: String,
    /// Version.
    pub version: String,
    /// Seed of the initial positions.
    pub seed: u64,
    /// Law of its contacts ([`Code::contact_law`](crate::codes::Code::contact_law)).
    pub contact_law: String,
    /// Time step, s; 0 where the code does not report it.
    pub time_step: f64,
    /// Time step over the Rayleigh step, for explicit codes.
    pub rayleigh_fraction: Option<f64>,
    /// Wall time of the time stepping, s.
    pub wall_seconds: f64,
    /// Processor time of the time stepping on one core, s; absent where the code does not report it, and for recorded runs: `runs.csv`
    /// lacks it.
    #[serde(default)]
    pub core_seconds: Option<f64>,
    /// Simulated time, s.
    pub simulated_seconds: f64,
    /// Processor of the run.
    pub processor: String,
    /// Date of its end, ISO 8601.
    pub date: String,
    /// Hash of the scene of the run ([`physics_hash`](makadam_frames::plan::physics_hash)); empty until the run is recorded.
    pub scene_hash: String,
    /// Measurements; a line of `runs.csv` lacks them.
    #[serde(default)]
    pub measurements: Vec<Measurement>,
}

impl MeasuredRun {
    /// Value of an observable, if it was measured.
    pub fn value(&self, observable: &str) -> Option<f64> {
        self.measurements.iter().find(|measurement| measurement.observable == observable).map(|found| found.value)
    }

    /// Time of the stepping over simulated time: processor time, or wall time where that is absent.
    pub fn pace(&self) -> f64 {
        self.core_seconds.unwrap_or(self.wall_seconds) / self.simulated_seconds
    }
}

/// Measured run, and the data of its pictures and distributions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Harvest {
    /// Measured run.
    pub run: MeasuredRun,
    /// Normal forces.
    pub forces: ForcePool,
    /// Observables over time.
    pub series: Vec<Series>,
    /// Grains at the end.
    pub final_state: Option<FinalState>,
    /// Violations that a watchdog found.
    pub alarms: Vec<Noticed>,
    /// Content that its frames lack; observables that need the content were not measured.
    pub lacks: Vec<Content>,
    /// Requested observables without a value, with the reason.
    #[serde(default)]
    pub without_value: Vec<(String, String)>,
    /// Notes on its frames, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
}

impl Harvest {
    /// Measures a recording that ended at `date` on this machine, under a contact law.
    pub fn of(scene: &MeasuredScene, recording: &Recording, contact_law: &str, date: String) -> Harvest {
        let mut forces = ForcePool::new(&recording.code);
        forces.add_recording(scene, recording);
        let measured = measured_in(scene, recording);
        let without = unmeasured(scene, &recording.lacks, &measured);
        Harvest {
            run: MeasuredRun {
                code: recording.code.clone(),
                version: recording.version.clone(),
                contact_law: contact_law.into(),
                seed: recording.seed,
                time_step: recording.time_step,
                rayleigh_fraction: recording.rayleigh_fraction,
                wall_seconds: recording.wall_seconds,
                core_seconds: recording.core_seconds,
                simulated_seconds: recording.simulated_seconds,
                processor: processor(),
                date,
                scene_hash: String::new(),
                measurements: measured.measurements,
            },
            forces,
            alarms: recording.alarms.clone(),
            lacks: recording.lacks.clone(),
            without_value: without.into_iter().map(|one| (one.observable.into(), one.reason)).collect(),
            notes: recording.notes.clone(),
            series: series(scene, recording),
            final_state: recording.frames.last().map(|frame| FinalState {
                code: recording.code.clone(),
                seed: recording.seed,
                time: frame.time,
                particles: frame.particles.clone(),
            }),
        }
    }
}

/// Returns sentences on the watchdog violations in the runs of a code, and on assumptions about their frames: each assumption once, with
/// its seeds.
pub fn noticed(code: &str, harvests: &[Harvest]) -> Vec<String> {
    let alarms_of = |harvest: &Harvest| {
        let seed = harvest.run.seed;
        harvest.alarms.iter().map(|alarm| format!("{code}, seed {seed}: {}", alarm.words())).collect::<Vec<_>>()
    };
    let mut known: Vec<(&str, Vec<u64>)> = Vec::new();
    for harvest in harvests {
        for note in &harvest.notes {
            match known.iter_mut().find(|(text, _)| text == note) {
                Some((_, seeds)) => seeds.push(harvest.run.seed),
                None => known.push((note, vec![harvest.run.seed])),
            }
        }
    }
    let sentence = |(note, seeds): (&str, Vec<u64>)| match &seeds[..] {
        [seed] => format!("{code}, seed {seed}: {note}"),
        all if all.len() == harvests.len() => format!("{code}, all {} seeds: {note}", all.len()),
        some => {
            let some: Vec<String> = some.iter().map(ToString::to_string).collect();
            format!("{code}, seeds {}: {note}", some.join(", "))
        }
    };
    harvests.iter().flat_map(alarms_of).chain(known.into_iter().map(sentence)).collect()
}

/// Bins of a force distribution and their width in mean forces.
const FORCE_BINS: (usize, f64) = (32, 0.25);

/// Runs of one code, in the order of their seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct CodeRuns {
    /// Code.
    pub code: String,
    /// Live or recorded.
    pub source: Source,
    /// Timing of the runs.
    pub timing: Timing,
    /// Provenance of the numbers, as a sentence.
    pub provenance: String,
    /// Successful runs.
    pub runs: Vec<MeasuredRun>,
    /// Requested seeds whose runs failed: the measurements of the code lack their values.
    pub failed: Vec<u64>,
    /// Reason why none of the runs counts; absent where they do.
    pub discarded: Option<String>,
    /// Normal forces of all runs.
    pub forces: Option<ForceDistribution>,
    /// Observables over time in the run with the first seed.
    pub series: Vec<Series>,
    /// Grains at the end of the run with the first seed.
    pub final_state: Option<FinalState>,
}

impl CodeRuns {
    /// Returns new runs for measuring, with up to `side_by_side` of them in parallel.
    pub fn live(code: &str, side_by_side: usize, mut harvests: Vec<Harvest>) -> CodeRuns {
        harvests.sort_by_key(|harvest| harvest.run.seed);
        let mut pool = ForcePool::new(code);
        harvests.iter().for_each(|harvest| pool.merge(&harvest.forces));
        let (bins, width) = FORCE_BINS;
        CodeRuns {
            code: code.into(),
            source: Source::Live,
            timing: if side_by_side > 1 { Timing::SideBySide } else { Timing::Measuring },
            provenance: match side_by_side {
                0 | 1 => "run by this command, one run after the other".into(),
                several => format!("run by this command, up to {several} runs side by side"),
            },
            forces: (pool.samples() > 0).then(|| pool.distribution(bins, width)),
            series: harvests.first().map(|first| first.series.clone()).unwrap_or_default(),
            final_state: harvests.first().and_then(|first| first.final_state.clone()),
            runs: harvests.into_iter().map(|harvest| harvest.run).collect(),
            failed: Vec::new(),
            discarded: None,
        }
    }

    /// Values of an observable, one per run that has it.
    pub fn values(&self, observable: &str) -> Vec<f64> {
        self.runs.iter().filter_map(|run| run.value(observable)).collect()
    }

    /// Summarises the runs; `None` without any.
    pub fn summary(&self) -> Option<CodeSummary> {
        let first = self.runs.first()?;
        let mut pace: Vec<f64> = self.runs.iter().map(MeasuredRun::pace).collect();
        pace.sort_by(f64::total_cmp);
        let middle = (pace[(pace.len() - 1) / 2] + pace[pace.len() / 2]) / 2.0;
        Some(CodeSummary {
            code: self.code.clone(),
            version: first.version.clone(),
            source: self.source,
            seeds: self.runs.iter().map(|run| run.seed).collect(),
            time_step: Some(first.time_step).filter(|step| *step > 0.0),
            rayleigh_fraction: first.rayleigh_fraction,
            wall_seconds_per_simulated_second: middle,
            timing: self.timing,
            processor: first.processor.clone(),
            provenance: self.provenance.clone(),
        })
    }
}
