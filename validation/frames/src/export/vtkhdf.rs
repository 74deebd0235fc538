//! One VTKHDF file for all frames of one kind: temporal polygonal data, read by ParaView and `vtkHDFReader`.
//!
//! Arrays of all frames are concatenated, and `Steps` states the start of each frame:
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/vtkhdf_specifications.html>. The HDF5 library appends to
//! one-dimensional arrays only, so an array is gathered over all frames before it is added. Each pass over the frames gathers as many
//! arrays as fit into [`PASS`] bytes, and at least one.

use super::{ExportError, Written, for_each};
use crate::output::{Draft, FIELD_DATA};
use crate::run_frames::columns::{Column, DOUBLE, DRIVEN_WALLS, Number, Part, Shape};
use crate::run_frames::{Kind, RunFrames};
use hdf5_pure::{AttrValue, File};
use std::mem::take;
use std::path::Path;

/// Rows of a chunk.
const CHUNK: u64 = 16_384;

/// Attribute for the number of the scene's first grain in a file.
pub(crate) const FIRST_ID: &str = "MakadamFirstId";

/// Level of zlib after a byte shuffle.
const LEVEL: u32 = 3;

/// Groups of cells, in the order of the format, which is the order of [`Kind::ALL`].
const TOPOLOGIES: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];

/// Byte limit of one pass over the frames, unless a single array is larger.
const PASS: usize = 1 << 28;

/// Smallest number of rows of a compressed array.
const PACKED: u64 = 1024;

/// Groups of arrays.
const POINT_DATA: &str = "PointData/";
const CELL_DATA: &str = "CellData/";

/// Counts and offsets.
const COUNT: Shape = (Number::Int64, 1);

/// Writes `grains.vtkhdf`, and `contacts.vtkhdf` and `walls.vtkhdf` if the run has contacts and walls.
pub(super) fn write(run: &RunFrames, folder: &Path, progress: &dyn Fn(f64)) -> Result<Vec<Written>, ExportError> {
    let kinds: Vec<Kind> = Kind::ALL.into_iter().filter(|kind| !run.numbers(*kind).is_empty()).collect();
    let mut written = Vec::new();
    for (number, kind) in kinds.iter().enumerate() {
        let path = folder.join(format!("{}.vtkhdf", kind.name()));
        write_kind(&path, run, *kind, &|share| progress((number as f64 + share) / kinds.len() as f64))?;
        written.push(Written { path, frames: run.numbers(*kind).len() });
    }
    Ok(written)
}

/// Array of a file, over all frames.
struct Array {
    /// Path below the group of the format.
    path: String,
    column: Column,
}

impl Array {
    fn new(path: impl Into<String>, shape: Shape, values: impl IntoIterator<Item = f64>) -> Array {
        Array { path: path.into(), column: Column::new("", shape, values) }
    }

    /// Returns the arrays of a part of a frame.
    fn all_of(part: Part) -> Vec<Array> {
        let of = |group: &'static str| move |column: Column| Array { path: format!("{group}{}", column.name), column };
        let (points, cells) =
            (part.of_points.into_iter().map(of(POINT_DATA)), part.of_cells.into_iter().map(of(CELL_DATA)));
        std::iter::once(of("")(part.points)).chain(points).chain(cells).collect()
    }

    fn put(&self, file: &File) -> Result<(), hdf5_pure::Error> {
        let Column { number, width, values, .. } = &self.column;
        let rows = self.column.tuples() as u64;
        file.root().create_dataset(&format!("VTKHDF/{}", self.path), |dataset| {
            match number {
                Number::UInt8 => dataset.with_u8_data(&number.encode(values)),
                Number::Int32 => dataset.with_i32_data(&values.iter().map(|value| *value as i32).collect::<Vec<_>>()),
                Number::Int64 => dataset.with_i64_data(&values.iter().map(|value| *value as i64).collect::<Vec<_>>()),
                Number::Float32 => dataset.with_f32_data(&values.iter().map(|value| *value as f32).collect::<Vec<_>>()),
                // Runs write no other kinds.
                _ => dataset.with_f64_data(values),
            };
            let of = |rows: u64| if *width == 1 { vec![rows] } else { vec![rows, *width as u64] };
            dataset.with_shape(&of(rows));
            if rows >= PACKED {
                dataset.with_chunks(&of(CHUNK.min(rows))).with_shuffle().with_deflate(LEVEL);
            }
        })?;
        Ok(())
    }
}

