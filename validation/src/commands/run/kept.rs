//! What an unfinished run leaves to be continued from.

use super::progress::Progress;
use crate::commands::Failure;
use crate::output::{RunFiles, WriteError};
use crate::plan::Scene;
use crate::provenance::scene_hash;
use makadam::BUILD;
use makadam::checkpoint::{open, seal, sync_folder, write_atomically};
use makadam::scene::Watch;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// First bytes of a run's checkpoint; the last one is the version of the format.
const RUN: [u8; 8] = *b"mkd-run\x04";

/// The way out where a checkpoint cannot be used.
const ANEW: &str = "give --restart to start anew";

/// What a checkpoint is of. It stands before all else, and its layout stays: every build can tell whose checkpoint it is.
#[derive(Serialize, Deserialize)]
struct Label {
    /// [`BUILD`] of the program that wrote it.
    build: String,
    scene: String,
    scene_hash: u64,
    seed: u64,
}

/// What a run is continued from.
#[derive(Serialize, Deserialize)]
pub(super) struct Kept {
    /// The simulation's own checkpoint.
    pub simulation: Vec<u8>,
    /// The run's account of itself.
    pub progress: Progress,
}

/// Where a run keeps it: a file inside its output folder.
pub(super) struct Place {
    file: PathBuf,
}

impl Place {
    pub fn inside(output: &Path) -> Place {
        Place { file: output.join(RunFiles::CHECKPOINT) }
    }

    /// Whether an unfinished run was left here.
    pub fn is_taken(&self) -> bool {
        self.file.is_file()
    }

    /// Removes the checkpoint, so that nobody goes on from it, before what it speaks of changes.
    pub fn withdraw(&self) -> Result<(), WriteError> {
        match std::fs::remove_file(&self.file) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(WriteError::new(&self.file, error)),
            Err(_) => Ok(()),
            Ok(()) => {
                let folder = self.file.parent().unwrap_or(Path::new(""));
                sync_folder(folder).map_err(|error| WriteError::new(folder, error))
            }
        }
    }

    /// Writes a sealed checkpoint; the frames that it speaks of are on the disk already.
    pub fn write(&self, sealed: &[u8]) -> Result<(), WriteError> {
        write_atomically(&self.file, sealed).map_err(|source| WriteError::new(&self.file, source))
    }

    /// Removes what a finished run no longer needs.
    pub fn clear(&self) {
        // What cannot be removed is found out of date by its seal and scene, or taken up again: no harm in either.
        let _ = std::fs::remove_file(&self.file);
    }

    /// The checkpoint of a run of this scene and seed.
    pub fn read(&self, scene: &Scene, seed: u64) -> Result<Kept, Failure> {
        let failed = |what: String| Failure::Running(format!("{} {what}; {ANEW}", self.file.display()));
        let bytes = std::fs::read(&self.file).map_err(|error| failed(format!("cannot be read: {error}")))?;
        let body = open(RUN, &bytes).map_err(failed)?;
        let unfit = |error| failed(format!("does not hold what it should ({error})"));
        let (label, rest) = postcard::take_from_bytes::<Label>(body).map_err(unfit)?;
        let refuse = |what: String| Err(Failure::Usage(format!("{}: {what}", self.file.display())));
        if label.build != BUILD {
            return refuse(format!(
                "was written by build {}, and this is build {BUILD}, which may give other bits; go on with the former, or {ANEW} \
                 with this one",
                label.build
            ));
        }
        if (label.scene_hash, label.seed) != (hash_to_go_on(scene), seed) {
            return refuse(format!(
                "belongs to {} with seed {} and other settings than {} with seed {seed} now has; give the same scene, seed and \
                 settings, or --restart",
                label.scene, label.seed, scene.name
            ));
        }
        postcard::from_bytes(rest).map_err(unfit)
    }

    /// For messages.
    pub fn file(&self) -> &Path {
        &self.file
    }
}

impl Kept {
    /// A checkpoint of a run, sealed.
    pub fn seal(scene: &Scene, seed: u64, simulation: Vec<u8>, progress: Progress) -> Vec<u8> {
        let label = Label { build: BUILD.into(), scene: scene.name.clone(), scene_hash: hash_to_go_on(scene), seed };
        let parts = (label, Kept { simulation, progress });
        seal(RUN, &postcard::to_stdvec(&parts).expect("a checkpoint holds only numbers, names and lists"))
    }
}

/// Hash of what must be the same to go on. What is watched for changes no bit of a state: a run that its watch has stopped may go on
/// under another one.
fn hash_to_go_on(scene: &Scene) -> u64 {
    let mut unwatched = scene.clone();
    unwatched.watch = Watch::default();
    scene_hash(&unwatched)
}
