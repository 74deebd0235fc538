//! Names of files and folders, and the cache folder.

use super::WriteError;
use makadam::checkpoint::checksum;
use makadam::lanes::InstructionSet;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Longest part of a file name from a scene's name, bytes: suffixes follow, and file systems allow 255.
const LONGEST_STEM: usize = 120;

/// Returns a scene's name as a part of a file name: never empty, never a folder such as `..`, never longer than 120 bytes.
pub fn file_stem(name: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '-' }
    };
    let stem: String = name.chars().map(plain).collect();
    if stem.bytes().all(|byte| byte == b'.') {
        return format!("scene{}", "-".repeat(stem.len().min(LONGEST_STEM / 2)));
    }
    if stem.len() <= LONGEST_STEM {
        return stem;
    }
    // Long names often have the same beginning.
    let hash = format!("-{:016x}", checksum(name.as_bytes()));
    stem[..LONGEST_STEM - hash.len()].to_string() + &hash
}

/// Folder of a scene's recorded tables of one kind, such as "scaling": a folder of that name next to a `scene.toml`,
/// `NAME-scaling` next to any other file. It contains a folder named after the processor, an instruction set and, for tables that depend
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

/// Returns the folder for cached states and recordings: `makadam` in `XDG_CACHE_HOME` or in `~/.cache`.
///
/// # Errors
/// [`WriteError`] if the environment names neither.
pub fn cache_folder() -> Result<PathBuf, WriteError> {
    let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let own = absolute("XDG_CACHE_HOME").or_else(|| absolute("HOME").map(|home| home.join(".cache")));
    let missing = || {
        let words = "neither HOME nor XDG_CACHE_HOME is an absolute path; set XDG_CACHE_HOME to a folder of your own";
        WriteError::new(Path::new("cache"), Error::new(ErrorKind::InvalidData, words))
    };
    own.map(|folder| folder.join("makadam")).ok_or_else(missing)
}

/// Returns a path in [`cache_folder`] for the files of one run of a code, unique among all runs of this and other processes while this
/// process lives, even for the same scene and seed. Creates nothing.
pub fn run_folder(name: &str) -> Result<PathBuf, WriteError> {
    static RUNS: AtomicU64 = AtomicU64::new(1);
    let number = RUNS.fetch_add(1, Ordering::Relaxed);
    Ok(cache_folder()?.join("runs").join(format!("{name}-{}-{number}", std::process::id())))
}

#[cfg(test)]
#[path = "../../tests/unit/output_folders.rs"]
mod tests;
