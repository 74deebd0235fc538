//! Legacy VTK files, in ASCII or binary, of polygonal data or an unstructured grid, as YADE's `VTKExporter`, LIGGGHTS's `dump custom/vtk`
//! and ParaView write them: points and arrays over them, or lines and arrays over them.

use super::columns::{StatedColumns, number};
use super::table::{FrameTable, ImportError, Named, is_wanted, table_of};
use crate::run_frames::columns::Number;
use std::path::Path;

/// Cell groups of polygonal data, in the order of the format, and the cells of an unstructured grid.
const CELLS: [&str; 5] = ["VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS", "CELLS"];

/// Number type of an array; `None` for bits.
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

/// Reader position, and the data read so far.
struct Reader<'a> {
    stated: &'a StatedColumns,
    bytes: &'a [u8],
    at: usize,
    line: usize,
    is_binary: bool,
    coordinates: Option<Vec<f64>>,
    points: usize,
    lines: usize,
    /// Arrays over points, and over cells.
    arrays: [Vec<Named>; 2],
    /// Section of the following arrays; absent for arrays of the whole file.
    section: Option<usize>,
    /// Tuples of each array of the section.
    tuples: usize,
}

/// Line and message.
type Fault = (usize, String);

impl<'a> Reader<'a> {
    fn fault<T>(&self, problem: impl Into<String>) -> Result<T, Fault> {
        Err((self.line, problem.into()))
    }