/// Sizes of the frames of a kind, known before their arrays are read.
#[derive(Default)]
struct Survey {
    times: Vec<f64>,
    points: Vec<usize>,
    cells: Vec<usize>,
    /// Numbers of the points of all cells, and the first point of each cell among the points of its frame, with their end.
    corners: Vec<f64>,
    offsets: Vec<f64>,
    corners_per_cell: usize,
    /// Arrays over points and cells, still empty.
    arrays: Vec<Array>,
    /// Poses of dynamic walls, and the number of tuples in each frame.
    poses: Vec<(Column, Vec<usize>)>,
}

impl Survey {
    fn add(&mut self, mut part: Part) {
        let cells = part.cells();
        self.times.push(part.time);
        self.points.push(part.points.tuples());
        self.cells.push(cells);
        self.corners.extend(part.corners().into_iter().map(f64::from));
        self.offsets.extend((0..=cells).map(|cell| (cell * part.corners_per_cell) as f64));
        self.corners_per_cell = part.corners_per_cell;
        for column in part.whole.drain(..).filter(|column| DRIVEN_WALLS.contains(&column.name.as_str())) {
            let tuples = column.tuples();
            match self.poses.iter_mut().find(|(known, _)| known.name == column.name) {
                Some((known, counts)) => {
                    known.values.extend(column.values);
                    counts.push(tuples);
                }
                None => self.poses.push((column, vec![tuples])),
            }
        }
        if self.arrays.is_empty() {
            self.arrays = Array::all_of(part);
            self.arrays.iter_mut().for_each(|array| array.column.values.clear());
        }
    }

