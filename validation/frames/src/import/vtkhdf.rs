//! Frames in VTKHDF files of polygonal data or of an unstructured grid: points and arrays over them, or lines and arrays over them.
//!
//! In [VTKHDF](https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/vtkhdf_specifications.html) arrays of all frames are
//! concatenated. `Steps` states the parts of each frame, the start of its geometry, and the start of its numbers in each array; an
//! array without offsets begins with the geometry.

use super::columns::StatedColumns;
use super::table::{FrameTable, ImportError, Named, is_wanted, table_of};
use crate::export::FIRST_ID;
use crate::run_frames::columns::{DRIVEN_WALLS, driven_walls};
use hdf5_pure::{AttrValue, File};
use std::path::Path;

/// Largest ratio of a dataset's numbers to the bytes of its file: no frames compress further.
const MOST_NUMBERS_PER_BYTE: u64 = 1000;

/// Groups of cells of polygonal data, in the order of the format.
const CELLS: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];

/// Reads the frames of a file: one per step, or a single frame without a time.
pub(super) fn hdf(file: &Path, bytes: Vec<u8>, stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let length = bytes.len() as u64;
    let fault = |problem: String| ImportError::new(file, 1, problem);
    let opened =
        File::from_bytes(bytes).map_err(|error| fault(format!("it is no HDF5 file, or not all of one ({error})")))?;
    let reader = Reader { file: opened, length };
    let (spans, arrays) = reader.layout(stated).map_err(fault)?;
    let first_id = match reader.attribute(FIRST_ID).map_err(fault)? {
        Some(AttrValue::I64(first)) => Some(first),
        _ => None,
    };
    // Only frames of Makadam state poses.
    let fields = |name: &str| first_id.map_or(Ok(None), |_| reader.field(name));
    let poses: Vec<_> = DRIVEN_WALLS.into_iter().map(fields).collect::<Result<_, _>>().map_err(fault)?;
    let frame = |(step, span): (usize, &Span)| {
        let named: Result<Vec<Named>, String> = arrays.iter().map(|array| array.part(step, span)).collect();
        let own =
            |name: &str| poses[DRIVEN_WALLS.iter().position(|known| *known == name)?].as_ref()?.get(step).cloned();
        let driven_walls = driven_walls(|name| Ok(own(name))).map_err(fault)?;
        let named = named.map_err(fault)?;
        Ok(FrameTable { time: span.time, first_id, driven_walls, ..table_of(file, span.count, &named, stated)? })
    };
    spans.iter().enumerate().map(frame).collect()
}

struct Reader {
    file: File,
    /// Bytes of the file.
    length: u64,
}

/// Tuples of one frame: the first in the order of the geometry, and their number.
#[derive(Clone, Copy)]
struct Span {
    time: Option<f64>,
    first: usize,
    count: usize,
}

/// Array over all frames; its numbers are absent if its name has no meaning.
struct Held {
    name: String,
    columns: usize,
    numbers: Option<Vec<f64>>,
    /// First tuple of each step, for arrays with own offsets.
    firsts: Option<Vec<f64>>,
}

impl Held {
    /// Returns the numbers of a frame.
    fn part(&self, step: usize, span: &Span) -> Result<Named, String> {
        let Held { name, columns, numbers, firsts } = self;
        let first = match firsts.as_ref().map(|firsts| firsts.get(step)) {
            Some(Some(first)) => whole(*first)?,
            Some(None) => return Err(format!("Steps/...Offsets/{name} has fewer entries than steps")),
            None => span.first,
        };
        let Some(numbers) = numbers else { return Ok(Named::new(name.clone(), *columns, None)) };
        let bound = |tuple: Option<usize>| tuple?.checked_mul(*columns);
        let (start, end) = (bound(Some(first)), bound(first.checked_add(span.count)));
        let own = start.zip(end).and_then(|(start, end)| numbers.get(start..end));
        let own = own.ok_or_else(|| format!("{name} ends before the frame at {:?} s", span.time.unwrap_or(0.0)))?;
        Ok(Named::new(name.clone(), *columns, Some(own.to_vec())))
    }
}

