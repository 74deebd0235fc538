//! Folders for tables of one machine, next to their scene.

use crate::output::file_stem;
use makadam::lanes::InstructionSet;
use std::path::{Path, PathBuf};

/// Folder of a scene's recorded tables of one kind, such as "scaling": a folder of that name beside a `scene.toml`,
/// `NAME-scaling` beside any other file, and in it a folder named after the processor, an instruction set and, for tables that depend
/// on it, the number of cores.
pub fn record_folder(
    kind: &str,
    scene_file: &Path,
    processor: &str,
    set: Option<InstructionSet>,
    cores: Option<usize>,
) -> PathBuf {
    let folder = match scene_file.file_stem().and_then(|stem| stem.to_str()) {
        Some("scene") | None => scene_file.with_file_name(kind),
        Some(stem) => scene_file.with_file_name(format!("{stem}-{kind}")),
    };
    let trade_marks_left_out = ["(R)", "(TM)"].iter().fold(processor.to_string(), |name, mark| name.replace(mark, ""));
    let processor = file_stem(&trade_marks_left_out).to_ascii_lowercase();
    // Brackets and spaces leave rows of dashes.
    let parts: Vec<&str> = processor.split('-').filter(|part| !part.is_empty()).collect();
    let set = set.map_or("", InstructionSet::name);
    let cores = cores.map_or(String::new(), |cores| format!("-{cores}-cores"));
    folder.join(format!("{}-{set}{cores}", parts.join("-")))
}

#[cfg(test)]
#[path = "../../tests/unit/output_record.rs"]
mod tests;
