//! Frames from the bytes of a file: the first bytes determine the format; unsupported formats are refused by name.

use super::columns::StatedColumns;
use super::table::{FrameTable, ImportError};
use super::{dump, legacy_vtk, text, vtkhdf, xml};
use crate::output::HDF5;
use flate2::read::MultiGzDecoder;
use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

/// Reads the frames of a file, with the stated names of its columns, if any.
type Reader = fn(&Path, Vec<u8>, &StatedColumns) -> Result<Vec<FrameTable>, ImportError>;

/// First bytes of supported formats.
const READ: [(&[u8], Reader); 6] = [
    (b"ITEM:", |file, bytes, columns| dump::dump(file, &whole_text(file, &bytes)?, columns)),
    (&HDF5, vtkhdf::hdf),
    (b"<?xml", |file, bytes, columns| xml::xml(file, &bytes, columns)),
    (b"<VTKFile", |file, bytes, columns| xml::xml(file, &bytes, columns)),
    (b"# vtk DataFile", |file, bytes, columns| {
        if !legacy_vtk::is_binary(&bytes) {
            whole_text(file, &bytes)?;
        }
        legacy_vtk::legacy_vtk(file, &bytes, columns)
    }),
    (b"#format ", |file, bytes, columns| text::yade(file, &whole_text(file, &bytes)?, columns)),
];

/// First bytes of unsupported files, their format, and the remedy.
const REFUSED: [(&[u8], &str); 10] = [
    (b"\x28\xb5\x2f\xfd", "it is compressed by zstd; unpack it, or compress it by gzip"),
    (b"BZh", "it is compressed by bzip2; unpack it, or compress it by gzip"),
    (b"\xfd7zXZ", "it is compressed by xz; unpack it, or compress it by gzip"),
    (b"PK\x03\x04", "it is a zip archive; unpack it, and give the files in it"),
    (
        b"\xdf\x65\xdf\x65\xdf\x65\xdf\x65",
        "it is a GSD file, which is written and not read; give the folder of the run, or VTKHDF",
    ),
    (b"\x93NUMPY", "it is an array of NumPy, which has no names of columns; write CSV with a first row of names"),
    (b"CDF\x01", "it is a NetCDF file; write a text dump (dump custom) or VTK"),
    (b"{", "it is JSON; write CSV with a first row of names"),
    (b"---", "it is YAML; write a text dump (dump custom) or CSV"),
    (b"solid ", "it is a mesh in STL; give frames of grains"),
];

/// Largest compression ratio of gzip.
const BEST_COMPRESSION: u64 = 1032;

/// Reads the frames in the bytes of a file; all bytes are either frames or an error. `columns` states the names of the columns, if any.
///
/// # Errors
/// [`ImportError`] with file and line.
pub fn parse(file: &Path, bytes: Vec<u8>, columns: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let bytes = unpacked(file, bytes)?;
    reader_of(file, &bytes)?(file, bytes, columns)
}

/// Refuses rows that may be cut off inside a number. Readers refuse bytes that are not text.
fn whole_text<'b>(file: &Path, bytes: &'b [u8]) -> Result<Cow<'b, str>, ImportError> {
    if bytes.ends_with(b"\n") || bytes.ends_with(b"\r") || bytes.contains(&0) {
        return Ok(String::from_utf8_lossy(bytes));
    }
    let line = bytes.split(|byte| *byte == b'\n').count();
    let problem = "the last row has no line end: the file may be cut off in the middle of a number; write it again, or end it with a \
                   line end";
    Err(ImportError::new(file, line, problem))
}

/// Decompresses gzip; other bytes are unchanged.
///
/// # Errors
/// [`ImportError`] for a damaged or truncated file.
pub(super) fn unpacked(file: &Path, bytes: Vec<u8>) -> Result<Vec<u8>, ImportError> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes);
    }
    let most = BEST_COMPRESSION * bytes.len() as u64;
    let mut unpacked = Vec::new();
    match MultiGzDecoder::new(&bytes[..]).take(most).read_to_end(&mut unpacked) {
        Ok(_) => Ok(unpacked),
        Err(error) => Err(ImportError::new(file, 1, format!("gzip: {error}; the file is damaged, or cut off"))),
    }
}

/// Finds the reader of a file by its first bytes.
///
/// # Errors
/// [`ImportError`] with the name of an unsupported format.
fn reader_of(file: &Path, bytes: &[u8]) -> Result<Reader, ImportError> {
    let refused = |problem: &str| Err(ImportError::new(file, 1, problem));
    if bytes.is_empty() {
        return refused("the file is empty");
    }
    if let Some((_, reader)) = READ.iter().find(|(mark, _)| bytes.starts_with(mark)) {
        return Ok(*reader);
    }
    if let Some((_, problem)) = REFUSED.iter().find(|(mark, _)| bytes.starts_with(mark)) {
        return refused(problem);
    }
    let head = &bytes[..bytes.len().min(4096)];
    if head.contains(&0) {
        return refused("it is binary, and of no format that is read: dumps in text, VTK, VTKHDF, text of YADE, CSV");
    }
    let head = String::from_utf8_lossy(head);
    let mut lines = head.lines().map(str::trim);
    if lines.clone().next().is_some_and(|line| !line.is_empty() && line.bytes().all(|byte| byte.is_ascii_digit())) {
        return refused(
            "it begins with a count, as XYZ files do, whose columns have no names and no units; write a dump of LAMMPS, or CSV with a \
             first row of names",
        );
    }
    let is_count = |line: &str| {
        line.split_once(' ').is_some_and(|(count, what)| count.parse::<u64>().is_ok() && what.trim() == "atoms")
    };
    if lines.any(is_count) {
        return refused(
            "it is a data file of LAMMPS or LIGGGHTS, whose columns depend on the atom style; write a dump (dump custom id type x y z radius \
             vx vy vz omegax omegay omegaz)",
        );
    }
    Ok(|file, bytes, columns| {
        whole_text(file, &bytes)?;
        text::csv(file, &bytes, columns)
    })
}