impl Reader {
    /// Returns frames and arrays.
    fn layout(&self, stated: &StatedColumns) -> Result<(Vec<Span>, Vec<Held>), String> {
        let kind = match self.attribute("Type")? {
            Some(AttrValue::AsciiString(text) | AttrValue::String(text)) => text.trim_end_matches('\0').to_string(),
            _ => "no known type".into(),
        };
        if !["PolyData", "UnstructuredGrid"].contains(&&*kind) {
            return Err(format!("it holds {kind}, not PolyData or UnstructuredGrid"));
        }
        let mut found = [false; 4];
        for (found, group) in found.iter_mut().zip(CELLS).filter(|_| kind == "PolyData") {
            let counts = self.optional(&format!("VTKHDF/{group}/NumberOfCells"))?;
            *found = counts.is_some_and(|counts| counts.iter().any(|&count| count > 0.0));
        }
        let lines = !found[0] && found[1];
        if lines && found[2..].contains(&true) {
            return Err("it has lines and surfaces, and arrays over cells run over both; write lines alone".into());
        }
        let (section, counts) = match lines {
            true => ("CellData", "VTKHDF/Lines/NumberOfCells"),
            false => ("PointData", "VTKHDF/NumberOfPoints"),
        };
        let spans = self.spans(&self.numbers(counts)?.1, lines)?;
        let mut arrays = Vec::new();
        if !lines {
            let (columns, points) = self.numbers("VTKHDF/Points")?;
            arrays.push(Held { name: "points".into(), columns, numbers: Some(points), firsts: None });
        }
        for name in self.names(&format!("VTKHDF/{section}")) {
            let path = format!("VTKHDF/{section}/{name}");
            let columns = self.columns(&path)?;
            let is_read = is_wanted(&name, columns, stated);
            let numbers = if is_read { Some(self.numbers(&path)?.1) } else { None };
            let firsts = self.optional(&format!("VTKHDF/Steps/{section}Offsets/{name}"))?;
            arrays.push(Held { name, columns, numbers, firsts });
        }
        Ok((spans, arrays))
    }

    /// Returns an attribute of the format's group.
    fn attribute(&self, name: &str) -> Result<Option<AttrValue>, String> {
        let root = self.file.group("VTKHDF").map_err(|_| "it has no group VTKHDF".to_string())?;
        Ok(root.attrs().ok().and_then(|mut attributes| attributes.remove(name)))
    }

    /// Returns the names of the datasets of a group; empty if the group is missing.
    fn names(&self, group: &str) -> Vec<String> {
        self.file.group(group).and_then(|group| group.datasets()).unwrap_or_default()
    }

    /// Returns the numbers of a dataset, if the file has it.
    fn optional(&self, path: &str) -> Result<Option<Vec<f64>>, String> {
        let (group, name) = path.rsplit_once('/').unwrap_or(("", path));
        match self.names(group).iter().any(|known| known == name) {
            true => self.numbers(path).map(|(_, numbers)| Some(numbers)),
            false => Ok(None),
        }
    }

    /// Returns the number of columns of a dataset; refuses sizes beyond the file's.
    fn columns(&self, path: &str) -> Result<usize, String> {
        let wrong = |problem: String| format!("{path}: {problem}");
        let dataset = self.file.dataset(path).map_err(|error| wrong(error.to_string()))?;
        let shape = dataset.shape().map_err(|error| wrong(error.to_string()))?;
        let count = shape.iter().try_fold(1_u64, |product, &size| product.checked_mul(size));
        match count.filter(|count| *count <= self.length.saturating_mul(MOST_NUMBERS_PER_BYTE)) {
            Some(_) => Ok(shape.get(1).map_or(1, |&columns| columns as usize).max(1)),
            None => Err(wrong(format!("a shape of {shape:?} is more than the file can hold"))),
        }
    }

