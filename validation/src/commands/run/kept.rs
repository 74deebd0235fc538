//! What an unfinished run leaves to be continued from: a checkpoint, and the frames that are measured at the end.

use super::progress::Progress;
use crate::commands::Failure;
use crate::output::{RunFiles, WriteError};
use crate::provenance::{VERSION, scene_hash};
use makadam::checkpoint::{open, seal, sync_folder, write_atomically};
use makadam::scene::{Scene, Watch};
use makadam::snapshot::Snapshot;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// First bytes of a run's checkpoint and of a kept frame; the last one is the version of the format.
const RUN: [u8; 8] = *b"mkd-run\x02";
const FRAME: [u8; 8] = *b"mkd-frm\x01";

/// What a run is continued from.
#[derive(Serialize, Deserialize)]
pub(super) struct Kept {
    version: String,
    scene: String,
    scene_hash: u64,
    seed: u64,
    /// The simulation's own checkpoint.
    pub simulation: Vec<u8>,
    /// The run's account of itself.
    pub progress: Progress,
}

/// Where a run keeps it: a file and a folder inside its output folder.
pub(super) struct Place {
    file: PathBuf,
    frames: PathBuf,
}

impl Place {
    pub fn inside(output: &Path) -> Place {
        Place { file: output.join(RunFiles::CHECKPOINT), frames: output.join(RunFiles::KEPT_FRAMES) }
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

    /// Writes a sealed checkpoint after the frames that it speaks of.
    pub fn write(&self, sealed: &[u8], frames: &[(usize, &Snapshot)]) -> Result<(), WriteError> {
        for (number, frame) in frames {
            let file = self.frame(*number);
            if !file.is_file() {
                let body = postcard::to_stdvec(frame).expect("a frame holds only numbers and lists");
                write_atomically(&file, &seal(FRAME, &body)).map_err(|source| WriteError::new(&file, source))?;
            }
        }
        write_atomically(&self.file, sealed).map_err(|source| WriteError::new(&self.file, source))?;
        // Earlier frames are measured no more.
        let first = frames.first().map_or(0, |(number, _)| *number);
        for number in (0..first).rev().take_while(|&number| self.frame(number).is_file()) {
            let _ = std::fs::remove_file(self.frame(number));
        }
        Ok(())
    }

    /// Removes what a finished run no longer needs.
    pub fn clear(&self) {
        let _ = std::fs::remove_file(&self.file);
        if let Some(output) = self.file.parent() {
            let _ = RunFiles::inside(output).remove_kept_frames();
        }
    }

    /// The checkpoint of a run of this scene and seed.
    pub fn read(&self, scene: &Scene, seed: u64) -> Result<Kept, Failure> {
        let kept: Kept = unsealed(RUN, &self.file)?;
        let refuse = |what: String| Err(Failure::Usage(format!("{}: {what}", self.file.display())));
        if (kept.scene_hash, kept.seed) != (hash_to_go_on(scene), seed) {
            return refuse(format!(
                "belongs to {} with seed {} and other settings than {} with seed {seed} now has; give the same scene, seed and \
                 settings, or --restart",
                kept.scene, kept.seed, scene.name
            ));
        }
        if kept.version != VERSION {
            return refuse(format!("was written by version {}, this is {VERSION}; give --restart", kept.version));
        }
        Ok(kept)
    }

    /// Kept frames, by their numbers.
    pub fn frames(&self, numbers: &[usize]) -> Result<Vec<Snapshot>, Failure> {
        numbers.iter().map(|&number| unsealed(FRAME, &self.frame(number))).collect()
    }

    fn frame(&self, number: usize) -> PathBuf {
        self.frames.join(format!("{number:05}.frame"))
    }

    /// For messages.
    pub fn file(&self) -> &Path {
        &self.file
    }
}

impl Kept {
    /// A checkpoint of a run, sealed.
    pub fn seal(scene: &Scene, seed: u64, simulation: Vec<u8>, progress: Progress) -> Vec<u8> {
        let kept = Kept {
            version: VERSION.into(),
            scene: scene.name.clone(),
            scene_hash: hash_to_go_on(scene),
            seed,
            simulation,
            progress,
        };
        seal(RUN, &postcard::to_stdvec(&kept).expect("a checkpoint holds only numbers, names and lists"))
    }
}

/// Hash of what must be the same to go on. What is watched for changes no bit of a state: a run that its watch has stopped may go on
/// under another one.
fn hash_to_go_on(scene: &Scene) -> u64 {
    scene_hash(&Scene { watch: Watch::default(), ..scene.clone() })
}

fn unsealed<T: for<'a> Deserialize<'a>>(mark: [u8; 8], file: &Path) -> Result<T, Failure> {
    let refuse = |what: String| Failure::Running(format!("{} {what}; give --restart to start anew", file.display()));
    let bytes = std::fs::read(file).map_err(|error| refuse(format!("cannot be read: {error}")))?;
    let body = open(mark, &bytes).map_err(refuse)?;
    postcard::from_bytes(body).map_err(|error| refuse(format!("does not hold what it should ({error})")))
}
