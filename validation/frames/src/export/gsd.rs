//! GSD with the schema of HOOMD-blue, which OVITO opens: grains over time.
//!
//! ```text
//! header (256 bytes), chunks of numbers, index (32 bytes per chunk, by frame and name), names (64 bytes, separated by zeros)
//! ```
//!
//! Format: <https://gsd.readthedocs.io/en/stable/file-layer.html>; schema:
//! <https://gsd.readthedocs.io/en/stable/schema-hoomd.html>. The existing crate (`hoomd-gsd`) has forty dependencies, among them a column
//! store; this writer is small.

use super::{ExportError, Written, for_each};
use crate::output::{Draft, WriteError};
use crate::provenance::VERSION;
use crate::run_frames::columns::{DOUBLE, Number, REAL, Shape, VECTOR, pose_columns};
use crate::run_frames::{RunFrame, RunFrames};
use std::fs::File;
use std::io::{BufWriter, Error, Seek, SeekFrom, Write};
use std::path::Path;

const MAGIC: u64 = 0x65df_65df_65df_65df;

/// Versions of the file's layers and of the schema: major and minor, 16 bits each.
const LAYERS: u32 = 2 << 16;
const SCHEMA: u32 = 1 << 16 | 4;

/// Bytes of the header, and unit of the size of the name table.
const HEADER: u64 = 256;
const NAME: usize = 64;

/// Number types, by their codes less one.
const KINDS: [Number; 10] = [
    Number::UInt8,
    Number::UInt16,
    Number::UInt32,
    Number::UInt64,
    Number::Int8,
    Number::Int16,
    Number::Int32,
    Number::Int64,
    Number::Float32,
    Number::Float64,
];

/// Columns of grains, and their names in the file: HOOMD-blue's own names, and names for user data.
const COLUMNS: [(&str, &str); 6] = [
    ("velocity", "particles/velocity"),
    ("mass", "particles/mass"),
    ("pressure", "log/particles/pressure"),
    ("coordination_number", "log/particles/coordination_number"),
    ("force", "log/particles/force"),
    ("angular_velocity", "log/particles/angular_velocity"),
];

/// GSD file during writing.
struct Gsd {
    file: BufWriter<File>,
    place: u64,
    frame: u64,
    names: Vec<String>,
    index: Vec<u8>,
    /// Entries of the present frame, by the numbers of their names.
    entries: Vec<(u16, [u8; 32])>,
}

impl Gsd {
    fn create(path: &Path) -> Result<Gsd, Error> {
        let mut file = BufWriter::new(File::create(path)?);
        file.write_all(&[0; HEADER as usize])?;
        Ok(Gsd { file, place: HEADER, frame: 0, names: Vec::new(), index: Vec::new(), entries: Vec::new() })
    }

    /// Adds numbers in rows.
    fn chunk(&mut self, name: &str, (kind, width): Shape, values: &[f64]) -> Result<(), Error> {
        let number = self.names.iter().position(|known| known == name).unwrap_or_else(|| {
            self.names.push(name.to_string());
            self.names.len() - 1
        }) as u16;
        let bytes = kind.encode(values);
        let mut entry = [0; 32];
        entry[..8].copy_from_slice(&self.frame.to_le_bytes());
        entry[8..16].copy_from_slice(&((values.len() / width) as u64).to_le_bytes());
        entry[16..24].copy_from_slice(&self.place.to_le_bytes());
        entry[24..28].copy_from_slice(&(width as u32).to_le_bytes());
        entry[28..30].copy_from_slice(&number.to_le_bytes());
        entry[30] = KINDS.iter().position(|known| *known == kind).map_or(0, |place| place as u8 + 1);
        self.file.write_all(&bytes)?;
        self.place += bytes.len() as u64;
        self.entries.push((number, entry));
        Ok(())
    }

    fn end_frame(&mut self) {
        self.entries.sort_unstable_by_key(|(number, _)| *number);
        self.index.extend(self.entries.drain(..).flat_map(|(_, entry)| entry));
        self.frame += 1;
    }

    /// Writes index, names and header.
    fn finish(mut self) -> Result<(), Error> {
        let mut names: Vec<u8> = self.names.iter().flat_map(|name| name.bytes().chain([0])).collect();
        names.push(0);
        names.resize(names.len().next_multiple_of(NAME), 0);
        self.file.write_all(&self.index)?;
        self.file.write_all(&names)?;
        let mut header = Vec::with_capacity(HEADER as usize);
        let (entries, behind) = ((self.index.len() / 32) as u64, self.place + self.index.len() as u64);
        for number in [MAGIC, self.place, entries, behind, (names.len() / NAME) as u64] {
            header.extend(number.to_le_bytes());
        }
        header.extend(SCHEMA.to_le_bytes());
        header.extend(LAYERS.to_le_bytes());
        for text in [format!("Makadam {VERSION}"), "hoomd".into()] {
            let mut text = text.into_bytes();
            text.resize(64, 0);
            header.extend(text);
        }
        header.resize(HEADER as usize, 0);
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(&header)?;
        self.file.flush()
    }
}

