//! Output folder of a run: its checkpoint, the summary of an earlier run, and the task that follows from both.

use super::RunArguments;
use super::progress::Progress;
use crate::commands::Failure;
use makadam::BUILD;
use makadam::checkpoint::{open, seal_value, sync_folder, write_atomically};
use makadam_compare::prepared::Label;
use makadam_frames::output::{RunFiles, WriteError};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::scene_hash;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Magic bytes of a run's checkpoint; the last byte is the format version.
const RUN: [u8; 8] = *b"mkd-run\x06";

#[derive(Serialize, Deserialize)]
pub(super) struct Checkpoint {
    pub simulation: Vec<u8>,
    pub progress: Progress,
}

/// Checkpoint of a run in its output folder.
pub(super) struct CheckpointFile(PathBuf);

impl CheckpointFile {
    pub fn inside(output: &Path) -> CheckpointFile {
        CheckpointFile(output.join(RunFiles::CHECKPOINT))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    pub fn exists(&self) -> bool {
        self.0.is_file()
    }

    /// Removes the checkpoint durably, before the files that it describes change.
    pub fn withdraw(&self) -> Result<(), WriteError> {
        match std::fs::remove_file(&self.0) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(WriteError::new(&self.0, error)),
            Err(_) => Ok(()),
            Ok(()) => {
                let folder = self.0.parent().unwrap_or(Path::new(""));
                sync_folder(folder).map_err(|error| WriteError::new(folder, error))
            }
        }
    }

    /// Writes the bytes of a checkpoint; its frames must already be on the disk.
    pub fn write(&self, sealed: &[u8]) -> Result<(), WriteError> {
        write_atomically(&self.0, sealed).map_err(|source| WriteError::new(&self.0, source))
    }

    /// Stores a state without a violation, for this process alone.
    pub fn hold(&self, simulation: &[u8]) -> Result<(), WriteError> {
        let file = self.held();
        std::fs::write(&file, simulation).map_err(|source| WriteError::new(&file, source))
    }

    /// Reads the stored state.
    pub fn take_held(&self) -> Result<Vec<u8>, WriteError> {
        let file = self.held();
        std::fs::read(&file).map_err(|source| WriteError::new(&file, source))
    }

    fn held(&self) -> PathBuf {
        self.0.with_file_name(RunFiles::HELD)
    }

    /// Removes the stored state.
    pub fn release(&self) {
        // A new run replaces what cannot be removed.
        let _ = std::fs::remove_file(self.held());
    }

    /// Removes the checkpoint of a finished run.
    pub fn clear(&self) {
        // A checkpoint that cannot be removed is out of date by its checksum and scene, or is resumed again.
        let _ = std::fs::remove_file(&self.0);
    }

    /// Reads the checkpoint of a run of this scene and seed.
    pub fn read(&self, scene: &MeasuredScene, seed: u64) -> Result<Checkpoint, Failure> {
        let failed =
            |what: String| Failure::Running(format!("{} {what}; give --restart to start anew", self.0.display()));
        let bytes = std::fs::read(&self.0).map_err(|error| failed(format!("cannot be read: {error}")))?;
        let body = open(RUN, &bytes).map_err(failed)?;
        let unfit = |error| failed(format!("does not hold what it should ({error})"));
        let (label, rest) = postcard::take_from_bytes::<Label>(body).map_err(unfit)?;
        let refuse = |what: String| Err(Failure::Usage(format!("{}: {what}", self.0.display())));
        if label.build != BUILD {
            return refuse(format!(
                "was written by build {}, and this is build {BUILD}, which may give other bits; go on with the former, or give \
                 --restart to start anew with this one",
                label.build
            ));
        }
        if label != Label::of(scene, seed) {
            return refuse(format!(
                "belongs to {} with seed {} and other settings than {} with seed {seed} now has; give the same scene, seed and \
                 settings, or --restart",
                label.scene, label.seed, scene.name
            ));
        }
        postcard::from_bytes(rest).map_err(unfit)
    }
}

impl Checkpoint {
    /// Encodes a checkpoint with its checksum envelope.
    pub fn seal(scene: &MeasuredScene, seed: u64, simulation: Vec<u8>, progress: Progress) -> Vec<u8> {
        let label = Label::of(scene, seed);
        seal_value(RUN, &(label, Checkpoint { simulation, progress }))
    }
}

