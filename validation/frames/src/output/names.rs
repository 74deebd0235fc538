//! Names of files.

use makadam::checkpoint::checksum;

/// Longest part of a file name that is made from a name, bytes: others are added to it, and file systems take 255.
const LONGEST_STEM: usize = 120;

/// A scene's name as a part of a file name: never empty, never one that stands for a folder, never longer than 120 bytes.
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
    // Long names are often alike at their beginnings.
    let hash = format!("-{:016x}", checksum(name.as_bytes()));
    stem[..LONGEST_STEM - hash.len()].to_string() + &hash
}

#[cfg(test)]
#[path = "../../tests/unit/output_names.rs"]
mod tests;