    /// Writes counts, offsets and cells, without the arrays.
    fn write(&mut self, file: &File, kind: Kind) -> Result<(), hdf5_pure::Error> {
        let frames = self.times.len();
        let numbers = |counts: &[usize]| counts.iter().map(|count| *count as f64).collect::<Vec<_>>();
        let ids: Vec<usize> = self.cells.iter().map(|count| count * self.corners_per_cell).collect();
        let mut groups = vec!["PointData", "CellData", "Steps", "Steps/PointDataOffsets", "Steps/CellDataOffsets"];
        groups.extend(TOPOLOGIES);
        let mut arrays = vec![
            Array::new("NumberOfPoints", COUNT, numbers(&self.points)),
            Array::new("Steps/Values", DOUBLE, self.times.clone()),
            Array::new("Steps/PartOffsets", COUNT, (0..frames).map(|frame| frame as f64)),
            Array::new("Steps/NumberOfParts", COUNT, vec![1.0; frames]),
            Array::new("Steps/PointOffsets", COUNT, starts(&self.points)),
        ];
        for (name, counts) in [("CellOffsets", &self.cells), ("ConnectivityIdOffsets", &ids)] {
            let of_topology =
                |start| (0..TOPOLOGIES.len()).map(move |of| if of == kind as usize { start } else { 0.0 });
            let rows = starts(counts).into_iter().flat_map(of_topology);
            arrays.push(Array::new(format!("Steps/{name}"), (Number::Int64, TOPOLOGIES.len()), rows));
        }
        for (of, name) in TOPOLOGIES.into_iter().enumerate() {
            // A frame without cells has one offset.
            let [cells, ids, offsets, corners] = match of == kind as usize {
                true => [numbers(&self.cells), numbers(&ids), take(&mut self.offsets), take(&mut self.corners)],
                false => [vec![0.0; frames], vec![0.0; frames], vec![0.0; frames], Vec::new()],
            };
            let all = [("NumberOfCells", cells), ("NumberOfConnectivityIds", ids), ("Offsets", offsets)];
            let all = all.into_iter().chain([("Connectivity", corners)]);
            arrays.extend(all.map(|(array, values)| Array::new(format!("{name}/{array}"), COUNT, values)));
        }
        for Array { path, .. } in &self.arrays {
            if let Some((section, name)) = path.split_once('/') {
                let counts = if section == "CellData" { &self.cells } else { &self.points };
                arrays.push(Array::new(format!("Steps/{section}Offsets/{name}"), COUNT, starts(counts)));
            }
        }
        if !self.poses.is_empty() {
            groups.extend([FIELD_DATA, "Steps/FieldDataOffsets", "Steps/FieldDataSizes"]);
        }
        for (column, counts) in &self.poses {
            let (name, shape) = (&column.name, (column.number, column.width));
            let sizes = counts.iter().flat_map(|count| [column.width as f64, *count as f64]);
            arrays.push(Array::new(format!("{FIELD_DATA}/{name}"), shape, column.values.clone()));
            arrays.push(Array::new(format!("Steps/FieldDataOffsets/{name}"), COUNT, starts(counts)));
            arrays.push(Array::new(format!("Steps/FieldDataSizes/{name}"), (Number::Int64, 2), sizes));
        }
        file.root().create_group_with("VTKHDF", |root| {
            root.set_attr("Version", AttrValue::I64Array(vec![2, 0]));
            root.set_attr("Type", AttrValue::AsciiString("PolyData".into()));
            // Grains are numbered as in the scene, from this number on.
            root.set_attr(FIRST_ID, AttrValue::I64(0));
            groups.iter().for_each(|group| _ = root.create_group(group));
        })?;
        file.root().group("VTKHDF/Steps")?.set_attr("NSteps", AttrValue::I64(frames as i64))?;
        arrays.iter().try_for_each(|array| array.put(file))?;
        file.commit()
    }
}

/// Returns the cumulative sums of counts, from zero.
fn starts(counts: &[usize]) -> Vec<f64> {
    let sums = counts.iter().scan(0, |sum, count| {
        *sum += count;
        Some((*sum - count) as f64)
    });
    sums.collect()
}

fn write_kind(path: &Path, run: &RunFrames, kind: Kind, progress: &dyn Fn(f64)) -> Result<(), ExportError> {
    let failed =
        |error: hdf5_pure::Error| ExportError::Format { file: path.display().to_string(), problem: error.to_string() };
    let mut survey = Survey::default();
    for_each(run.numbers(kind), &|_| {}, |number| {
        survey.add(run.part(number, kind)?);
        Ok(())
    })?;
    let draft = Draft::of(path);
    let file = File::create(draft.name()).map_err(failed)?;
    survey.write(&file, kind).map_err(failed)?;
    let (points, cells) = (survey.points.iter().sum::<usize>(), survey.cells.iter().sum::<usize>());
    let mut left = survey.arrays;
    let count = left.len();
    while !left.is_empty() {
        let mut bytes = 0;
        let fits = |array: &&Array| {
            let tuples = if array.path.starts_with(CELL_DATA) { cells } else { points };
            bytes += tuples * array.column.width * size_of::<f64>();
            bytes <= PASS
        };
        let pass = left.iter().take_while(fits).count().max(1);
        let mut own: Vec<Array> = left.drain(..pass).collect();
        for_each(run.numbers(kind), &|_| {}, |number| {
            for found in Array::all_of(run.part(number, kind)?) {
                if let Some(array) = own.iter_mut().find(|array| array.path == found.path) {
                    array.column.values.extend(found.column.values);
                }
            }
            Ok(())
        })?;
        own.iter().try_for_each(|array| array.put(&file)).and_then(|()| file.commit()).map_err(failed)?;
        progress((count - left.len()) as f64 / count as f64);
    }
    file.close().map_err(failed)?;
    Ok(draft.finish()?)
}
