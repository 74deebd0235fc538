//! Sources of scenes: files, or the reference scenes inside the program.
//!
//! A folder `reference-scenes` in the current folder or above takes precedence over the program's own scenes. The latter are the scenes and their
//! recorded references at the time of the build; no path of the build machine is read.

mod change;
mod schema;

pub use change::{Change, ChangeError, changed, key_of};
use makadam::scene::{Document, SceneFileError, suggestion};
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::catalogue;
pub use schema::{page, schema};
use std::collections::BTreeMap;
use std::io::{Error, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Name of the scene on standard input.
pub const STANDARD_INPUT: &str = "-";

/// Error of a missing or invalid scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The name is neither a file nor a known scene.
    #[error(
        "no scene '{name}'; {}",
        suggestion(
            name,
            known.iter().map(String::as_str),
            "give a path to a TOML file, - for standard input, or a name that `makadam print scenes` lists"
        )
    )]
    Unknown {
        /// Requested name.
        name: String,
        /// Scenes that exist.
        known: Vec<String>,
    },
    /// The file cannot be read, or its content is refused.
    #[error(transparent)]
    File(#[from] SceneFileError),
    /// A value cannot replace that of the scene.
    #[error("--set {0}")]
    Change(#[from] ChangeError),
}

/// Converts a fault of the scene of a file to an error that names the file and, where available, the line.
pub fn in_file(file: &Path) -> impl Fn(makadam::scene::SceneError) -> SceneError + '_ {
    move |error| error.in_file(file, text(file).ok().as_deref()).into()
}

/// Converts an error of a scene made in code to one that names the scene.
pub fn named(name: &str) -> impl Fn(makadam::scene::SceneError) -> SceneError + '_ {
    move |error| error.in_file(Path::new(name), None).into()
}

/// Folders searched for `reference-scenes`: the current one and those above it.
pub fn roots() -> Vec<PathBuf> {
    let here = std::env::current_dir().unwrap_or_default();
    here.ancestors().map(PathBuf::from).collect()
}

/// Finds the file of a scene named by a path, by its folder under `reference-scenes/` in `roots`, or by its name among the program's
/// own scenes.
///
/// # Errors
/// [`SceneFileError::Missing`] if a path names no file, [`SceneError::Unknown`] if no scene has the name.
pub fn find(name: &str, roots: &[PathBuf]) -> Result<PathBuf, SceneError> {
    let as_path = PathBuf::from(name);
    if as_path.is_file() {
        return Ok(as_path);
    }
    let folders = roots.iter().map(|root| root.join("reference-scenes").join(name));
    let files = std::iter::once(as_path).chain(folders).map(|folder| folder.join("scene.toml"));
    if let Some(file) = files.into_iter().find(|file| file.is_file()) {
        return Ok(file);
    }
    let held = Path::new(BUILT_IN).join(name).join("scene.toml");
    if bytes_of(&held).is_some() {
        return Ok(held);
    }
    if name.contains('/') || name.ends_with(".toml") {
        let source = match std::fs::metadata(name) {
            Err(source) => source,
            Ok(there) if there.is_dir() => Error::other("it is a folder without a scene.toml"),
            Ok(_) => Error::other(
                "it is no regular file, such as a pipe or a device; write the scene to a file and name that",
            ),
        };
        return Err(SceneFileError::Missing { file: name.into(), source }.into());
    }
    Err(SceneError::Unknown { name: name.into(), known: known(roots) })
}

/// Names of the scenes in folders `reference-scenes` of `roots`, and of the program's own scenes, sorted.
pub fn known(roots: &[PathBuf]) -> Vec<String> {
    let entries =
        roots.iter().filter_map(|root| std::fs::read_dir(root.join("reference-scenes")).ok()).flatten().flatten();
    let mut known: Vec<String> = entries
        .filter(|entry| entry.path().join("scene.toml").is_file())
        .filter_map(|entry| entry.file_name().into_string().ok())
        .chain(names().map(String::from))
        .collect();
    known.sort();
    known.dedup();
    known
}

/// Reads a scene's file as text.
///
/// # Errors
/// [`SceneFileError::Missing`] if it cannot be read, or is not text.
pub fn text(file: &Path) -> Result<String, SceneError> {
    let missing = |source| SceneFileError::Missing { file: file.to_path_buf(), source };
    let bytes = read(file).map_err(missing)?;
    String::from_utf8(bytes).map_err(|error| missing(Error::new(ErrorKind::InvalidData, error)).into())
}

