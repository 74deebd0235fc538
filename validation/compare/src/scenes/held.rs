//! Scenes that lie in no file of the disk: those that the program holds, and texts that it was given when it was started.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The first part of the paths of what the program holds; what follows is as under `reference-scenes`.
pub const BUILT_IN: &str = "<built-in>";

/// A file under `reference-scenes`: its path there, and what it holds.
type Held = (&'static str, &'static [u8]);

include!(concat!(env!("OUT_DIR"), "/scenes.rs"));

/// A text that was given at the start, by a path that leads to no file.
#[derive(Clone)]
struct Given {
    path: PathBuf,
    text: String,
    /// The file of which it is a change.
    origin: Option<PathBuf>,
}

static GIVEN: Mutex<Vec<Given>> = Mutex::new(Vec::new());

/// Names of the scenes that the program holds.
pub fn names() -> impl Iterator<Item = &'static str> {
    HELD.iter().filter_map(|(path, _)| path.strip_suffix("/scene.toml"))
}

/// Returns true for a path into the program.
pub fn is_built_in(path: &Path) -> bool {
    path.starts_with(BUILT_IN)
}

/// Returns the bytes that the program holds at a path.
pub(super) fn bytes_of(path: &Path) -> Option<&'static [u8]> {
    let path = path.strip_prefix(BUILT_IN).ok()?.to_str()?;
    HELD.iter().find(|(held, _)| *held == path).map(|(_, bytes)| *bytes)
}

/// Gives a text a path, under which it is read from then on, and the file of which it is a change.
pub(super) fn give(path: PathBuf, text: String, origin: Option<PathBuf>) {
    let mut given = GIVEN.lock().unwrap_or_else(PoisonError::into_inner);
    given.retain(|known| known.path != path);
    given.push(Given { path, text, origin });
}

/// Returns true for the path of a text that was given, which no file holds.
pub fn is_given(path: &Path) -> bool {
    given(path).is_some()
}

/// The file of a scene: of one that was changed when the program was started, the one that was changed.
pub fn origin(path: &Path) -> PathBuf {
    given(path).and_then(|given| given.origin).unwrap_or_else(|| path.to_path_buf())
}

fn given(path: &Path) -> Option<Given> {
    let given = GIVEN.lock().unwrap_or_else(PoisonError::into_inner);
    given.iter().find(|known| known.path == path).cloned()
}

/// Reads a file, whether it lies on a disk or in the program.
///
/// # Errors
/// What the system says; [`ErrorKind::NotFound`] for what the program does not hold.
pub fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    if let Some(given) = given(path) {
        return Ok(given.text.into_bytes());
    }
    match is_built_in(path) {
        true => bytes_of(path).map(<[u8]>::to_vec).ok_or_else(|| ErrorKind::NotFound.into()),
        false => std::fs::read(path),
    }
}
