//! Legacy VTK files, in ASCII or binary, of polygonal data or an unstructured grid, as YADE's `VTKExporter`, LIGGGHTS's `dump custom/vtk`
//! and ParaView write them: points and arrays over them, or lines and arrays over them.

use super::columns::{StatedColumns, number};
use super::table::{FrameTable, ImportError, Named, is_wanted, table_of};
use crate::run_frames::columns::Number;
use std::path::Path;

/// Cells of polygonal data, in the order of the format, and those of an unstructured grid.
const CELLS: [&str; 5] = ["VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS", "CELLS"];

/// Kind of the numbers of an array; none for bits.
type Type = Option<Number>;

fn type_of(name: &str) -> Option<Type> {
    Some(Some(match name.to_ascii_lowercase().as_str() {
        "bit" => return Some(None),
        "char" | "signed_char" => Number::Int8,
        "unsigned_char" => Number::UInt8,
        "short" => Number::Int16,
        "unsigned_short" => Number::UInt16,
        // VTK writes its own integers as int.
        "int" | "vtkidtype" => Number::Int32,
        "unsigned_int" => Number::UInt32,
        "long" | "vtktypeint64" => Number::Int64,
        "unsigned_long" | "vtktypeuint64" => Number::UInt64,
        "float" => Number::Float32,
        "double" => Number::Float64,
        _ => return None,
    }))
}

/// Position in a file.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    is_binary: bool,
}

/// Line and problem.
type Fault = (usize, String);

impl<'a> Reader<'a> {
    fn fault<T>(&self, problem: impl Into<String>) -> Result<T, Fault> {
        Err((self.line, problem.into()))
    }

    /// The rest of a line, without its end.
    fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|byte| *byte == b'\n');
        self.at += end.map_or(rest.len(), |end| end + 1);
        self.line += usize::from(end.is_some());
        &rest[..end.unwrap_or(rest.len())]
    }

    /// The next word; none at the end of the file.
    fn word(&mut self) -> Option<&'a [u8]> {
        while let Some(byte) = self.bytes.get(self.at).filter(|byte| byte.is_ascii_whitespace()) {
            self.line += usize::from(*byte == b'\n');
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += length;
        (length > 0).then_some(&rest[..length])
    }

    fn text(&mut self, what: &str) -> Result<&'a str, Fault> {
        match self.word().map(std::str::from_utf8) {
            Some(Ok(word)) => Ok(word),
            Some(Err(_)) => self.fault(format!("{what} belongs here, and there is no text")),
            None => self.fault(format!("the file ends where {what} belongs")),
        }
    }

    fn count(&mut self, what: &str) -> Result<usize, Fault> {
        let word = self.text(what)?;
        let count = word.parse::<usize>().ok().filter(|count| *count <= i32::MAX as usize);
        count.map_or_else(|| self.fault(format!("'{word}' is no {what}")), Ok)
    }

    fn number_type(&mut self) -> Result<Type, Fault> {
        let word = self.text("a type of numbers")?;
        type_of(word).map_or_else(|| self.fault(format!("'{word}' is no type of numbers")), Ok)
    }

    /// Passes over the description of an array, which ends with an empty line.
    fn pass_metadata(&mut self) {
        self.rest_of_line();
        while self.at < self.bytes.len() && !self.rest_of_line().trim_ascii().is_empty() {}
    }

    /// The numbers of an array; none where they are not wanted.
    fn numbers(&mut self, name: &str, kind: Type, count: usize, wanted: bool) -> Result<Option<Vec<f64>>, Fault> {
        if self.is_binary {
            self.rest_of_line();
            let size = kind.map_or(count.div_ceil(8), |number| count.saturating_mul(number.size()));
            let Some(own) = self.bytes.get(self.at..self.at.saturating_add(size)) else {
                return self.fault(format!("{name} ends before its last number"));
            };
            self.at += size;
            let bits = || (0..count).map(|bit| f64::from(own[bit / 8] >> (7 - bit % 8) & 1)).collect();
            return Ok(wanted.then(|| kind.map_or_else(bits, |number| number.decode(own.to_vec(), true))));
        }
        if count > self.bytes.len() - self.at {
            return self.fault(format!("{name} has more numbers than the file can hold"));
        }
        let mut numbers = Vec::with_capacity(if wanted { count } else { 0 });
        for _ in 0..count {
            let Some(word) = self.word() else {
                return self.fault(format!("{name} ends before its last number"));
            };
            match number(&String::from_utf8_lossy(word)) {
                Ok(number) if wanted => numbers.push(number),
                Err(problem) if wanted => return self.fault(format!("{name}: {problem}")),
                _ => {}
            }
        }
        Ok(wanted.then_some(numbers))
    }

    /// Passes over texts.
    fn pass_texts(&mut self, name: &str, count: usize) -> Result<(), Fault> {
        if !self.is_binary {
            return (0..count).try_for_each(|_| self.text(name).map(|_| ()));
        }
        self.rest_of_line();
        for _ in 0..count {
            // The first two bits state how many bytes the length has.
            let size = self.bytes.get(self.at).map_or(1, |first| 8 >> (first >> 6));
            let own = self.bytes.get(self.at..self.at + size).unwrap_or_default();
            let length = own.iter().fold(0_usize, |sum, byte| sum << 8 | usize::from(*byte)) & !(3 << (8 * size - 2));
            self.at = self.at.saturating_add(size).saturating_add(length);
            if self.at > self.bytes.len() {
                return self.fault(format!("{name} ends too early"));
            }
        }
        Ok(())
    }
}

