//! Where tables that belong to one machine are kept beside their scene.

use crate::prepared::file_stem;
use makadam::lanes::InstructionSet;
use std::path::{Path, PathBuf};

/// Folder of a scene's recorded tables of one kind, such as "scaling": a folder of that name beside a `scene.toml`,
/// `NAME-scaling` beside any other file, and in it a folder named after the processor and an instruction set.
pub fn record_folder(kind: &str, scene_file: &Path, processor: &str, set: Option<InstructionSet>) -> PathBuf {
    let folder = match scene_file.file_stem().and_then(|stem| stem.to_str()) {
        Some("scene") | None => scene_file.with_file_name(kind),
        Some(stem) => scene_file.with_file_name(format!("{stem}-{kind}")),
    };
    let processor = file_stem(processor).to_ascii_lowercase();
    // Brackets and trade marks leave rows of dashes.
    let parts: Vec<&str> = processor.split('-').filter(|part| !part.is_empty()).collect();
    let set = set.map_or("", InstructionSet::name);
    folder.join(format!("{}-{set}", parts.join("-")))
}
