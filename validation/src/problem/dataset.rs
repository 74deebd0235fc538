//! The datasets of a file: their paths, kinds and columns, and the checksum over them.

use std::collections::BTreeMap;

/// What a dataset's numbers are.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Numbers {
    /// IEEE double precision.
    Real(Vec<f64>),
    /// Integers of 32 bits.
    Whole(Vec<i32>),
}

/// Datasets by their paths.
pub(super) type Datasets = BTreeMap<&'static str, Numbers>;

/// Where the checksum stands.
pub(super) const CHECKSUM: &str = "makadam/checksum";

/// Where the title stands for FCLIB.
pub(super) const TITLE: &str = "fclib_local/info/title";

/// Impulses of a solution, which are no part of the problem.
pub(super) const SOLUTION: &str = "solution/r";

/// Version of the layout below `makadam`.
pub(super) const VERSION: i32 = 1;

/// The version where contacts have tangential springs, which a reader of the first one would pass over.
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

/// What the sweeps over lanes came to.
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

/// Whether numbers are real or whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Real,
    Whole,
}

/// FNV-1a, 64 bits, over the paths and the numbers of all datasets in the order of their paths.
pub(super) fn checksum(datasets: &Datasets) -> u64 {
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    for (path, numbers) in datasets {
        hash.add(path.as_bytes());
        match numbers {
            Numbers::Real(values) => values.iter().for_each(|value| hash.add(&value.to_bits().to_le_bytes())),
            Numbers::Whole(values) => values.iter().for_each(|value| hash.add(&value.to_le_bytes())),
        }
    }
    hash.0
}

struct Fnv(u64);

impl Fnv {
    fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