/// Summary of an earlier run.
pub(super) struct Record {
    complete: bool,
    steps: u64,
    scene: String,
    pub text: String,
    document: Value,
}

impl Record {
    /// Reads the summary in a folder, if readable.
    fn read(output: &Path) -> Option<Record> {
        let text = std::fs::read_to_string(output.join(RunFiles::SUMMARY)).ok()?;
        let document: Value = serde_json::from_str(&text).ok()?;
        (document["command"] == "run").then_some(())?;
        Some(Record {
            complete: document["complete"].as_bool()?,
            steps: document["steps"].as_u64()?,
            scene: document["scene"].as_str()?.to_string(),
            text,
            document,
        })
    }

    /// Returns true for a run of this scene with these settings and this seed.
    fn is_of(&self, scene: &MeasuredScene, seed: u64) -> bool {
        let provenance = &self.document["provenance"];
        provenance["scene_hash"] == format!("{:016x}", scene_hash(scene)) && provenance["seed"] == seed
    }

    pub fn describe(&self) -> String {
        let text = |field: &str| self.document[field].as_str().unwrap_or("unknown").to_string();
        format!(
            "{}: complete since its {} steps were taken\nstate hash       {}\nframes, observables.csv and run.json: {}",
            self.scene,
            self.steps,
            text("state_hash"),
            text("output")
        )
    }
}

/// Task of a run in its folder.
pub(super) enum Task {
    /// Begin, and remove the files of an earlier run.
    Begin,
    /// Resume from the checkpoint.
    Resume,
    /// Report the complete run.
    Ended(Record),
}

/// Decides on the task in a locked folder: files of an earlier run are unchanged unless the arguments request otherwise.
pub(super) fn task(
    output: &Path,
    scene: &MeasuredScene,
    seed: u64,
    wish: &RunArguments,
    last_step: u64,
) -> Result<Task, Failure> {
    let shown = output.display();
    let refuse = |what: String| Err(Failure::Usage(what));
    let (record, checkpoint) = (Record::read(output), CheckpointFile::inside(output));
    let ended = record.as_ref().is_some_and(|record| record.complete);
    if wish.restart || !(checkpoint.exists() || RunFiles::inside(output).any()) {
        return Ok(Task::Begin);
    }
    let other = format!("{shown} holds a run of another scene, or with another seed or other settings");
    const WAYS: &str = "--restart removes it and begins anew, --output writes elsewhere";
    match record {
        Some(record) if ended && wish.resume => {
            let Record { steps, scene: name, .. } = &record;
            if !record.is_of(scene, seed) {
                return refuse(format!("{other} ({name}), which has ended: {WAYS}"));
            }
            if wish.ledger && record.document["balance"].is_null() {
                return refuse(format!("{shown} holds this run without a ledger, and it has ended: {WAYS}"));
            }
            // Conditions end stages earlier.
            if *steps != last_step && (wish.steps.is_some() || scene.stage.is_empty()) {
                return refuse(format!(
                    "{shown} holds this run, which has ended after {steps} steps, not {last_step}; one that has ended cannot be made \
                     longer or shorter: {WAYS}"
                ));
            }
            // A kill after the writing of the summary leaves the checkpoint behind.
            checkpoint.clear();
            let _ = std::fs::remove_file(output.join(RunFiles::MEASURED));
            Ok(Task::Ended(record))
        }
        Some(Record { steps, scene: name, .. }) if ended => {
            refuse(format!("{shown} holds a run of {name} that has ended after {steps} steps: {WAYS}"))
        }
        _ if checkpoint.exists() && wish.resume => Ok(Task::Resume),
        _ if checkpoint.exists() => refuse(format!(
            "{} is left of a run that did not end: --resume goes on from there, --restart throws it away, --output writes \
             elsewhere",
            checkpoint.path().display()
        )),
        Some(record) if wish.resume && record.is_of(scene, seed) => Ok(Task::Begin),
        Some(record) if wish.resume => refuse(format!("{other} ({}), which left no checkpoint: {WAYS}", record.scene)),
        Some(record) => refuse(format!(
            "{shown} holds what is left of a run of {} that did not end and left no checkpoint: {WAYS}",
            record.scene
        )),
        None => refuse(format!(
            "{shown} holds frames or tables of a run, but no {} that can be read: {WAYS}",
            RunFiles::SUMMARY
        )),
    }
}
