//! VTK XML files of polygonal data: what ParaView opens without a plug-in.
//!
//! Arrays stand behind the document (`appended`, `raw`) in blocks that zlib has compressed. In front of the blocks of an array stand, as
//! integers of 64 bits, the number of blocks, the size of a whole block, the size of the last one if it is not whole (otherwise zero), and
//! the compressed size of each: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use flate2::{Compress, Compression, FlushCompress};
use std::fmt::Write;

/// Bytes of a whole block before compression.
const BLOCK: usize = 1 << 16;

/// Level of zlib. The fastest: higher ones take twice the time for a few percent of the size (`validation/docs/pictures.md`).
const LEVEL: u32 = 1;

/// Share of its size to which a block must shrink, so that the blocks behind it are tried too: what looks like noise is stored as it is.
const PAYS: f64 = 0.9;

/// Blocks that are stored as they are after one that did not shrink, before one is tried again.
const REST: usize = 15;

/// Kind of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Bytes.
    UInt8,
    /// Integers of 32 bits.
    Int32,
    /// Single precision.
    Float32,
    /// Double precision.
    Float64,
}

impl Kind {
    pub const ALL: [Kind; 4] = [Kind::UInt8, Kind::Int32, Kind::Float32, Kind::Float64];

    /// Its name in a file.
    pub fn name(self) -> &'static str {
        match self {
            Kind::UInt8 => "UInt8",
            Kind::Int32 => "Int32",
            Kind::Float32 => "Float32",
            Kind::Float64 => "Float64",
        }
    }

    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Kind::UInt8 => 1,
            Kind::Int32 | Kind::Float32 => 4,
            Kind::Float64 => 8,
        }
    }
}

/// A named array: tuples of numbers, as bytes in little endian.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Array {
    /// Its name.
    pub name: String,
    /// Numbers of a tuple.
    pub components: usize,
    /// What its numbers are.
    pub kind: Kind,
    /// The numbers, tuple after tuple.
    pub bytes: Vec<u8>,
}

impl Array {
    /// Single precision is far finer than a pixel and halves the files.
    pub fn floats(name: &str, components: usize, values: impl Iterator<Item = f64>) -> Array {
        let bytes = values.flat_map(|value| (value as f32).to_le_bytes()).collect();
        Array { name: name.into(), components, kind: Kind::Float32, bytes }
    }

    /// In double precision.
    pub fn doubles(name: &str, components: usize, values: impl Iterator<Item = f64>) -> Array {
        let bytes = values.flat_map(f64::to_le_bytes).collect();
        Array { name: name.into(), components, kind: Kind::Float64, bytes }
    }

    /// Integers, one a tuple.
    pub fn integers(name: &str, values: impl Iterator<Item = i32>) -> Array {
        Array {
            name: name.into(),
            components: 1,
            kind: Kind::Int32,
            bytes: values.flat_map(i32::to_le_bytes).collect(),
        }
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
        fn each<const SIZE: usize>(bytes: &[u8], number: impl Fn([u8; SIZE]) -> f64) -> Vec<f64> {
            bytes.as_chunks::<SIZE>().0.iter().map(|bytes| number(*bytes)).collect()
        }
        match self.kind {
            Kind::UInt8 => each(&self.bytes, |[byte]: [u8; 1]| f64::from(byte)),
            Kind::Int32 => each(&self.bytes, |bytes| f64::from(i32::from_le_bytes(bytes))),
            Kind::Float32 => each(&self.bytes, |bytes| f64::from(f32::from_le_bytes(bytes))),
            Kind::Float64 => each(&self.bytes, f64::from_le_bytes),
        }
    }
}

