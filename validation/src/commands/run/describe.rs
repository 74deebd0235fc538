//! A run's summary for people.

use crate::draw::numbers::{duration, plural};
use crate::draw::values;
use crate::output::RunSummary;
use makadam::Balance;

/// The summary for people: problems, physics, energy budget, then the computation and the files.
pub(super) fn describe(summary: &RunSummary) -> String {
    let ended = if summary.complete { "" } else { " (not complete)" };
    let mut text = findings(summary);
    text += &format!(
        "{}: {} grains, {:.4} s simulated in {} of wall time{ended}\n\n",
        summary.scene,
        summary.particles,
        summary.simulated_seconds,
        duration(summary.wall_seconds)
    );
    let physics = physics(summary);
    if !physics.is_empty() {
        text += &format!("{physics}\n");
    }
    if let Some(balance) = &summary.balance {
        text += &format!("{}\n", ledger(balance));
    }
    text += &computation(summary);
    text + &format!("\nframes.mkd, observables.csv and run.json: {}", summary.output)
}

/// The observables, rounded by their standard errors.
fn physics(summary: &RunSummary) -> String {
    let measured = summary.observables.iter();
    let mut text =
        values(measured.map(|(name, one)| (name.as_str(), one.value, one.standard_error, one.unit.as_str())));
    for (name, why) in &summary.without_value {
        text += &format!("{name}: no value: {why}\n");
    }
    if let Some(why) = &summary.not_measured {
        text += &format!("not measured: {why}\n");
    }
    text
}

/// Steps, solves, time and memory.
fn computation(summary: &RunSummary) -> String {
    let mut text = format!("steps            {} of {:e} s\n", summary.steps, summary.time_step);
    if let Some(solve) = &summary.residuals {
        text += &format!(
            "solves           {:.1} sweeps on average, {} at most{}\n",
            solve.mean_sweeps,
            solve.most_sweeps,
            match solve.unconverged {
                0 => String::new(),
                some => format!("; {some} ended before reaching the requested residual"),
            }
        );
        text += &format!(
            "residual         {:.2e} m/s normal (rms of the last solve), {:.2e} at worst\n",
            solve.last.normal.rms, solve.worst_normal_rms
        );
    }
    if let (Some(rate), Some(cost)) = (summary.contact_sweeps_per_second, summary.nanoseconds_per_contact_sweep) {
        text += &format!(
            "contact sweeps   {} ({:.1} million per second, {cost:.1} ns each)\n",
            summary.contact_sweeps,
            rate / 1e6
        );
    }
    let phases = &summary.phase_seconds;
    let shares = [
        ("detect", phases.detect),
        ("constrain", phases.constrain),
        ("sweep", phases.sweep),
        ("integrate", phases.integrate),
        ("output", phases.output),
    ];
    let total: f64 = shares.iter().map(|(_, seconds)| seconds).sum();
    let shares = shares.map(|(name, seconds)| format!("{name} {:.0}%", 100.0 * seconds / total.max(1e-300)));
    text += &format!("time by phase    {}\n", shares.join(", "));
    text += &format!(
        "memory           {:.0} bytes per grain, {:.1} MB at the peak of the process\n",
        summary.bytes_per_particle,
        summary.peak_bytes as f64 / 1e6
    );
    text + &format!("state hash       {}\n", summary.state_hash)
}

/// What was noticed on the way, at the head of the summary: it says what the numbers below are worth.
fn findings(summary: &RunSummary) -> String {
    if summary.sound {
        return String::new();
    }
    let mut text = String::new();
    for alarm in summary.alarms.iter().filter(|alarm| alarm.grave) {
        text += &format!("THESE NUMBERS ARE WORTHLESS: {}\n", alarm.first);
    }
    text += "NOT SOUND: the problems below make the numbers doubtful\n";
    for alarm in &summary.alarms {
        text += &format!("{:<16} {}; noticed in {}\n", alarm.kind, alarm.first, plural(alarm.count as usize, "check"));
    }
    text
}

/// The ledger in four lines.
fn ledger(balance: &Balance) -> String {
    let Balance { start, end, .. } = balance;
    let line = |name: &str, before: f64, after: f64| format!("{name} {before:.4e} to {after:.4e}");
    let states = [
        line("kinetic", start.kinetic, end.kinetic),
        line("potential", start.potential, end.potential),
        line("elastic", start.elastic, end.elastic),
    ];
    let resistance = match balance.resistance {
        0.0 => String::new(),
        lost => format!(", resistance to turning {lost:.4e} J"),
    };
    let changes = match balance.changing_gravity {
        0.0 => String::new(),
        gained => format!(", changing gravity {gained:.4e}"),
    };
    let paths = match balance.wall_paths {
        0.0 => String::new(),
        gained => format!(", paths of walls {gained:.4e}"),
    };
    let released = match balance.let_go {
        0.0 => String::new(),
        lost => format!(", contacts let go {lost:.4e} J"),
    };
    let size = |vector: [f64; 3]| vector.iter().map(|component| component * component).sum::<f64>().sqrt();
    format!(
        "energy           {} J\n\
         lost to          friction {:.4e}, restitution {:.4e}, stabilisation {:.4e} J{resistance}{released}\n\
         gained from      walls {:.4e}, overlap at first touch {:.4e}{changes}, normals that turned {:.4e}{paths} J; \
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
