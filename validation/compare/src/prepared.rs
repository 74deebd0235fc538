//! Start of a run: the jittered lattice, or a flowing state that is prepared once and stored on the machine.

use crate::scenes::{SceneError, in_file};
use makadam::checkpoint::{CheckpointError, write_atomically};
use makadam::watch::{Alarm, Watchdog};
use makadam::{BUILD, Simulation};
use makadam_frames::execution::Execution;
use makadam_frames::output::{WriteError, cache_folder, create_folder, file_stem};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::scene_hash;
use makadam_frames::stepping::{Halt, Stepping, steps_in};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Error of a run that cannot start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The scene cannot be populated.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The cache cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The state cannot be stored or read back.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The machine cannot run the requested settings.
    #[error(transparent)]
    Execution(#[from] makadam::SettingError),
    /// The prepared state is invalid.
    #[error("while the flowing state was prepared: {0}")]
    InvalidState(Alarm),
    /// The user asked to stop during the preparation.
    #[error("interrupted while the flowing state was prepared")]
    Interrupted,
}

/// Source of the start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Start {
    /// Jittered lattice.
    Fresh,
    /// Flowing state in this file.
    Prepared(PathBuf),
}

/// Identity of the state of a run. The label comes first in a file and its layout never changes, so that every build can read it.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Label {
    /// [`BUILD`] of the program that stored the state.
    pub build: String,
    /// Name of the scene.
    pub scene: String,
    /// Hash of the scene.
    pub scene_hash: u64,
    /// Seed of the initial positions.
    pub seed: u64,
}

impl Label {
    /// Returns the label of this build for a scene and a seed.
    pub fn of(scene: &MeasuredScene, seed: u64) -> Label {
        Label { build: BUILD.into(), scene: scene.name.clone(), scene_hash: scene_hash(scene), seed }
    }
}

/// Returns the simulation at the start of its run. A scene with `[prepare]` is simulated for that time first, unless a state of
/// the same scene, seed and build is in the cache; `progress` receives the completed fraction.
pub fn start(
    scene: &MeasuredScene,
    seed: u64,
    scene_file: &Path,
    execution: &Execution,
    progress: &dyn Fn(f64),
) -> Result<(Simulation, Start), StartError> {
    let Some(prepare) = &scene.prepare else {
        let mut simulation = Simulation::new(scene, seed).map_err(in_file(scene_file))?;
        execution.apply(&mut simulation)?;
        return Ok((simulation, Start::Fresh));
    };
    let file = state_file(scene, seed)?;
    // A missing or damaged state is prepared again.
    if let Some(mut simulation) = std::fs::read(&file).ok().and_then(|state| Simulation::start_from(scene, &state).ok())
    {
        execution.apply(&mut simulation)?;
        return Ok((simulation, Start::Prepared(file)));
    }
    let mut beforehand = scene.clone();
    beforehand.solver.step = prepare.step;
    let mut simulation = Simulation::new(&beforehand, seed).map_err(in_file(scene_file))?;
    execution.apply(&mut simulation)?;
    let steps = steps_in(prepare.duration, prepare.step);
    let mut watchdog = Watchdog::new(&scene.watch, &simulation);
    let stepping = Stepping::new(steps, progress).watched(&mut watchdog);
    stepping.carry_out(&mut simulation, |_, _| {}).map_err(|halt| match halt {
        Halt::InvalidState(alarm) => StartError::InvalidState(alarm),
        Halt::Interrupted | Halt::OutOfTime(_) => StartError::Interrupted,
    })?;
    if let Some(folder) = file.parent() {
        create_folder(folder)?;
    }
    let state = simulation.checkpoint();
    write_atomically(&file, &state).map_err(|error| WriteError::new(&file, error))?;
    let mut simulation = Simulation::start_from(scene, &state)?;
    execution.apply(&mut simulation)?;
    Ok((simulation, Start::Prepared(file)))
}

/// Returns true if a run can start at once: the scene prepares no flowing state, or the state is in the cache.
pub fn is_ready(scene: &MeasuredScene, seed: u64) -> bool {
    scene.prepare.is_none() || state_file(scene, seed).is_ok_and(|file| file.is_file())
}

/// File of the state of a scene, a seed and a build.
fn state_file(scene: &MeasuredScene, seed: u64) -> Result<PathBuf, WriteError> {
    let name = format!("{}-s{seed}-{:016x}-{BUILD}.state", file_stem(&scene.name), scene_hash(scene));
    Ok(cache_folder()?.join("prepared").join(name))
}