/// What connects the points of a file.
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
    /// What VTK calls them.
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
    /// What connects the points.
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

    /// The bytes of the file.
    pub fn encode(&self) -> Vec<u8> {
        let mut file = Encoder::new();
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

/// A file that is being put together.
struct Encoder {
    text: String,
    /// What stands behind the document.
    appended: Vec<u8>,
    deflate: Compress,
    store: Compress,
}

impl Encoder {
    fn new() -> Encoder {
        Encoder {
            text: String::new(),
            appended: Vec::new(),
            deflate: Compress::new(Compression::new(LEVEL), true),
            store: Compress::new(Compression::none(), true),
        }
    }

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
        let mut stored = 0;
        for (number, block) in bytes.chunks(BLOCK).enumerate() {
            let start = self.appended.len();
            let how = match stored {
                0 => &mut self.deflate,
                _ => &mut self.store,
            };
            compress(how, block, &mut self.appended);
            let mut size = self.appended.len() - start;
            stored = match stored {
                0 if size as f64 > PAYS * block.len() as f64 => REST,
                0 => 0,
                left => left - 1,
            };
            if size > block.len() + 64 {
                // Noise that grew.
                self.appended.truncate(start);
                compress(&mut self.store, block, &mut self.appended);
                size = self.appended.len() - start;
            }
            let place = header + 24 + 8 * number;
            self.appended[place..place + 8].copy_from_slice(&(size as u64).to_le_bytes());
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

/// Adds a whole stream of zlib to what there is.
fn compress(how: &mut Compress, block: &[u8], to: &mut Vec<u8>) {
    how.reset();
    // Stored blocks take five bytes for each 32 kB or more; head and checksum six.
    to.reserve(block.len() + block.len() / 1024 + 128);
    let mut read = 0;
    loop {
        let before = how.total_in();
        let status = how.compress_vec(&block[read..], to, FlushCompress::Finish);
        read += (how.total_in() - before) as usize;
        match status {
            Ok(flate2::Status::StreamEnd) => return,
            _ => to.reserve(block.len() / 8 + 128),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::vtk_read::decode;

    /// A file of every kind of array.
    fn sample(points: usize) -> PolyData {
        let noise = |n: usize| f64::from((n as u32).wrapping_mul(2_654_435_769)) / 4e9;
        PolyData {
            time: 1.25,
            points: Array::floats("Points", 3, (0..3 * points).map(noise)),
            cells: Cells::Vertices,
            point_data: vec![
                Array::integers("id", (0..points as i32).map(|id| id - 3)),
                Array::doubles("mass", 1, (0..points).map(|n| 0.5 * n as f64)),
                Array { name: "material".into(), components: 1, kind: Kind::UInt8, bytes: vec![7; points] },
            ],
            cell_data: Vec::new(),
            field_data: vec![Array::doubles("gravity", 3, [0.0, 0.0, -9.81].into_iter())],
            texts: vec![("materials".into(), vec!["glass".into(), "a <b> & \"ü\"".into()])],
        }
    }

    #[test]
    fn what_is_written_is_read_back_whatever_its_size() {
        for points in [0, 1, 7, BLOCK / 12, BLOCK / 4, 50_000] {
            let file = sample(points);
            assert_eq!(decode(&file.encode()).unwrap(), file, "{points} points");
        }
        let mut file = sample(5);
        file.cells = Cells::Triangles(vec![[0, 1, 2], [2, 3, 4]]);
        file.cell_data = vec![Array::integers("wall", [4, 5].into_iter())];
        assert_eq!(decode(&file.encode()).unwrap(), file);
    }

    #[test]
    fn what_repeats_itself_shrinks_and_noise_does_not_grow() {
        let file = sample(50_000);
        let raw: usize = [&file.points].into_iter().chain(&file.point_data).map(|array| array.bytes.len()).sum();
        let size = file.encode().len();
        assert!(size < raw, "{size} bytes for {raw}");
        let noise =
            Array::floats("noise", 1, (0..100_000_u32).map(|n| f64::from(n.wrapping_mul(n).wrapping_mul(0x9e37_79b9))));
        let mut encoder = Encoder::new();
        encoder.blocks(&noise.bytes);
        assert!(encoder.appended.len() < noise.bytes.len() + 1000);
    }

    #[test]
    fn coordinates_far_from_the_origin_keep_their_places() {
        let at = |x: f64| Array::coordinates("Points", [x, 0.0, 0.0, x + 0.01, 0.0, 0.0].into_iter(), 0.005);
        let far = at(9e5);
        assert_eq!((far.kind, &far.values()[..]), (Kind::Float64, &[9e5, 0.0, 0.0, 9e5 + 0.01, 0.0, 0.0][..]));
        assert_eq!(at(0.2).kind, Kind::Float32, "near the origin single precision tells them apart");
    }
}
