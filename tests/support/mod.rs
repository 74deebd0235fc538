//! What all end-to-end tests share: the command. The small scene, changed copies of it and the lines of a scene have files of
//! their own beside this one, for the tests that need them.

use assert_cmd::Command;
use std::path::Path;

/// The command, with a cache folder of its own.
pub fn makadam(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_makadam"));
    command.env("XDG_CACHE_HOME", folder.join("cache")).current_dir(folder);
    command
}
