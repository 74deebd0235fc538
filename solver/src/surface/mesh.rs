//! Triangles of a file, with welded corners.
//!
//! Rules: corners nearer to each other than the seam, `2^-21` of the largest coordinate, are one corner: four last bits of single
//! precision, in which STL stores them. A triangle without an area, or with the corners of an earlier triangle in any order, is dropped
//! and counted. Open, non-manifold and self-touching meshes are valid.

use super::triangle::Triangle;
use base64::prelude::{BASE64_STANDARD, Engine};
use nalgebra::Vector3;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Seam over the largest coordinate.
const SEAM: f64 = 1.0 / (1 << 21) as f64;

/// Largest number of triangles: faces have 32-bit indices, and tables of frames hold three corners of each.
pub(super) const MOST_TRIANGLES: usize = 50_000_000;

/// Surface of triangles, in units of its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    points: Arc<[[f64; 3]]>,
    triangles: Arc<[[u32; 3]]>,
    /// Number of triangles without area that were dropped.
    flat: u32,
    /// Number of repeated triangles that were dropped.
    repeated: u32,
}

/// Rotation of a mesh by the right-hand rule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshRotation {
    /// Direction of the axis through the origin; need not be of unit length.
    pub axis: [f64; 3],
    /// Angle, degrees.
    pub angle: f64,
}

impl TriangleMesh {
    /// Creates a mesh from the corners of triangles, counter-clockwise as seen from outside.
    ///
    /// # Errors
    /// Text that follows the name of the mesh, if a corner is not finite or no triangle has an area.
    pub fn new(triangles: &[[[f64; 3]; 3]]) -> Result<TriangleMesh, String> {
        if triangles.len() > MOST_TRIANGLES {
            return Err(format!("has {} triangles; give at most {MOST_TRIANGLES}", triangles.len()));
        }
        let coordinates = || triangles.iter().flatten().flatten();
        if let Some(number) =
            triangles.iter().position(|corners| corners.iter().flatten().any(|x| x.is_nan() || x.abs() >= 1e30))
        {
            return Err(format!("has a corner that is not finite in triangle {}; export it again", number + 1));
        }
        let mut welder =
            Welder { seam: coordinates().fold(0.0, |most, x| f64::max(most, x.abs())) * SEAM, ..Welder::default() };
        let (mut mesh, mut kept) = (TriangleMesh::default(), Vec::new());
        let mut known = HashSet::new();
        for corners in triangles {
            let numbers = corners.map(|corner| welder.number(corner));
            let welded = numbers.map(|number| Vector3::from(welder.points[number as usize]));
            let mut sorted = numbers;
            sorted.sort_unstable();
            if !Triangle::new(welded).has_area() {
                mesh.flat += 1;
            } else if !known.insert(sorted) {
                mesh.repeated += 1;
            } else {
                kept.push(numbers);
            }
        }
        if kept.is_empty() {
            return Err("has no triangle with an area; give a surface".into());
        }
        (mesh.points, mesh.triangles) = (welder.points.into(), kept.into());
        Ok(mesh)
    }

    /// Reads the content of a file: STL, text or binary, or OBJ.
    ///
    /// # Errors
    /// Text that follows the name of the file, with the remedy.
    pub fn read(bytes: &[u8]) -> Result<TriangleMesh, String> {
        TriangleMesh::new(&super::files::triangles(bytes)?)
    }

    /// Returns the corners of each triangle, in units of the file.
    pub fn corners(&self) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
        self.triangles.iter().map(|numbers| numbers.map(|number| self.points[number as usize]))
    }

    crate::getters! {
        /// Returns the number of triangles.
        pub len: usize = |mesh| mesh.triangles.len();
        /// Returns true if the file has not been read.
        pub is_empty: bool = |mesh| mesh.triangles.is_empty();
        /// Returns the numbers of triangles that were dropped: without an area, and repeated.
        pub dropped: [usize; 2] = |mesh| [mesh.flat as usize, mesh.repeated as usize];
    }

    /// Returns the distance below which corners are one corner, in units of the file.
    pub(super) fn seam(&self) -> f64 {
        self.points.iter().flatten().fold(0.0, |most, x| f64::max(most, x.abs())) * SEAM
    }
}

/// Numbers of distinct corners.
#[derive(Default)]
struct Welder {
    seam: f64,
    points: Vec<[f64; 3]>,
    /// Last corner of each cell of a grid with the width of the seam, and the corner before each corner in its cell.
    last: HashMap<[i64; 3], u32>,
    before: Vec<Option<u32>>,
}

impl Welder {
    /// Returns the number of the first corner within the seam of a point, or a new one.
    fn number(&mut self, point: [f64; 3]) -> u32 {
        let width = self.seam.max(f64::MIN_POSITIVE);
        let cell = point.map(|x| (x / width).floor() as i64);
        let gap = |number: u32| (Vector3::from(self.points[number as usize]) - Vector3::from(point)).norm();
        let around = (0..27).map(|n| [cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1]);
        let known = around.flat_map(|cell| {
            std::iter::successors(self.last.get(&cell).copied(), |&number| self.before[number as usize])
        });
        if let Some(number) = known.filter(|&number| gap(number) <= self.seam).min() {
            return number;
        }
        let number = self.points.len() as u32;
        self.points.push(point);
        self.before.push(self.last.insert(cell, number));
        number
    }
}

/// Little-endian numbers: triangles without area, repeated triangles, points, coordinates, corners.
impl Serialize for TriangleMesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut bytes = Vec::with_capacity(12 + 24 * self.points.len() + 12 * self.triangles.len());
        for number in [self.flat, self.repeated, self.points.len() as u32] {
            bytes.extend(number.to_le_bytes());
        }
        self.points.iter().flatten().for_each(|x| bytes.extend(x.to_le_bytes()));
        self.triangles.iter().flatten().for_each(|corner| bytes.extend(corner.to_le_bytes()));
        serializer.serialize_str(&BASE64_STANDARD.encode(bytes))
    }
}

impl<'de> Deserialize<'de> for TriangleMesh {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<TriangleMesh, D::Error> {
        let text = String::deserialize(deserializer)?;
        let bytes = BASE64_STANDARD.decode(text).ok();
        let mesh = bytes.and_then(|bytes| decode(&bytes));
        mesh.ok_or_else(|| serde::de::Error::custom("content is not a mesh that Makadam has written; remove the key"))
    }
}

fn decode(bytes: &[u8]) -> Option<TriangleMesh> {
    let words = |bytes: &[u8]| bytes.as_chunks().0.iter().map(|four| u32::from_le_bytes(*four)).collect::<Vec<u32>>();
    let (head, rest) = bytes.split_at_checked(12)?;
    let [flat, repeated, points] = words(head)[..] else { return None };
    let (coordinates, corners) = rest.split_at_checked((points as usize).checked_mul(24)?)?;
    let coordinates: Vec<f64> = coordinates.as_chunks().0.iter().map(|eight| f64::from_le_bytes(*eight)).collect();
    let (welded, triangles) = (coordinates.as_chunks().0.into(), words(corners).as_chunks().0.into());
    let mesh = TriangleMesh { points: welded, triangles, flat, repeated };
    let valid = corners.len().is_multiple_of(12)
        && mesh.points.iter().flatten().all(|x| x.abs() < 1e30)
        && mesh.triangles.iter().flatten().all(|&corner| corner < points)
        && mesh.corners().all(|corners| Triangle::new(corners.map(Vector3::from)).has_area());
    valid.then_some(mesh)
}
