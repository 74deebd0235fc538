//! Reader of problem files. Every fault of a file is an error that names it.

use super::layout::{
    BODY, CHECKSUM, CONTACT, Datasets, Described, ENDS, Field, Kind, LANES, LOCAL, Numbers, SOLUTION, SPRINGS, TITLE,
    VERSION, VERSION_WITH_SPRINGS, checksum, contact_problem,
};
use super::{BodyVelocities, ProblemFile};
use hdf5_pure::File;
use makadam::problem::{Body, Contact, ContactProblem, LocalProblem, MatrixBlock};
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Error of a file without a problem that could be solved.
#[derive(Debug, thiserror::Error)]
pub enum ProblemFileError {
    /// It cannot be read.
    #[error("{}: {source}; check the path and that the file may be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// Its content is wrong.
    #[error("{}: {problem}; write it anew with makadam lab problem export, or copy it again", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The fault.
        problem: String,
    },
}

/// Most numbers of a dataset over the bytes of its file: more than that no compression makes of a problem.
const MOST_NUMBERS_PER_BYTE: u64 = 100;

/// Reads a file.
///
/// # Errors
/// [`ProblemFileError`] that names the file and what is wrong with it.
pub fn read(path: &Path) -> Result<ProblemFile, ProblemFileError> {
    let bytes = std::fs::read(path).map_err(|source| ProblemFileError::Io { path: path.into(), source })?;
    parse(bytes).map_err(|problem| ProblemFileError::Content { path: path.into(), problem })
}

/// Takes the bytes of a file apart.
pub fn parse(bytes: Vec<u8>) -> Result<ProblemFile, String> {
    let length = bytes.len() as u64;
    let file = File::from_bytes(bytes).map_err(|error| format!("it is no HDF5 file, or not all of one ({error})"))?;
    let reader = Reader { file, length };
    let groups = reader.file.root().groups().map_err(|error| error.to_string())?;
    let has = |name: &str| groups.iter().any(|group| group == name);
    if !has("makadam") && !has("fclib_local") {
        return Err(match has("fclib_global") {
            true => "it holds a global problem of FCLIB; only local ones, fclib_local, can be solved".into(),
            false => "it has neither of the groups makadam and fclib_local".into(),
        });
    }
    let mut datasets = Datasets::new();
    if has("makadam") {
        reader.all(contact_problem(), &mut datasets)?;
        if integer(&datasets, "makadam/version")? == VERSION_WITH_SPRINGS as usize {
            reader.all(SPRINGS.iter().map(Field::described), &mut datasets)?;
        }
        let within =
            reader.file.group("makadam").and_then(|group| group.groups()).map_err(|error| error.to_string())?;
        if within.iter().any(|name| name == "lanes") {
            reader.all(LANES, &mut datasets)?;
        }
    }
    if has("fclib_local") {
        reader.all(LOCAL, &mut datasets)?;
    }
    let contact = if has("makadam") {
        let sum = reader.file.dataset(CHECKSUM).and_then(|dataset| dataset.read_u64());
        if sum.ok() != Some(vec![checksum(&datasets)]) {
            return Err("its numbers do not have the checksum that it carries".into());
        }
        Some(problem_with_bodies(&datasets)?)
    } else {
        None
    };
    let local = match has("fclib_local") {
        true => Some(local_problem(&datasets, contact.as_ref())?),
        false => None,
    };
    let lanes = datasets
        .contains_key(LANES[0].0)
        .then(|| BodyVelocities { velocities: vectors(&datasets, LANES[0].0), spins: vectors(&datasets, LANES[1].0) });
    if let (Some(lanes), Some(contact)) = (&lanes, &contact)
        && [&lanes.velocities, &lanes.spins].into_iter().any(|vectors| vectors.len() != contact.bodies.len())
    {
        return Err("makadam/lanes has not one row for each body".into());
    }
    let title = if has("makadam") { "makadam/title" } else { TITLE };
    let title = reader.file.dataset(title).and_then(|dataset| dataset.read_string()).unwrap_or_default();
    Ok(ProblemFile { title: title.into_iter().next().unwrap_or_default(), contact, local, lanes })
}

/// The impulses of the solution that a file holds, in the frames of the contacts, N s: FCLIB's `solution/r`.
pub fn solution(bytes: Vec<u8>) -> Result<Vec<Vector3<f64>>, String> {
    let file = File::from_bytes(bytes).map_err(|error| format!("it is no HDF5 file, or not all of one ({error})"))?;
    let numbers = file.dataset(SOLUTION).and_then(|dataset| dataset.read_f64());
    let numbers = numbers.map_err(|error| format!("{SOLUTION}: {error}"))?;
    Ok(numbers.chunks_exact(3).map(Vector3::from_column_slice).collect())
}