/// Finds the text of a scene by its name, by a path, or on standard input, makes changes, and returns the path under which later
/// reads find it.
///
/// # Errors
/// [`SceneError`] if there is no such scene, or a change cannot be made.
pub fn take(name: &str, roots: &[PathBuf], changes: &[Change]) -> Result<PathBuf, SceneError> {
    let (mut path, mut given) = match name {
        STANDARD_INPUT => (PathBuf::from("<standard input>"), Some(standard_input()?)),
        name => (find(name, roots)?, None),
    };
    let origin = given.is_none().then(|| path.clone());
    if !changes.is_empty() {
        let text = given.map_or_else(|| text(&path), Ok)?;
        given = Some(changed(&text, &folder(&path), changes)?);
        let written: Vec<String> = changes.iter().map(|change| format!("--set {change}")).collect();
        path = format!("{} with {}", path.display(), written.join(" ")).into();
    }
    if let Some(text) = given {
        GIVEN.lock().unwrap_or_else(PoisonError::into_inner).insert(path.clone(), (text, origin));
    }
    Ok(path)
}

/// Returns a scene with the content of its files after changes; errors name its place.
pub fn with_changes(scene: &MeasuredScene, place: &Path, changes: &[Change]) -> Result<MeasuredScene, SceneError> {
    let text = toml::to_string(scene).expect("a scene is made of plain tables");
    parse(&changed(&text, place, changes)?, place)
}

fn standard_input() -> Result<String, SceneError> {
    let mut text = String::new();
    let read = std::io::stdin().lock().read_to_string(&mut text);
    let missing = |source| SceneFileError::Missing { file: "<standard input>".into(), source };
    read.map_err(missing)?;
    Ok(text)
}

/// Reads and checks a scene: also that every compared observable is measured.
pub fn load(file: &Path) -> Result<MeasuredScene, SceneError> {
    parse(&text(file)?, file)
}

/// Reads and checks the text of a scene; `file` is its file in messages.
pub fn parse(text: &str, file: &Path) -> Result<MeasuredScene, SceneError> {
    let scene = plan(text, &folder(file));
    let scene = scene.map_err(|error| error.in_file(file, Some(text)))?;
    catalogue::check(&scene, text, file)?;
    Ok(scene)
}

/// Reads and checks the text of a scene in a folder, which may be in the program.
pub fn plan(text: &str, folder: &Path) -> Result<MeasuredScene, makadam::scene::SceneError> {
    MeasuredScene::read(&Document::parse(text)?.in_folder(folder).reading_with(read))
}

/// First part of the paths into the program; the rest is as under `reference-scenes`.
pub const BUILT_IN: &str = "<built-in>";

/// File under `reference-scenes`: its path there, and its content.
type Held = (&'static str, &'static [u8]);

include!(concat!(env!("OUT_DIR"), "/scenes.rs"));

/// Texts given at the start, by paths without a file; each with the file of the original scene.
static GIVEN: Mutex<BTreeMap<PathBuf, (String, Option<PathBuf>)>> = Mutex::new(BTreeMap::new());

/// Names of the program's own scenes.
pub fn names() -> impl Iterator<Item = &'static str> {
    HELD.iter().filter_map(|(path, _)| path.strip_suffix("/scene.toml"))
}

/// Returns true for a path into the program.
pub fn is_built_in(path: &Path) -> bool {
    path.starts_with(BUILT_IN)
}

/// Returns the bytes at a path into the program.
pub(super) fn bytes_of(path: &Path) -> Option<&'static [u8]> {
    let path = path.strip_prefix(BUILT_IN).ok()?.to_str()?;
    HELD.iter().find(|(held, _)| *held == path).map(|(_, bytes)| *bytes)
}

/// Returns true for the path of a given text, which has no file.
pub fn is_given(path: &Path) -> bool {
    given(path).is_some()
}

/// File of a scene; for a scene that was changed at the start, the file of the original.
pub fn origin(path: &Path) -> PathBuf {
    given(path).and_then(|(_, origin)| origin).unwrap_or_else(|| path.to_path_buf())
}

/// Returns the folder of the files that a scene names: that of its file, or the current folder for a scene without a file.
pub fn folder(file: &Path) -> PathBuf {
    let origin = match given(file) {
        Some((_, origin)) => origin.unwrap_or_default(),
        None => file.to_path_buf(),
    };
    origin.parent().unwrap_or(Path::new("")).to_path_buf()
}

fn given(path: &Path) -> Option<(String, Option<PathBuf>)> {
    GIVEN.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned()
}

/// Reads a file, on a disk or in the program.
///
/// # Errors
/// Error of the system, or [`ErrorKind::NotFound`] for an unknown path into the program.
pub fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    if let Some((text, _)) = given(path) {
        return Ok(text.into_bytes());
    }
    match is_built_in(path) {
        true => bytes_of(path).map(<[u8]>::to_vec).ok_or_else(|| ErrorKind::NotFound.into()),
        false => std::fs::read(path),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/scenes.rs"]
mod tests;
