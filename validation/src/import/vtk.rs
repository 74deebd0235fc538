//! Frames in VTK's XML files (`.vtp`, `.vtu`) and in VTKHDF files: points and what is told of them, or lines and what is told of them.

use super::frame_table::{FrameTable, ImportError};
use super::text::{component_names, join};
use crate::output::vtk::Array;
use crate::output::{DRIVEN_WALLS, outline_vtk, vtk_field_arrays};
use hdf5_pure::{AttrValue, File};
use makadam::snapshot::DrivenWall;
use std::path::Path;

/// Most numbers of a dataset over the bytes of its file: no compression makes more of frames.
const MOST_NUMBERS_PER_BYTE: u64 = 1000;

/// What a table is made of, by its names: numbers of points or of cells.
type Named = (Vec<String>, Vec<f64>);

/// The frame in an XML file of polygonal data or of an unstructured grid: its points, or its lines, if it has some.
///
/// # Errors
/// [`ImportError`].
pub(super) fn xml(file: &Path, bytes: &[u8]) -> Result<Vec<FrameTable>, ImportError> {
    let outline = outline_vtk(bytes, &|_| true).map_err(|problem| ImportError::new(file, 1, problem))?;
    let told = |section: &str| outline.sections.iter().any(|(name, arrays)| *name == section && !arrays.is_empty());
    // A frame without contacts has no lines, and is told by what it says of them.
    let lines = outline.topology == "Lines" || (outline.points == 0 && !told("PointData") && told("CellData"));
    let (wanted, count) =
        if lines { (&["CellData"][..], outline.cells) } else { (&["Points", "PointData"][..], outline.points) };
    let of_kind = outline.sections.iter().filter(|(section, _)| wanted.contains(section));
    let arrays = of_kind.flat_map(|(section, arrays)| arrays.iter().map(move |array| (*section, array)));
    let named = arrays.map(|(section, array)| {
        let name = if section == "Points" { "points" } else { &array.name };
        (component_names(name, array.components), array.values())
    });
    let named: Vec<Named> = named.collect();
    if named.iter().any(|(_, numbers)| !numbers.iter().all(|number| number.is_finite())) {
        return Err(ImportError::new(file, 1, "a number is not finite: the run has blown up"));
    }
    let driven_walls = driven_walls(bytes).map_err(|problem| ImportError::new(file, 1, problem))?;
    Ok(vec![FrameTable { time: outline.time, driven_walls, ..join(file, 1, count, named) }])
}

/// Poses of driven walls that a frame of a run states; none where it has none.
fn driven_walls(bytes: &[u8]) -> Result<Vec<DrivenWall>, String> {
    let arrays = vtk_field_arrays(bytes, &DRIVEN_WALLS)?;
    let values = |name: &str| arrays.iter().find(|array| array.name == name).map(Array::values);
    let [Some(walls), Some(displacements), Some(rates)] = DRIVEN_WALLS.map(values) else { return Ok(Vec::new()) };
    let all = walls.iter().chain(&displacements).chain(&rates);
    if [displacements.len(), rates.len()] != [walls.len(); 2] || !all.into_iter().all(|number| number.is_finite()) {
        return Err(format!("{} are not as many finite numbers each", DRIVEN_WALLS.join(", ")));
    }
    let poses = walls.iter().zip(displacements.iter().zip(&rates));
    Ok(poses.map(|(&wall, (&displacement, &rate))| DrivenWall { wall: wall as u32, displacement, rate }).collect())
}

/// The frames in a VTKHDF file of polygonal data or of an unstructured grid: one a step, or a single one without a time.
///
/// # Errors
/// [`ImportError`].
pub(super) fn hdf(file: &Path, bytes: Vec<u8>) -> Result<Vec<FrameTable>, ImportError> {
    let length = bytes.len() as u64;
    let fault = |problem: String| ImportError::new(file, 1, problem);
    let opened =
        File::from_bytes(bytes).map_err(|error| fault(format!("it is no HDF5 file, or not all of one ({error})")))?;
    Reader { file: opened, length }.frames(file).map_err(fault)
}

struct Reader {
    file: File,
    /// Bytes of the file.
    length: u64,
}

/// Where the numbers of one frame stand in arrays over all of them.
#[derive(Clone, Copy)]
struct Span {
    time: Option<f64>,
    first: usize,
    count: usize,
}