struct Reader {
    file: File,
    /// Bytes of the file.
    length: u64,
}

impl Reader {
    fn all(&self, described: impl IntoIterator<Item = Described>, datasets: &mut Datasets) -> Result<(), String> {
        for (path, columns, kind) in described {
            let numbers = self.one(path, columns, kind).map_err(|problem| format!("{path}: {problem}"))?;
            datasets.insert(path, numbers);
        }
        Ok(())
    }

    fn one(&self, path: &str, columns: usize, kind: Kind) -> Result<Numbers, String> {
        let dataset = self.file.dataset(path).map_err(|error| error.to_string())?;
        let shape = dataset.shape().map_err(|error| error.to_string())?;
        let count = shape.iter().try_fold(1_u64, |product, &size| product.checked_mul(size));
        match count {
            Some(count) if count <= self.length.saturating_mul(MOST_NUMBERS_PER_BYTE) => {}
            _ => return Err(format!("a shape of {shape:?} is more than the file can hold")),
        }
        if columns > 1 && (shape.len() != 2 || shape[1] != columns as u64) {
            return Err(format!("a shape of {shape:?}, where rows have {columns} columns"));
        }
        match kind {
            Kind::Real => dataset.read_f64().map(Numbers::Real),
            Kind::Whole => dataset.read_i32().map(Numbers::Whole),
        }
        .map_err(|error| error.to_string())
    }
}

/// Real numbers of a dataset; none if it is not there.
fn real<'a>(datasets: &'a Datasets, path: &str) -> &'a [f64] {
    match datasets.get(path) {
        Some(Numbers::Real(values)) => values,
        _ => &[],
    }
}

/// Integers of a dataset; none if it is not there.
fn whole<'a>(datasets: &'a Datasets, path: &str) -> &'a [i32] {
    match datasets.get(path) {
        Some(Numbers::Whole(values)) => values,
        _ => &[],
    }
}

fn vectors(datasets: &Datasets, path: &str) -> Vec<Vector3<f64>> {
    real(datasets, path).chunks_exact(3).map(Vector3::from_column_slice).collect()
}

fn scalar(datasets: &Datasets, path: &str) -> Result<f64, String> {
    real(datasets, path).first().copied().ok_or_else(|| format!("{path} is empty"))
}

fn integer(datasets: &Datasets, path: &str) -> Result<usize, String> {
    let number = whole(datasets, path).first().ok_or_else(|| format!("{path} is empty"))?;
    usize::try_from(*number).map_err(|_| format!("{path} is {number}"))
}

fn problem_with_bodies(datasets: &Datasets) -> Result<ContactProblem, String> {
    let version = integer(datasets, "makadam/version")?;
    let known = [VERSION, VERSION_WITH_SPRINGS];
    if known.iter().all(|&known| version != known as usize) {
        let [first, second] = known;
        return Err(format!("makadam/version is {version}; this program reads versions {first} and {second}"));
    }
    let mut bodies = vec![Body::default(); real(datasets, BODY[2].0).len() / 3];
    fill(datasets, &BODY, &mut bodies)?;
    let [firsts, seconds] = ENDS.map(|path| whole(datasets, path));
    let mut contacts = vec![Contact::default(); firsts.len()];
    if seconds.len() != firsts.len() {
        return Err(format!("{} has {} rows, {} has {}", ENDS[1], seconds.len(), ENDS[0], firsts.len()));
    }
    for (number, contact) in contacts.iter_mut().enumerate() {
        let first = firsts[number];
        contact.first = usize::try_from(first).map_err(|_| format!("contact {number} names body {first}"))?;
        contact.second = usize::try_from(seconds[number]).ok();
    }
    fill(datasets, &CONTACT, &mut contacts)?;
    if version == VERSION_WITH_SPRINGS as usize {
        fill(datasets, &SPRINGS, &mut contacts)?;
    }
    let problem = ContactProblem {
        time: scalar(datasets, "makadam/time")?,
        step: scalar(datasets, "makadam/step")?,
        unit: scalar(datasets, "makadam/unit")?,
        grains: integer(datasets, "makadam/grains")?,
        bodies,
        contacts,
    };
    problem.check()?;
    Ok(problem)
}

/// Sets the fields of all rows; every dataset must have as many rows.
fn fill<T: Copy + Default>(datasets: &Datasets, fields: &[Field<T>], rows: &mut [T]) -> Result<(), String> {
    for field in fields {
        let (path, columns, _) = field.described();
        let (numbers, count) = (real(datasets, path), rows.len());
        if numbers.len() != columns * count {
            return Err(format!("{path} has {} rows, where its group has {count}", numbers.len() / columns));
        }
        for (row, numbers) in rows.iter_mut().zip(numbers.chunks_exact(columns)) {
            (field.1)(row).into_iter().zip(numbers).for_each(|(slot, number)| *slot = *number);
        }
    }
    Ok(())
}

