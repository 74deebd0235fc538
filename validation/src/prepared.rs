//! Where a run starts: at the lattice gas, or at a flowing state that was prepared once and is kept on the machine.

use crate::execution::{Execution, ExecutionError};
use crate::output::{WriteError, create_folder};
use crate::provenance::{VERSION, scene_hash};
use makadam::Simulation;
use makadam::checkpoint::{CheckpointError, checksum};
use makadam::scene::{Scene, SceneError};
use std::path::{Path, PathBuf};

/// Why a run could not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The scene cannot be populated.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The cache cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The state cannot be kept or read back.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The machine cannot run it as asked.
    #[error(transparent)]
    Execution(#[from] ExecutionError),
    /// The user asked to stop while the state was prepared.
    #[error("interrupted while the flowing state was prepared")]
    Interrupted,
}

/// How the start was obtained.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Start {
    /// From the lattice gas.
    Fresh,
    /// From a flowing state in this file.
    Prepared(PathBuf),
}

/// Folder in which prepared states and recordings are kept: `makadam` in `XDG_CACHE_HOME` or in `~/.cache`.
pub fn cache_folder() -> PathBuf {
    let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    absolute("XDG_CACHE_HOME")
        .or_else(|| absolute("HOME").map(|home| home.join(".cache")))
        .unwrap_or_else(std::env::temp_dir)
        .join("makadam")
}

/// The simulation at the start of its run. A scene with `[prepare]` is simulated for that time first, unless a state of
/// the same scene, seed and version is in the cache; `progress` is told the share that is done.
///
/// # Errors
/// [`StartError`].
pub fn start(
    scene: &Scene,
    seed: u64,
    scene_file: &Path,
    execution: &Execution,
    progress: &dyn Fn(f64),
) -> Result<(Simulation, Start), StartError> {
    let Some(prepare) = &scene.prepare else {
        let mut simulation = Simulation::new(scene, seed, scene_file)?;
        execution.apply(&mut simulation)?;
        return Ok((simulation, Start::Fresh));
    };
    let file = state_file(scene, seed);
    // A state that cannot be read is made anew.
    if file.is_file()
        && let Ok(mut simulation) = start_from(scene, &file)
    {
        execution.apply(&mut simulation)?;
        return Ok((simulation, Start::Prepared(file)));
    }
    let mut beforehand = scene.clone();
    beforehand.solver.step = prepare.step;
    let mut simulation = Simulation::new(&beforehand, seed, scene_file)?;
    execution.apply(&mut simulation)?;
    let steps = steps_in(prepare.duration, prepare.step);
    for step in 1..=steps {
        simulation.step();
        progress(step as f64 / steps as f64);
        if crate::interrupt::requested() {
            return Err(StartError::Interrupted);
        }
    }
    if let Some(folder) = file.parent() {
        create_folder(folder)?;
    }
    simulation.save(&file)?;
    let mut simulation = start_from(scene, &file)?;
    execution.apply(&mut simulation)?;
    Ok((simulation, Start::Prepared(file)))
}

/// Starts from a state that is kept.
fn start_from(scene: &Scene, file: &Path) -> Result<Simulation, CheckpointError> {
    let bytes = std::fs::read(file).map_err(|source| CheckpointError::Io { file: file.into(), source })?;
    Simulation::start_from(scene, &bytes, file)
}

/// Whether a run of the scene can start at once: it prepares no flowing state, or that is in the cache.
pub fn is_ready(scene: &Scene, seed: u64) -> bool {
    scene.prepare.is_none() || state_file(scene, seed).is_file()
}

/// Where a flowing state is kept.
fn state_file(scene: &Scene, seed: u64) -> PathBuf {
    let name = format!("{}-s{seed}-{:016x}-{VERSION}.state", file_stem(&scene.name), scene_hash(scene));
    cache_folder().join("prepared").join(name)
}

/// Whole steps nearest to a duration.
pub fn steps_in(duration: f64, step: f64) -> u64 {
    (duration / step).round() as u64
}

/// Longest part of a file name that is made from a name, bytes: others are added to it, and file systems take 255.
const LONGEST_STEM: usize = 120;

/// A scene's name as a part of a file name: never empty, never one that stands for a folder, never longer than 120 bytes.
pub fn file_stem(name: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '-' }
    };
    let stem: String = name.chars().map(plain).collect();
    if stem.bytes().all(|byte| byte == b'.') {
        return format!("scene{}", "-".repeat(stem.len().min(LONGEST_STEM / 2)));
    }
    if stem.len() <= LONGEST_STEM {
        return stem;
    }
    // Long names are often alike at their beginnings.
    let hash = format!("-{:016x}", checksum(name.as_bytes()));
    stem[..LONGEST_STEM - hash.len()].to_string() + &hash
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_becomes_a_part_of_a_file_name_that_stands_for_itself_alone() {
        assert_eq!(file_stem("drum-50k_v1.2"), "drum-50k_v1.2");
        assert_eq!(file_stem("a/../b c"), "a-..-b-c");
        for name in ["", ".", "..", "..."] {
            let stem = file_stem(name);
            assert!(stem.starts_with("scene") && !stem.contains('.'), "{name}: {stem}");
        }
        let long = "n".repeat(4000);
        let other = long.clone() + "m";
        assert!(file_stem(&long).len() <= LONGEST_STEM);
        assert_ne!(file_stem(&long), file_stem(&other));
        assert!(file_stem(&".".repeat(4000)).len() <= LONGEST_STEM);
    }
}
