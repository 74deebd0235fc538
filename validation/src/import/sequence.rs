//! The order of files by the numbers in their names, and which of them tell of one thing from frame to frame.

use super::frame_table::{FrameTable, ImportError};
use super::numbering::{InOrder, by_numbers, pattern};
use std::collections::BTreeMap;
use std::path::Path;

/// The name of a path with `#` in place of its numbers.
fn name_of(path: &Path) -> String {
    pattern(Path::new(path.file_name().unwrap_or(path.as_os_str())))
}

/// Files whose names differ in numbers alone, by these numbers; gaps between the numbers are noted.
fn counted<'t>(files: Vec<&'t Path>, notes: &mut Vec<String>) -> Result<Vec<&'t Path>, ImportError> {
    let InOrder { files, even } = by_numbers(files)?;
    if let [first, .., last] = files[..]
        && !even
    {
        let name = |file: &Path| file.file_name().unwrap_or_default().display().to_string();
        notes.push(format!(
            "the numbers in the names of files, from {} to {}, are not evenly apart: frames are counted, and each is taken as one \
             interval after the one before; where files are missing, later frames are taken too early",
            name(first),
            name(last)
        ));
    }
    Ok(files)
}

/// Files without repetition, in the order of their tables.
fn files_of(tables: &[FrameTable]) -> Vec<&Path> {
    let mut files: Vec<&Path> = tables.iter().map(|table| &*table.file).collect();
    files.dedup();
    files
}

/// Frames of grains that follow one another, of one file or of several: by the numbers in the names where these differ in numbers
/// alone, else as they stand.
///
/// # Errors
/// [`ImportError`] where the names do not tell one order.
pub(super) fn one_after_the_other<'t>(
    tables: &'t [FrameTable],
    notes: &mut Vec<String>,
) -> Result<Vec<&'t FrameTable>, ImportError> {
    let files = files_of(tables);
    let mut alike: BTreeMap<String, Vec<&Path>> = BTreeMap::new();
    files.iter().for_each(|file| alike.entry(pattern(file)).or_default().push(file));
    let files = match alike.len() {
        1 => counted(files, notes)?,
        names if names == files.len() => files,
        _ => {
            let [one, other] =
                [0, 1].map(|place| alike.values().nth(place).map_or_else(String::new, |files| name_of(files[0])));
            let problem = format!(
                "files of several names ({one}, {other}) tell neither times nor one order; leave files of one name, or tell times by \
                 steps (--time-step) or by a column time"
            );
            return Err(ImportError::new(files[0], 1, problem));
        }
    };
    let rank: BTreeMap<&Path, usize> = files.into_iter().zip(0..).collect();
    let mut ordered: Vec<&FrameTable> = tables.iter().collect();
    ordered.sort_by_key(|table| rank[&*table.file]);
    Ok(ordered)
}

/// Frames of contacts as series, each of which has a frame for each of the grains', in their order: a file of several frames, or files
/// of one frame each whose names differ in numbers alone.
///
/// # Errors
/// [`ImportError`] where the names do not tell one order.
pub(super) fn side_by_side<'t>(
    tables: &'t [FrameTable],
    notes: &mut Vec<String>,
) -> Result<Vec<Vec<&'t FrameTable>>, ImportError> {
    let mut of_file: BTreeMap<&Path, Vec<&FrameTable>> = BTreeMap::new();
    tables.iter().for_each(|table| of_file.entry(&table.file).or_default().push(table));
    let mut series = Vec::new();
    let mut alike: BTreeMap<String, Vec<&Path>> = BTreeMap::new();
    for file in files_of(tables) {
        match &of_file[file][..] {
            [_] => alike.entry(pattern(file)).or_default().push(file),
            several => series.push(several.to_vec()),
        }
    }
    for files in alike.into_values() {
        series.push(counted(files, notes)?.iter().flat_map(|file| of_file[file].iter().copied()).collect());
    }
    Ok(series)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables(files: &[&str]) -> Vec<FrameTable> {
        let table = |file: &&str| FrameTable { file: file.into(), line: 1, ..FrameTable::default() };
        files.iter().map(table).collect()
    }

    fn names(tables: &[&FrameTable]) -> Vec<String> {
        tables.iter().map(|table| table.file.display().to_string()).collect()
    }

    #[test]
    fn frames_follow_the_numbers_in_their_names() {
        let ordered =
            |files: &[&str]| one_after_the_other(&tables(files), &mut Vec::new()).map(|ordered| names(&ordered));
        assert_eq!(ordered(&["a10.csv", "a2.csv", "a1.csv"]).unwrap(), ["a1.csv", "a2.csv", "a10.csv"]);
        assert_eq!(ordered(&["a10.csv", "a002.csv"]).unwrap(), ["a002.csv", "a10.csv"]);
        assert_eq!(ordered(&["f10/a.csv", "f9/a.csv"]).unwrap(), ["f9/a.csv", "f10/a.csv"]);
        assert_eq!(ordered(&["9_of_10.csv", "10_of_10.csv"]).unwrap(), ["9_of_10.csv", "10_of_10.csv"]);
        // Without numbers the order is that in which they are given.
        assert_eq!(ordered(&["late.csv", "early.csv"]).unwrap(), ["late.csv", "early.csv"]);
        let refused = |files: &[&str], words: &str| {
            let error = ordered(files).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        refused(&["small_1.csv", "small_2.csv", "large_1.csv"], "files of several names (large_#.csv, small_#.csv)");
        refused(&["rank0_1.csv", "rank0_2.csv", "rank1_1.csv"], "rank1_1.csv: line 1: which number in the names");
    }

    #[test]
    fn each_series_of_contacts_counts_its_own_frames() {
        let of = |files: &[&str]| -> Vec<Vec<String>> {
            side_by_side(&tables(files), &mut Vec::new()).unwrap().iter().map(|series| names(series)).collect()
        };
        let both = ["pair10.csv", "pair9.csv", "wall9.csv", "wall10.csv"];
        assert_eq!(of(&both), [["pair9.csv", "pair10.csv"], ["wall9.csv", "wall10.csv"]]);
        // A file of several frames counts its own.
        assert_eq!(of(&["w0.csv", "w0.csv", "w1.csv", "w1.csv"]), [["w0.csv", "w0.csv"], ["w1.csv", "w1.csv"]]);
        let walls = tables(&["wall0.1.csv", "wall0.2.csv", "wall1.1.csv", "wall1.2.csv"]);
        assert!(side_by_side(&walls, &mut Vec::new()).unwrap_err().to_string().contains("which number in the names"));
    }
}
