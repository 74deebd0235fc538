//! Frames of contacts by what they tell of: each series has to tell every measured frame.

use super::frame_table::FrameTable;
use super::numbering::{all_digits, pattern};
use std::collections::{BTreeMap, BTreeSet};

/// A frame of contacts.
pub(super) struct OfSeries<'t> {
    pub table: &'t FrameTable,
    /// Its time, s, if it is known.
    pub time: Option<f64>,
    /// Place of the frame of grains that it belongs to.
    pub at: Option<usize>,
}

/// Frames with the same columns, of one file or of files whose names differ in numbers alone.
#[derive(Default)]
pub(super) struct ContactSeries<'t>(BTreeMap<(String, &'t [String]), Vec<OfSeries<'t>>>);

impl<'t> ContactSeries<'t> {
    pub fn add(&mut self, one: OfSeries<'t>) {
        self.0.entry((pattern(&one.table.file), &one.table.columns)).or_default().push(one);
    }

    /// The series, each of which tells a frame once.
    pub fn apart(self) -> Vec<Vec<OfSeries<'t>>> {
        self.0.into_values().flat_map(split_by_numbers).collect()
    }
}

/// Earliest and latest time of a series, s.
pub(super) fn span(series: &[OfSeries<'_>]) -> Option<[f64; 2]> {
    let times = || series.iter().filter_map(|one| one.time);
    let (from, to) = (times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max));
    (from <= to).then_some([from, to])
}

/// Parts of a series that tell each frame once: where two files are of one frame, the numbers in which their names differ tell what they
/// are of, such as `wall0_100.csv` and `wall1_100.csv`.
fn split_by_numbers(all: Vec<OfSeries<'_>>) -> Vec<Vec<OfSeries<'_>>> {
    let mut of_frame: BTreeMap<usize, Vec<Vec<String>>> = BTreeMap::new();
    for one in &all {
        // Those that belong to no frame tell nothing of one another.
        if let Some(at) = one.at {
            of_frame.entry(at).or_default().push(all_digits(&one.table.file));
        }
    }
    let mut kinds: BTreeSet<usize> = BTreeSet::new();
    for names in of_frame.values() {
        let width = names.iter().map(Vec::len).max().unwrap_or(0);
        kinds.extend((0..width).filter(|place| names.iter().any(|name| name.get(*place) != names[0].get(*place))));
    }
    let mut parts: BTreeMap<Vec<Option<String>>, Vec<OfSeries<'_>>> = BTreeMap::new();
    for one in all {
        let digits = all_digits(&one.table.file);
        let kind = kinds.iter().map(|place| digits.get(*place).cloned()).collect();
        parts.entry(kind).or_default().push(one);
    }
    parts.into_values().collect()
}
