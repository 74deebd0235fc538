//! How long each task of a step took: what a schedule is replayed from.

use serde::{Deserialize, Serialize};

/// Phase of a time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Candidate list.
    Detect,
    /// Gaps, normals, constraint data, lane groups, warm start.
    Constrain,
    /// Sweeps.
    Sweep,
    /// Forces, motion, remembering impulses.
    Integrate,
}

/// Tasks that may run at the same time; the next region starts when all are done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Phase that it belongs to.
    pub phase: Phase,
    /// Duration of each task, s. Work that is not cut into tasks is a region of one.
    pub tasks: Vec<f64>,
}

/// The regions of a step, in their order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepTrace {
    /// Regions.
    pub regions: Vec<Region>,
}

/// Gathers regions while a step runs.
#[derive(Debug, Default)]
pub(super) struct Tracer {
    trace: StepTrace,
}

impl Tracer {
    pub fn add(&mut self, phase: Phase, tasks: Vec<f64>) {
        self.trace.regions.push(Region { phase, tasks });
    }

    pub fn take(&mut self) -> StepTrace {
        std::mem::take(&mut self.trace)
    }
}
