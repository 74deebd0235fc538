//! What the columns of a table of grains or contacts mean, by the names that codes give them.

use super::frame_table::FrameTable;

/// A number of a grain or of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Number of the grain, in whatever count the code has.
    Id,
    /// A coordinate of the centre, m.
    Position(usize),
    /// Radius, m.
    Radius,
    /// Diameter, m.
    Diameter,
    /// A component of the velocity, m/s.
    Velocity(usize),
    /// A component of the angular velocity, rad/s.
    Spin(usize),
    /// Number of the first grain of a contact.
    First,
    /// Number of its second grain; negative where it is one with a wall.
    Second,
    /// Number of the wall, from 0 in the order of the scene; negative where it is one between grains.
    Wall,
    /// A component of the force on the first grain, N.
    Force(usize),
    /// A coordinate of the contact point, m.
    Point(usize),
    /// A component of the unit normal from the first grain to its partner.
    Normal(usize),
    /// Normal force, N: positive pushes the two apart.
    NormalForce,
    /// A component of the tangential force on the partner, N.
    Tangential(usize),
    /// A component of the normal force on the first grain, N.
    NormalOnFirst(usize),
    /// A component of the tangential force on the first grain, N.
    TangentialOnFirst(usize),
    /// Simulated time, s.
    Time,
    /// Number of the time step.
    Step,
    /// Material or kind of the grain, a number or a name.
    Kind,
}

/// Names of single numbers, in small letters.
const PLAIN: [(&str, Column); 28] = [
    ("id", Column::Id),
    ("radius", Column::Radius),
    ("r", Column::Radius),
    ("radii", Column::Radius),
    ("diameter", Column::Diameter),
    ("d", Column::Diameter),
    ("time", Column::Time),
    ("step", Column::Step),
    ("timestep", Column::Step),
    ("type", Column::Kind),
    ("material", Column::Kind),
    ("matid", Column::Kind),
    ("mat_id", Column::Kind),
    ("materialid", Column::Kind),
    ("material_id", Column::Kind),
    ("first", Column::First),
    ("id1", Column::First),
    ("grain1", Column::First),
    ("second", Column::Second),
    ("second_grain", Column::Second),
    ("id2", Column::Second),
    ("grain2", Column::Second),
    ("wall", Column::Wall),
    ("second_wall", Column::Wall),
    ("normal_force", Column::NormalForce),
    ("fn", Column::NormalForce),
    ("xu", Column::Position(0)),
    ("yu", Column::Position(1)),
];

/// Makes a column of a component.
type OfComponent = fn(usize) -> Column;

/// Names of vectors, in small letters: the axis follows, as `x`, `_x`, `_0` or `[0]`.
const VECTORS: [(&str, OfComponent); 23] = [
    ("", Column::Position),
    ("position", Column::Position),
    ("points", Column::Position),
    ("v", Column::Velocity),
    ("velocity", Column::Velocity),
    ("vel", Column::Velocity),
    ("linvelvec", Column::Velocity),
    ("omega", Column::Spin),
    ("w", Column::Spin),
    ("spin", Column::Spin),
    ("angular_velocity", Column::Spin),
    ("angularvelocity", Column::Spin),
    ("angvel", Column::Spin),
    ("angvelvec", Column::Spin),
    ("f", Column::Force),
    ("force", Column::Force),
    ("p", Column::Point),
    ("point", Column::Point),
    ("n", Column::Normal),
    ("normal", Column::Normal),
    ("tangential_force", Column::Tangential),
    ("fn", Column::NormalOnFirst),
    ("ft", Column::TangentialOnFirst),
];

/// What a column means; none where the name says nothing of that kind.
pub fn column_of(name: &str) -> Option<Column> {
    let name = name.trim().to_lowercase();
    if let Some((_, column)) = PLAIN.iter().find(|(known, _)| *known == name) {
        return Some(*column);
    }
    if name == "zu" {
        return Some(Column::Position(2));
    }
    let (vector, axis) = split_axis(&name)?;
    VECTORS.iter().find(|(known, _)| *known == vector).map(|(_, of)| of(axis))
}

/// The name of a vector and the number of its axis.
fn split_axis(name: &str) -> Option<(&str, usize)> {
    let bare = name.strip_suffix(']').unwrap_or(name);
    let axis = match bare.chars().last()? {
        'x' | '0' => 0,
        'y' | '1' => 1,
        'z' | '2' => 2,
        _ => return None,
    };
    let vector = &bare[..bare.len() - 1];
    let counted = bare.ends_with(['0', '1', '2']);
    let trimmed = vector.trim_end_matches(['_', ':', '[', '.']);
    // "id1" and the like count something else than axes.
    match counted && trimmed.len() == vector.len() {
        true => None,
        false => Some((trimmed, axis)),
    }
}

/// Where the columns of a table stand.
pub(super) struct Places<'t> {
    table: &'t FrameTable,
    columns: Vec<Option<Column>>,
}

impl<'t> Places<'t> {
    /// Reads the heads of a table.
    pub fn of(table: &'t FrameTable) -> Places<'t> {
        Places { table, columns: table.columns.iter().map(|name| column_of(name)).collect() }
    }

    /// Place of a column, if the table has it.
    pub fn find(&self, column: Column) -> Option<usize> {
        self.columns.iter().position(|known| *known == Some(column))
    }

    /// Places of three components, if the table has them all.
    pub fn vector(&self, of: OfComponent) -> Option<[usize; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis| self.find(of(axis)));
        Some([x?, y?, z?])
    }

    /// Place of the radius or the diameter, and what makes it a radius.
    pub fn radius(&self) -> Option<(usize, f64)> {
        let of_diameter = || Some((self.find(Column::Diameter)?, 0.5));
        self.find(Column::Radius).map(|place| (place, 1.0)).or_else(of_diameter)
    }

    /// Names of all columns, for an error.
    pub fn names(&self) -> String {
        self.table.columns.iter().chain(&self.table.unread).map(String::as_str).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_name_their_columns_in_many_ways() {
        let same = |names: &[&str], column: Column| {
            for name in names {
                assert_eq!(column_of(name), Some(column), "{name}");
            }
        };
        same(&["x", "X", "xu", "position_x", "Points_0", "Points:0"], Column::Position(0));
        same(&["vz", "velocity_z", "velocity_2", "linVelVec_2"], Column::Velocity(2));
        same(&["omegay", "wy", "angular_velocity_y", "angVelVec_1", "omega[1]"], Column::Spin(1));
        same(&["radius", "r", "radii"], Column::Radius);
        same(&["id1", "first"], Column::First);
        same(&["fx", "force_x"], Column::Force(0));
        same(&["fny", "fn_y"], Column::NormalOnFirst(1));
        same(&["ftz"], Column::TangentialOnFirst(2));
        same(&["type", "material", "matId", "materialId"], Column::Kind);
        // A temperature, or a time: the name does not say which.
        for nothing in ["T", "t", "xs", "mass", "id3", "fn2", "", "c_pairs[4]", "_"] {
            assert_eq!(column_of(nothing), None, "{nothing}");
        }
    }
}
