//! Steps before a run: preflight warnings, memory, the start of the simulation.

use super::{Console, Failure};
use makadam::Simulation;
use makadam::scene::{Finding, Stop};
use makadam_compare::prepared::{Start, is_ready, start};
use makadam_compare::scenes;
use makadam_frames::execution::Execution;
use makadam_frames::output::cache_folder;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::stepping::{Stepping, steps_in};
use makadam_measure::observables::impossible;
use std::path::Path;

/// Prints preflight warnings on standard error; returns the findings, which `run.json` lists as well.
pub(super) fn tell_findings(scene: &MeasuredScene, file: &Path, console: &Console) -> Vec<Finding> {
    let text = scenes::text(file).ok();
    let mut findings = scene.findings(text.as_deref());
    findings.extend(impossible(scene, text.as_deref()));
    for finding in &findings {
        let line = finding.line.map(|line| format!(":{line}")).unwrap_or_default();
        console.warn(&format!("{}{line}: {finding}", file.display()));
    }
    findings
}

/// Refuses a scene that needs more memory than available.
pub(super) fn refuse_beyond_memory(scene: &MeasuredScene, file: &Path) -> Result<(), Failure> {
    match available_bytes() {
        Some(available) if scene.memory() > available => Err(Failure::Running(beyond(scene, file, available))),
        _ => Ok(()),
    }
}

/// Refuses a picture that needs more memory to draw than available.
pub(super) fn refuse_picture_beyond_memory(size: [usize; 2], needed: u64) -> Result<(), Failure> {
    match available_bytes() {
        Some(available) if needed > available => Err(Failure::Running(picture_beyond(size, needed, available))),
        _ => Ok(()),
    }
}

fn picture_beyond([width, height]: [usize; 2], needed: u64, available: u64) -> String {
    let share = (0.9 * available as f64 / needed as f64).sqrt();
    let [across, down] = [width, height].map(|side| (side as f64 * share) as usize);
    format!(
        "drawing {width}x{height} pixels takes some {} of memory, and {} are available; give a smaller --size, such as {across}x{down}",
        gigabytes(needed),
        gigabytes(available)
    )
}

fn gigabytes(bytes: u64) -> String {
    format!("{:.1} GB", bytes as f64 * 1e-9)
}

fn beyond(scene: &MeasuredScene, file: &Path, available: u64) -> String {
    let grains = scene.most_grains();
    let few = (grains as f64 * available as f64 / scene.memory() as f64 / 1e3).floor() * 1e3;
    format!(
        "{}: {grains} grains take some {} of memory, and {} are available; lower population.count to some {few} grains, end other \
         programs, or use a machine with more",
        file.display(),
        gigabytes(scene.memory()),
        gigabytes(available)
    )
}

/// Returns the available memory of the system, bytes; `None` if the system does not report it.
fn available_bytes() -> Option<u64> {
    std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| of_meminfo(&text))
}

/// Returns available memory and free swap, bytes.
fn of_meminfo(text: &str) -> Option<u64> {
    let field = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.trim_start_matches(':').split_whitespace().next()?.parse::<u64>().ok()
    };
    Some(1024 * (field("MemAvailable")? + field("SwapFree").unwrap_or(0)))
}

/// Refuses solves with a wall-time budget.
pub(super) fn refuse_time_budget(scene: &MeasuredScene) -> Result<(), Failure> {
    match scene.solver.stop {
        Stop::TimeBudget { .. } => Err(Failure::Usage(format!(
            "the solves of {} stop after a wall time, so no two runs do the same work; set solver.stop to sweeps or \
             residual",
            scene.name
        ))),
        _ => Ok(()),
    }
}

/// Refuses to record next to a scene without a folder.
pub(super) fn refuse_without_folder(file: &Path) -> Result<(), Failure> {
    let origin = match (scenes::is_built_in(file), scenes::is_given(file)) {
        (_, true) => "was given on the command line or on standard input",
        (true, false) => "is a scene built into the program",
        (false, false) => return Ok(()),
    };
    Err(Failure::Usage(format!(
        "{} {origin}, so there is no folder to record into; run where a folder reference-scenes contains it, or give the path to a file",
        file.display()
    )))
}

/// Returns the simulation at the start of its run, with a progress bar during the preparation of a flowing state.
pub(super) fn begin(
    scene: &MeasuredScene,
    seed: u64,
    file: &Path,
    execution: &Execution,
    console: &Console,
) -> Result<(Simulation, Start), Failure> {
    if let Some(prepare) = scene.prepare.as_ref().filter(|_| !is_ready(scene, seed)) {
        console.note(&format!(
            "{} starts from a flowing state, which is prepared first: {} steps of {:e} s, {} s of simulated time, in addition to \
             the run's own steps; it is stored under {} for later runs",
            scene.name,
            steps_in(prepare.duration, prepare.step),
            prepare.step,
            prepare.duration,
            cache_folder()?.join("prepared").display(),
        ));
    }
    let bar = console.bar("preparing the flow");
    let (simulation, start) = start(scene, seed, file, execution, &|fraction| bar.set(fraction))?;
    if let Start::Prepared(file) = &start {
        console.note(&format!("starting from the flowing state {}", file.display()));
    }
    Ok((simulation, start))
}

/// Simulates for a time, s.
pub(super) fn settle(simulation: &mut Simulation, seconds: f64, console: &Console) -> Result<(), Failure> {
    let bar = console.bar("settling");
    let steps = steps_in(seconds, simulation.time_step());
    let settled = Stepping::new(steps, &|fraction| bar.set(fraction)).carry_out(simulation, |_, _| {});
    settled.map(|_| ()).map_err(|_| Failure::interrupted("none, the flowing state was not finished"))
}

/// Returns the simulation at the start of its run; without a prepared flowing state, settled for a time (s): newly placed grains have
/// hardly any contacts.
pub(super) fn flowing(
    scene: &MeasuredScene,
    seed: u64,
    file: &Path,
    execution: &Execution,
    seconds: f64,
    console: &Console,
) -> Result<Simulation, Failure> {
    let (mut simulation, start) = begin(scene, seed, file, execution, console)?;
    if start == Start::Fresh {
        settle(&mut simulation, seconds, console)?;
    }
    Ok(simulation)
}

#[cfg(test)]
#[path = "../../tests/unit/commands_beforehand.rs"]
mod tests;
