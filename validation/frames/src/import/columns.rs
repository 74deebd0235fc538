//! Meaning of the columns of a table of grains or contacts: by the usual names of codes, or by names from the caller.

use super::table::{FrameTable, ImportError};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

/// Meaning of a number of a grain or of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Number of the grain, in the code's own numbering.
    Id,
    /// Coordinate of the centre, m.
    Position(usize),
    /// Radius, m.
    Radius,
    /// Diameter, m.
    Diameter,
    /// Component of the velocity, m/s.
    Velocity(usize),
    /// Component of the angular velocity, rad/s.
    Spin(usize),
    /// Number of the first grain of a contact.
    First,
    /// Number of the second grain of a contact; negative for a contact with a wall.
    Second,
    /// Number of the wall, from 0 in the order of the scene; negative for a contact between grains.
    Wall,
    /// Component of the force on the first grain, N.
    Force(usize),
    /// Coordinate of the contact point, m.
    Point(usize),
    /// Component of the unit normal from the first grain to its partner.
    Normal(usize),
    /// Normal force, N: positive for repulsion.
    NormalForce,
    /// Component of the tangential force on the partner, N.
    Tangential(usize),
    /// Component of the normal force on the first grain, N.
    NormalOnFirst(usize),
    /// Component of the tangential force on the first grain, N.
    TangentialOnFirst(usize),
    /// Simulated time, s.
    Time,
    /// Number of the time step.
    Step,
    /// Material or kind of the grain, a number or a name.
    Kind,
}

/// Names of scalars, in small letters.
const PLAIN: [(&[&str], Column); 13] = [
    (&["id"], Column::Id),
    (&["radius", "r", "radii"], Column::Radius),
    (&["diameter", "d"], Column::Diameter),
    (&["time"], Column::Time),
    (&["step", "timestep"], Column::Step),
    (&["type", "material", "matid", "mat_id", "materialid", "material_id"], Column::Kind),
    (&["first", "id1", "grain1"], Column::First),
    (&["second", "second_grain", "id2", "grain2"], Column::Second),
    (&["wall", "second_wall"], Column::Wall),
    (&["normal_force", "fn"], Column::NormalForce),
    // Unwrapped coordinates of LAMMPS.
    (&["xu"], Column::Position(0)),
    (&["yu"], Column::Position(1)),
    (&["zu"], Column::Position(2)),
];

/// Constructor of a column from the number of a component.
pub(super) type OfComponent = fn(usize) -> Column;

/// Names of vectors, in small letters: the axis follows, as `x`, `_x`, `_0` or `[0]`.
const VECTORS: [(&[&str], OfComponent); 9] = [
    (&["", "position", "points"], Column::Position),
    (&["v", "velocity", "vel", "linvelvec"], Column::Velocity),
    (&["omega", "w", "spin", "angular_velocity", "angularvelocity", "angvel", "angvelvec"], Column::Spin),
    (&["f", "force"], Column::Force),
    (&["p", "point"], Column::Point),
    (&["n", "normal"], Column::Normal),
    (&["tangential_force"], Column::Tangential),
    (&["fn"], Column::NormalOnFirst),
    (&["ft"], Column::TangentialOnFirst),
];

/// Returns the meaning of a column; `None` for unknown names.
pub fn column_of(name: &str) -> Option<Column> {
    let name = name.trim().to_lowercase();
    if let Some((_, column)) = PLAIN.iter().find(|(known, _)| known.contains(&&*name)) {
        return Some(*column);
    }
    let (vector, axis) = split_axis(&name)?;
    VECTORS.iter().find(|(known, _)| known.contains(&vector)).map(|(_, of)| of(axis))
}

/// Splits the name of a component into the name of its vector and the number of its axis.
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
    // The digit of "id1" is not an axis.
    match counted && trimmed.len() == vector.len() {
        true => None,
        false => Some((trimmed, axis)),
    }
}

/// Names of columns: of each file under an empty name, or of columns that a file numbers under one name, such as `c_pairs[1]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(from = "Written")]
pub struct StatedColumns(BTreeMap<String, Vec<String>>);

/// `StatedColumns` in a file: a list, or a table of lists.
#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    All(Vec<String>),
    Numbered(BTreeMap<String, Vec<String>>),
}

