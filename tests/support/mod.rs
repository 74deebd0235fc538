//! What the end-to-end tests share: the command, the small scene, changed copies of it.

use assert_cmd::Command;
use std::path::{Path, PathBuf};

/// Root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The small scene.
pub fn smoke() -> PathBuf {
    root().join("tests/scenes/smoke.toml")
}

/// The command, with a cache folder of its own.
pub fn makadam(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_makadam"));
    command.env("XDG_CACHE_HOME", folder.join("cache")).current_dir(folder);
    command
}

/// A copy of the small scene in `folder`, with one piece of text replaced.
#[allow(dead_code, reason = "not every test changes the scene")]
pub fn changed(folder: &Path, from: &str, to: &str) -> PathBuf {
    let text = std::fs::read_to_string(smoke()).unwrap();
    assert!(text.contains(from), "the small scene has no '{from}'");
    let file = folder.join("changed.toml");
    std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
    file
}

/// Line of the changed scene that holds a piece of text.
#[allow(dead_code, reason = "not every test changes the scene")]
pub fn line_of(file: &Path, text: &str) -> usize {
    let content = std::fs::read_to_string(file).unwrap();
    1 + content.lines().position(|line| line.contains(text)).unwrap()
}
