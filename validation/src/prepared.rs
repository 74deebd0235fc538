//! Where a run starts: at the lattice gas, or at a flowing state that was prepared once and is kept on the machine.

use crate::execution::Execution;
use crate::output::{WriteError, create_folder};
use crate::plan::Scene;
use crate::provenance::scene_hash;
use crate::scenes::{SceneError, in_file};
use makadam::checkpoint::{CheckpointError, checksum, open, seal, write_atomically};
use makadam::watch::{Alarm, Watchdog};
use makadam::{BUILD, Simulation};
use serde::{Deserialize, Serialize};
use std::fs::DirBuilder;
use std::io::{Error, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
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
    Execution(#[from] makadam::SettingError),
    /// The state that was prepared is worth nothing.
    #[error("while the flowing state was prepared: {0}")]
    Worthless(Alarm),
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
    /// From a flowing state in this file, made anew in place of one that was refused for this reason.
    Remade(PathBuf, String),
}

/// First bytes of a flowing state; the last one is the version of the format.
const MARK: [u8; 8] = *b"mkd-flw\x01";

/// What a flowing state is. It stands before the state, and its layout stays.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Label {
    /// [`BUILD`] of the program that prepared it.
    build: String,
    scene: String,
    scene_hash: u64,
    seed: u64,
}

impl Label {
    /// The state that this build prepares of a scene and a seed.
    fn of(scene: &Scene, seed: u64) -> Label {
        Label { build: BUILD.into(), scene: scene.name.clone(), scene_hash: scene_hash(scene), seed }
    }
}

/// Folder in which prepared states and recordings are kept: `makadam` in `XDG_CACHE_HOME` or in `~/.cache`. Without either it is
/// `makadam-UID` where the system keeps temporary files, with the number of the user, who alone may read and write it.
///
/// # Errors
/// [`WriteError`] if the folder among temporary files belongs to somebody else, or others may write to it.
pub fn cache_folder() -> Result<PathBuf, WriteError> {
    let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let own = absolute("XDG_CACHE_HOME").or_else(|| absolute("HOME").map(|home| home.join(".cache")));
    match own {
        Some(folder) => Ok(folder.join("makadam")),
        None => private_folder(&std::env::temp_dir(), rustix::process::getuid().as_raw()),
    }
}

/// The folder of a user in one that all users share.
fn private_folder(shared: &Path, user: u32) -> Result<PathBuf, WriteError> {
    let folder = shared.join(format!("makadam-{user}"));
    let refuse = |error| WriteError::new(&folder, error);
    match DirBuilder::new().mode(0o700).create(&folder) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(refuse(error)),
        _ => {}
    }
    // Not through a link: anybody may have put one there.
    let data = folder.symlink_metadata().map_err(refuse)?;
    let problem = match () {
        () if !data.is_dir() => "it is not a folder",
        () if data.uid() != user => "it belongs to somebody else",
        () if data.mode() & 0o022 != 0 => "others may write to it",
        () => return Ok(folder),
    };
    let words =
        format!("{problem}, so that what is kept there cannot be trusted; set XDG_CACHE_HOME to a folder of your own");
    Err(refuse(Error::new(ErrorKind::PermissionDenied, words)))
}

/// The simulation at the start of its run. A scene with `[prepare]` is simulated for that time first, unless a state of
/// the same scene, seed and build is in the cache; `progress` is told the share that is done.
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
        let mut simulation = Simulation::new(scene, seed).map_err(in_file(scene_file))?;
        execution.apply(&mut simulation)?;
        return Ok((simulation, Start::Fresh));
    };
    let file = state_file(scene, seed)?;
    // A state that cannot be taken is made anew.
    let refused = match start_from(scene, seed, &file) {
        Some(Ok(mut simulation)) => {
            execution.apply(&mut simulation)?;
            return Ok((simulation, Start::Prepared(file)));
        }
        Some(Err(reason)) => Some(reason),
        None => None,
    };
    let mut beforehand = scene.clone();
    beforehand.solver.step = prepare.step;
    let mut simulation = Simulation::new(&beforehand, seed).map_err(in_file(scene_file))?;
    execution.apply(&mut simulation)?;
    let steps = steps_in(prepare.duration, prepare.step);
    let mut watchdog = Watchdog::new(&scene.watch, &simulation);
    for step in 1..=steps {
        let report = simulation.step();
        watchdog.check(&simulation, &report, step == steps).map_err(StartError::Worthless)?;
        progress(step as f64 / steps as f64);
        if crate::interrupt::requested() {
            return Err(StartError::Interrupted);
        }
    }
    if let Some(folder) = file.parent() {
        create_folder(folder)?;
    }
    let state = simulation.checkpoint();
    let labelled = postcard::to_stdvec(&(Label::of(scene, seed), &state)).expect("numbers, text and bytes");
    write_atomically(&file, &seal(MARK, &labelled)).map_err(|error| WriteError::new(&file, error))?;
    let mut simulation = Simulation::start_from(scene, &state)?;
    execution.apply(&mut simulation)?;
    Ok((
        simulation,
        refused.map_or_else(|| Start::Prepared(file.clone()), |reason| Start::Remade(file.clone(), reason)),
    ))
}

