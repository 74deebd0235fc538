//! VTP files for ParaView: one file per frame of grains, contacts and walls, and a collection over time of each.
//!
//! A file is an XML document followed by arrays (`appended`, `raw`) in zlib-compressed blocks. The header of an array consists of
//! 64-bit integers: the number of blocks, the size of a whole block, the size of an incomplete last block
//! (otherwise zero), and the compressed size of each: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use super::{ExportError, Written, for_each};
use crate::output::{WriteError, create_folder, write_whole};
use crate::run_frames::columns::{Column, DOUBLE, Part, WHOLE};
use crate::run_frames::{Kind, RunFrames};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Folder of the files inside the output folder.
const FOLDER: &str = "frames";

/// Script that opens the collections in ParaView.
const SCRIPT: &str = include_str!("open-in-paraview.py");

/// Bytes of a whole block before compression.
const BLOCK: usize = 1 << 16;

/// Groups of cells, by the number of points of a cell.
const CELLS: [&str; 3] = ["Verts", "Lines", "Polys"];

/// Writes `frames/KIND-NUMBER.vtp`, `KIND.pvd` and `open-in-paraview.py` into a folder. Walls at rest are in the first frame alone.
pub(super) fn write(run: &RunFrames, folder: &Path, progress: &dyn Fn(f64)) -> Result<Vec<Written>, ExportError> {
    create_folder(&folder.join(FOLDER))?;
    remove_earlier(&folder.join(FOLDER))?;
    let mut written = Vec::new();
    for (part, kind) in Kind::ALL.into_iter().enumerate() {
        let name = kind.name();
        let mut list = Vec::new();
        let of_all = |fraction| progress((part as f64 + fraction) / Kind::ALL.len() as f64);
        for_each(run.numbers(kind), &of_all, |number| {
            let file = format!("{FOLDER}/{name}-{number:05}.vtp");
            write_whole(&folder.join(&file), &encode(&run.part(number, kind)?))?;
            list.push((run.time(number), file));
            Ok(())
        })?;
        if !run.numbers(kind).is_empty() {
            written.push(write_collection(folder.join(format!("{name}.pvd")), &list)?);
        }
    }
    let script = folder.join("open-in-paraview.py");
    std::fs::write(&script, SCRIPT).map_err(|error| WriteError::new(&script, error))?;
    Ok(written)
}

/// Writes the list of the files of a series, each with its time (s).
pub(super) fn write_collection(path: PathBuf, files: &[(f64, String)]) -> Result<Written, ExportError> {
    let mut list = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (time, file) in files {
        list += &format!("<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>\n");
    }
    write_whole(&path, (list + "</Collection>\n</VTKFile>\n").as_bytes())?;
    Ok(Written { path, frames: files.len() })
}

/// Removes the frames of an earlier export, possibly more numerous.
fn remove_earlier(folder: &Path) -> Result<(), ExportError> {
    let refused = |error| ExportError::Write(WriteError::new(folder, error));
    for entry in std::fs::read_dir(folder).map_err(refused)? {
        let path = entry.map_err(refused)?.path();
        let name = path.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_suffix(".vtp"));
        let number =
            name.and_then(|name| Kind::ALL.iter().find_map(|kind| name.strip_prefix(kind.name())?.strip_prefix('-')));
        if number.is_some_and(|number| number.len() >= 5 && number.bytes().all(|byte| byte.is_ascii_digit())) {
            std::fs::remove_file(&path).map_err(|error| WriteError::new(&path, error))?;
        }
    }
    Ok(())
}

