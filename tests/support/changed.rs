//! Changed copies of the small scene.

use std::path::{Path, PathBuf};

/// A copy of the small scene in `folder`, with one piece of text replaced.
pub fn changed(folder: &Path, from: &str, to: &str) -> PathBuf {
    let text = std::fs::read_to_string(super::small_scene::smoke()).unwrap();
    assert!(text.contains(from), "the small scene has no '{from}'");
    let file = folder.join("changed.toml");
    std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
    file
}
