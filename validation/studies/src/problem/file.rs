//! Files of contact problems in the layout of FCLIB (HDF5): one table of fields defines writing and reading. Every fault of a
//! file is an error that names it.

use super::{BodyVelocities, ProblemFile, compressed_columns};
use hdf5_pure::{File, FileBuilder, LibVer};
use makadam::checkpoint::checksum as fnv1a;
use makadam::problem::{Body, Contact, ContactProblem, LocalProblem, MatrixBlock};
use makadam_frames::output::{WriteError, write_durably};
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Error of a file without a solvable problem.
#[derive(Debug, thiserror::Error)]
pub enum ProblemFileError {
    /// The file cannot be read.
    #[error("{}: {source}; check the path and that the file may be read", path.display())]
    Io {
        /// File.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The content is wrong.
    #[error("{}: {problem}; write it anew with makadam lab problem export, or copy it again", path.display())]
    Content {
        /// File.
        path: PathBuf,
        /// Fault.
        problem: String,
    },
}

/// Numbers of a dataset in rows of columns. Whole numbers have 32 bits in files.
#[derive(Clone, Debug, Default, PartialEq)]
struct Numbers {
    is_whole: bool,
    columns: usize,
    values: Vec<f64>,
}

/// Datasets by their paths.
type Datasets = BTreeMap<&'static str, Numbers>;

/// Path and number of columns of a dataset, and true if its numbers are integers.
type Described = (&'static str, usize, bool);

const CHECKSUM: &str = "makadam/checksum";
const TITLE: &str = "fclib_local/info/title";
/// Impulses of a solution, which do not belong to the problem.
const SOLUTION: &str = "solution/r";
/// Version of the group `makadam`.
const VERSION: i32 = 1;
/// Version with tangential springs, which a reader of the first one would ignore.
const VERSION_WITH_SPRINGS: i32 = 2;

/// Real field of bodies or contacts: its path, and the numbers of a row.
struct Field<T>(&'static str, fn(&mut T) -> Vec<&mut f64>);

impl<T: Copy + Default> Field<T> {
    fn described(&self) -> Described {
        (self.0, (self.1)(&mut T::default()).len(), false)
    }
}

/// Fields of bodies; blocks are symmetric, so that rows are columns.
const BODY: [Field<Body>; 4] = [
    Field("makadam/bodies/inverse_mass", |body| body.inverse_mass.iter_mut().collect()),
    Field("makadam/bodies/inverse_inertia", |body| body.inverse_inertia.iter_mut().collect()),
    Field("makadam/bodies/velocity", |body| body.velocity.iter_mut().collect()),
    Field("makadam/bodies/spin", |body| body.spin.iter_mut().collect()),
];

const CONTACT: [Field<Contact>; 15] = [
    Field("makadam/contacts/normal", |contact| contact.normal.iter_mut().collect()),
    Field("makadam/contacts/tangents", |contact| contact.tangents.iter_mut().flatten().collect()),
    Field("makadam/contacts/first_arm", |contact| contact.arms[0].iter_mut().collect()),
    Field("makadam/contacts/second_arm", |contact| contact.arms[1].iter_mut().collect()),
    Field("makadam/contacts/wall_velocity", |contact| contact.wall_velocity.iter_mut().collect()),
    Field("makadam/contacts/wall_spin", |contact| contact.wall_spin.iter_mut().collect()),
    Field("makadam/contacts/bias", |contact| vec![&mut contact.bias]),
    Field("makadam/contacts/compliance", |contact| vec![&mut contact.compliance]),
    Field("makadam/contacts/friction", |contact| vec![&mut contact.friction]),
    Field("makadam/contacts/rolling_lever", |contact| vec![&mut contact.rolling_lever]),
    Field("makadam/contacts/twisting_lever", |contact| vec![&mut contact.twisting_lever]),
    Field("makadam/contacts/pull", |contact| vec![&mut contact.pull]),
    Field("makadam/contacts/normal_impulse", |contact| vec![&mut contact.impulse.normal]),
    Field("makadam/contacts/tangential_impulse", |contact| contact.impulse.tangential.iter_mut().collect()),
    Field("makadam/contacts/angular_impulse", |contact| contact.impulse.angular.iter_mut().collect()),
];

/// Tangential springs, in files of the second version.
const SPRINGS: [Field<Contact>; 2] = [
    Field("makadam/contacts/tangential_compliance", |contact| vec![&mut contact.tangential_compliance]),
    Field("makadam/contacts/tangential_bias", |contact| contact.tangential_bias.iter_mut().collect()),
];

/// Numbers of the bodies of contacts; the second one is -1 for a wall.
const ENDS: [Described; 2] = [("makadam/contacts/first", 1, true), ("makadam/contacts/second", 1, true)];

/// Numbers of the whole problem.
const GENERAL: [Described; 5] = [
    ("makadam/version", 1, true),
    ("makadam/grains", 1, true),
    ("makadam/time", 1, false),
    ("makadam/step", 1, false),
    ("makadam/unit", 1, false),
];

/// Answer of the sweeps over lanes.
const LANES: [Described; 2] = [("makadam/lanes/velocity", 3, false), ("makadam/lanes/spin", 3, false)];

/// FCLIB's group.
const LOCAL: [Described; 10] = [
    ("fclib_local/spacedim", 1, true),
    ("fclib_local/W/nzmax", 1, true),
    ("fclib_local/W/m", 1, true),
    ("fclib_local/W/n", 1, true),
    ("fclib_local/W/nz", 1, true),
    ("fclib_local/W/p", 1, true),
    ("fclib_local/W/i", 1, true),
    ("fclib_local/W/x", 1, false),
    ("fclib_local/vectors/q", 1, false),
    ("fclib_local/vectors/mu", 1, false),
];

const DESCRIPTION: &str = "One time step of Makadam. Impulses r (N s) and velocities u (m/s) are in the frames of contacts, normal \
                           first, from the first body to the second; q holds velocities before the contacts act less the biases \
                           of the normals; the compliance of normals stands on the diagonal of W.";

/// FNV-1a, 64 bits, over the paths and the numbers of all datasets in the order of their paths.
fn checksum(datasets: &Datasets) -> u64 {
    let mut bytes = Vec::new();
    for (path, Numbers { is_whole, values, .. }) in datasets {
        bytes.extend(path.as_bytes());
        match is_whole {
            true => bytes.extend(values.iter().flat_map(|&value| (value as i32).to_le_bytes())),
            false => bytes.extend(values.iter().flat_map(|value| value.to_bits().to_le_bytes())),
        }
    }
    fnv1a(&bytes)
}

/// Writes a file, with the impulses of a solution in the frames of the contacts if there is one.
pub fn write(path: &Path, file: &ProblemFile, solution: Option<&[Vector3<f64>]>) -> Result<(), WriteError> {
    let bytes =
        bytes(file, solution).map_err(|error| WriteError::new(path, std::io::Error::other(error.to_string())))?;
    write_durably(path, &bytes)
}

/// Returns the bytes of a file.
///
/// # Errors
/// [`hdf5_pure::Error`] if HDF5 cannot hold the numbers.
pub fn bytes(file: &ProblemFile, solution: Option<&[Vector3<f64>]>) -> Result<Vec<u8>, hdf5_pure::Error> {
    let mut datasets = Datasets::new();
    if let Some(problem) = &file.contact {
        put_problem(&mut datasets, problem);
    }
    if let Some(BodyVelocities { velocities, spins }) = &file.lanes {
        put(&mut datasets, LANES, [flat(velocities), flat(spins)]);
    }
    if let Some(local) = &file.local {
        // W in compressed columns.
        let (starts, indices, values) = compressed_columns(local);
        let (rows, entries) = (3.0 * local.offset.len() as f64, values.len() as f64);
        let whole = |numbers: Vec<usize>| numbers.into_iter().map(|number| number as f64).collect();
        let matrix =
            [vec![3.0], vec![entries], vec![rows], vec![rows], vec![-1.0], whole(starts), whole(indices), values];
        let vectors = [flat(&local.offset), local.friction.clone()];
        put(&mut datasets, LOCAL, matrix.into_iter().chain(vectors));
    }
    let sum = checksum(&datasets);
    if let (Some(local), Some(impulses)) = (&file.local, solution) {
        let described = [(SOLUTION, 1, false), ("solution/u", 1, false)];
        put(&mut datasets, described, [flat(impulses), flat(&local.velocities(impulses))]);
    }
    // Groups, by their paths; inner groups are added to their parents once complete.
    let mut builder = FileBuilder::new();
    // Features that HDF5 reads since 1.8.
    builder.with_libver_bounds(LibVer::Earliest, LibVer::V18);
    let mut groups = BTreeMap::new();
    let title = file.local.as_ref().map(|_| TITLE);
    for path in datasets.keys().copied().chain(title) {
        let mut folder = path;
        while let Some((parent, _)) = folder.rsplit_once('/') {
            let name = parent.rsplit('/').next().unwrap_or(parent);
            groups.entry(parent).or_insert_with(|| builder.create_group(name));
            folder = parent;
        }
    }
    for (path, Numbers { is_whole, columns, values }) in &datasets {
        let Some((folder, name)) = path.rsplit_once('/') else { continue };
        let Some(group) = groups.get_mut(folder) else { continue };
        let dataset = group.create_dataset(name);
        match is_whole {
            true => dataset.with_i32_data(&values.iter().map(|&value| value as i32).collect::<Vec<i32>>()),
            false => dataset.with_f64_data(values),
        };
        if *columns > 1 {
            dataset.with_shape(&[(values.len() / columns) as u64, *columns as u64]);
        }
    }
    if let Some(info) = groups.get_mut("fclib_local/info") {
        info.create_dataset("title").with_strings(&[&file.title])?;
        info.create_dataset("description").with_ascii_strings(&[DESCRIPTION])?;
    }
    if let Some(group) = groups.get_mut("makadam") {
        group.create_dataset("title").with_strings(&[&file.title])?;
        group.create_dataset("checksum").with_u64_data(&[sum]);
    }
    // From the innermost outwards: a path sorts before the paths inside it.
    while let Some((path, group)) = groups.pop_last() {
        let done = group.finish();
        match path.rsplit_once('/').and_then(|(parent, _)| groups.get_mut(parent)) {
            Some(parent) => {
                parent.add_group(done);
            }
            None => builder.add_group(done),
        }
    }
    builder.finish()
}

fn put(
    datasets: &mut Datasets,
    described: impl IntoIterator<Item = Described>,
    values: impl IntoIterator<Item = Vec<f64>>,
) {
    let numbers = |((path, columns, is_whole), values)| (path, Numbers { is_whole, columns, values });
    datasets.extend(described.into_iter().zip(values).map(numbers));
}

fn put_problem(datasets: &mut Datasets, problem: &ContactProblem) {
    let ContactProblem { time, step, unit, grains, bodies, contacts } = problem;
    let has_springs = contacts.iter().any(|contact| contact.tangential_compliance != 0.0);
    let version = if has_springs { VERSION_WITH_SPRINGS } else { VERSION };
    let general = [f64::from(version), *grains as f64, *time, *step, *unit];
    put(datasets, GENERAL, general.map(|number| vec![number]));
    let firsts = contacts.iter().map(|contact| contact.first as f64).collect();
    let seconds = contacts.iter().map(|contact| contact.second.map_or(-1.0, |body| body as f64)).collect();
    put(datasets, ENDS, [firsts, seconds]);
    put_rows(datasets, &BODY, bodies);
    put_rows(datasets, &CONTACT, contacts);
    if has_springs {
        put_rows(datasets, &SPRINGS, contacts);
    }
}

fn put_rows<T: Copy + Default>(datasets: &mut Datasets, fields: &[Field<T>], rows: &[T]) {
    let values = |Field(_, numbers): &Field<T>| {
        rows.iter()
            .flat_map(|&(mut row)| numbers(&mut row).into_iter().map(|number| *number).collect::<Vec<f64>>())
            .collect()
    };
    put(datasets, fields.iter().map(Field::described), fields.iter().map(values));
}

fn flat(vectors: &[Vector3<f64>]) -> Vec<f64> {
    vectors.iter().flatten().copied().collect()
}

/// Limit of the numbers of a dataset over the bytes of its file: no compression of a problem exceeds it.
const MOST_NUMBERS_PER_BYTE: u64 = 100;

/// Reads a file.
///
/// # Errors
/// [`ProblemFileError`] that names the file and its fault.
pub fn read(path: &Path) -> Result<ProblemFile, ProblemFileError> {
    let bytes = std::fs::read(path).map_err(|source| ProblemFileError::Io { path: path.into(), source })?;
    parse(bytes).map_err(|problem| ProblemFileError::Content { path: path.into(), problem })
}

fn open(bytes: Vec<u8>) -> Result<File, String> {
    File::from_bytes(bytes).map_err(|error| format!("it is no HDF5 file, or not all of one ({error})"))
}

/// Parses the bytes of a file.
pub fn parse(bytes: Vec<u8>) -> Result<ProblemFile, String> {
    let most = MOST_NUMBERS_PER_BYTE.saturating_mul(bytes.len() as u64);
    let file = open(bytes)?;
    let groups = file.root().groups().map_err(|error| error.to_string())?;
    let [has_bodies, has_local, has_global] =
        ["makadam", "fclib_local", "fclib_global"].map(|name| groups.iter().any(|group| group == name));
    if !has_bodies && !has_local {
        return Err(match has_global {
            true => "it holds a global problem of FCLIB; only local ones, fclib_local, can be solved".into(),
            false => "it has neither of the groups makadam and fclib_local".into(),
        });
    }
    let mut datasets = Datasets::new();
    let mut take = |described: Vec<Described>| {
        for (path, columns, is_whole) in described {
            let values =
                values(&file, most, path, columns, is_whole).map_err(|problem| format!("{path}: {problem}"))?;
            datasets.insert(path, Numbers { is_whole, columns, values });
        }
        Ok::<usize, String>(integer(&datasets, GENERAL[0].0).unwrap_or_default())
    };
    if has_bodies {
        let bodies = BODY.iter().map(Field::described);
        let contacts = CONTACT.iter().map(Field::described);
        let version = take(GENERAL.into_iter().chain(bodies).chain(ENDS).chain(contacts).collect())?;
        if version == VERSION_WITH_SPRINGS as usize {
            take(SPRINGS.iter().map(Field::described).collect())?;
        }
        let within = file.group("makadam").and_then(|group| group.groups()).map_err(|error| error.to_string())?;
        if within.iter().any(|name| name == "lanes") {
            take(LANES.into())?;
        }
    }
    if has_local {
        take(LOCAL.into())?;
    }
    let contact = if has_bodies {
        let sum = file.dataset(CHECKSUM).and_then(|dataset| dataset.read_u64());
        if sum.ok() != Some(vec![checksum(&datasets)]) {
            return Err("its numbers do not have the checksum that it carries".into());
        }
        Some(problem_with_bodies(&datasets)?)
    } else {
        None
    };
    let local = has_local.then(|| local_problem(&datasets, contact.as_ref())).transpose()?;
    let [velocities, spins] = LANES.map(|(path, ..)| vectors(&datasets, path));
    let lanes = datasets.contains_key(LANES[0].0).then_some(BodyVelocities { velocities, spins });
    if let (Some(lanes), Some(contact)) = (&lanes, &contact)
        && [&lanes.velocities, &lanes.spins].into_iter().any(|vectors| vectors.len() != contact.bodies.len())
    {
        return Err("makadam/lanes has not one row for each body".into());
    }
    let title = if has_bodies { "makadam/title" } else { TITLE };
    let title = file.dataset(title).and_then(|dataset| dataset.read_string()).unwrap_or_default();
    Ok(ProblemFile { title: title.into_iter().next().unwrap_or_default(), contact, local, lanes })
}

/// Returns the impulses of the solution in a file, in the frames of the contacts, N s: FCLIB's `solution/r`.
pub fn solution(bytes: Vec<u8>) -> Result<Vec<Vector3<f64>>, String> {
    let numbers = open(bytes)?.dataset(SOLUTION).and_then(|dataset| dataset.read_f64());
    let numbers = numbers.map_err(|error| format!("{SOLUTION}: {error}"))?;
    Ok(numbers.chunks_exact(3).map(Vector3::from_column_slice).collect())
}

/// Reads the numbers of a dataset, at most `most` of them.
fn values(file: &File, most: u64, path: &str, columns: usize, is_whole: bool) -> Result<Vec<f64>, String> {
    let dataset = file.dataset(path).map_err(|error| error.to_string())?;
    let shape = dataset.shape().map_err(|error| error.to_string())?;
    let count = shape.iter().try_fold(1_u64, |product, &size| product.checked_mul(size));
    if count.is_none_or(|count| count > most) {
        return Err(format!("a shape of {shape:?} is more than the file can hold"));
    }
    if columns > 1 && (shape.len() != 2 || shape[1] != columns as u64) {
        return Err(format!("a shape of {shape:?}, where rows have {columns} columns"));
    }
    let numbers = match is_whole {
        true => dataset.read_i32().map(|numbers| numbers.into_iter().map(f64::from).collect()),
        false => dataset.read_f64(),
    };
    numbers.map_err(|error| error.to_string())
}

/// Numbers of a dataset; none if it is missing.
fn numbers<'a>(datasets: &'a Datasets, path: &str) -> &'a [f64] {
    datasets.get(path).map_or(&[], |numbers| &numbers.values)
}

fn vectors(datasets: &Datasets, path: &str) -> Vec<Vector3<f64>> {
    numbers(datasets, path).chunks_exact(3).map(Vector3::from_column_slice).collect()
}

fn scalar(datasets: &Datasets, path: &str) -> Result<f64, String> {
    numbers(datasets, path).first().copied().ok_or_else(|| format!("{path} is empty"))
}

/// Converts an integer to an index; none below zero.
fn place(number: f64) -> Option<usize> {
    (number >= 0.0).then_some(number as usize)
}

fn integer(datasets: &Datasets, path: &str) -> Result<usize, String> {
    let number = scalar(datasets, path)?;
    place(number).ok_or_else(|| format!("{path} is {number}"))
}

fn problem_with_bodies(datasets: &Datasets) -> Result<ContactProblem, String> {
    let version = integer(datasets, "makadam/version")?;
    if ![VERSION, VERSION_WITH_SPRINGS].map(|known| known as usize).contains(&version) {
        return Err(format!(
            "makadam/version is {version}; this program reads versions {VERSION} and {VERSION_WITH_SPRINGS}"
        ));
    }
    let mut bodies = vec![Body::default(); numbers(datasets, BODY[2].0).len() / 3];
    fill(datasets, &BODY, &mut bodies)?;
    let [firsts, seconds] = ENDS.map(|(path, ..)| numbers(datasets, path));
    if seconds.len() != firsts.len() {
        return Err(format!("{} has {} rows, {} has {}", ENDS[1].0, seconds.len(), ENDS[0].0, firsts.len()));
    }
    let ends = firsts.iter().zip(seconds).enumerate();
    let contact = |(number, (&first, &second))| match place(first) {
        Some(first) => Ok(Contact { first, second: place(second), ..Contact::default() }),
        None => Err(format!("contact {number} names body {first}")),
    };
    let mut contacts = ends.map(contact).collect::<Result<Vec<Contact>, String>>()?;
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
        let (numbers, count) = (numbers(datasets, path), rows.len());
        if numbers.len() != columns * count {
            return Err(format!("{path} has {} rows, where its group has {count}", numbers.len() / columns));
        }
        for (row, numbers) in rows.iter_mut().zip(numbers.chunks_exact(columns)) {
            (field.1)(row).into_iter().zip(numbers).for_each(|(slot, number)| *slot = *number);
        }
    }
    Ok(())
}