/// Arrays over points or over lines, as far as they are read.
#[derive(Default)]
struct Found {
    points: usize,
    lines: usize,
    coordinates: Option<Vec<f64>>,
    of_points: Vec<Named>,
    of_cells: Vec<Named>,
}

/// Data that arrays belong to.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    Whole,
    Points,
    Cells,
}

/// Reads a file.
///
/// # Errors
/// [`ImportError`] with the line.
pub(super) fn legacy_vtk(file: &Path, bytes: &[u8], stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let found = read(bytes, stated).map_err(|(line, problem)| ImportError::new(file, line, problem))?;
    let Some(points) = found.coordinates else { return Err(ImportError::new(file, 1, "it holds no points")) };
    if found.lines > 0 {
        return Ok(vec![table_of(file, found.lines, &found.of_cells, stated)?]);
    }
    let mut arrays = vec![Named::new("points", 3, Some(points))];
    arrays.extend(found.of_points);
    Ok(vec![table_of(file, found.points, &arrays, stated)?])
}

fn read(bytes: &[u8], stated: &StatedColumns) -> Result<Found, Fault> {
    let mut reader = Reader { bytes, at: 0, line: 1, is_binary: false };
    // Before the third line there are a version, and words of the writer.
    reader.rest_of_line();
    reader.rest_of_line();
    match reader.text("ASCII or BINARY")? {
        "ASCII" => {}
        "BINARY" => reader.is_binary = true,
        other => return reader.fault(format!("'{other}' is neither ASCII nor BINARY")),
    }
    let mut found = Found::default();
    let (mut of, mut tuples) = (Of::Whole, 0);
    while let Some(word) = reader.word() {
        let word = String::from_utf8_lossy(word).into_owned();
        match &*word {
            "DATASET" => {
                let kind = reader.text("a kind of data")?;
                if !["POLYDATA", "UNSTRUCTURED_GRID"].contains(&kind) {
                    return reader.fault(format!("it holds {kind}, not POLYDATA or UNSTRUCTURED_GRID"));
                }
            }
            "POINTS" => {
                found.points = reader.count("number of points")?;
                let kind = reader.number_type()?;
                found.coordinates = reader.numbers("POINTS", kind, 3 * found.points, true)?;
            }
            "METADATA" => reader.pass_metadata(),
            "CELL_TYPES" => {
                let count = reader.count("number of cells")?;
                reader.numbers(&word, Some(Number::Int32), count, false)?;
            }
            cells if CELLS.contains(&cells) => pass_cells(&mut reader, cells, &mut found)?,
            "POINT_DATA" | "CELL_DATA" => {
                of = if word == "POINT_DATA" { Of::Points } else { Of::Cells };
                tuples = reader.count("number of tuples")?;
                if of == Of::Points && tuples != found.points {
                    return reader.fault(format!("data of {tuples} points, and there are {}", found.points));
                }
                if of == Of::Cells && found.lines > 0 && tuples != found.lines {
                    return reader.fault(format!("data of {tuples} cells, and there are {} lines", found.lines));
                }
            }
            "FIELD" => {
                reader.text("a name")?;
                for _ in 0..reader.count("number of arrays")? {
                    field_array(&mut reader, of, tuples, &mut found, stated)?;
                }
            }
            "LOOKUP_TABLE" | "COLOR_SCALARS" | "TEXTURE_COORDINATES" => {
                reader.text("a name")?;
                let size = reader.count("number of components")?;
                let (kind, count) = match &*word {
                    "LOOKUP_TABLE" => (Some(Number::UInt8), 4 * size),
                    "COLOR_SCALARS" => (Some(Number::UInt8), size.saturating_mul(tuples)),
                    _ => (reader.number_type()?, size.saturating_mul(tuples)),
                };
                reader.numbers(&word, kind, count, false)?;
            }
            attribute => {
                let components = match attribute {
                    "VECTORS" | "NORMALS" => 3,
                    "TENSORS" => 9,
                    "TENSORS6" => 6,
                    "SCALARS" | "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => 1,
                    _ => return reader.fault(format!("'{attribute}' is no word of the format")),
                };
                let name = reader.text("a name")?.to_string();
                let kind = reader.number_type()?;
                let components = if attribute == "SCALARS" { scalars(&mut reader)? } else { components };
                let is_wanted = of != Of::Whole && is_wanted(&name, components, stated);
                let numbers = reader.numbers(&name, kind, components.saturating_mul(tuples), is_wanted)?;
                keep(&mut found, of, Named::new(name, components, numbers));
            }
        }
    }
    Ok(found)
}

