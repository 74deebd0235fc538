//! VTK XML files of polygonal data: what ParaView opens without a plug-in.
//!
//! Arrays stand behind the document (`appended`, `raw`) in blocks that zlib has compressed. In front of the blocks of an array stand, as
//! integers of 64 bits, the number of blocks, the size of a whole block, the size of the last one if it is not whole (otherwise zero), and
//! the compressed size of each: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::fmt::Write as _;
use std::io::Write as _;

/// Bytes of a whole block before compression.
const BLOCK: usize = 1 << 16;

/// Defines the kinds of numbers with their Rust types; VTK's names are those of the kinds.
macro_rules! kinds {
    ($($kind:ident $type:ty),*) => {
        /// Kind of the numbers of an array. Runs write `UInt8`, `Int32`, `Float32` and `Float64`; other codes write all.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Kind {
            $(#[doc = stringify!($type)] $kind),*
        }

        impl Kind {
            /// Returns the kind of a name in a file.
            pub fn of(name: &str) -> Option<Kind> {
                match name {
                    $(stringify!($kind) => Some(Kind::$kind),)*
                    _ => None,
                }
            }

            /// Returns the name in a file.
            pub fn name(self) -> &'static str {
                match self {
                    $(Kind::$kind => stringify!($kind)),*
                }
            }

            /// Returns the bytes of a number.
            pub fn size(self) -> usize {
                match self {
                    $(Kind::$kind => size_of::<$type>()),*
                }
            }

            /// Converts a number to bytes.
            pub fn bytes(self, number: f64) -> Vec<u8> {
                match self {
                    $(Kind::$kind => (number as $type).to_le_bytes().to_vec()),*
                }
            }

            /// Converts bytes to numbers.
            fn numbers(self, bytes: &[u8]) -> Vec<f64> {
                match self {
                    $(Kind::$kind => bytes.as_chunks().0.iter().map(|one| <$type>::from_le_bytes(*one) as f64).collect()),*
                }
            }
        }
    };
}

kinds!(UInt8 u8, Int8 i8, Int16 i16, UInt16 u16, Int32 i32, UInt32 u32, Int64 i64, UInt64 u64, Float32 f32, Float64 f64);

/// A named array: tuples of numbers, as bytes in little endian.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Array {
    /// Its name.
    pub name: String,
    /// Numbers of a tuple.
    pub components: usize,
    /// Kind of its numbers.
    pub kind: Kind,
    /// The numbers, tuple after tuple.
    pub bytes: Vec<u8>,
}

impl Array {
    /// Single precision is far finer than a pixel and halves the files.
    pub fn floats(name: &str, components: usize, values: impl Iterator<Item = f64>) -> Array {
        let bytes = bytes_of(values.map(|value| (value as f32).to_le_bytes()));
        Array { name: name.into(), components, kind: Kind::Float32, bytes }
    }

    /// In double precision.
    pub fn doubles(name: &str, components: usize, values: impl Iterator<Item = f64>) -> Array {
        let bytes = bytes_of(values.map(f64::to_le_bytes));
        Array { name: name.into(), components, kind: Kind::Float64, bytes }
    }

    /// Integers, one a tuple.
    pub fn integers(name: &str, values: impl Iterator<Item = i32>) -> Array {
        Array { name: name.into(), components: 1, kind: Kind::Int32, bytes: bytes_of(values.map(i32::to_le_bytes)) }
    }

    /// Coordinates, in single precision as everything else, unless that would shift points by more than a thousandth of what has to be
    /// told apart (m).
    pub fn coordinates(name: &str, values: impl Iterator<Item = f64> + Clone, told_apart: f64) -> Array {
        let farthest = values.clone().fold(0.0, |farthest: f64, coordinate| farthest.max(coordinate.abs()));
        match farthest * f64::from(f32::EPSILON) <= 1e-3 * told_apart {
            true => Array::floats(name, 3, values),
            false => Array::doubles(name, 3, values),
        }
    }

    /// Number of tuples.
    pub fn tuples(&self) -> usize {
        self.bytes.len() / (self.kind.size() * self.components)
    }

    /// The numbers, tuple after tuple.
    pub fn values(&self) -> Vec<f64> {
        self.kind.numbers(&self.bytes)
    }
}

/// The bytes of numbers one after the other, a number at a time.
fn bytes_of<const SIZE: usize>(numbers: impl Iterator<Item = [u8; SIZE]>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(SIZE * numbers.size_hint().0);
    numbers.for_each(|number| bytes.extend_from_slice(&number));
    bytes
}

/// Cells that connect the points of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cells {
    /// One vertex per point.
    Vertices,
    /// One line per pair of points.
    Lines,
    /// Triangles, by the numbers of their points.
    Triangles(Vec<[u32; 3]>),
}

