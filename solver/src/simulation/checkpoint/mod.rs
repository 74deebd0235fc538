//! Checkpoints: a simulation written down, to be continued bit for bit, or to start another one from.
//!
//! What the next step depends on is the state of the grains, the impulses that contacts bore, and the candidate list: the order
//! of its pairs is the order in which contacts are relaxed. The list itself is not written. It follows from where the grains
//! were when it was built, so these places are, and reading builds it again. What it holds besides, because grains were too fast for the step,
//! is written as it is: it came from velocities that nobody knows any more.
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
use state::State;
use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use xxhash_rust::xxh3::xxh3_64;

/// First bytes of a file; the last one is the version of the format.
const MARK: [u8; 8] = *b"makadam\x0f";

/// Checkpoint of a simulation in which grains have come or gone, walls are moved by the caller, the candidate list holds more than what was
/// near when it was built, or the ledger has something from outside or in tangential springs: what that is follows the state.
const MARK_OF_ALTERED: [u8; 8] = *b"makadam\x10";

/// Reason for which a checkpoint could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The system refused.
    #[error("{}: {source}; check that the path is right and the disk has room", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// Message of the system.
        source: std::io::Error,
    },
    /// The bytes are no checkpoint of this version, or not one of this scene.
    #[error("the checkpoint {problem}; delete it and start anew")]
    Format {
        /// Problem.
        problem: String,
    },
}

impl Simulation {
    /// The present state as a checkpoint. Forces that were [applied](Simulation::apply_forces) to the step to come are not part of it.
    pub fn checkpoint(&self) -> Vec<u8> {
        State::of(self).write()
    }

    /// Writes a checkpoint to a file; whatever happens meanwhile, what stood there before or the whole of it is there.
    ///
    /// # Errors
    /// [`CheckpointError::Io`] if the file cannot be written.
    pub fn save(&self, file: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let file = file.as_ref();
        write_atomically(file, &self.checkpoint()).map_err(|source| CheckpointError::Io { file: file.into(), source })
    }

    /// Goes on from a checkpoint of the same scene, bit for bit as if it had never stopped; also where grains had been inserted or removed,
    /// or walls been moved by the caller.
    ///
    /// # Errors
    /// [`CheckpointError::Format`] if the bytes are damaged, or belong to another version or scene.
    pub fn resume(scene: &Scene, bytes: &[u8]) -> Result<Simulation, CheckpointError> {
        let refuse = |problem| CheckpointError::Format { problem };
        State::read(bytes).and_then(|state| state.resume(scene)).map_err(refuse)
    }

    /// Starts a scene at time zero from the grains of a checkpoint in place of its jittered lattice, with the impulses of their
    /// contacts scaled to the scene's time step.
    ///
    /// # Errors
    /// [`CheckpointError::Format`] if the bytes are damaged, of another version, or hold other grains than the scene.
    pub fn start_from(scene: &Scene, bytes: &[u8]) -> Result<Simulation, CheckpointError> {
        let refuse = |problem| CheckpointError::Format { problem };
        State::read(bytes).and_then(|state| state.start(scene)).map_err(refuse)
    }
}

/// Bytes before the body: a mark of eight bytes, the length of the body and its checksum (XXH3, 64 bits).
const HEAD: usize = 24;

/// Puts a mark, the length and the checksum before a body. The last byte of a mark is the version of what follows.
pub fn seal(mark: [u8; 8], body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + body.len());
    bytes.extend(mark);
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(xxh3_64(body).to_le_bytes());
    bytes.extend(body);
    bytes
}

/// The body of what [`seal`] made.
///
/// # Errors
/// What is wrong: it is too short, another kind of file or version, cut off, or damaged.
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

/// Hash of a text or a state by which it is known: FNV-1a, 64 bits (G. Fowler, L. C. Noll, K.-P. Vo).
pub fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// Ending of the name of a draft of a file; a number follows it.
pub const DRAFT: &str = ".part";

/// Names that are tried before a folder full of drafts is given up.
const TRIES: usize = 1000;

/// Writes a file and its place in the folder to the disk; the folder is made where it is missing. Whatever happens, a cut of power
/// included, the whole new file or the whole old one is there.
///
/// # Errors
/// What the system says; the whole old file or the whole new one stands there then.
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

/// Puts what `write` writes in the place of a file. Whatever happens to the process, the whole new file or the whole old one is
/// there; a cut of power may leave neither until [`sync_file`] and [`sync_folder`] have returned.
///
/// # Errors
/// What the system or `write` says; the old file stays then.
pub fn replace_with(file: &Path, write: impl FnOnce(&mut File) -> Result<(), Error>) -> Result<(), Error> {
    let (draft, mut open) = draft_of(file)?;
    let written = write(&mut open);
    drop(open);
    written.and_then(|()| std::fs::rename(&draft, file)).inspect_err(|_| {
        // A draft that cannot be removed does no harm: it is never read.
        let _ = std::fs::remove_file(&draft);
    })
}

/// A new file beside `file`. What stands there already is never opened: it may be a link that somebody planted.
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

/// Writes what a file holds to the disk.
///
/// # Errors
/// What the system says.
pub fn sync_file(file: &Path) -> Result<(), Error> {
    File::open(file)?.sync_all()
}

/// Writes the names in a folder to the disk: what was made, renamed and removed there. An empty path is the folder at hand.
///
/// # Errors
/// What the system says; a file system that cannot do it is no error.
pub fn sync_folder(folder: &Path) -> Result<(), Error> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match File::open(here)?.sync_all() {
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        done => done,
    }
}
