//! One VTKHDF file for all frames of one kind: temporal polygonal data, read by ParaView and `vtkHDFReader`.
//!
//! Arrays of all frames stand one behind the other, and `Steps` states where each frame begins in them:
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/vtkhdf_specifications.html>. The library that writes HDF5 appends to
//! arrays of one dimension only, so an array is gathered over all frames before it is added: each pass over the frames gathers as many
//! arrays as fit into [`PASS`] bytes, and one at least.

use super::{ExportError, Written};
use crate::output::vtk::{Array, Cells, Kind as Number, PolyData};
use crate::output::{DRIVEN_WALLS, Draft, FIELD_DATA, create_folder};
use crate::run_frames::{Kind, RunFrames};
use hdf5_pure::{AttrValue, DatasetBuilder, File, FileBuilder};
use std::ops::Range;
use std::path::Path;

/// Rows of a chunk.
const CHUNK: u64 = 16_384;

/// Attribute by which a file states the number of the scene's first grain.
pub(crate) const FIRST_ID: &str = "MakadamFirstId";

/// Level of zlib behind a shuffle of bytes.
const LEVEL: u32 = 3;

/// Groups of cells, in the order of the format, which is that of [`Kind::ALL`].
const TOPOLOGIES: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];

/// Most bytes that one pass over the frames gathers, unless a single array takes more.
const PASS: usize = 1 << 28;

/// Sizes of the frames, known before their arrays are read.
#[derive(Default)]
struct Survey {
    times: Vec<f64>,
    points: Vec<i64>,
    cells: Vec<i64>,
    /// Place of the topology that has cells.
    topology: usize,
    /// Points of a cell.
    corners: i64,
}

/// Writes `grains.vtkhdf`, and `contacts.vtkhdf` and `walls.vtkhdf` where the run has them.
///
/// # Errors
/// [`ExportError`] if a frame cannot be read, or the system refuses.
pub(super) fn write(run: &RunFrames, folder: &Path, progress: &dyn Fn(f64)) -> Result<Vec<Written>, ExportError> {
    create_folder(folder)?;
    let kinds: Vec<Kind> = Kind::ALL.into_iter().filter(|kind| !run.numbers(*kind).is_empty()).collect();
    let mut written = Vec::new();
    for (number, kind) in kinds.iter().enumerate() {
        let path = folder.join(format!("{}.vtkhdf", kind.name()));
        write_kind(&path, run, *kind, &|share| progress((number as f64 + share) / kinds.len() as f64))?;
        written.push(Written { path, frames: run.numbers(*kind).len() });
    }
    Ok(written)
}

fn write_kind(path: &Path, run: &RunFrames, kind: Kind, progress: &dyn Fn(f64)) -> Result<(), ExportError> {
    let (survey, arrays) = survey(run, kind)?;
    let poses = if kind == Kind::Grains { poses(run)? } else { Vec::new() };
    let failed =
        |error: hdf5_pure::Error| ExportError::Format { file: path.display().to_string(), problem: error.to_string() };
    let draft = Draft::of(path);
    skeleton(&survey, &arrays, &poses).write(draft.name()).map_err(failed)?;
    let file = File::open_rw(draft.name()).map_err(failed)?;
    let passes = survey.passes(&arrays);
    for (pass, range) in passes.iter().enumerate() {
        let own = &arrays[range.clone()];
        let mut gathered = vec![(Vec::new(), 0); own.len()];
        for number in run.numbers(kind) {
            let data = run.poly_data(number, kind)?;
            for ((group, array), (bytes, rows)) in own.iter().zip(&mut gathered) {
                let found = arrays_of(&data).find(|(of, found)| of == group && found.name == array.name);
                let (_, found) = found.expect("all frames of a run have the same arrays");
                bytes.extend(as_kind(found, array.kind));
                *rows += found.tuples() as u64;
            }
            if crate::interrupt::requested() {
                return Err(ExportError::Interrupted);
            }
        }
        for ((group, array), (bytes, rows)) in own.iter().zip(gathered) {
            add(&file, &format!("VTKHDF/{group}{}", array.name), &bytes, array, rows).map_err(failed)?;
        }
        progress((pass + 1) as f64 / (passes.len() + 1) as f64);
    }
    connectivity(run, kind, &survey, &file, &failed)?;
    file.close().map_err(failed)?;
    progress(1.0);
    Ok(draft.finish()?)
}

