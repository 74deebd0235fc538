//! Plan and progress of a run.

use super::measured::Mark;
use makadam::StepReport;
use makadam::scene::Finding;
use makadam::solve::StopReason;
use makadam::watch::Alarm;
use makadam_frames::output::TableWritten;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::Provenance;
use makadam_frames::run_frames::StoreMark;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

/// Run and its storage.
pub(super) struct Plan<'a> {
    pub scene: &'a MeasuredScene,
    pub seed: u64,
    pub output: PathBuf,
    /// Wall time between checkpoints.
    pub interval: Duration,
    /// Preflight warnings.
    pub findings: Vec<Finding>,
    pub provenance: Provenance,
}

/// Progress of a run, stored in its checkpoint. Its size does not grow with the number of frames.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Progress {
    /// Simulated time at the start, s.
    pub started: f64,
    /// Contact sweeps at the start.
    pub contact_sweeps_before: u64,
    /// Wall time of the phases before the run was resumed, s.
    pub phases: [f64; 4],
    pub steps: u64,
    /// Wall time of the steps.
    pub wall: Duration,
    /// Wall time of measurement and output.
    pub output_time: Duration,
    pub last: Option<StepReport>,
    /// Largest root mean square residual of the normal direction, m/s.
    pub worst_normal_rms: f64,
    pub solves: Solves,
    /// Frames on disk, for the checkpoint.
    pub frames: StoreMark,
    /// Rows on disk, for the checkpoint.
    pub table: TableWritten,
    /// Steps before the last frame; absent before the first frame.
    pub framed_at: Option<u64>,
    /// Contacts of the last frame.
    pub contacts: usize,
    /// Frames to measure at the end.
    pub measured: Mark,
    /// Steps at which the run was resumed.
    pub continued_at: Vec<u64>,
    /// Violations by kind.
    pub alarms: BTreeMap<String, AlarmSummary>,
}

/// Violations of one kind; `fatal` ones invalidate the numbers of the run.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct AlarmSummary {
    pub kind: String,
    pub first: String,
    /// Number of checks with such a violation.
    pub count: u64,
    #[serde(rename = "grave")]
    pub fatal: bool,
}

/// Effort of the solves of a run.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Solves {
    /// Solves with a contact.
    pub count: u64,
    /// Total number of sweeps.
    pub sweeps: u64,
    /// Sweeps of the longest solve.
    pub most: u32,
    /// Solves that ended before the requested residual.
    pub unconverged: u64,
}

impl Progress {
    pub fn note(&mut self, report: StepReport) {
        self.worst_normal_rms = self.worst_normal_rms.max(report.solve.residuals.normal.rms);
        self.solves.count += u64::from(report.solve.reason != StopReason::NoContacts);
        self.solves.sweeps += u64::from(report.solve.sweeps);
        self.solves.most = self.solves.most.max(report.solve.sweeps);
        self.solves.unconverged += u64::from(report.solve.reason == StopReason::MaxSweeps);
        self.last = Some(report);
    }

    /// Counts an alarm; returns its text if it is the first of its kind.
    pub fn count(&mut self, alarm: &Alarm) -> Option<&str> {
        let kind = alarm.trouble.kind();
        let known = self.alarms.entry(kind.into()).or_insert_with(|| AlarmSummary {
            kind: kind.into(),
            first: alarm.to_string(),
            count: 0,
            fatal: alarm.trouble.is_fatal(),
        });
        known.count += 1;
        (known.count == 1).then_some(&known.first)
    }
}