impl Cells {
    /// Returns VTK's name.
    pub fn name(&self) -> &'static str {
        match self {
            Cells::Vertices => "Verts",
            Cells::Lines => "Lines",
            Cells::Triangles(_) => "Polys",
        }
    }

    /// Points of a cell.
    pub fn size(&self) -> usize {
        match self {
            Cells::Vertices => 1,
            Cells::Lines => 2,
            Cells::Triangles(_) => 3,
        }
    }

    /// Number of cells on so many points.
    pub fn count(&self, points: usize) -> usize {
        match self {
            Cells::Vertices => points,
            Cells::Lines => points / 2,
            Cells::Triangles(triangles) => triangles.len(),
        }
    }

    /// Numbers of the points, cell after cell.
    pub fn connectivity(&self, points: usize) -> Vec<i32> {
        match self {
            Cells::Triangles(triangles) => triangles.iter().flatten().map(|&point| point as i32).collect(),
            _ => (0..points as i32).collect(),
        }
    }
}

/// A file of polygonal data.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PolyData {
    /// Simulated time, s.
    pub time: f64,
    /// Three coordinates for each point, m.
    pub points: Array,
    /// Cells on the points.
    pub cells: Cells,
    /// Arrays over points.
    pub point_data: Vec<Array>,
    /// Arrays over cells.
    pub cell_data: Vec<Array>,
    /// Arrays of the whole file.
    pub field_data: Vec<Array>,
    /// Texts of the whole file, such as names.
    pub texts: Vec<(String, Vec<String>)>,
}

impl PolyData {
    /// Number of points.
    pub fn count(&self) -> usize {
        self.points.tuples()
    }

    /// Returns the bytes of the file.
    pub fn encode(&self) -> Vec<u8> {
        let mut file = Encoder { text: String::new(), appended: Vec::new() };
        let (points, cells) = (self.count(), self.cells.count(self.count()));
        file.text += "<?xml version=\"1.0\"?>\n\
            <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
            compressor=\"vtkZLibDataCompressor\">\n<PolyData>\n<FieldData>\n";
        file.array(&Array::doubles("TimeValue", 1, std::iter::once(self.time)), true);
        self.field_data.iter().for_each(|array| file.array(array, true));
        self.texts.iter().for_each(|(name, texts)| file.texts(name, texts));
        let counts = ["Verts", "Lines", "Polys"].map(|name| if name == self.cells.name() { cells } else { 0 });
        let [vertices, lines, polygons] = counts;
        let _ = writeln!(
            file.text,
            "</FieldData>\n<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" NumberOfLines=\"{lines}\" \
             NumberOfStrips=\"0\" NumberOfPolys=\"{polygons}\">"
        );
        let connectivity = Array::integers("connectivity", self.cells.connectivity(points).into_iter());
        let size = self.cells.size() as i32;
        let offsets = Array::integers("offsets", (1..=cells as i32).map(|cell| cell * size));
        let sections: [(&str, &[Array]); 4] = [
            ("PointData", &self.point_data),
            ("CellData", &self.cell_data),
            ("Points", std::slice::from_ref(&self.points)),
            (self.cells.name(), &[connectivity, offsets]),
        ];
        for (name, arrays) in sections {
            let _ = writeln!(file.text, "<{name}>");
            arrays.iter().for_each(|array| file.array(array, false));
            let _ = writeln!(file.text, "</{name}>");
        }
        file.close()
    }
}

/// Encoder of a file.
struct Encoder {
    text: String,
    /// Bytes behind the document.
    appended: Vec<u8>,
}

impl Encoder {
    fn array(&mut self, array: &Array, of_file: bool) {
        let Array { name, components, kind, bytes } = array;
        let tuples = if of_file { format!(" NumberOfTuples=\"{}\"", array.tuples()) } else { String::new() };
        let _ = writeln!(
            self.text,
            "<DataArray type=\"{}\" Name=\"{name}\" NumberOfComponents=\"{components}\"{tuples} format=\"appended\" offset=\"{}\"/>",
            kind.name(),
            self.appended.len()
        );
        self.blocks(bytes);
    }

    /// Texts, as the numbers of their bytes, each with a zero behind it.
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
        let (count, last) = (bytes.len().div_ceil(BLOCK), bytes.len() % BLOCK);
        let header = self.appended.len();
        self.appended.extend([count, BLOCK, last].iter().flat_map(|&number| (number as u64).to_le_bytes()));
        self.appended.resize(self.appended.len() + 8 * count, 0);
        for (number, block) in bytes.chunks(BLOCK).enumerate() {
            let start = self.appended.len();
            let mut encoder = ZlibEncoder::new(&mut self.appended, Compression::fast());
            encoder.write_all(block).and_then(|()| encoder.try_finish()).expect("memory takes all bytes");
            drop(encoder);
            let (size, place) = ((self.appended.len() - start) as u64, header + 24 + 8 * number);
            self.appended[place..place + 8].copy_from_slice(&size.to_le_bytes());
        }
    }

    fn close(mut self) -> Vec<u8> {
        self.text += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
        let mut bytes = self.text.into_bytes();
        bytes.append(&mut self.appended);
        bytes.extend(b"\n</AppendedData>\n</VTKFile>\n");
        bytes
    }
}

#[cfg(test)]
#[path = "../../tests/unit/output_vtk.rs"]
mod tests;
