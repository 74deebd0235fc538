//! The small scene of the end-to-end tests.

use std::path::{Path, PathBuf};

/// Its file.
pub fn smoke() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml")
}

/// The text of a scene of which the first observable alone is compared.
pub fn compared_once(text: &str) -> String {
    let (head, compared) = text.split_once("[[compare]]").unwrap();
    format!("{head}[[compare]]{}", compared.split("[[compare]]").next().unwrap())
}
