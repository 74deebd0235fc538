//! Checkpoints: stored simulations, to resume bit for bit or to start another simulation from.
//!
//! The next step depends on the state of the grains, the contact impulses, and the candidate list: the order of its pairs is the
//! order in which contacts are relaxed. The checkpoint stores the grain positions at the last build of the list, and reading
//! rebuilds the list from them. Extra candidates, added because grains were too fast for the step, are stored explicitly: the
//! velocities behind them are no longer known.
//!
//! ```
//! # use makadam::{Scene, Simulation};
//! # let scene = Scene::example();
//! let mut simulation = Simulation::builder(&scene).time_step(5e-4).build()?;
//! for _ in 0..100 {
//!     simulation.step();
//! }
//! let bytes = simulation.checkpoint(); // `save` writes them to a file
//! let mut resumed = Simulation::resume(&scene, &bytes)?;
//! for _ in 0..100 {
//!     simulation.step();
//!     resumed.step();
//! }
//! assert_eq!(resumed.state_hash(), simulation.state_hash());
//! # Ok::<(), makadam::Error>(())
//! ```

pub(super) mod state;

use crate::Simulation;
use crate::scene::Scene;
use serde::Serialize;
#[doc(hidden)]
pub use state::KeptContact;
use state::State;
use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use xxhash_rust::xxh3::xxh3_64;

/// Magic bytes of a file; the last byte is the version of the format.
const MARK: [u8; 8] = *b"makadam\x11";

/// Magic bytes of a checkpoint with optional state after the state: grains inserted or removed, kinematic walls, stages, extra
/// candidates, gauges, records of walls, or ledger entries of external actions or tangential springs.
const MARK_OF_ALTERED: [u8; 8] = *b"makadam\x13";

/// Reason why a checkpoint could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// Operating system error.
    #[error("{}: {source}; check that the path is right and the disk has room", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// Message of the system.
        source: std::io::Error,
    },
    /// Format error: not a checkpoint of this version, or not of this scene.
    #[error("the checkpoint {problem}; delete it and start anew")]
    Format {
        /// Problem.
        problem: String,
    },
}

impl Simulation {
    /// Returns the present state as a checkpoint. Forces [applied](Simulation::apply_forces) for the next step are not part of the checkpoint.
    pub fn checkpoint(&self) -> Vec<u8> {
        State::of(self).write()
    }

    /// Writes a checkpoint to a file atomically: after any failure, the file holds either the old or the new checkpoint.
    ///
    /// # Errors
    /// [`CheckpointError::Io`] if the file cannot be written.
    pub fn save(&self, file: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let file = file.as_ref();
        write_atomically(file, &self.checkpoint()).map_err(|source| CheckpointError::Io { file: file.into(), source })
    }

    /// Resumes from a checkpoint of the same scene, bit for bit like an uninterrupted run. This includes inserted and removed
    /// grains and kinematic walls.
    ///
    /// # Errors
    /// [`CheckpointError::Format`] if the bytes are damaged, or belong to another version or scene.
    pub fn resume(scene: &Scene, bytes: &[u8]) -> Result<Simulation, CheckpointError> {
        let refuse = |problem| CheckpointError::Format { problem };
        State::read(bytes).and_then(|state| state.resume(scene)).map_err(refuse)
    }

    /// Starts a scene at time zero from the grains of a checkpoint instead of its jittered lattice. Contact impulses are scaled
    /// to the scene's time step.
    ///
    /// # Errors
    /// [`CheckpointError::Format`] if the bytes are damaged or of another version, or if the grains differ from those of the scene.
    pub fn start_from(scene: &Scene, bytes: &[u8]) -> Result<Simulation, CheckpointError> {
        let refuse = |problem| CheckpointError::Format { problem };
        State::read(bytes).and_then(|state| state.start(scene)).map_err(refuse)
    }
}

/// Header length, bytes: eight magic bytes, the length of the body and its checksum (XXH3, 64 bits).
const HEAD: usize = 24;

/// Adds magic bytes, length and checksum before a body. The last magic byte is the version of the body format.
pub fn seal(mark: [u8; 8], body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + body.len());
    bytes.resize(HEAD, 0);
    bytes.extend(body);
    close(mark, bytes)
}

/// Encodes a value of numbers, texts and lists as the body of [`seal`], without a copy of the body.
///
/// # Panics
/// If the value has a list of unknown length.
pub fn seal_value(mark: [u8; 8], value: &impl Serialize) -> Vec<u8> {
    close(mark, postcard::to_extend(value, vec![0; HEAD]).expect("the value holds only numbers, texts and lists"))
}

