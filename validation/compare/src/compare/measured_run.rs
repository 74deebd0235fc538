//! Stored result of one run, once its frames have been measured.

use super::FinalState;
use crate::codes::UNDAMPED_TANGENT;
use makadam_frames::plan::Scene;
use makadam_frames::provenance::processor;
use makadam_frames::recording::{Content, Noticed, Recording};
use makadam_measure::observables::Series;
use makadam_measure::observables::{ForcePool, Measurement, measure, series};
use serde::{Deserialize, Serialize};

/// One run of one code, measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredRun {
    /// The code.
    pub code: String,
    /// Its version.
    pub version: String,
    /// Seed of the initial positions.
    pub seed: u64,
    /// The law of its contacts ([`Code::contact_law`](crate::codes::Code::contact_law)).
    #[serde(default = "earlier_law")]
    pub contact_law: String,
    /// Time step, s; 0 where the code does not tell.
    pub time_step: f64,
    /// Time step over the Rayleigh step, for explicit codes.
    pub rayleigh_fraction: Option<f64>,
    /// Wall time of the time stepping, s.
    pub wall_seconds: f64,
    /// Processor time of the time stepping on one core, s; absent where the code does not tell, and of recorded runs: a line of `runs.csv`
    /// does not say it.
    #[serde(default)]
    pub core_seconds: Option<f64>,
    /// Simulated time, s.
    pub simulated_seconds: f64,
    /// Processor that it ran on.
    pub processor: String,
    /// When it ended, ISO 8601.
    pub date: String,
    /// Hash of the scene that was run ([`physics_hash`](makadam_frames::plan::physics_hash)); empty until the run is recorded.
    pub scene_hash: String,
    /// Measurements; a line of `runs.csv` does not hold them.
    #[serde(default)]
    pub measurements: Vec<Measurement>,
}

/// The law of runs that were recorded before it was noted.
fn earlier_law() -> String {
    UNDAMPED_TANGENT.into()
}

impl MeasuredRun {
    /// Value of an observable, if it was measured.
    pub fn value(&self, observable: &str) -> Option<f64> {
        self.measurements.iter().find(|measurement| measurement.observable == observable).map(|found| found.value)
    }

    /// Time of the stepping over simulated time: processor time, or wall time where nothing else is known.
    pub fn pace(&self) -> f64 {
        self.core_seconds.unwrap_or(self.wall_seconds) / self.simulated_seconds
    }
}

/// A measured run, and what pictures and distributions are made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Harvest {
    /// The run.
    pub run: MeasuredRun,
    /// Its normal forces.
    pub forces: ForcePool,
    /// Its observables over time.
    pub series: Vec<Series>,
    /// Its grains at the end.
    pub final_state: Option<FinalState>,
    /// Violations that a watchdog found.
    pub alarms: Vec<Noticed>,
    /// Content that its frames lack; observables that need it were not measured.
    pub lacks: Vec<Content>,
    /// Notes on its frames, one sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
}

impl Harvest {
    /// Measures a recording under a law of contacts that ended at `date` on this machine.
    pub fn of(scene: &Scene, recording: &Recording, contact_law: &str, date: String) -> Harvest {
        let mut forces = ForcePool::new(&recording.code);
        forces.add_recording(scene, recording);
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
                measurements: measure(scene, recording),
            },
            forces,
            alarms: recording.alarms.clone(),
            lacks: recording.lacks.clone(),
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

/// In sentences, what watchdogs noticed on the runs of a code, and what had to be assumed of their frames: each assumption once, with the
/// seeds that it is of.
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
