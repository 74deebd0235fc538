//! The small scene of the end-to-end tests.

use std::path::{Path, PathBuf};

/// Its file.
pub fn smoke() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml")
}
