//! One VTKHDF file for all frames of one kind: temporal polygonal data, read by ParaView and `vtkHDFReader`.
//!
//! Arrays of all frames stand one behind the other, and `Steps` says where each frame begins in them:
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/vtkhdf_specifications.html>. The library that writes HDF5 appends to
//! arrays of one dimension only, so that one array after the other is put together over all frames and added to the file: memory holds no
//! more than the largest one.

use super::ExportError;
use crate::output::vtk::{Array, Kind as Number};
use crate::output::{DRIVEN_WALLS, FIELD_DATA, Outline, WriteError};
use crate::run_frames::RunFrames;
use hdf5_pure::{AttrValue, DatasetBuilder, File, FileBuilder};
use std::path::{Path, PathBuf};

/// Rows of a chunk.
const CHUNK: u64 = 16_384;

/// Attribute by which a file states the number of the scene's first grain.
pub(crate) const FIRST_ID: &str = "MakadamFirstId";

/// Level of zlib behind a shuffle of bytes.
const LEVEL: u32 = 3;

/// Groups of cells, in the order of the format.
const TOPOLOGIES: [(&str, &str); 4] =
    [("Vertices", "Verts"), ("Lines", "Lines"), ("Polygons", "Polys"), ("Strips", "")];

/// What frames are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Points.
    Grains,
    /// Lines.
    Contacts,
    /// Triangles.
    Walls,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 3] = [Kind::Grains, Kind::Contacts, Kind::Walls];

    /// Its name, of which files are named.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Grains => "grains",
            Kind::Contacts => "contacts",
            Kind::Walls => "walls",
        }
    }
}

/// What is known of the frames before their arrays are read.
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

/// Writes all frames of a kind into one file and returns how many; none where the run has written none of that kind. `progress` is told the
/// share that is done.
///
/// # Errors
/// [`ExportError`] if a frame cannot be read, or the system refuses.
pub fn write_vtkhdf(path: &Path, run: &RunFrames, kind: Kind, progress: &dyn Fn(f64)) -> Result<usize, ExportError> {
    let files = run.files(kind.name());
    if files.is_empty() {
        return Ok(0);
    }
    let (survey, arrays) = survey(run, files)?;
    let poses = if kind == Kind::Grains { poses(run, files)? } else { Vec::new() };
    let failed =
        |error: hdf5_pure::Error| ExportError::Format { file: path.display().to_string(), problem: error.to_string() };
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".part{}", std::process::id()));
    let draft = PathBuf::from(name);
    let written = skeleton(&survey, &arrays, &poses).write(&draft).and_then(|()| File::open_rw(&draft)).map_err(failed);
    let filled = written.and_then(|file| {
        // Arrays, and the connectivity.
        let count = arrays.len() + 1;
        for (number, (group, array)) in arrays.iter().enumerate() {
            let (mut all, mut rows) = (Vec::new(), 0);
            for (_, frame) in files {
                let data = run.read_some(frame, &|_, name| name == array.name)?;
                let found = arrays_of(&data).find(|(of, found)| of == group && found.name == array.name);
                let found = found.map(|(_, found)| found).filter(|found| found.components == array.components);
                let found = found.ok_or_else(|| ExportError::Format {
                    file: frame.display().to_string(),
                    problem: format!(
                        "it has no {} as the first frame has; export what lies before it or after it",
                        array.name
                    ),
                })?;
                all.extend(as_kind(found, array.kind));
                rows += found.tuples() as u64;
                if crate::interrupt::requested() {
                    return Err(ExportError::Interrupted);
                }
            }
            add(&file, &format!("VTKHDF/{group}{}", array.name), &all, array, rows).map_err(failed)?;
            progress((number + 1) as f64 / count as f64);
        }
        connectivity(run, files, &survey, &file, &failed)?;
        file.close().map_err(failed)?;
        progress(1.0);
        Ok(())
    });
    if let Err(error) = filled {
        // What cannot be removed is told from the file by its name.
        let _ = std::fs::remove_file(&draft);
        return Err(error);
    }
    std::fs::rename(&draft, path).map_err(|source| WriteError::new(path, source))?;
    Ok(files.len())
}

