//! Lines of the keys of a scene.

use std::path::Path;

/// Line of the changed scene that holds a piece of text.
pub fn line_of(file: &Path, text: &str) -> usize {
    let content = std::fs::read_to_string(file).unwrap();
    1 + content.lines().position(|line| line.contains(text)).unwrap()
}
