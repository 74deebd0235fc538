//! Summary of a run: `run.json`, and its text on the terminal. `validation/docs/json.md` describes the fields.

use super::measured::Measurements;
use super::progress::{AlarmSummary, Plan, Progress};
use makadam::scene::Finding;
use makadam::solve::StopReason;
use makadam::sweep::Residuals;
use makadam::{Balance, FlowReport, Passed, Simulation, StageReport};
use makadam_frames::output::JSON_VERSION;
use makadam_frames::plan::setup_hash;
use makadam_frames::provenance::{Provenance, peak_bytes};
use makadam_view::draw::numbers::{duration, plural};
use makadam_view::draw::values;
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct RunSummary {
    version: u32,
    command: &'static str,
    scene: String,
    pub complete: bool,
    pub failure: Option<String>,
    sound: bool,
    alarms: Vec<AlarmSummary>,
    findings: Vec<Finding>,
    continued_at: Vec<u64>,
    state_hash: String,
    setup_hash: String,
    steps: u64,
    time_step: f64,
    simulated_seconds: f64,
    wall_seconds: f64,
    particles: usize,
    contacts: usize,
    contact_sweeps: u64,
    nanoseconds_per_contact_sweep: Option<f64>,
    contact_sweeps_per_second: Option<f64>,
    phase_seconds: PhaseTimes,
    peak_bytes: u64,
    simulation_bytes: u64,
    bytes_per_particle: f64,
    residuals: Option<SolveSummary>,
    balance: Option<Balance>,
    #[serde(skip_serializing_if = "Option::is_none")]
    flow: Option<FlowReport>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    stages: Vec<StageReport>,
    #[serde(flatten)]
    measurements: Measurements,
    output: String,
    frames: usize,
    provenance: Provenance,
}

#[derive(Serialize)]
struct PhaseTimes {
    detect: f64,
    constrain: f64,
    sweep: f64,
    integrate: f64,
    output: f64,
}

/// Convergence of the solves; residuals in m/s.
#[derive(Serialize)]
struct SolveSummary {
    sweeps: u32,
    mean_sweeps: f64,
    most_sweeps: u32,
    unconverged: u64,
    stop_reason: StopReason,
    #[serde(flatten)]
    last: Residuals,
    worst_normal_rms: f64,
}

impl RunSummary {
    /// Makes the summary of the run so far; `failure` is the reason for its incompleteness.
    pub fn new(
        plan: &Plan<'_>,
        simulation: &Simulation,
        progress: &Progress,
        measurements: Measurements,
        failure: Option<String>,
    ) -> RunSummary {
        let [detect, constrain, sweep, integrate] = progress.phases;
        let contact_sweeps = simulation.contact_sweeps() - progress.contact_sweeps_before;
        let has_sweeps = contact_sweeps > 0;
        let bytes = simulation.memory_bytes() as u64;
        RunSummary {
            version: JSON_VERSION,
            command: "run",
            scene: plan.scene.name.clone(),
            complete: failure.is_none(),
            failure,
            sound: progress.alarms.is_empty(),
            alarms: progress.alarms.values().cloned().collect(),
            findings: plan.findings.clone(),
            continued_at: progress.continued_at.clone(),
            state_hash: format!("{:016x}", simulation.state_hash()),
            setup_hash: setup_hash(plan.scene),
            steps: progress.steps,
            time_step: simulation.time_step(),
            simulated_seconds: simulation.time() - progress.started,
            wall_seconds: (progress.wall + progress.output_time).as_secs_f64(),
            particles: simulation.grains(),
            contacts: progress.contacts,
            contact_sweeps,
            nanoseconds_per_contact_sweep: has_sweeps.then(|| 1e9 * sweep / contact_sweeps as f64),
            contact_sweeps_per_second: has_sweeps.then(|| contact_sweeps as f64 / sweep),
            phase_seconds: PhaseTimes {
                detect,
                constrain,
                sweep,
                integrate,
                output: progress.output_time.as_secs_f64(),
            },
            peak_bytes: peak_bytes(),
            simulation_bytes: bytes,
            bytes_per_particle: bytes as f64 / simulation.grains().max(1) as f64,
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
            flow: simulation.flow(),
            stages: simulation.stages(),
            measurements,
            output: plan.output.display().to_string(),
            frames: progress.frames.frames,
            provenance: plan.provenance.clone(),
        }
    }

    /// Formats problems, observables, energy budget, then the computation and the files.
    pub fn text(&self) -> String {
        let ended = if self.complete { "" } else { " (not complete)" };
        let mut text = self.violations();
        text += &format!(
            "{}: {} grains, {:.4} s simulated in {} of wall time{ended}\n\n",
            self.scene,
            self.particles,
            self.simulated_seconds,
            duration(self.wall_seconds)
        );
        for StageReport { name, start, end, steps, ended } in &self.stages {
            let ended = if *ended { "" } else { ", not ended" };
            text += &format!("stage {name:<10} {start:.6} to {end:.6} s, {steps} steps{ended}\n");
        }
        let observables = self.observables();
        if !observables.is_empty() {
            text += &format!("{observables}\n");
        }
        if let Some(flow) = &self.flow {
            text += &format!("{}\n", passed(flow));
        }
        if let Some(balance) = &self.balance {
            text += &format!("{}\n", ledger(balance));
        }
        text += &self.computation();
        text + &format!("\nframes.mkd, observables.csv and run.json: {}", self.output)
    }

