//! Common parts of the end-to-end tests: the command, a command in the background, a small and a tiny scene, changed copies of the former,
//! invented records and the lines of a scene.

pub mod changed;
pub mod child;
pub mod disk;
pub mod invented;
pub mod lines;
pub mod small_scene;
pub mod tiny_scene;

use assert_cmd::Command;
use std::path::Path;

/// The command, with a cache folder of its own.
pub fn makadam(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_makadam"));
    command.env("XDG_CACHE_HOME", folder.join("cache")).current_dir(folder);
    command
}
