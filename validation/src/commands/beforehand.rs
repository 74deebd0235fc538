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
mod tests {
    use super::*;

    #[test]
    fn available_memory_includes_free_swap() {
        let text = "MemTotal:  100 kB\nMemFree:  10 kB\nMemAvailable:   40 kB\nSwapFree:  2 kB\n";
        assert_eq!(of_meminfo(text), Some(42 * 1024));
        assert_eq!(of_meminfo("MemTotal: 100 kB\n"), None);
    }

    #[test]
    fn a_picture_beyond_memory_is_refused_with_a_size_that_fits() {
        assert!(refuse_picture_beyond_memory([64, 64], 1 << 20).is_ok());
        assert!(matches!(refuse_picture_beyond_memory([16_384, 16_384], u64::MAX), Err(Failure::Running(_))));
        let message = picture_beyond([16_384, 16_384], 40_000_000_000, 4_000_000_000);
        for word in ["16384x16384 pixels takes some 40.0 GB", "4.0 GB are available", "such as 4915x4915"] {
            assert!(message.contains(word), "no '{word}' in: {message}");
        }
    }

    #[test]
    fn more_than_there_is_is_refused_with_figures() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
        let mut scene = Scene::load(&file).unwrap();
        assert!(refuse_beyond_memory(&scene, &file).is_ok());
        scene.population[0].count = 1_000_000_000_000;
        assert!(matches!(refuse_beyond_memory(&scene, &file), Err(Failure::Running(_))));
        scene.population[0].count = 10_000_000;
        let message = beyond(&scene, &file, 1_500_000_000);
        for word in ["10000000 grains take some 15.", "1.5 GB are available", "lower population.count to some"] {
            assert!(message.contains(word), "no '{word}' in: {message}");
        }
    }
}