/// Returns the bytes of a file.
pub(crate) fn encode(part: &Part) -> Vec<u8> {
    let mut file = File { text: String::new(), appended: Vec::new() };
    let (points, cells) = (part.points.tuples(), part.cells());
    file.text += "<?xml version=\"1.0\"?>\n\
        <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
        compressor=\"vtkZLibDataCompressor\">\n<PolyData>\n<FieldData>\n";
    file.column(&Column::new("TimeValue", DOUBLE, [part.time]), true);
    part.whole.iter().for_each(|column| file.column(column, true));
    part.texts.iter().for_each(|(name, texts)| file.texts(name, texts));
    let own = CELLS[part.corners_per_cell - 1];
    let [vertices, lines, polygons] = CELLS.map(|name| if name == own { cells } else { 0 });
    let _ = writeln!(
        file.text,
        "</FieldData>\n<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" NumberOfLines=\"{lines}\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"{polygons}\">"
    );
    let connectivity = Column::new("connectivity", WHOLE, part.corners().into_iter().map(f64::from));
    let offsets = Column::new("offsets", WHOLE, (1..=cells).map(|cell| (cell * part.corners_per_cell) as f64));
    let sections: [(&str, &[Column]); 4] = [
        ("PointData", &part.of_points),
        ("CellData", &part.of_cells),
        ("Points", std::slice::from_ref(&part.points)),
        (own, &[connectivity, offsets]),
    ];
    for (name, columns) in sections {
        let _ = writeln!(file.text, "<{name}>");
        columns.iter().for_each(|column| file.column(column, false));
        let _ = writeln!(file.text, "</{name}>");
    }
    file.text += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    [file.text.as_bytes(), &file.appended, b"\n</AppendedData>\n</VTKFile>\n"].concat()
}

/// Columns over the nodes of a regular grid.
pub(super) struct ImageData<'a> {
    /// Simulated time, s.
    pub time: f64,
    /// First node, m.
    pub origin: [f64; 3],
    /// Distances of the nodes along the axes, m.
    pub spacing: [f64; 3],
    /// Numbers of nodes along the axes.
    pub counts: [usize; 3],
    /// Columns, the first axis fastest.
    pub columns: &'a [Column],
}

impl ImageData<'_> {
    /// Returns the bytes of a VTI file.
    pub fn encode(&self) -> Vec<u8> {
        let mut file = File { text: String::new(), appended: Vec::new() };
        let list = |numbers: [f64; 3]| numbers.map(|number| number.to_string()).join(" ");
        let [x, y, z] = self.counts.map(|count| count - 1);
        let extent = format!("0 {x} 0 {y} 0 {z}");
        let _ = writeln!(
            file.text,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
             compressor=\"vtkZLibDataCompressor\">\n<ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">\n<FieldData>",
            list(self.origin),
            list(self.spacing)
        );
        file.column(&Column::new("TimeValue", DOUBLE, [self.time]), true);
        let _ = writeln!(file.text, "</FieldData>\n<Piece Extent=\"{extent}\">\n<PointData>");
        self.columns.iter().for_each(|column| file.column(column, false));
        file.text += "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
        [file.text.as_bytes(), &file.appended, b"\n</AppendedData>\n</VTKFile>\n"].concat()
    }
}

/// XML file during writing.
struct File {
    text: String,
    /// Bytes after the document.
    appended: Vec<u8>,
}

impl File {
    fn column(&mut self, column: &Column, of_file: bool) {
        let Column { name, number, width, values } = column;
        let tuples = if of_file { format!(" NumberOfTuples=\"{}\"", column.tuples()) } else { String::new() };
        let _ = writeln!(
            self.text,
            "<DataArray type=\"{number:?}\" Name=\"{name}\" NumberOfComponents=\"{width}\"{tuples} format=\"appended\" offset=\"{}\"/>",
            self.appended.len()
        );
        self.blocks(&number.encode(values));
    }

    /// Adds texts, as the numbers of their bytes, each followed by a zero.
    fn texts(&mut self, name: &str, texts: &[String]) {
        let count = texts.len();
        let _ =
            write!(self.text, "<Array type=\"String\" Name=\"{name}\" NumberOfTuples=\"{count}\" format=\"ascii\">");
        for byte in texts.iter().flat_map(|text| text.bytes().filter(|byte| *byte != 0).chain([0])) {
            let _ = write!(self.text, "{byte} ");
        }
        self.text += "</Array>\n";
    }

    fn blocks(&mut self, bytes: &[u8]) {
        let packed = bytes.chunks(BLOCK).map(|block| {
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
            encoder.write_all(block).and_then(|()| encoder.finish()).expect("memory takes all bytes")
        });
        let packed: Vec<Vec<u8>> = packed.collect();
        let head = [packed.len(), BLOCK, bytes.len() % BLOCK].into_iter().chain(packed.iter().map(Vec::len));
        self.appended.extend(head.flat_map(|number| (number as u64).to_le_bytes()));
        packed.iter().for_each(|block| self.appended.extend(block));
    }
}