/// Starts from a state that is kept: `None` if there is none, and the reason if it is refused.
fn start_from(scene: &Scene, seed: u64, file: &Path) -> Option<Result<Simulation, String>> {
    let bytes = match std::fs::read(file) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return None,
        Err(error) => return Some(Err(format!("cannot be read: {error}"))),
    };
    let state = labelled_state(scene, seed, &bytes);
    let started = |state: Vec<u8>| {
        Simulation::start_from(scene, &state).map_err(|error| match error {
            CheckpointError::Format { problem } => problem,
            other => other.to_string(),
        })
    };
    Some(state.and_then(started))
}

/// The state in the bytes of a file, if it is one of this scene, seed and build.
fn labelled_state(scene: &Scene, seed: u64, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let unfit = |error| format!("does not hold what it should ({error})");
    let (label, rest) = postcard::take_from_bytes::<Label>(open(MARK, bytes)?).map_err(unfit)?;
    let wanted = Label::of(scene, seed);
    if label.build != wanted.build {
        return Err(format!("was prepared by build {}, and this is build {}", label.build, wanted.build));
    }
    if label != wanted {
        return Err(format!(
            "is a state of {} with seed {} (scene {:016x}), not of {} with seed {seed} (scene {:016x})",
            label.scene, label.seed, label.scene_hash, wanted.scene, wanted.scene_hash
        ));
    }
    postcard::from_bytes(rest).map_err(unfit)
}

/// Whether a run of the scene can start at once: it prepares no flowing state, or that is in the cache.
pub fn is_ready(scene: &Scene, seed: u64) -> bool {
    let takes = |file: PathBuf| std::fs::read(file).is_ok_and(|bytes| labelled_state(scene, seed, &bytes).is_ok());
    scene.prepare.is_none() || state_file(scene, seed).is_ok_and(takes)
}

/// Where a flowing state is kept.
fn state_file(scene: &Scene, seed: u64) -> Result<PathBuf, WriteError> {
    let name = format!("{}-s{seed}-{:016x}.state", file_stem(&scene.name), scene_hash(scene));
    Ok(cache_folder()?.join("prepared").join(name))
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
    use std::fs::{Permissions, set_permissions};
    use std::os::unix::fs::{PermissionsExt, symlink};

    fn smoke() -> Scene {
        Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml")).unwrap()
    }

    fn bytes(label: &Label) -> Vec<u8> {
        seal(MARK, &postcard::to_stdvec(&(label, b"a state".to_vec())).unwrap())
    }

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

    #[test]
    fn a_state_says_what_it_is_and_any_other_one_is_refused_in_words() {
        let scene = smoke();
        let label = || Label::of(&scene, 1);
        assert_eq!(labelled_state(&scene, 1, &bytes(&label())).unwrap(), b"a state");
        let refused = |seed: u64, bytes: &[u8], words: &str| {
            let message = labelled_state(&scene, seed, bytes).unwrap_err();
            assert!(message.contains(words), "{message}");
        };
        refused(2, &bytes(&label()), "with seed 1");
        refused(1, &bytes(&Label { scene_hash: 7, ..label() }), "0000000000000007");
        refused(1, &bytes(&Label { build: "0.1.9-abc".into(), ..label() }), "by build 0.1.9-abc, and this is build");
        let mut damaged = bytes(&label());
        *damaged.last_mut().unwrap() ^= 1;
        refused(1, &damaged, "damaged");
    }

    #[test]
    fn a_folder_among_temporary_files_is_taken_only_from_its_user() {
        let shared = tempfile::tempdir().unwrap();
        let user = shared.path().metadata().unwrap().uid();
        let folder = private_folder(shared.path(), user).unwrap();
        assert_eq!(folder.metadata().unwrap().mode() & 0o777, 0o700);
        assert_eq!(private_folder(shared.path(), user).unwrap(), folder, "it is taken again");

        let refused = |user: u32, words: &str| {
            let message = private_folder(shared.path(), user).unwrap_err().to_string();
            assert!(message.contains(words) && message.contains("XDG_CACHE_HOME"), "{message}");
        };
        set_permissions(&folder, Permissions::from_mode(0o770)).unwrap();
        refused(user, "others may write");
        refused(user + 1, "belongs to somebody else");
        set_permissions(&folder, Permissions::from_mode(0o700)).unwrap();
        symlink(&folder, shared.path().join(format!("makadam-{}", user + 2))).unwrap();
        refused(user + 2, "not a folder");
    }
}
