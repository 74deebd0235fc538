//! Named columns of numbers: the common form of frames for exports, pictures and VTK readers.

use makadam::snapshot::DrivenWall;

/// Defines the number types with their Rust types; the variants have VTK's names.
macro_rules! numbers {
    ($($kind:ident $type:ty),*) => {
        /// Number type of a column. Runs write `UInt8`, `Int32`, `Float32` and `Float64`; other codes write all types.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Number {
            $(#[doc = stringify!($type)] $kind),*
        }

        impl Number {
            /// Returns the number type for a name in a file.
            pub fn of(name: &str) -> Option<Number> {
                match name {
                    $(stringify!($kind) => Some(Number::$kind),)*
                    _ => None,
                }
            }

            /// Returns the bytes per number.
            pub fn size(self) -> usize {
                match self {
                    $(Number::$kind => size_of::<$type>()),*
                }
            }

            /// Returns a value rounded to this number type.
            fn rounded(self, value: f64) -> f64 {
                match self {
                    $(Number::$kind => value as $type as f64),*
                }
            }

            /// Converts numbers to bytes in little endian.
            pub fn encode(self, values: &[f64]) -> Vec<u8> {
                let mut bytes = Vec::with_capacity(self.size() * values.len());
                match self {
                    $(Number::$kind => values.iter().for_each(|value| bytes.extend((*value as $type).to_le_bytes()))),*
                }
                bytes
            }

            /// Converts bytes to numbers.
            pub fn decode(self, mut bytes: Vec<u8>, is_big_endian: bool) -> Vec<f64> {
                if is_big_endian {
                    bytes.chunks_exact_mut(self.size()).for_each(<[u8]>::reverse);
                }
                match self {
                    $(Number::$kind => bytes.as_chunks().0.iter().map(|one| <$type>::from_le_bytes(*one) as f64).collect()),*
                }
            }
        }
    };
}

numbers!(UInt8 u8, Int8 i8, Int16 i16, UInt16 u16, Int32 i32, UInt32 u32, Int64 i64, UInt64 u64, Float32 f32, Float64 f64);

/// Number type, and numbers per tuple.
pub(crate) type Shape = (Number, usize);

pub(crate) const REAL: Shape = (Number::Float32, 1);
pub(crate) const VECTOR: Shape = (Number::Float32, 3);
pub(crate) const WHOLE: Shape = (Number::Int32, 1);
pub(crate) const DOUBLE: Shape = (Number::Float64, 1);
pub(crate) const DOUBLES: Shape = (Number::Float64, 3);

/// Named column: tuples of numbers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    /// Name.
    pub name: String,
    /// Number type in files.
    pub number: Number,
    /// Numbers per tuple.
    pub width: usize,
    /// Numbers, tuple after tuple, rounded to the number type.
    pub values: Vec<f64>,
}

impl Column {
    pub fn new(name: &str, (number, width): Shape, values: impl IntoIterator<Item = f64>) -> Column {
        let values = values.into_iter().map(|value| number.rounded(value)).collect();
        Column { name: name.into(), number, width, values }
    }

    /// Makes a column of coordinates (m), in single precision unless that would shift points by more than a thousandth of a `resolution` (m).
    pub fn coordinates(name: &str, values: Vec<f64>, resolution: f64) -> Column {
        let farthest = values.iter().fold(0.0, |farthest: f64, coordinate| farthest.max(coordinate.abs()));
        let is_single = farthest * f64::from(f32::EPSILON) <= 1e-3 * resolution;
        Column::new(name, (if is_single { Number::Float32 } else { Number::Float64 }, 3), values)
    }

    /// Returns the number of tuples.
    pub fn tuples(&self) -> usize {
        self.values.len() / self.width
    }
}

/// Part of a frame with a file of its own in exports.
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
    /// All kinds.
    pub const ALL: [Kind; 3] = [Kind::Grains, Kind::Contacts, Kind::Walls];

    /// Returns the name, which begins the names of files.
    pub fn name(self) -> &'static str {
        ["grains", "contacts", "walls"][self as usize]
    }
}

/// Part of a frame: points, their cells, and columns over both.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    /// Points per cell: 1, 2 or 3.
    pub corners_per_cell: usize,
    /// Simulated time, s.
    pub time: f64,
    /// Coordinates of the points, three per point, m.
    pub points: Column,
    /// Numbers of the points, cell after cell; if absent, all points in their order.
    pub corners: Option<Vec<u32>>,
    /// Columns over points.
    pub of_points: Vec<Column>,
    /// Columns over cells.
    pub of_cells: Vec<Column>,
    /// Columns of the whole part.
    pub whole: Vec<Column>,
    /// Texts of the whole part, such as names.
    pub texts: Vec<(&'static str, Vec<String>)>,
}

impl Part {
    /// Returns the numbers of the points, cell after cell.
    pub fn corners(&self) -> Vec<u32> {
        self.corners.clone().unwrap_or_else(|| (0..self.points.tuples() as u32).collect())
    }

    /// Returns the number of cells.
    pub fn cells(&self) -> usize {
        self.corners.as_ref().map_or(self.points.tuples(), Vec::len) / self.corners_per_cell
    }
}

/// Names of the columns of the poses of dynamic walls, one tuple per wall: number in the scene, displacement (m or rad), and rate (m/s or
/// rad/s).
pub(crate) const DRIVEN_WALLS: [&str; 3] = ["driven_wall", "driven_wall_displacement", "driven_wall_rate"];

/// Returns the columns of the poses of dynamic walls.
pub(crate) fn pose_columns(walls: &[DrivenWall]) -> [Column; 3] {
    let [wall, displacement, rate] = DRIVEN_WALLS;
    [
        Column::new(wall, WHOLE, walls.iter().map(|driven| f64::from(driven.wall))),
        Column::new(displacement, DOUBLE, walls.iter().map(|driven| driven.displacement)),
        Column::new(rate, DOUBLE, walls.iter().map(|driven| driven.rate)),
    ]
}

/// Reads the poses of dynamic walls from these columns; empty if one of them is absent.
///
/// # Errors
/// Message with the names of the columns.
pub(crate) fn driven_walls(
    values: impl Fn(&str) -> Result<Option<Vec<f64>>, String>,
) -> Result<Vec<DrivenWall>, String> {
    let [walls, displacements, rates] = DRIVEN_WALLS.map(values);
    let (Some(walls), Some(displacements), Some(rates)) = (walls?, displacements?, rates?) else {
        return Ok(Vec::new());
    };
    let all = walls.iter().chain(&displacements).chain(&rates);
    if [displacements.len(), rates.len()] != [walls.len(); 2] || !all.into_iter().all(|number| number.is_finite()) {
        return Err(format!("{} are not as many finite numbers each", DRIVEN_WALLS.join(", ")));
    }
    let poses = walls.iter().zip(displacements.iter().zip(&rates));
    Ok(poses.map(|(&wall, (&displacement, &rate))| DrivenWall { wall: wall as u32, displacement, rate }).collect())
}

#[cfg(test)]
#[path = "../../tests/unit/run_frames_columns.rs"]
mod tests;