impl From<Written> for StatedColumns {
    fn from(written: Written) -> StatedColumns {
        StatedColumns(match written {
            Written::All(all) => BTreeMap::from([(String::new(), all)]),
            Written::Numbered(numbered) => numbered,
        })
    }
}

impl FromStr for StatedColumns {
    type Err = String;

    /// Reads `id,x,y,z`, or `c_pairs:first,second,_` for the columns `c_pairs[1]` and so on.
    fn from_str(text: &str) -> Result<StatedColumns, String> {
        let list = |text: &str| text.split(',').map(|name| name.trim().to_string()).collect::<Vec<_>>();
        // `Points:0` is a name of ParaView: the name of several columns precedes the first comma, and the second name.
        let is_head = |head: &str, names: &str| {
            !head.contains(',') && names.contains(',') && !names.starts_with(char::is_numeric)
        };
        let head = text.split_once(':').filter(|(head, names)| is_head(head, names));
        let names = list(head.map_or(text, |(_, names)| names));
        if names.iter().any(String::is_empty) {
            return Err("a name is empty; write _ for a column that is not wanted".into());
        }
        let head = head.map_or("", |(head, _)| head.trim());
        Ok(StatedColumns(BTreeMap::from([(head.to_string(), names)])))
    }
}

impl StatedColumns {
    /// Joins lists stated one after the other; a later list replaces an earlier one of its kind.
    pub fn joined(all: impl IntoIterator<Item = StatedColumns>) -> StatedColumns {
        StatedColumns(all.into_iter().flat_map(|one| one.0).collect())
    }

    /// Returns true if no names are stated.
    pub fn is_empty(&self) -> bool {
        self.0.values().all(Vec::is_empty)
    }

    /// Makes the empty table of a file from the names of its columns and their line.
    ///
    /// # Errors
    /// [`ImportError`] for a list with more or fewer names than the file has columns, or for two columns with one meaning.
    pub(super) fn table(&self, file: &Path, line: usize, own: Vec<String>) -> Result<FrameTable, ImportError> {
        let fault = |problem: String| ImportError::new(file, line.max(1), problem);
        let remedy = "name each, those that are not wanted with _";
        let mut names = own;
        // The names of all columns come first.
        for (compute, stated) in self.0.iter().filter(|(_, stated)| !stated.is_empty()) {
            let is_named = |name: &str| compute.is_empty() || numbered(name) == Some(compute);
            let places: Vec<usize> = (0..names.len()).filter(|place| is_named(&names[*place])).collect();
            let (count, named) = (places.len(), stated.len());
            if compute.is_empty() && count != named {
                return Err(fault(format!("its rows have {count} numbers, and {named} columns are named; {remedy}")));
            }
            if count > 0 && count != named {
                let problem = format!("it has {count} columns {compute}[...], and {named} are named; {remedy}");
                return Err(fault(problem));
            }
            places.into_iter().zip(stated).for_each(|(place, name)| names[place].clone_from(name));
        }
        let mut table = FrameTable { file: file.into(), line, ..FrameTable::default() };
        for (place, name) in names.into_iter().enumerate() {
            let Some(meaning) = column_of(&name) else {
                table.unread.push(name);
                continue;
            };
            let size = |column: Column| if column == Column::Diameter { Column::Radius } else { column };
            if let Some(first) = table.meanings.iter().position(|known| size(*known) == size(meaning)) {
                return Err(fault(format!(
                    "two columns have one meaning, {} and {name}; name each once, those that are not wanted with _",
                    table.columns[first]
                )));
            }
            table.columns.push(name);
            table.meanings.push(meaning);
            table.places.push(place);
        }
        Ok(table)
    }
}

/// Returns the name under which a column is numbered: `c_pairs` of `c_pairs[3]`.
pub(super) fn numbered(name: &str) -> Option<&str> {
    let (compute, number) = name.strip_suffix(']')?.split_once('[')?;
    number.parse::<usize>().ok().map(|_| compute)
}

/// Reads a finite number.
pub(super) fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(format!("'{word}' is not finite: the run diverged")),
        Err(_) => Err(format!("'{word}' is not a number")),
    }
}
