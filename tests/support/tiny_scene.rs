//! A scene of few grains and few steps, for tests that run it many times.

use std::path::{Path, PathBuf};

/// A scene file in `folder`: twenty grains, a frame every four steps of 0.5 ms, measured from the second frame on.
pub fn tiny(folder: &Path) -> PathBuf {
    let text = std::fs::read_to_string(super::small_scene::smoke()).unwrap();
    let text = [
        ("name = \"smoke\"", "name = \"tiny\""),
        ("count = 200", "count = 20"),
        ("interval = 0.05", "interval = 0.002\nfrom = 0.002"),
    ]
    .iter()
    .fold(text, |text, (from, to)| {
        assert!(text.contains(from), "the small scene has no '{from}'");
        text.replacen(from, to, 1)
    });
    let file = folder.join("tiny.toml");
    std::fs::write(&file, text).unwrap();
    file
}