    /// Returns the rest of a line, without the line end.
    fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|byte| *byte == b'\n');
        self.at += end.map_or(rest.len(), |end| end + 1);
        self.line += usize::from(end.is_some());
        &rest[..end.unwrap_or(rest.len())]
    }

    /// Returns the next word; `None` at the end of the file.
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

    /// Skips the description of an array, which ends with an empty line.
    fn pass_metadata(&mut self) {
        self.rest_of_line();
        while self.at < self.bytes.len() && !self.rest_of_line().trim_ascii().is_empty() {}
    }

    /// Reads the numbers of an array; `None` if not wanted.
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

    /// Skips texts.
    fn pass_texts(&mut self, name: &str, count: usize) -> Result<(), Fault> {
        if !self.is_binary {
            return (0..count).try_for_each(|_| self.text(name).map(|_| ()));
        }
        self.rest_of_line();
        for _ in 0..count {
            // The first two bits give the number of bytes of the length.
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

/// Reads a file.
pub(super) fn legacy_vtk(file: &Path, bytes: &[u8], stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let mut reader = Reader {
        stated,
        bytes,
        at: 0,
        line: 1,
        is_binary: is_binary(bytes),
        coordinates: None,
        points: 0,
        lines: 0,
        arrays: [Vec::new(), Vec::new()],
        section: None,
        tuples: 0,
    };
    reader.read().map_err(|(line, problem)| ImportError::new(file, line, problem))?;
    let Reader { points, lines, coordinates, arrays: [of_points, of_cells], .. } = reader;
    let Some(coordinates) = coordinates else { return Err(ImportError::new(file, 1, "it holds no points")) };
    if lines > 0 {
        return Ok(vec![table_of(file, lines, &of_cells, stated)?]);
    }
    let arrays: Vec<Named> = [Named::new("points", 3, Some(coordinates))].into_iter().chain(of_points).collect();
    Ok(vec![table_of(file, points, &arrays, stated)?])
}

impl Reader<'_> {
    fn read(&mut self) -> Result<(), Fault> {
        // The first two lines hold a version and a title.
        self.rest_of_line();
        self.rest_of_line();
        let encoding = self.text("ASCII or BINARY")?;
        if !["ASCII", "BINARY"].contains(&encoding) {
            return self.fault(format!("'{encoding}' is neither ASCII nor BINARY"));
        }
        while let Some(word) = self.word() {
            let word = String::from_utf8_lossy(word).into_owned();
            match &*word {
                "DATASET" => {
                    let kind = self.text("a kind of data")?;
                    if !["POLYDATA", "UNSTRUCTURED_GRID"].contains(&kind) {
                        return self.fault(format!("it holds {kind}, not POLYDATA or UNSTRUCTURED_GRID"));
                    }
                }
                "POINTS" => {
                    self.points = self.count("number of points")?;
                    let kind = self.number_type()?;
                    self.coordinates = self.numbers("POINTS", kind, 3 * self.points, true)?;
                }
                "METADATA" => self.pass_metadata(),
                "CELL_TYPES" => {
                    let count = self.count("number of cells")?;
                    self.numbers(&word, Some(Number::Int32), count, false)?;
                }
                cells if CELLS.contains(&cells) => self.pass_cells(cells)?,
                "POINT_DATA" | "CELL_DATA" => {
                    let tuples = self.count("number of tuples")?;
                    (self.section, self.tuples) = (Some(usize::from(word == "CELL_DATA")), tuples);
                    if word == "POINT_DATA" && tuples != self.points {
                        return self.fault(format!("data of {tuples} points, and there are {}", self.points));
                    }
                    if word == "CELL_DATA" && self.lines > 0 && tuples != self.lines {
                        return self.fault(format!("data of {tuples} cells, and there are {} lines", self.lines));
                    }
                }
                "FIELD" => {
                    self.text("a name")?;
                    for _ in 0..self.count("number of arrays")? {
                        self.field_array()?;
                    }
                }
                "LOOKUP_TABLE" | "COLOR_SCALARS" | "TEXTURE_COORDINATES" => {
                    self.text("a name")?;
                    let size = self.count("number of components")?;
                    let (kind, count) = match &*word {
                        "LOOKUP_TABLE" => (Some(Number::UInt8), 4 * size),
                        "COLOR_SCALARS" => (Some(Number::UInt8), size.saturating_mul(self.tuples)),
                        _ => (self.number_type()?, size.saturating_mul(self.tuples)),
                    };
                    self.numbers(&word, kind, count, false)?;
                }
                attribute => {
                    let components = match attribute {
                        "VECTORS" | "NORMALS" => 3,
                        "TENSORS" => 9,
                        "TENSORS6" => 6,
                        "SCALARS" | "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => 1,
                        _ => return self.fault(format!("'{attribute}' is no word of the format")),
                    };
                    let name = self.text("a name")?.to_string();
                    let kind = self.number_type()?;
                    let components = if attribute == "SCALARS" { self.scalars()? } else { components };
                    self.array(&name, components, kind, self.tuples)?;
                }
            }
        }
        Ok(())
    }

    /// Reads the number of components after `SCALARS name type`, and the line of the table of colours.
    fn scalars(&mut self) -> Result<usize, Fault> {
        let mut word = self.text("LOOKUP_TABLE")?;
        let mut components = 1;
        if word != "LOOKUP_TABLE" {
            match word.parse() {
                Ok(count) if (1..=9).contains(&count) => components = count,
                _ => return self.fault(format!("'{word}' is no number of components")),
            }
            word = self.text("LOOKUP_TABLE")?;
        }
        if word != "LOOKUP_TABLE" {
            return self.fault("LOOKUP_TABLE belongs behind SCALARS");
        }
        self.text("name of a table of colours")?;
        Ok(components)
    }

    /// Skips the points of cells, in either layout of the format versions.
    fn pass_cells(&mut self, cells: &str) -> Result<(), Fault> {
        let [first, second] = [self.count("number of cells")?, self.count("number of numbers")?];
        let (at, line) = (self.at, self.line);
        // From version 5: offsets, one more than cells, and points.
        let has_offsets = matches!(self.word(), Some(b"OFFSETS"));
        if has_offsets {
            let kind = self.number_type()?;
            self.numbers(cells, kind, first, false)?;
            if self.text("CONNECTIVITY")? != "CONNECTIVITY" {
                return self.fault("CONNECTIVITY belongs behind OFFSETS");
            }
        } else {
            (self.at, self.line) = (at, line);
        }
        let kind = if has_offsets { self.number_type()? } else { Some(Number::Int32) };
        self.numbers(cells, kind, second, false)?;
        if cells == "LINES" {
            self.lines = if has_offsets { first.saturating_sub(1) } else { first };
        }
        Ok(())
    }

    fn field_array(&mut self) -> Result<(), Fault> {
        let mut name = self.text("a name")?.to_string();
        // The description of the previous array precedes the next array.
        if name == "METADATA" {
            self.pass_metadata();
            name = self.text("a name")?.to_string();
        }
        let (components, rows) = (self.count("number of components")?, self.count("number of rows")?);
        let kind = self.text("a type of numbers")?;
        if self.is_wanted(&name, components) && (kind == "string" || rows != self.tuples || components == 0) {
            let (tuples, what) = (self.tuples, ["points", "cells"][self.section.unwrap_or_default()]);
            return self.fault(format!(
                "{name} has {rows} rows of {kind}, and there are {tuples} {what}; leave numbers, one row for each"
            ));
        }
        match (kind, type_of(kind)) {
            ("string", _) => self.pass_texts(&name, components.saturating_mul(rows)),
            (_, Some(of_numbers)) => self.array(&name, components, of_numbers, rows),
            (kind, None) => self.fault(format!("'{kind}' is no type of numbers")),
        }
    }

    fn is_wanted(&self, name: &str, components: usize) -> bool {
        self.section.is_some() && is_wanted(name, components, self.stated)
    }

    /// Reads an array, or skips it.
    fn array(&mut self, name: &str, components: usize, kind: Type, rows: usize) -> Result<(), Fault> {
        let numbers = self.numbers(name, kind, components.saturating_mul(rows), self.is_wanted(name, components))?;
        if let Some(section) = self.section {
            self.arrays[section].push(Named::new(name, components, numbers));
        }
        Ok(())
    }
}

/// Returns true if a file declares its arrays as binary.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    bytes.splitn(4, |byte| *byte == b'\n').nth(2).is_some_and(|line| line.trim_ascii() == b"BINARY")
}