/// Returns FCLIB's local problem; its initial values are known only with bodies.
fn local_problem(datasets: &Datasets, contact: Option<&ContactProblem>) -> Result<LocalProblem, String> {
    let dimension = integer(datasets, "fclib_local/spacedim")?;
    if dimension != 3 {
        return Err(format!("fclib_local/spacedim is {dimension}; only problems in three dimensions can be solved"));
    }
    let [rows, columns] = [integer(datasets, "fclib_local/W/m")?, integer(datasets, "fclib_local/W/n")?];
    let offset = vectors(datasets, "fclib_local/vectors/q");
    let friction = numbers(datasets, "fclib_local/vectors/mu").to_vec();
    let lengths = [rows, columns, numbers(datasets, "fclib_local/vectors/q").len(), 3 * friction.len()];
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

/// Entries of W in any of FCLIB's three forms: compressed columns (-1), compressed rows (-2), triplets.
fn entries(datasets: &Datasets, size: usize) -> Result<Vec<(usize, usize, f64)>, String> {
    let [starts, across, values, form] =
        ["p", "i", "x", "nz"].map(|name| numbers(datasets, format!("fclib_local/W/{name}").as_str()));
    let form = form.first().copied().unwrap_or(-3.0);
    let most = across.len().min(values.len());
    let lines: Vec<f64> = if form == -1.0 || form == -2.0 {
        let falls = starts.windows(2).any(|pair| pair[0] > pair[1]);
        let end = starts.last().copied().and_then(place);
        if starts.len() != size + 1 || starts[0] != 0.0 || falls || end.is_none_or(|end| end > most) {
            return Err("fclib_local/W/p does not divide its entries among columns or rows".into());
        }
        let line = |(line, pair): (usize, &[f64])| vec![line as f64; (pair[1] - pair[0]) as usize];
        starts.windows(2).enumerate().flat_map(line).collect()
    } else {
        let count = place(form).filter(|&count| count <= most.min(starts.len()));
        starts[..count.ok_or("fclib_local/W/nz is no number of its entries")?].to_vec()
    };
    let index = |index: f64| match place(index) {
        Some(place) if place < size => Ok(place),
        _ => Err(format!("W has an index {index} where there are {size} rows")),
    };
    let entry = |((&line, &across), &value)| {
        let (line, across) = (index(line)?, index(across)?);
        Ok(if form == -1.0 { (across, line, value) } else { (line, across, value) })
    };
    lines.iter().zip(across).zip(values).map(entry).collect()
}