/// Arrays with their groups below `VTKHDF`.
type Grouped = Vec<(&'static str, Array)>;

/// Numbers of frames, and the arrays that the first one has, by their groups.
fn survey(run: &RunFrames, files: &[(f64, PathBuf)]) -> Result<(Survey, Grouped), ExportError> {
    let mut survey = Survey::default();
    for (time, file) in files {
        let data = run.read_some(file, &|_, _| false)?;
        survey.times.push(*time);
        survey.points.push(data.points as i64);
        survey.cells.push(data.cells as i64);
        if data.cells > 0 {
            survey.topology = TOPOLOGIES.iter().position(|(_, of)| *of == data.topology).unwrap_or(0);
            survey.corners = data.corners as i64;
        }
    }
    let first = run.read_some(&files[0].1, &|_, _| true)?;
    let arrays =
        arrays_of(&first).map(|(group, array)| (group, Array { bytes: Vec::new(), ..array.clone() })).collect();
    Ok((survey, arrays))
}

/// Poses of driven walls, in arrays over all frames, each with the number of its tuples in each frame; none where no wall is driven.
fn poses(run: &RunFrames, files: &[(f64, PathBuf)]) -> Result<Vec<(Array, Vec<i64>)>, ExportError> {
    let mut all: Vec<(Array, Vec<i64>)> = Vec::new();
    for (_, file) in files {
        let data = run.read_some(file, &|section, name| section == FIELD_DATA && DRIVEN_WALLS.contains(&name))?;
        let own =
            data.sections.into_iter().filter(|(section, _)| *section == FIELD_DATA).flat_map(|(_, arrays)| arrays);
        for array in own {
            let tuples = array.tuples() as i64;
            match all.iter_mut().find(|(known, _)| known.name == array.name) {
                Some((known, counts)) => {
                    known.bytes.extend(as_kind(&array, known.kind));
                    counts.push(tuples);
                }
                None => all.push((array, vec![tuples])),
            }
        }
    }
    match all.iter().all(|(_, counts)| counts.len() == files.len()) {
        true => Ok(all),
        false => Err(ExportError::Format {
            file: files[0].1.display().to_string(),
            problem: format!("not all frames have {}", DRIVEN_WALLS.join(", ")),
        }),
    }
}

/// Arrays that go into the file, each with its group below `VTKHDF`.
fn arrays_of(data: &Outline) -> impl Iterator<Item = (&'static str, &Array)> {
    let group = |section: &str| match section {
        "Points" => Some(""),
        "PointData" => Some("PointData/"),
        "CellData" => Some("CellData/"),
        _ => None,
    };
    let sections = data.sections.iter().filter_map(move |(section, arrays)| Some((group(section)?, arrays)));
    sections.flat_map(|(group, arrays)| arrays.iter().map(move |array| (group, array)))
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
    for (place, (name, _)) in TOPOLOGIES.iter().enumerate() {
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
    files: &[(f64, PathBuf)],
    survey: &Survey,
    file: &File,
    failed: &dyn Fn(hdf5_pure::Error) -> ExportError,
) -> Result<(), ExportError> {
    let (mut corners, mut offsets): (Vec<i64>, Vec<i64>) = (Vec::new(), Vec::new());
    for ((_, frame), (points, cells)) in files.iter().zip(survey.points.iter().zip(&survey.cells)) {
        match TOPOLOGIES[survey.topology].1 {
            "Polys" => {
                let data = run.read_some(frame, &|_, name| name == "connectivity")?;
                let arrays = data.sections.iter().filter(|(section, _)| *section == "Polys");
                corners
                    .extend(arrays.flat_map(|(_, arrays)| arrays).flat_map(Array::values).map(|corner| corner as i64));
            }
            _ => corners.extend(0..*points),
        }
        offsets.extend((0..=*cells).map(|cell| cell * survey.corners));
    }
    let group = format!("VTKHDF/{}", TOPOLOGIES[survey.topology].0);
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
