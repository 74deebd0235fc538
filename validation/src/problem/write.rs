//! Problems into files: the datasets, their paths and columns, the checksum over them, and the writer.

use super::{BodyVelocities, ProblemFile, compressed_columns};
use crate::output::{WriteError, write_durably};
use hdf5_pure::{FileBuilder, LibVer};
use makadam::checkpoint::checksum as fnv1a;
use makadam::problem::{Body, Contact, ContactProblem, LocalProblem};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;

/// Numbers of a dataset.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Numbers {
    /// IEEE double precision.
    Real(Vec<f64>),
    /// Integers of 32 bits.
    Whole(Vec<i32>),
}

/// Datasets by their paths.
pub(super) type Datasets = BTreeMap<&'static str, Numbers>;

/// Path of the checksum.
pub(super) const CHECKSUM: &str = "makadam/checksum";

/// Path of the title for FCLIB.
pub(super) const TITLE: &str = "fclib_local/info/title";

/// Impulses of a solution, which are no part of the problem.
pub(super) const SOLUTION: &str = "solution/r";

/// Version of the layout below `makadam`.
pub(super) const VERSION: i32 = 1;

/// Version with tangential springs, which a reader of the first one would ignore.
pub(super) const VERSION_WITH_SPRINGS: i32 = 2;

/// The group of bodies and contacts, the number of columns after each name.
pub(super) const CONTACT_PROBLEM: [(&str, usize, Kind); 26] = [
    ("makadam/version", 1, Kind::Whole),
    ("makadam/grains", 1, Kind::Whole),
    ("makadam/time", 1, Kind::Real),
    ("makadam/step", 1, Kind::Real),
    ("makadam/unit", 1, Kind::Real),
    ("makadam/bodies/inverse_mass", 9, Kind::Real),
    ("makadam/bodies/inverse_inertia", 9, Kind::Real),
    ("makadam/bodies/velocity", 3, Kind::Real),
    ("makadam/bodies/spin", 3, Kind::Real),
    ("makadam/contacts/first", 1, Kind::Whole),
    ("makadam/contacts/second", 1, Kind::Whole),
    ("makadam/contacts/normal", 3, Kind::Real),
    ("makadam/contacts/tangents", 6, Kind::Real),
    ("makadam/contacts/first_arm", 3, Kind::Real),
    ("makadam/contacts/second_arm", 3, Kind::Real),
    ("makadam/contacts/wall_velocity", 3, Kind::Real),
    ("makadam/contacts/wall_spin", 3, Kind::Real),
    ("makadam/contacts/bias", 1, Kind::Real),
    ("makadam/contacts/compliance", 1, Kind::Real),
    ("makadam/contacts/friction", 1, Kind::Real),
    ("makadam/contacts/rolling_lever", 1, Kind::Real),
    ("makadam/contacts/twisting_lever", 1, Kind::Real),
    ("makadam/contacts/pull", 1, Kind::Real),
    ("makadam/contacts/normal_impulse", 1, Kind::Real),
    ("makadam/contacts/tangential_impulse", 3, Kind::Real),
    ("makadam/contacts/angular_impulse", 3, Kind::Real),
];

/// Tangential springs, in files of the second version.
pub(super) const SPRINGS: [(&str, usize, Kind); 2] =
    [("makadam/contacts/tangential_compliance", 1, Kind::Real), ("makadam/contacts/tangential_bias", 3, Kind::Real)];

/// Answer of the sweeps over lanes.
pub(super) const LANES: [(&str, usize, Kind); 2] =
    [("makadam/lanes/velocity", 3, Kind::Real), ("makadam/lanes/spin", 3, Kind::Real)];

/// FCLIB's group.
pub(super) const LOCAL: [(&str, usize, Kind); 10] = [
    ("fclib_local/spacedim", 1, Kind::Whole),
    ("fclib_local/W/nzmax", 1, Kind::Whole),
    ("fclib_local/W/m", 1, Kind::Whole),
    ("fclib_local/W/n", 1, Kind::Whole),
    ("fclib_local/W/nz", 1, Kind::Whole),
    ("fclib_local/W/p", 1, Kind::Whole),
    ("fclib_local/W/i", 1, Kind::Whole),
    ("fclib_local/W/x", 1, Kind::Real),
    ("fclib_local/vectors/q", 1, Kind::Real),
    ("fclib_local/vectors/mu", 1, Kind::Real),
];

/// Type of the numbers of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Real,
    Whole,
}