    fn violations(&self) -> String {
        if self.sound {
            return String::new();
        }
        let mut text = String::new();
        for alarm in self.alarms.iter().filter(|alarm| alarm.fatal) {
            text += &format!("THESE NUMBERS ARE INVALID: {}\n", alarm.first);
        }
        text += "NOT SOUND: the problems below make the numbers doubtful\n";
        for alarm in &self.alarms {
            let checks = plural(alarm.count as usize, "check");
            text += &format!("{:<16} {}; noticed in {checks}\n", alarm.kind, alarm.first);
        }
        text
    }

    /// Formats the observables, rounded by their standard errors.
    fn observables(&self) -> String {
        let Measurements { observables, not_measured, without_value } = &self.measurements;
        let measured = observables.iter();
        let mut text =
            values(measured.map(|(name, one)| (name.as_str(), one.value, one.standard_error, one.unit.as_str())));
        for (name, reason) in without_value {
            text += &format!("{name}: no value: {reason}\n");
        }
        if let Some(reason) = not_measured {
            text += &format!("not measured: {reason}\n");
        }
        text
    }

    /// Formats steps, solves, time and memory.
    fn computation(&self) -> String {
        let steps = if self.stages.is_empty() { format!(" of {:e} s", self.time_step) } else { String::new() };
        let mut text = format!("steps            {}{steps}\n", self.steps);
        if let Some(solve) = &self.residuals {
            let unconverged = match solve.unconverged {
                0 => String::new(),
                some => format!("; {some} ended before reaching the requested residual"),
            };
            text += &format!(
                "solves           {:.1} sweeps on average, {} at most{unconverged}\n\
                 residual         {:.2e} m/s normal (rms of the last solve), {:.2e} at worst\n",
                solve.mean_sweeps, solve.most_sweeps, solve.last.normal.rms, solve.worst_normal_rms
            );
        }
        if let (Some(rate), Some(cost)) = (self.contact_sweeps_per_second, self.nanoseconds_per_contact_sweep) {
            text += &format!(
                "contact sweeps   {} ({:.1} million per second, {cost:.1} ns each)\n",
                self.contact_sweeps,
                rate / 1e6
            );
        }
        let PhaseTimes { detect, constrain, sweep, integrate, output } = self.phase_seconds;
        let phases = [
            ("detect", detect),
            ("constrain", constrain),
            ("sweep", sweep),
            ("integrate", integrate),
            ("output", output),
        ];
        let total: f64 = phases.iter().map(|(_, seconds)| seconds).sum();
        let phases = phases.map(|(name, seconds)| format!("{name} {:.0}%", 100.0 * seconds / total.max(1e-300)));
        text += &format!(
            "time by phase    {}\n\
             memory           {:.0} bytes per grain, {:.1} MB at the peak of the process\n",
            phases.join(", "),
            self.bytes_per_particle,
            self.peak_bytes as f64 / 1e6
        );
        text + &format!("state hash       {}\n", self.state_hash)
    }
}

/// Formats what came and went, and the sources that are late.
fn passed(flow: &FlowReport) -> String {
    let amount = |one: &Passed| format!("{} ({:.4e} kg)", plural(one.grains as usize, "grain"), one.mass);
    let mut text = String::new();
    for (index, (came, lag)) in flow.inserted.iter().zip(&flow.lags).enumerate() {
        text += &format!("insert[{index}]        {}", amount(came));
        if *lag > flow.usual_lag {
            text += &format!("; late by {lag:.4} s: grains find no free place");
        }
        text.push('\n');
    }
    for (index, went) in flow.removed.iter().enumerate() {
        text += &format!("remove[{index}]        {}\n", amount(went));
    }
    text
}

/// Formats the energy and momentum budget.
fn ledger(balance: &Balance) -> String {
    let Balance { start, end, .. } = balance;
    let line = |name: &str, before: f64, after: f64| format!("{name} {before:.4e} to {after:.4e}");
    let states = [
        line("kinetic", start.kinetic, end.kinetic),
        line("potential", start.potential, end.potential),
        line("elastic", start.elastic, end.elastic),
    ];
    // Rare terms are left out if they are zero.
    let term = |name: &str, amount: f64, unit: &str| match amount {
        0.0 => String::new(),
        amount => format!(", {name} {amount:.4e}{unit}"),
    };
    let resistance = term("resistance to turning", balance.resistance, " J");
    let changes = term("changing gravity", balance.changing_gravity, "");
    let paths = term("paths of walls", balance.wall_paths, "");
    let released = term("contacts let go", balance.let_go, " J") + &term("grains that went", balance.outflow, " J");
    let inflow = term("grains that came", balance.inflow, "") + &term("changes of stage", balance.outside, "");
    let size = |vector: [f64; 3]| vector.iter().map(|component| component * component).sum::<f64>().sqrt();
    format!(
        "energy           {} J\n\
         lost to          friction {:.4e}, restitution {:.4e}, stabilisation {:.4e} J{resistance}{released}\n\
         gained from      walls {:.4e}, overlap at first touch {:.4e}{changes}, normals that turned {:.4e}{paths}{inflow} J; \
         closure error {:.2e} J\n\
         momentum         gravity gave {:.4e}, walls {:.4e} kg m/s; closure error {:.2e} kg m/s\n\
         angular momentum gravity gave {:.4e}, walls {:.4e}, overlaps {:.4e} kg m2/s; closure error {:.2e} kg m2/s\n",
        states.join(", "),
        balance.friction,
        balance.restitution,
        balance.stabilisation,
        balance.walls,
        balance.first_touch,
        balance.turning,
        balance.closure,
        size(balance.gravity_impulse),
        size(balance.wall_impulse),
        size(balance.momentum_closure),
        size(balance.gravity_angular_impulse),
        size(balance.wall_angular_impulse),
        size(balance.overlap_angular_impulse),
        size(balance.angular_momentum_closure),
    )
}
