//! The JSON contract of `makadam run`; its documentation is `validation/docs/json.md`.

use crate::provenance::Provenance;
use makadam::Balance;
use makadam::scene::Finding;
use makadam::solve::StopReason;
use makadam::sweep::Residuals;
use serde::Serialize;

/// Version of the JSON contract; raised when a field changes its meaning or goes away.
pub const JSON_VERSION: u32 = 1;

/// What `makadam run --json` prints and `run.json` holds.
#[derive(Clone, Debug, Serialize)]
pub struct RunSummary {
    /// [`JSON_VERSION`].
    pub version: u32,
    /// Always "run".
    pub command: String,
    /// Name of the scene.
    pub scene: String,
    /// Whether the run reached its last step.
    pub complete: bool,
    /// Why it did not.
    pub failure: Option<String>,
    /// Whether nothing was noticed on the way that makes the numbers doubtful.
    pub sound: bool,
    /// What was noticed on the way, one entry a kind.
    pub alarms: Vec<AlarmSummary>,
    /// What the settings were not expected to bear, told before the run.
    pub findings: Vec<Finding>,
    /// Steps at which the run was continued from a checkpoint.
    pub continued_at: Vec<u64>,
    /// Hash of positions, velocities and spins at the end, 16 hexadecimal digits.
    pub state_hash: String,
    /// Hash of the physics of the scene, 16 hexadecimal digits: what is measured, the duration and the solver's settings are left out.
    pub setup_hash: String,
    /// Steps taken.
    pub steps: u64,
    /// Time step, s.
    pub time_step: f64,
    /// Simulated time, s.
    pub simulated_seconds: f64,
    /// Wall time of stepping and output, s; preparing the start is left out.
    pub wall_seconds: f64,
    /// Number of grains.
    pub particles: usize,
    /// Contacts at the end.
    pub contacts: usize,
    /// Contacts times sweeps, summed over all steps.
    pub contact_sweeps: u64,
    /// Time in sweeps over contact sweeps, ns; absent if there were none.
    pub nanoseconds_per_contact_sweep: Option<f64>,
    /// Contact sweeps a second of time in sweeps; absent if there were none.
    pub contact_sweeps_per_second: Option<f64>,
    /// Wall time by phase, s.
    pub phase_seconds: PhaseTimes,
    /// Largest resident memory of the process, bytes.
    pub peak_bytes: u64,
    /// Memory that the simulation itself holds, bytes.
    pub simulation_bytes: u64,
    /// `simulation_bytes` a grain.
    pub bytes_per_particle: f64,
    /// The last solve and the worst one.
    pub residuals: Option<SolveSummary>,
    /// Where energy and momentum came from and went; absent without `--ledger`.
    pub balance: Option<Balance>,
    /// Measured over the frames that the scene names, by name.
    pub observables: std::collections::BTreeMap<String, Measured>,
    /// Why nothing was measured, where the run ended before the state that the scene wants measured.
    pub not_measured: Option<String>,
    /// What the scene measures and has no value of, by name, with why.
    #[serde(default)]
    pub without_value: std::collections::BTreeMap<String, String>,
    /// Folder of frames, CSV and JSON.
    pub output: String,
    /// Frames written.
    pub frames: usize,
    /// Where it came from.
    pub provenance: Provenance,
}

/// Alarms of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct AlarmSummary {
    /// What kind of thing was noticed, such as "overlap".
    pub kind: String,
    /// The first one: what, which grain, step and time.
    pub first: String,
    /// Number of looks that found it.
    pub count: u64,
    /// Whether the numbers of the run mean nothing.
    pub grave: bool,
}

/// Wall time by phase, s.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct PhaseTimes {
    /// Finding contacts.
    pub detect: f64,
    /// Turning contacts into constraints.
    pub constrain: f64,
    /// Sweeping over constraints.
    pub sweep: f64,
    /// Moving grains and walls.
    pub integrate: f64,
    /// Measuring and writing frames.
    pub output: f64,
}

/// How well the solves converged; residuals are in m/s.
#[derive(Clone, Debug, Serialize)]
pub struct SolveSummary {
    /// Sweeps of the last solve.
    pub sweeps: u32,
    /// Sweeps of a solve, on average over the run.
    pub mean_sweeps: f64,
    /// Sweeps of the longest solve.
    pub most_sweeps: u32,
    /// Solves that had to end before their residual was as small as asked for.
    pub unconverged: u64,
    /// Why the last solve stopped.
    pub stop_reason: StopReason,
    /// Last solve: `normal`, `tangential_u`, `tangential_v`, each with `rms` and `max`.
    #[serde(flatten)]
    pub last: Residuals,
    /// Largest root mean square residual of the normal direction over the run.
    pub worst_normal_rms: f64,
}

/// A measured value.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// Value.
    pub value: f64,
    /// Standard error over blocks of time, where there are several frames.
    pub standard_error: Option<f64>,
    /// Unit; empty where it has none.
    pub unit: String,
}