/// FNV-1a, 64 bits, over the paths and the numbers of all datasets in the order of their paths.
pub(super) fn checksum(datasets: &Datasets) -> u64 {
    let mut bytes = Vec::new();
    for (path, numbers) in datasets {
        bytes.extend(path.as_bytes());
        match numbers {
            Numbers::Real(values) => bytes.extend(values.iter().flat_map(|value| value.to_bits().to_le_bytes())),
            Numbers::Whole(values) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        }
    }
    fnv1a(&bytes)
}

const DESCRIPTION: &str = "One time step of Makadam. Impulses r (N s) and velocities u (m/s) are in the frames of contacts, normal \
                           first, from the first body to the second; q holds velocities before the contacts act less the biases \
                           of the normals; the compliance of normals stands on the diagonal of W.";

/// Writes a file, with the impulses of a solution in the frames of the contacts if there is one.
///
/// # Errors
/// [`WriteError`] if the system refuses.
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
        datasets.insert("makadam/lanes/velocity", flat(velocities));
        datasets.insert("makadam/lanes/spin", flat(spins));
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
    let columns: BTreeMap<&str, usize> = CONTACT_PROBLEM
        .iter()
        .chain(&SPRINGS)
        .chain(&LANES)
        .chain(&LOCAL)
        .map(|(path, columns, _)| (*path, *columns))
        .collect();
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
    let body = |of: fn(&Body) -> Vec<f64>| Numbers::Real(bodies.iter().flat_map(of).collect());
    let contact = |of: fn(&Contact) -> Vec<f64>| Numbers::Real(contacts.iter().flat_map(of).collect());
    let whole = |of: fn(&Contact) -> i32| Numbers::Whole(contacts.iter().map(of).collect());
    let second = |contact: &Contact| contact.second.map_or(-1, |body| body as i32);
    let tangents = |contact: &Contact| contact.tangents.iter().flatten().copied().collect();
    let springs = contacts.iter().any(|contact| contact.tangential_compliance != 0.0);
    let version = if springs { VERSION_WITH_SPRINGS } else { VERSION };
    if springs {
        let [compliance, bias] = SPRINGS.map(|(path, ..)| path);
        datasets.insert(compliance, contact(|contact| vec![contact.tangential_compliance]));
        datasets.insert(bias, contact(|contact| contact.tangential_bias.as_slice().to_vec()));
    }
    datasets.extend([
        ("makadam/version", Numbers::Whole(vec![version])),
        ("makadam/grains", Numbers::Whole(vec![*grains as i32])),
        ("makadam/time", Numbers::Real(vec![*time])),
        ("makadam/step", Numbers::Real(vec![*step])),
        ("makadam/unit", Numbers::Real(vec![*unit])),
        // Symmetric: rows are columns.
        ("makadam/bodies/inverse_mass", body(|body| body.inverse_mass.as_slice().to_vec())),
        ("makadam/bodies/inverse_inertia", body(|body| body.inverse_inertia.as_slice().to_vec())),
        ("makadam/bodies/velocity", body(|body| body.velocity.as_slice().to_vec())),
        ("makadam/bodies/spin", body(|body| body.spin.as_slice().to_vec())),
        ("makadam/contacts/first", whole(|contact| contact.first as i32)),
        ("makadam/contacts/second", whole(second)),
        ("makadam/contacts/normal", contact(|contact| contact.normal.as_slice().to_vec())),
        ("makadam/contacts/tangents", contact(tangents)),
        ("makadam/contacts/first_arm", contact(|contact| contact.arms[0].as_slice().to_vec())),
        ("makadam/contacts/second_arm", contact(|contact| contact.arms[1].as_slice().to_vec())),
        ("makadam/contacts/wall_velocity", contact(|contact| contact.wall_velocity.as_slice().to_vec())),
        ("makadam/contacts/wall_spin", contact(|contact| contact.wall_spin.as_slice().to_vec())),
        ("makadam/contacts/bias", contact(|contact| vec![contact.bias])),
        ("makadam/contacts/compliance", contact(|contact| vec![contact.compliance])),
        ("makadam/contacts/friction", contact(|contact| vec![contact.friction])),
        ("makadam/contacts/rolling_lever", contact(|contact| vec![contact.rolling_lever])),
        ("makadam/contacts/twisting_lever", contact(|contact| vec![contact.twisting_lever])),
        ("makadam/contacts/pull", contact(|contact| vec![contact.pull])),
        ("makadam/contacts/normal_impulse", contact(|contact| vec![contact.impulse.normal])),
        ("makadam/contacts/tangential_impulse", contact(|contact| contact.impulse.tangential.as_slice().to_vec())),
        ("makadam/contacts/angular_impulse", contact(|contact| contact.impulse.angular.as_slice().to_vec())),
    ]);
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
