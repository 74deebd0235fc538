//! A run's account of itself: what its summary needs and a simulation does not know. It travels in the checkpoint.

use super::measured::Mark;
use crate::output::TableWritten;
use crate::run_frames::StoreMark;
use makadam::StepReport;
use makadam::solve::StopReason;
use makadam::watch::Alarm;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Duration;

/// How far a run has come. Its size does not grow with the number of frames.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Progress {
    /// Simulated time at the start, s.
    pub started: f64,
    /// Contact sweeps at the start.
    pub contact_sweeps_before: u64,
    /// Wall time of the phases before the run was continued, s.
    pub phases: [f64; 4],
    /// Steps taken.
    pub steps: u64,
    /// Wall time of the steps.
    pub wall: Duration,
    /// Wall time of measuring and writing.
    pub output_time: Duration,
    /// The last step.
    pub last: Option<StepReport>,
    /// Largest root mean square residual of the normal direction, m/s.
    pub worst_normal_rms: f64,
    /// What the solves took.
    pub solves: Solves,
    /// Frames on disk, as far as a checkpoint speaks of them.
    pub frames: StoreMark,
    /// Rows on disk, as far as a checkpoint speaks of them.
    pub table: TableWritten,
    /// Steps that were taken before the last frame; absent before the first one.
    pub framed_at: Option<u64>,
    /// Grains of the last frame.
    pub particles: usize,
    /// Contacts of the last frame.
    pub contacts: usize,
    /// How far the frames that are measured at the end have come.
    pub measured: Mark,
    /// Steps at which the run was continued.
    pub continued_at: Vec<u64>,
    /// What was noticed, by kind.
    pub alarms: BTreeMap<String, AlarmCount>,
}

/// Alarms of one kind.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct AlarmCount {
    /// The first one.
    pub first: String,
    /// Number of looks that found it.
    pub count: u64,
    /// Whether it makes the numbers of the run worthless.
    pub grave: bool,
}

/// What the solves of a run took.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Solves {
    /// Solves with a contact.
    pub count: u64,
    /// Their sweeps.
    pub sweeps: u64,
    /// Sweeps of the longest one.
    pub most: u32,
    /// Those that ended before their residual was as small as asked for.
    pub unconverged: u64,
}

impl Progress {
    /// Takes note of a step.
    pub fn note(&mut self, report: StepReport) {
        self.worst_normal_rms = self.worst_normal_rms.max(report.solve.residuals.normal.rms);
        self.solves.count += u64::from(report.solve.reason != StopReason::NoContacts);
        self.solves.sweeps += u64::from(report.solve.sweeps);
        self.solves.most = self.solves.most.max(report.solve.sweeps);
        self.solves.unconverged += u64::from(report.solve.reason == StopReason::MaxSweeps);
        self.last = Some(report);
    }

    /// Counts an alarm; says it in words if it is the first of its kind.
    pub fn count(&mut self, alarm: &Alarm) -> Option<&str> {
        let known = self.alarms.entry(alarm.trouble.kind().into()).or_default();
        known.count += 1;
        if known.count > 1 {
            return None;
        }
        known.first = alarm.to_string();
        known.grave = alarm.trouble.is_grave();
        Some(&known.first)
    }
}