/// Writes the header into the first bytes, which are reserved for it.
fn close(mark: [u8; 8], mut bytes: Vec<u8>) -> Vec<u8> {
    let (length, sum) = ((bytes.len() - HEAD) as u64, xxh3_64(&bytes[HEAD..]));
    bytes[..8].copy_from_slice(&mark);
    bytes[8..16].copy_from_slice(&length.to_le_bytes());
    bytes[16..HEAD].copy_from_slice(&sum.to_le_bytes());
    bytes
}

/// Returns the body of a file written by [`seal`].
///
/// # Errors
/// Message that states the problem: too short, another kind of file or version, truncated, or damaged.
pub fn open(mark: [u8; 8], bytes: &[u8]) -> Result<&[u8], String> {
    let number = |at: usize| bytes[at..at + 8].try_into().map(u64::from_le_bytes).unwrap_or_default();
    if bytes.len() < HEAD {
        return Err(format!("is too short: {} bytes", bytes.len()));
    }
    if bytes[..7] != mark[..7] {
        return Err("is no such file: its first bytes are others".into());
    }
    if bytes[7] != mark[7] {
        return Err(format!("has version {} of the format, not {}", bytes[7], mark[7]));
    }
    let (length, body) = (number(8), &bytes[HEAD..]);
    if length != body.len() as u64 {
        return Err(format!("is cut off: it holds {} of {length} bytes", body.len()));
    }
    if number(16) != xxh3_64(body) {
        return Err("is damaged: its checksum does not fit".into());
    }
    Ok(body)
}

/// Hash that identifies a text or a state: FNV-1a, 64 bits (G. Fowler, L. C. Noll, K.-P. Vo).
pub fn checksum(bytes: &[u8]) -> u64 {
    checksum_after(0xcbf2_9ce4_8422_2325, bytes)
}

/// Continues a [`checksum`] with further bytes.
pub fn checksum_after(before: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(before, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// Suffix of the name of a temporary file; a number follows.
pub const DRAFT: &str = ".part";

/// Number of names tried before a folder full of temporary files is given up.
const TRIES: usize = 1000;

/// Writes a file and its folder entry to the disk, and creates a missing folder. After any failure, a power cut included, the
/// whole new file or the whole old file exists.
///
/// # Errors
/// Error of the operating system; the whole old file or the whole new file exists then.
pub fn write_atomically(file: &Path, bytes: &[u8]) -> Result<(), Error> {
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder)?;
    }
    replace_with(file, |open| {
        open.write_all(bytes)?;
        open.sync_all()
    })?;
    sync_folder(file.parent().unwrap_or(Path::new("")))
}

/// Replaces a file by the output of `write`. If the process fails, the whole new file or the whole old file exists. After a power
/// cut neither may exist, unless [`sync_file`] and [`sync_folder`] have returned.
///
/// # Errors
/// Error of the operating system or of `write`; the old file remains then.
pub fn replace_with(file: &Path, write: impl FnOnce(&mut File) -> Result<(), Error>) -> Result<(), Error> {
    let (draft, mut open) = draft_of(file)?;
    let written = write(&mut open);
    drop(open);
    written.and_then(|()| std::fs::rename(&draft, file)).inspect_err(|_| {
        // A temporary file that cannot be removed is harmless: no code reads it.
        let _ = std::fs::remove_file(&draft);
    })
}

/// Creates a temporary file next to `file`. An existing file is never opened: it may be a planted link.
fn draft_of(file: &Path) -> Result<(PathBuf, File), Error> {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let name = file.file_name().ok_or_else(|| Error::new(ErrorKind::InvalidInput, "is not the name of a file"))?;
    let mut refused = None;
    for _ in 0..TRIES {
        let mut name: OsString = name.to_os_string();
        name.push(format!("{DRAFT}{}-{}", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed)));
        let draft = file.with_file_name(name);
        match OpenOptions::new().write(true).create_new(true).open(&draft) {
            Ok(open) => return Ok((draft, open)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => refused = Some(error),
            Err(error) => return Err(error),
        }
    }
    Err(refused.unwrap_or_else(|| ErrorKind::AlreadyExists.into()))
}

/// Writes the content of a file to the disk.
///
/// # Errors
/// Error of the operating system.
pub fn sync_file(file: &Path) -> Result<(), Error> {
    File::open(file)?.sync_all()
}

/// Writes the entries of a folder to the disk: files created, renamed and removed. An empty path is the current folder.
///
/// # Errors
/// Error of the operating system; a file system without this operation causes no error.
pub fn sync_folder(folder: &Path) -> Result<(), Error> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match File::open(here)?.sync_all() {
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        done => done,
    }
}
