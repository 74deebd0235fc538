//! Layout of problem files: paths and columns of the datasets, and the fields of bodies and contacts that they hold.

use makadam::checkpoint::checksum as fnv1a;
use makadam::problem::{Body, Contact};
use std::collections::BTreeMap;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Numbers {
    Real(Vec<f64>),
    Whole(Vec<i32>),
}

/// Datasets by their paths.
pub(super) type Datasets = BTreeMap<&'static str, Numbers>;

/// Path, number of columns, and type of the numbers of a dataset.
pub(super) type Described = (&'static str, usize, Kind);

#[derive(Clone, Copy)]
pub(super) enum Kind {
    Real,
    Whole,
}

pub(super) const CHECKSUM: &str = "makadam/checksum";

pub(super) const TITLE: &str = "fclib_local/info/title";

/// Impulses of a solution, which are no part of the problem.
pub(super) const SOLUTION: &str = "solution/r";

/// Version of the group `makadam`.
pub(super) const VERSION: i32 = 1;

/// Version with tangential springs, which a reader of the first one would ignore.
pub(super) const VERSION_WITH_SPRINGS: i32 = 2;

/// A real field of bodies or contacts: its path, and the numbers of a row.
pub(super) struct Field<T>(pub &'static str, pub fn(&mut T) -> Vec<&mut f64>);

impl<T: Copy + Default> Field<T> {
    pub fn described(&self) -> Described {
        (self.0, (self.1)(&mut T::default()).len(), Kind::Real)
    }
}

/// Fields of bodies; blocks are symmetric, so that rows are columns.
pub(super) const BODY: [Field<Body>; 4] = [
    Field("makadam/bodies/inverse_mass", |body| body.inverse_mass.iter_mut().collect()),
    Field("makadam/bodies/inverse_inertia", |body| body.inverse_inertia.iter_mut().collect()),
    Field("makadam/bodies/velocity", |body| body.velocity.iter_mut().collect()),
    Field("makadam/bodies/spin", |body| body.spin.iter_mut().collect()),
];

pub(super) const CONTACT: [Field<Contact>; 15] = [
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
pub(super) const SPRINGS: [Field<Contact>; 2] = [
    Field("makadam/contacts/tangential_compliance", |contact| vec![&mut contact.tangential_compliance]),
    Field("makadam/contacts/tangential_bias", |contact| contact.tangential_bias.iter_mut().collect()),
];

/// Numbers of the bodies of contacts; the second one is -1 for a wall.
pub(super) const ENDS: [&str; 2] = ["makadam/contacts/first", "makadam/contacts/second"];

/// Numbers of the whole problem.
const GENERAL: [Described; 5] = [
    ("makadam/version", 1, Kind::Whole),
    ("makadam/grains", 1, Kind::Whole),
    ("makadam/time", 1, Kind::Real),
    ("makadam/step", 1, Kind::Real),
    ("makadam/unit", 1, Kind::Real),
];

/// Answer of the sweeps over lanes.
pub(super) const LANES: [Described; 2] =
    [("makadam/lanes/velocity", 3, Kind::Real), ("makadam/lanes/spin", 3, Kind::Real)];

/// FCLIB's group.
pub(super) const LOCAL: [Described; 10] = [
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

/// Datasets of a problem with its bodies, in files without springs.
pub(super) fn contact_problem() -> impl Iterator<Item = Described> {
    let ends = ENDS.map(|path| (path, 1, Kind::Whole));
    GENERAL.into_iter().chain(BODY.iter().map(Field::described)).chain(ends).chain(CONTACT.iter().map(Field::described))
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
