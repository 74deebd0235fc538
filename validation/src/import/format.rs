//! Format of a file, by its first bytes; formats that are not read are refused by name.

use super::frame_table::ImportError;
use crate::output::HDF5;
use flate2::read::MultiGzDecoder;
use std::io::Read;
use std::path::Path;

/// Formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// Dump of LIGGGHTS or LAMMPS.
    Dump,
    /// VTKHDF.
    Hdf,
    /// VTK's XML.
    Xml,
    /// Legacy VTK.
    LegacyVtk,
    /// Text of YADE.
    Yade,
    /// Table with names in its first row.
    Csv,
}

/// First bytes of files that are not read, what they are, and what to write instead.
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

/// Bytes that gzip makes of one byte at best.
const BEST_COMPRESSION: u64 = 1032;

/// Unpacks what gzip has packed; other bytes stay as they are.
///
/// # Errors
/// [`ImportError`] for a damaged or cut file.
pub(super) fn unpacked(path: &Path, bytes: Vec<u8>) -> Result<Vec<u8>, ImportError> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes);
    }
    let most = BEST_COMPRESSION * bytes.len() as u64;
    let mut unpacked = Vec::new();
    match MultiGzDecoder::new(&bytes[..]).take(most).read_to_end(&mut unpacked) {
        Ok(_) => Ok(unpacked),
        Err(error) => Err(ImportError::new(path, 1, format!("gzip: {error}; the file is damaged, or cut off"))),
    }
}

/// Tells the format of a file by its first bytes.
///
/// # Errors
/// [`ImportError`] that names a format that is not read.
pub(super) fn format_of(path: &Path, bytes: &[u8]) -> Result<Format, ImportError> {
    let refused = |problem: &str| Err(ImportError::new(path, 1, problem));
    let begins = |mark: &str| bytes.starts_with(mark.as_bytes());
    if bytes.is_empty() {
        return refused("the file is empty");
    }
    if begins("ITEM:") {
        return Ok(Format::Dump);
    }
    if bytes.starts_with(&HDF5) {
        return Ok(Format::Hdf);
    }
    if begins("<?xml") || begins("<VTKFile") {
        return Ok(Format::Xml);
    }
    if begins("# vtk DataFile") {
        return Ok(Format::LegacyVtk);
    }
    if begins("#format ") {
        return Ok(Format::Yade);
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
    Ok(Format::Csv)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    #[test]
    fn other_formats_are_refused_by_name() {
        let refused = |bytes: &[u8], words: &str| {
            let error = format_of(Path::new("a"), bytes).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        refused(b"", "empty");
        refused(b"2\nProperties=species:S:1:pos:R:3\nA 0 0 0\nA 0 0 1\n", "XYZ");
        refused(
            b"LAMMPS data file via write_data, version 2 Aug 2023\n\n2 atoms\n1 atom types\n",
            "data file of LAMMPS",
        );
        refused(b"\x28\xb5\x2f\xfd....", "zstd");
        refused(b"{\"frames\": []}", "JSON");
        refused(b"id\0x", "binary");
        assert_eq!(format_of(Path::new("a"), b"id,x,y,z\n").unwrap(), Format::Csv);
    }

    #[test]
    fn gzip_is_unpacked_and_its_damage_refused() {
        let mut packer = GzEncoder::new(Vec::new(), Compression::fast());
        packer.write_all(b"id,x\n1,2\n").unwrap();
        let packed = packer.finish().unwrap();
        assert_eq!(unpacked(Path::new("a"), packed.clone()).unwrap(), b"id,x\n1,2\n");
        let error = unpacked(Path::new("a.gz"), packed[..packed.len() - 6].to_vec()).unwrap_err().to_string();
        assert!(error.contains("a.gz: line 1: gzip: ") && error.contains("cut off"), "{error}");
    }
}