/// Writes the grains of all frames into `grains.gsd`. The origin of a GSD file is the middle of its box. Along periodic axes the box has
/// the length of the period; along the others it holds all grains of all frames. `log/middle` states its position (m), and `log/driven_wall...`
/// the poses of dynamic walls, one row per wall.
pub(super) fn write(run: &RunFrames, folder: &Path, progress: &dyn Fn(f64)) -> Result<Vec<Written>, ExportError> {
    let path = folder.join("grains.gsd");
    let draft = Draft::of(&path);
    let refused = |error| ExportError::Write(WriteError::new(draft.name(), error));
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for number in 0..run.count() {
        for particle in &run.snapshot(number)?.particles {
            for axis in 0..3 {
                low[axis] = low[axis].min(particle.position[axis]);
                high[axis] = high[axis].max(particle.position[axis]);
            }
        }
    }
    let mut gsd = Gsd::create(draft.name()).map_err(refused)?;
    for_each(0..run.count(), progress, |number| {
        let frame = run.read(number)?;
        let (middle, sides) = cell(&frame, [low, high]);
        put(&mut gsd, &frame, run.step(number), middle, sides).map_err(refused)?;
        gsd.end_frame();
        Ok(())
    })?;
    gsd.finish().map_err(refused)?;
    draft.finish()?;
    Ok(vec![Written { path, frames: run.count() }])
}

/// Returns middle and sides of the box, m. Readers treat all boxes as periodic: along non-periodic axes of the scene, a margin prevents
/// contacts between grains and images.
fn cell(frame: &RunFrame, [low, high]: [[f64; 3]; 2]) -> ([f64; 3], [f64; 3]) {
    let room = 4.0 * frame.grains.radii.iter().copied().fold(0.0, f64::max);
    let (mut middle, mut sides) = ([0.0; 3], [0.0; 3]);
    for axis in 0..3 {
        let repeats = frame.repeats.filter(|[lengths, _]| lengths[axis] > 0.0);
        (middle[axis], sides[axis]) = match repeats {
            Some([lengths, starts]) => (starts[axis] + 0.5 * lengths[axis], lengths[axis]),
            None => (f64::midpoint(low[axis], high[axis]), (high[axis] - low[axis] + room).max(1e-9)),
        };
    }
    (middle, sides)
}

fn put(gsd: &mut Gsd, frame: &RunFrame, step: u64, middle: [f64; 3], sides: [f64; 3]) -> Result<(), Error> {
    const COUNT: Shape = (Number::UInt32, 1);
    let grains = &frame.grains;
    let places = grains.positions.iter().flat_map(|position| (0..3).map(move |axis| position[axis] - middle[axis]));
    gsd.chunk("configuration/step", (Number::UInt64, 1), &[step as f64])?;
    gsd.chunk("configuration/box", REAL, &[sides, [0.0; 3]].concat())?;
    gsd.chunk("particles/N", COUNT, &[grains.radii.len() as f64])?;
    gsd.chunk("particles/position", VECTOR, &places.collect::<Vec<_>>())?;
    gsd.chunk("particles/diameter", REAL, &grains.radii.iter().map(|radius| 2.0 * radius).collect::<Vec<_>>())?;
    for (name, own) in COLUMNS {
        let column = frame.column(name).expect("a column of every frame");
        gsd.chunk(own, (Number::Float32, column.width), &column.values)?;
    }
    let materials = frame.tables.materials();
    if let Some(material) = frame.column("material").filter(|_| !materials.is_empty()) {
        gsd.chunk("particles/typeid", COUNT, &material.values)?;
        let width = materials.iter().map(String::len).max().unwrap_or(0) + 1;
        let names = materials.iter().flat_map(|name| name.bytes().chain(std::iter::repeat(0)).take(width));
        let names: Vec<f64> = names.map(|byte| f64::from(byte.cast_signed())).collect();
        gsd.chunk("particles/types", (Number::Int8, width), &names)?;
    }
    let walls = &frame.snapshot.driven_walls;
    for column in pose_columns(walls).into_iter().filter(|_| !walls.is_empty()) {
        let number = if column.number == Number::Int32 { Number::UInt32 } else { column.number };
        gsd.chunk(&format!("log/{}", column.name), (number, 1), &column.values)?;
    }
    gsd.chunk("log/time", DOUBLE, &[frame.time])?;
    gsd.chunk("log/middle", DOUBLE, &middle)
}