/// Arrays with their groups below `VTKHDF`.
type Grouped = Vec<(&'static str, Array)>;

impl Survey {
    /// Returns the arrays of each pass over the frames.
    fn passes(&self, arrays: &[(&'static str, Array)]) -> Vec<Range<usize>> {
        let (points, cells) = (self.points.iter().sum::<i64>() as usize, self.cells.iter().sum::<i64>() as usize);
        let mut passes: Vec<Range<usize>> = Vec::new();
        let mut room = 0;
        for (number, (group, array)) in arrays.iter().enumerate() {
            let tuples = if *group == "CellData/" { cells } else { points };
            let bytes = tuples * array.components * array.kind.size();
            match passes.last_mut().filter(|_| bytes <= room) {
                Some(pass) => {
                    pass.end = number + 1;
                    room -= bytes;
                }
                None => {
                    passes.push(number..number + 1);
                    room = PASS.saturating_sub(bytes);
                }
            }
        }
        passes
    }
}

/// Returns the times and sizes of the frames, and their arrays without content.
fn survey(run: &RunFrames, kind: Kind) -> Result<(Survey, Grouped), ExportError> {
    let mut survey = Survey {
        topology: Kind::ALL.iter().position(|known| *known == kind).expect("a kind is one of all"),
        corners: match kind {
            Kind::Grains => 1,
            Kind::Contacts => 2,
            Kind::Walls => 3,
        },
        ..Survey::default()
    };
    let mut arrays = Vec::new();
    for number in run.numbers(kind) {
        let data = run.poly_data(number, kind)?;
        survey.times.push(data.time);
        survey.points.push(data.count() as i64);
        survey.cells.push(data.cells.count(data.count()) as i64);
        if arrays.is_empty() {
            arrays =
                arrays_of(&data).map(|(group, array)| (group, Array { bytes: Vec::new(), ..array.clone() })).collect();
        }
    }
    Ok((survey, arrays))
}

/// Returns the poses of driven walls, in arrays over all frames, each with the number of its tuples in each frame.
fn poses(run: &RunFrames) -> Result<Vec<(Array, Vec<i64>)>, ExportError> {
    let mut all: Vec<(Array, Vec<i64>)> = Vec::new();
    for number in run.numbers(Kind::Grains) {
        let data = run.poly_data(number, Kind::Grains)?;
        for array in data.field_data.into_iter().filter(|array| DRIVEN_WALLS.contains(&array.name.as_str())) {
            let tuples = array.tuples() as i64;
            match all.iter_mut().find(|(known, _)| known.name == array.name) {
                Some((known, counts)) => {
                    known.bytes.extend(array.bytes);
                    counts.push(tuples);
                }
                None => all.push((array, vec![tuples])),
            }
        }
    }
    Ok(all)
}

/// Arrays that go into the file, each with its group below `VTKHDF`.
fn arrays_of(data: &PolyData) -> impl Iterator<Item = (&'static str, &Array)> {
    let points = std::iter::once(("", &data.points));
    let of_points = data.point_data.iter().map(|array| ("PointData/", array));
    points.chain(of_points).chain(data.cell_data.iter().map(|array| ("CellData/", array)))
}

/// The bytes of an array as another kind of numbers: coordinates are single or double as a frame needs.
fn as_kind(array: &Array, kind: Number) -> Vec<u8> {
    match array.kind == kind {
        true => array.bytes.clone(),
        false => array.values().iter().flat_map(|value| kind.bytes(*value)).collect(),
    }
}

/// The file without its arrays: how many points and cells there are, and where each frame begins.
fn skeleton(survey: &Survey, arrays: &[(&'static str, Array)], poses: &[(Array, Vec<i64>)]) -> FileBuilder {
    let frames = survey.times.len();
    let starts = |counts: &[i64]| -> Vec<i64> {
        let mut sum = 0;
        let start = |count: &i64| {
            sum += count;
            sum - count
        };
        counts.iter().map(start).collect()
    };
    let (points, cells) = (starts(&survey.points), starts(&survey.cells));
    let mut builder = FileBuilder::new();
    let mut root = builder.create_group("VTKHDF");
    root.set_attr("Version", AttrValue::I64Array(vec![2, 0]));
    root.set_attr("Type", AttrValue::AsciiString("PolyData".into()));
    // Grains are numbered as in the scene, from this number on.
    root.set_attr(FIRST_ID, AttrValue::I64(0));
    root.create_dataset("NumberOfPoints").with_i64_data(&survey.points);
    let groups = ["PointData", "CellData"].map(|name| (name, root.create_group(name)));
    groups.into_iter().for_each(|(_, group)| {
        root.add_group(group.finish());
    });
    for (place, name) in TOPOLOGIES.iter().enumerate() {
        let of = |count: &i64| if place == survey.topology { *count } else { 0 };
        let counts: Vec<i64> = survey.cells.iter().map(of).collect();
        let corners: Vec<i64> = counts.iter().map(|count| count * survey.corners).collect();
        let mut group = root.create_group(name);
        group.create_dataset("NumberOfCells").with_i64_data(&counts);
        group.create_dataset("NumberOfConnectivityIds").with_i64_data(&corners);
        if place != survey.topology {
            // A frame without cells has one offset.
            group.create_dataset("Offsets").with_i64_data(&vec![0; frames]);
            group.create_dataset("Connectivity").with_i64_data(&[]).with_shape(&[0]);
        }
        root.add_group(group.finish());
    }
    if !poses.is_empty() {
        let mut group = root.create_group(FIELD_DATA);
        for (array, _) in poses {
            numbers(group.create_dataset(&array.name), &array.bytes, array.kind);
        }
        root.add_group(group.finish());
    }
    let mut steps = root.create_group("Steps");
    steps.set_attr("NSteps", AttrValue::I64(frames as i64));
    steps.create_dataset("Values").with_f64_data(&survey.times);
    steps.create_dataset("PartOffsets").with_i64_data(&(0..frames as i64).collect::<Vec<_>>());
    steps.create_dataset("NumberOfParts").with_i64_data(&vec![1; frames]);
    steps.create_dataset("PointOffsets").with_i64_data(&points);
    let by_topology = |starts: &[i64]| -> Vec<i64> {
        let row = |start: &i64| {
            (0..TOPOLOGIES.len()).map(|place| if place == survey.topology { *start } else { 0 }).collect()
        };
        starts.iter().flat_map(|start| -> Vec<i64> { row(start) }).collect()
    };
    let shape = [frames as u64, TOPOLOGIES.len() as u64];
    let corners: Vec<i64> = cells.iter().map(|start| start * survey.corners).collect();
    steps.create_dataset("CellOffsets").with_i64_data(&by_topology(&cells)).with_shape(&shape);
    steps.create_dataset("ConnectivityIdOffsets").with_i64_data(&by_topology(&corners)).with_shape(&shape);
    for (section, starts) in [("PointData", &points), ("CellData", &cells)] {
        let mut group = steps.create_group(&format!("{section}Offsets"));
        for (_, array) in arrays.iter().filter(|(of, _)| *of == format!("{section}/")) {
            group.create_dataset(&array.name).with_i64_data(starts);
        }
        steps.add_group(group.finish());
    }
    if !poses.is_empty() {
        let [mut firsts, mut sizes] =
            ["Offsets", "Sizes"].map(|name| steps.create_group(&format!("{FIELD_DATA}{name}")));
        for (array, counts) in poses {
            firsts.create_dataset(&array.name).with_i64_data(&starts(counts));
            let size = counts.iter().flat_map(|count| [array.components as i64, *count]);
            let size: Vec<i64> = size.collect();
            sizes.create_dataset(&array.name).with_i64_data(&size).with_shape(&[frames as u64, 2]);
        }
        steps.add_group(firsts.finish());
        steps.add_group(sizes.finish());
    }
    root.add_group(steps.finish());
    builder.add_group(root.finish());
    builder
}

/// Adds an array with all its rows.
fn add(file: &File, path: &str, bytes: &[u8], array: &Array, rows: u64) -> Result<(), hdf5_pure::Error> {
    file.root().create_dataset(path, |dataset| {
        numbers(dataset, bytes, array.kind);
        let columns = array.components as u64;
        let (shape, chunk) = match columns {
            1 => (vec![rows], vec![CHUNK.min(rows)]),
            _ => (vec![rows, columns], vec![CHUNK.min(rows), columns]),
        };
        dataset.with_shape(&shape);
        if rows > 0 {
            dataset.with_chunks(&chunk).with_shuffle().with_deflate(LEVEL);
        }
    })?;
    file.commit()
}

fn numbers(dataset: &mut DatasetBuilder, bytes: &[u8], kind: Number) {
    match kind {
        Number::UInt8 => dataset.with_u8_data(bytes),
        Number::Int32 => dataset
            .with_i32_data(&bytes.as_chunks().0.iter().map(|bytes| i32::from_le_bytes(*bytes)).collect::<Vec<_>>()),
        Number::Int64 => dataset
            .with_i64_data(&bytes.as_chunks().0.iter().map(|bytes| i64::from_le_bytes(*bytes)).collect::<Vec<_>>()),
        Number::Float32 => dataset
            .with_f32_data(&bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect::<Vec<_>>()),
        Number::Float64 => dataset
            .with_f64_data(&bytes.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect::<Vec<_>>()),
        // Runs write no other kinds.
        _ => {
            let array = Array { name: String::new(), components: 1, kind, bytes: bytes.to_vec() };
            dataset.with_f64_data(&array.values())
        }
    };
}

/// Adds the corners of the cells and where each cell begins among them, frame after frame.
fn connectivity(
    run: &RunFrames,
    kind: Kind,
    survey: &Survey,
    file: &File,
    failed: &dyn Fn(hdf5_pure::Error) -> ExportError,
) -> Result<(), ExportError> {
    let (mut corners, mut offsets): (Vec<i64>, Vec<i64>) = (Vec::new(), Vec::new());
    for (number, (points, cells)) in run.numbers(kind).zip(survey.points.iter().zip(&survey.cells)) {
        match kind {
            Kind::Grains | Kind::Contacts => corners.extend(0..*points),
            Kind::Walls => {
                if let Cells::Triangles(triangles) = run.poly_data(number, kind)?.cells {
                    corners.extend(triangles.iter().flatten().map(|corner| i64::from(*corner)));
                }
            }
        }
        offsets.extend((0..=*cells).map(|cell| cell * survey.corners));
    }
    let group = format!("VTKHDF/{}", TOPOLOGIES[survey.topology]);
    for (name, numbers) in [("Connectivity", corners), ("Offsets", offsets)] {
        let rows = numbers.len() as u64;
        let added = file.root().create_dataset(&format!("{group}/{name}"), |dataset| {
            dataset.with_i64_data(&numbers).with_shape(&[rows]);
            if rows > 0 {
                dataset.with_chunks(&[CHUNK.min(rows)]).with_shuffle().with_deflate(LEVEL);
            }
        });
        added.and_then(|_| file.commit()).map_err(failed)?;
    }
    Ok(())
}
