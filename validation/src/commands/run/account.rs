//! The summary of a run, finished or not.

use super::plan::Plan;
use super::progress::Progress;
use crate::output::{AlarmSummary, JSON_VERSION, PhaseTimes, RunSummary, SolveSummary};
use crate::plan::setup_hash;
use crate::provenance::peak_bytes;
use makadam::Simulation;
use std::collections::BTreeMap;

/// What a summary is made from.
pub(super) struct Account<'a> {
    plan: &'a Plan<'a>,
    simulation: &'a Simulation,
    progress: &'a Progress,
    /// Wall time of the phases, s.
    pub phases: [f64; 4],
    /// Frames on disk.
    pub frames: usize,
}

impl<'a> Account<'a> {
    /// The account of a run as it is now, with the times and frames of its beginning.
    pub fn new(plan: &'a Plan<'a>, simulation: &'a Simulation, progress: &'a Progress) -> Account<'a> {
        Account { plan, simulation, progress, phases: progress.phases, frames: progress.frames.frames }
    }

    /// The summary, without what was measured; `failure` is why the run is not complete.
    pub fn summary(&self, failure: Option<String>) -> RunSummary {
        let Account { simulation, progress, .. } = self;
        let [detect, constrain, sweep, integrate] = self.phases;
        let contact_sweeps = simulation.contact_sweeps() - progress.contact_sweeps_before;
        let some = contact_sweeps > 0;
        let bytes = simulation.memory_bytes() as u64;
        let alarms = progress.alarms.iter().map(|(kind, alarm)| AlarmSummary {
            kind: kind.clone(),
            first: alarm.first.clone(),
            count: alarm.count,
            grave: alarm.grave,
        });
        RunSummary {
            version: JSON_VERSION,
            command: "run".into(),
            scene: self.plan.scene.name.clone(),
            complete: failure.is_none(),
            failure,
            sound: progress.alarms.is_empty(),
            alarms: alarms.collect(),
            findings: self.plan.findings.clone(),
            continued_at: progress.continued_at.clone(),
            state_hash: format!("{:016x}", simulation.state_hash()),
            setup_hash: setup_hash(self.plan.scene),
            steps: progress.steps,
            time_step: simulation.time_step(),
            simulated_seconds: simulation.time() - progress.started,
            wall_seconds: (progress.wall + progress.output_time).as_secs_f64(),
            particles: progress.particles,
            contacts: progress.contacts,
            contact_sweeps,
            nanoseconds_per_contact_sweep: some.then(|| 1e9 * sweep / contact_sweeps as f64),
            contact_sweeps_per_second: some.then(|| contact_sweeps as f64 / sweep),
            phase_seconds: PhaseTimes {
                detect,
                constrain,
                sweep,
                integrate,
                output: progress.output_time.as_secs_f64(),
            },
            peak_bytes: peak_bytes(),
            simulation_bytes: bytes,
            bytes_per_particle: bytes as f64 / progress.particles.max(1) as f64,
            residuals: progress.last.map(|report| SolveSummary {
                sweeps: report.solve.sweeps,
                mean_sweeps: progress.solves.sweeps as f64 / progress.solves.count.max(1) as f64,
                most_sweeps: progress.solves.most,
                unconverged: progress.solves.unconverged,
                stop_reason: report.solve.reason,
                last: report.solve.residuals,
                worst_normal_rms: progress.worst_normal_rms,
            }),
            balance: simulation.balance(),
            observables: BTreeMap::new(),
            not_measured: Some("the run is not at its end".into()),
            without_value: BTreeMap::new(),
            output: self.plan.output.display().to_string(),
            frames: self.frames,
            provenance: self.plan.provenance.clone(),
        }
    }
}