/// Components behind `SCALARS name type`, and the line of the table of colours.
fn scalars(reader: &mut Reader<'_>) -> Result<usize, Fault> {
    let mut word = reader.text("LOOKUP_TABLE")?;
    let mut components = 1;
    if word != "LOOKUP_TABLE" {
        match word.parse() {
            Ok(count) if (1..=9).contains(&count) => components = count,
            _ => return reader.fault(format!("'{word}' is no number of components")),
        }
        word = reader.text("LOOKUP_TABLE")?;
    }
    if word != "LOOKUP_TABLE" {
        return reader.fault("LOOKUP_TABLE belongs behind SCALARS");
    }
    reader.text("name of a table of colours")?;
    Ok(components)
}

/// Passes over the points of cells, in either of the two ways in which versions write them.
fn pass_cells(reader: &mut Reader<'_>, cells: &str, found: &mut Found) -> Result<(), Fault> {
    let [first, second] = [reader.count("number of cells")?, reader.count("number of numbers")?];
    let (at, line) = (reader.at, reader.line);
    // Since version 5 there are offsets, one more than cells, and points.
    let has_offsets = matches!(reader.word(), Some(b"OFFSETS"));
    let count = if has_offsets {
        let kind = reader.number_type()?;
        reader.numbers(cells, kind, first, false)?;
        if reader.text("CONNECTIVITY")? != "CONNECTIVITY" {
            return reader.fault("CONNECTIVITY belongs behind OFFSETS");
        }
        let kind = reader.number_type()?;
        reader.numbers(cells, kind, second, false)?;
        first.saturating_sub(1)
    } else {
        (reader.at, reader.line) = (at, line);
        reader.numbers(cells, Some(Number::Int32), second, false)?;
        first
    };
    if cells == "LINES" {
        found.lines = count;
    }
    Ok(())
}

fn field_array(
    reader: &mut Reader<'_>,
    of: Of,
    tuples: usize,
    found: &mut Found,
    stated: &StatedColumns,
) -> Result<(), Fault> {
    let mut name = reader.text("a name")?.to_string();
    // A description of the array before stands between.
    if name == "METADATA" {
        reader.pass_metadata();
        name = reader.text("a name")?.to_string();
    }
    let (components, rows) = (reader.count("number of components")?, reader.count("number of rows")?);
    let kind = reader.text("a type of numbers")?.to_string();
    let is_wanted = of != Of::Whole && is_wanted(&name, components, stated);
    if is_wanted && (kind == "string" || rows != tuples || components == 0) {
        let what = if of == Of::Points { "points" } else { "cells" };
        let problem =
            format!("{name} has {rows} rows of {kind}, and there are {tuples} {what}; leave numbers, one row for each");
        return reader.fault(problem);
    }
    let count = components.saturating_mul(rows);
    if kind == "string" {
        reader.pass_texts(&name, count)?;
        return Ok(());
    }
    let Some(of_numbers) = type_of(&kind) else { return reader.fault(format!("'{kind}' is no type of numbers")) };
    let numbers = reader.numbers(&name, of_numbers, count, is_wanted)?;
    keep(found, of, Named::new(name, components, numbers));
    Ok(())
}

fn keep(found: &mut Found, of: Of, array: Named) {
    match of {
        Of::Whole => {}
        Of::Points => found.of_points.push(array),
        Of::Cells => found.of_cells.push(array),
    }
}

/// Reports whether a file says that its arrays are binary.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    bytes.splitn(4, |byte| *byte == b'\n').nth(2).is_some_and(|line| line.trim_ascii() == b"BINARY")
}
