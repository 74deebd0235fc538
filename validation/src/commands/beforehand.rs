//! What is told before a scene runs: what its settings are not expected to bear, and whether there is memory for it.

use super::{Console, Failure};
use crate::observables::impossible;
use crate::plan::Scene;
use crate::scenes;
use makadam::scene::Finding;
use std::path::Path;

/// Tells what a scene is not expected to bear, on standard error; the findings go to `run.json` as well.
pub(super) fn tell_findings(scene: &Scene, file: &Path, console: &Console) -> Vec<Finding> {
    let text = scenes::text(file).ok();
    let mut findings = scene.findings(text.as_deref());
    findings.extend(impossible(scene, text.as_deref()));
    for finding in &findings {
        let line = finding.line.map(|line| format!(":{line}")).unwrap_or_default();
        console.warn(&format!("{}{line}: {finding}", file.display()));
    }
    findings
}

/// Refuses a scene that takes more memory than there is.
pub(super) fn refuse_beyond_memory(scene: &Scene, file: &Path) -> Result<(), Failure> {
    match available_bytes() {
        Some(available) if scene.memory() > available => Err(Failure::Running(beyond(scene, file, available))),
        _ => Ok(()),
    }
}

/// Refuses a picture that takes more memory to draw than there is.
pub(super) fn refuse_picture_beyond_memory([width, height]: [usize; 2], needed: u64) -> Result<(), Failure> {
    match available_bytes().filter(|available| needed > *available) {
        Some(available) => Err(Failure::Running(picture_beyond([width, height], needed, available))),
        None => Ok(()),
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

fn beyond(scene: &Scene, file: &Path, available: u64) -> String {
    let grains = scene.grain_count();
    let few = (grains as f64 * available as f64 / scene.memory() as f64 / 1e3).floor() * 1e3;
    format!(
        "{}: {grains} grains take some {} of memory, and {} are available; lower population.count to some {few} grains, end other \
         programs, or use a machine with more",
        file.display(),
        gigabytes(scene.memory()),
        gigabytes(available)
    )
}

/// Returns the memory that the system has left, bytes; `None` where it does not report it.
fn available_bytes() -> Option<u64> {
    std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| of_meminfo(&text))
}

/// Available memory and free swap, bytes.
fn of_meminfo(text: &str) -> Option<u64> {
    let field = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.trim_start_matches(':').split_whitespace().next()?.parse::<u64>().ok()
    };
    Some(1024 * (field("MemAvailable")? + field("SwapFree").unwrap_or(0)))
}

#[cfg(test)]
#[path = "../../tests/unit/commands_beforehand.rs"]
mod tests;
