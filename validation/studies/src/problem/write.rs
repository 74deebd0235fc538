//! Writer of problem files.

use super::layout::{
    BODY, CONTACT, Datasets, ENDS, Field, LANES, LOCAL, Numbers, SOLUTION, SPRINGS, TITLE, VERSION,
    VERSION_WITH_SPRINGS, checksum, contact_problem,
};
use super::{BodyVelocities, ProblemFile, compressed_columns};
use hdf5_pure::{FileBuilder, LibVer};
use makadam::problem::{ContactProblem, LocalProblem};
use makadam_frames::output::{WriteError, write_durably};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;

const DESCRIPTION: &str = "One time step of Makadam. Impulses r (N s) and velocities u (m/s) are in the frames of contacts, normal \
                           first, from the first body to the second; q holds velocities before the contacts act less the biases \
                           of the normals; the compliance of normals stands on the diagonal of W.";

/// Writes a file, with the impulses of a solution in the frames of the contacts if there is one.
pub fn write(path: &Path, file: &ProblemFile, solution: Option<&[Vector3<f64>]>) -> Result<(), WriteError> {
    let bytes =
        bytes(file, solution).map_err(|error| WriteError::new(path, std::io::Error::other(error.to_string())))?;
    write_durably(path, &bytes)
}

/// The bytes of a file.
///
/// # Errors
/// [`hdf5_pure::Error`] if HDF5 cannot hold the numbers.
pub fn bytes(file: &ProblemFile, solution: Option<&[Vector3<f64>]>) -> Result<Vec<u8>, hdf5_pure::Error> {
    let mut datasets = Datasets::new();
    if let Some(problem) = &file.contact {
        put_problem(&mut datasets, problem);
    }
    if let Some(BodyVelocities { velocities, spins }) = &file.lanes {
        datasets.extend([(LANES[0].0, flat(velocities)), (LANES[1].0, flat(spins))]);
    }
    if let Some(local) = &file.local {
        put_local(&mut datasets, local);
    }
    let sum = checksum(&datasets);
    if let (Some(local), Some(impulses)) = (&file.local, solution) {
        datasets.insert(SOLUTION, flat(impulses));
        datasets.insert("solution/u", flat(&local.velocities(impulses)));
    }
    // Groups, by their paths; those inside of others are put into these when they are done.
    let mut builder = FileBuilder::new();
    // What HDF5 reads since 1.8.
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
    let described = contact_problem().chain(SPRINGS.iter().map(Field::described)).chain(LANES).chain(LOCAL);
    let columns: BTreeMap<&str, usize> = described.map(|(path, columns, _)| (path, columns)).collect();
    for (path, numbers) in &datasets {
        let Some((folder, name)) = path.rsplit_once('/') else { continue };
        let Some(group) = groups.get_mut(folder) else { continue };
        let dataset = group.create_dataset(name);
        let length = match numbers {
            Numbers::Real(values) => {
                dataset.with_f64_data(values);
                values.len()
            }
            Numbers::Whole(values) => {
                dataset.with_i32_data(values);
                values.len()
            }
        } as u64;
        let columns = columns.get(path).copied().unwrap_or(1) as u64;
        if columns > 1 {
            dataset.with_shape(&[length / columns, columns]);
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
    // From the innermost outwards: a path comes before those inside of it.
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

fn put_problem(datasets: &mut Datasets, problem: &ContactProblem) {
    let ContactProblem { time, step, unit, grains, bodies, contacts } = problem;
    let has_springs = contacts.iter().any(|contact| contact.tangential_compliance != 0.0);
    let version = if has_springs { VERSION_WITH_SPRINGS } else { VERSION };
    let firsts = contacts.iter().map(|contact| contact.first as i32);
    let seconds = contacts.iter().map(|contact| contact.second.map_or(-1, |body| body as i32));
    datasets.extend([
        ("makadam/version", Numbers::Whole(vec![version])),
        ("makadam/grains", Numbers::Whole(vec![*grains as i32])),
        ("makadam/time", Numbers::Real(vec![*time])),
        ("makadam/step", Numbers::Real(vec![*step])),
        ("makadam/unit", Numbers::Real(vec![*unit])),
        (ENDS[0], Numbers::Whole(firsts.collect())),
        (ENDS[1], Numbers::Whole(seconds.collect())),
    ]);
    datasets.extend(BODY.iter().map(|field| column(field, bodies)));
    datasets.extend(CONTACT.iter().map(|field| column(field, contacts)));
    if has_springs {
        datasets.extend(SPRINGS.iter().map(|field| column(field, contacts)));
    }
}

fn column<T: Copy>(Field(path, numbers): &Field<T>, rows: &[T]) -> (&'static str, Numbers) {
    let of_row = |row: &T| {
        let mut row = *row;
        numbers(&mut row).into_iter().map(|number| *number).collect::<Vec<f64>>()
    };
    (path, Numbers::Real(rows.iter().flat_map(of_row).collect()))
}

/// FCLIB's local problem, W in compressed columns.
fn put_local(datasets: &mut Datasets, local: &LocalProblem) {
    let rows = 3 * local.offset.len();
    let (starts, indices, values) = compressed_columns(local);
    let whole = |numbers: Vec<usize>| Numbers::Whole(numbers.into_iter().map(|number| number as i32).collect());
    let one = |number: usize| Numbers::Whole(vec![number as i32]);
    datasets.extend([
        ("fclib_local/spacedim", one(3)),
        ("fclib_local/W/nzmax", one(values.len())),
        ("fclib_local/W/m", one(rows)),
        ("fclib_local/W/n", one(rows)),
        // Compressed columns.
        ("fclib_local/W/nz", Numbers::Whole(vec![-1])),
        ("fclib_local/W/p", whole(starts)),
        ("fclib_local/W/i", whole(indices)),
        ("fclib_local/W/x", Numbers::Real(values)),
        ("fclib_local/vectors/q", flat(&local.offset)),
        ("fclib_local/vectors/mu", Numbers::Real(local.friction.clone())),
    ]);
}

fn flat(vectors: &[Vector3<f64>]) -> Numbers {
    Numbers::Real(vectors.iter().flatten().copied().collect())
}