/// FCLIB's local problem; what it starts from is known where there are bodies.
fn local_problem(datasets: &Datasets, contact: Option<&ContactProblem>) -> Result<LocalProblem, String> {
    let dimension = integer(datasets, "fclib_local/spacedim")?;
    if dimension != 3 {
        return Err(format!("fclib_local/spacedim is {dimension}; only problems in three dimensions can be solved"));
    }
    let [rows, columns] = [integer(datasets, "fclib_local/W/m")?, integer(datasets, "fclib_local/W/n")?];
    let offset = vectors(datasets, "fclib_local/vectors/q");
    let friction = real(datasets, "fclib_local/vectors/mu").to_vec();
    let lengths = [rows, columns, real(datasets, "fclib_local/vectors/q").len(), 3 * friction.len()];
    if lengths.iter().any(|&length| length != 3 * offset.len()) {
        return Err(format!("W has {rows} rows and {columns} columns, q {} rows, mu {}", lengths[2], friction.len()));
    }
    let mut blocks = BTreeMap::new();
    for (row, column, value) in entries(datasets, rows)? {
        let block = blocks.entry((column / 3, row / 3)).or_insert_with(Matrix3::<f64>::zeros);
        block[(row % 3, column % 3)] += value;
    }
    let numbers = friction.iter().chain(offset.iter().flatten()).chain(blocks.values().flatten());
    if !numbers.copied().all(f64::is_finite) || friction.iter().any(|&coefficient| coefficient < 0.0) {
        return Err("fclib_local has a number that is not finite, or a coefficient of friction below zero".into());
    }
    let still = |contact: usize| blocks.get(&(contact, contact)).is_none_or(|block| block.diagonal().min() <= 0.0);
    if let Some(contact) = (0..offset.len()).find(|&contact| still(contact)) {
        return Err(format!("W has no positive diagonal at contact {contact}"));
    }
    let (impulses, contacts) = match contact.map(ContactProblem::local) {
        Some(own) if own.contacts.len() != offset.len() => {
            return Err(format!("fclib_local has {} contacts, makadam {}", offset.len(), own.contacts.len()));
        }
        Some(own) => (own.impulses, own.contacts),
        None => (vec![Vector3::zeros(); offset.len()], (0..offset.len()).collect()),
    };
    let block = |((column, row), values)| MatrixBlock { row, column, values };
    Ok(LocalProblem { blocks: blocks.into_iter().map(block).collect(), offset, friction, impulses, contacts })
}

/// Entries of W, whichever of FCLIB's three forms it has: compressed columns (-1), compressed rows (-2), triplets.
fn entries(datasets: &Datasets, size: usize) -> Result<Vec<(usize, usize, f64)>, String> {
    let [starts, indices] = ["fclib_local/W/p", "fclib_local/W/i"].map(|path| whole(datasets, path));
    let values = real(datasets, "fclib_local/W/x");
    let form = whole(datasets, "fclib_local/W/nz").first().copied().unwrap_or(-3);
    let place = |index: i32| match usize::try_from(index) {
        Ok(place) if place < size => Ok(place),
        _ => Err(format!("W has an index {index} where there are {size} rows")),
    };
    let mut entries = Vec::with_capacity(values.len());
    match form {
        -1 | -2 => {
            let falls = starts.windows(2).any(|pair| pair[0] > pair[1]);
            let end = starts.last().and_then(|&end| usize::try_from(end).ok()).unwrap_or(usize::MAX);
            if starts.len() != size + 1 || starts[0] != 0 || falls || end > values.len().min(indices.len()) {
                return Err("fclib_local/W/p does not divide its entries among columns or rows".into());
            }
            for (line, pair) in starts.windows(2).enumerate() {
                for entry in pair[0] as usize..pair[1] as usize {
                    let across = place(indices[entry])?;
                    let (row, column) = if form == -1 { (across, line) } else { (line, across) };
                    entries.push((row, column, values[entry]));
                }
            }
        }
        count => {
            let count = usize::try_from(count).unwrap_or(usize::MAX);
            if count > starts.len().min(indices.len()).min(values.len()) {
                return Err("fclib_local/W/nz is no number of its entries".into());
            }
            for entry in 0..count {
                entries.push((place(starts[entry])?, place(indices[entry])?, values[entry]));
            }
        }
    }
    Ok(entries)
}