impl Reader {
    fn frames(&self, path: &Path) -> Result<Vec<FrameTable>, String> {
        let root = self.file.group("VTKHDF").map_err(|_| "it has no group VTKHDF".to_string())?;
        let kind = root.attrs().ok().and_then(|attributes| match attributes.get("Type") {
            Some(AttrValue::AsciiString(text) | AttrValue::String(text)) => Some(text.clone()),
            _ => None,
        });
        if !matches!(kind.as_deref(), Some("PolyData" | "UnstructuredGrid")) {
            return Err(format!(
                "it holds {}, not PolyData or UnstructuredGrid",
                kind.as_deref().unwrap_or("no known type")
            ));
        }
        let lines =
            self.numbers("VTKHDF/Lines/NumberOfCells").is_ok_and(|(_, counts)| counts.iter().any(|&count| count > 0.0));
        let (section, counts) = match lines {
            true => ("CellData", "VTKHDF/Lines/NumberOfCells"),
            false => ("PointData", "VTKHDF/NumberOfPoints"),
        };
        let spans = self.spans(&self.numbers(counts)?.1, lines)?;
        let mut arrays: Vec<(String, usize, Vec<f64>)> = Vec::new();
        if !lines {
            let (columns, points) = self.numbers("VTKHDF/Points")?;
            arrays.push(("points".into(), columns, points));
        }
        let group = self.file.group(&format!("VTKHDF/{section}"));
        for name in group.and_then(|group| group.datasets()).unwrap_or_default() {
            let (columns, numbers) = self.numbers(&format!("VTKHDF/{section}/{name}"))?;
            arrays.push((name, columns, numbers));
        }
        let frame = |span: &Span| {
            let named: Result<Vec<Named>, String> = arrays.iter().map(|array| part(array, span)).collect();
            Ok(FrameTable { time: span.time, ..join(path, 1, span.count, named?) })
        };
        spans.iter().map(frame).collect()
    }

    /// Columns and numbers of a dataset.
    fn numbers(&self, path: &str) -> Result<(usize, Vec<f64>), String> {
        let wrong = |problem: String| format!("{path}: {problem}");
        let dataset = self.file.dataset(path).map_err(|error| wrong(error.to_string()))?;
        let shape = dataset.shape().map_err(|error| wrong(error.to_string()))?;
        let count = shape.iter().try_fold(1_u64, |product, &size| product.checked_mul(size));
        if count.is_none_or(|count| count > self.length.saturating_mul(MOST_NUMBERS_PER_BYTE)) {
            return Err(wrong(format!("a shape of {shape:?} is more than the file can hold")));
        }
        let numbers = dataset.read_f64().map_err(|error| wrong(error.to_string()))?;
        match numbers.iter().all(|number| number.is_finite()) {
            true => Ok((shape.get(1).map_or(1, |&columns| columns as usize).max(1), numbers)),
            false => Err(wrong("a number is not finite: the run has blown up".into())),
        }
    }

    /// Where frames begin and end; `counts` are those of each part.
    fn spans(&self, counts: &[f64], lines: bool) -> Result<Vec<Span>, String> {
        let whole =
            |number: f64| (0.0..1e15).contains(&number).then_some(number as usize).ok_or("a count is none".to_string());
        let Ok((_, times)) = self.numbers("VTKHDF/Steps/Values") else {
            let count = counts.iter().map(|&count| whole(count)).sum::<Result<usize, _>>()?;
            return Ok(vec![Span { time: None, first: 0, count }]);
        };
        let each = |path: &str, otherwise: f64| {
            self.numbers(path).map_or_else(|_| vec![otherwise; times.len()], |(_, numbers)| numbers)
        };
        let (parts, first_parts) = (each("VTKHDF/Steps/NumberOfParts", 1.0), each("VTKHDF/Steps/PartOffsets", 0.0));
        let firsts: Vec<f64> = match lines {
            false => self.numbers("VTKHDF/Steps/PointOffsets")?.1,
            true => {
                let (columns, offsets) = self.numbers("VTKHDF/Steps/CellOffsets")?;
                // Vertices, lines, polygons, strips.
                offsets.chunks(columns).map(|row| row.get(1).or(row.first()).copied().unwrap_or(0.0)).collect()
            }
        };
        if [parts.len(), first_parts.len(), firsts.len()].iter().any(|&length| length < times.len()) {
            return Err("Steps has fewer entries than times".into());
        }
        let span = |step: usize| {
            let (first, parts) = (whole(first_parts[step])?, whole(parts[step])?);
            let own = first
                .checked_add(parts)
                .and_then(|end| counts.get(first..end))
                .ok_or("Steps names parts that are not there")?;
            let count = own.iter().map(|&count| whole(count)).sum::<Result<usize, _>>()?;
            Ok(Span { time: Some(times[step]), first: whole(firsts[step])?, count })
        };
        (0..times.len()).map(span).collect()
    }
}

/// A frame's part of an array.
fn part((name, columns, numbers): &(String, usize, Vec<f64>), span: &Span) -> Result<Named, String> {
    let start = span.first.checked_mul(*columns);
    let end = span.first.checked_add(span.count).and_then(|end| end.checked_mul(*columns));
    let own = start.zip(end).and_then(|(start, end)| numbers.get(start..end));
    let own = own.ok_or_else(|| format!("{name} ends before the frame at {:?} s", span.time.unwrap_or(0.0)))?;
    Ok((component_names(name, *columns), own.to_vec()))
}