    /// Returns columns and numbers of a dataset.
    fn numbers(&self, path: &str) -> Result<(usize, Vec<f64>), String> {
        let columns = self.columns(path)?;
        let numbers = self.file.dataset(path).and_then(|dataset| dataset.read_f64());
        numbers.map(|numbers| (columns, numbers)).map_err(|error| {
            format!("{path}: {error}; if it is whole, write it in the layout of HDF5 1.10 (h5py: libver=\"v110\")")
        })
    }

    /// Returns the numbers of an array over the whole data in each frame, if the file has it.
    fn field(&self, name: &str) -> Result<Option<Vec<Vec<f64>>>, String> {
        let part = |path: &str| self.optional(&format!("VTKHDF/{path}/{name}"));
        let Some(numbers) = part("FieldData")? else { return Ok(None) };
        let (Some(firsts), Some(sizes)) = (part("Steps/FieldDataOffsets")?, part("Steps/FieldDataSizes")?) else {
            return Err(format!("Steps has no FieldDataOffsets and FieldDataSizes of {name}"));
        };
        let frame = |(&first, size): (&f64, &[f64; 2])| {
            let (first, count) = (whole(first)?, whole(size[0] * size[1])?);
            let own = first.checked_add(count).and_then(|end| numbers.get(first..end));
            own.map(<[f64]>::to_vec).ok_or_else(|| format!("FieldData/{name} ends before its last frame"))
        };
        firsts.iter().zip(sizes.as_chunks::<2>().0).map(frame).collect::<Result<_, _>>().map(Some)
    }

    /// Returns the frames; `counts` are the points or lines of each part.
    fn spans(&self, counts: &[f64], lines: bool) -> Result<Vec<Span>, String> {
        let sum = |counts: &[f64]| counts.iter().map(|&count| whole(count)).sum::<Result<usize, _>>();
        let Some(times) = self.optional("VTKHDF/Steps/Values")? else {
            return Ok(vec![Span { time: None, first: 0, count: sum(counts)? }]);
        };
        if !times.iter().all(|time| time.is_finite()) {
            return Err("VTKHDF/Steps/Values: a time is not finite".into());
        }
        let optional = |name: &str| self.optional(&format!("VTKHDF/Steps/{name}"));
        let (first_parts, parts) = match (optional("PartOffsets")?, optional("NumberOfParts")?) {
            (Some(first_parts), Some(parts)) => (first_parts, parts),
            (first_parts, None) => {
                // Each step has the same number of parts, unless geometry is used again.
                let each = counts.len() / times.len().max(1);
                if each * times.len() != counts.len() {
                    return Err("Steps has no NumberOfParts, and the parts are not as many in each step".into());
                }
                let all = (0..times.len()).map(|step| (step * each) as f64).collect();
                (first_parts.unwrap_or(all), vec![each as f64; times.len()])
            }
            (None, Some(_)) => return Err("Steps has no PartOffsets".into()),
        };
        let firsts: Vec<f64> = match lines {
            false => optional("PointOffsets")?.ok_or("Steps has no PointOffsets")?,
            true => {
                // Arrays over cells cover vertices, lines, polygons and strips.
                let (columns, offsets) = self.numbers("VTKHDF/Steps/CellOffsets")?;
                offsets.chunks(columns).map(|row| row.iter().sum()).collect()
            }
        };
        if [parts.len(), first_parts.len(), firsts.len()].iter().any(|&length| length < times.len()) {
            return Err("Steps has fewer entries than times".into());
        }
        let span = |step: usize| {
            let (first, parts) = (whole(first_parts[step])?, whole(parts[step])?);
            let own = first.checked_add(parts).and_then(|end| counts.get(first..end));
            let own = own.ok_or("Steps names parts that are not there")?;
            Ok(Span { time: Some(times[step]), first: whole(firsts[step])?, count: sum(own)? })
        };
        (0..times.len()).map(span).collect()
    }
}

/// Converts a number to a count or an offset.
fn whole(number: f64) -> Result<usize, String> {
    (0.0..1e15).contains(&number).then_some(number as usize).ok_or_else(|| format!("{number} is no count"))
}
