//! Meaning that the caller states of files: names of columns, times, numbering, kinds of grains.

use super::columns::{Column, column_of};
use super::frame_table::{FrameTable, ImportError};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

/// Statements about frames that their files do not make.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stated {
    /// Names of the columns of grains.
    pub columns: StatedColumns,
    /// Names of the columns of contacts.
    pub contact_columns: StatedColumns,
    /// Time step by which frames are numbered, s.
    pub time_step: Option<f64>,
    /// Time between frames that are not numbered, s; the first is at time 0. Files follow the numbers in their names.
    pub interval: Option<f64>,
    /// Number in the files of the scene's first grain, where they number grains as the scene does.
    pub first_id: Option<i64>,
    /// Seed by which the grains were placed as the scene places them; with `first_id` it states their radii.
    pub seed: Option<u64>,
    /// Material, or population, that a value of the column `type` or `material` stands for.
    pub kinds: BTreeMap<String, String>,
    /// Walls of the scene that the numbers of the column `wall` stand for; empty where these are the scene's own.
    pub walls: Vec<u32>,
}

impl Stated {
    /// Checks the two times by which frames are dated.
    ///
    /// # Errors
    /// The problem, in names of keys of a file.
    pub fn check_times(time_step: Option<f64>, interval: Option<f64>) -> Result<(), &'static str> {
        let is_time = |time: f64| time.is_finite() && time > 0.0;
        match (time_step, interval) {
            (Some(_), Some(_)) => Err("give either time-step or interval"),
            (Some(time), None) | (None, Some(time)) if !is_time(time) => {
                Err("time-step and interval are times above zero, in seconds")
            }
            _ => Ok(()),
        }
    }
}

/// Names of columns: of each file, or of the columns that a file numbers under one name, such as `c_pairs[1]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(from = "Written")]
pub struct StatedColumns {
    all: Vec<String>,
    numbered: BTreeMap<String, Vec<String>>,
}

/// `StatedColumns` in a file: a list, or a table of lists.
#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    All(Vec<String>),
    Numbered(BTreeMap<String, Vec<String>>),
}

impl From<Written> for StatedColumns {
    fn from(written: Written) -> StatedColumns {
        match written {
            Written::All(all) => StatedColumns { all, ..StatedColumns::default() },
            Written::Numbered(numbered) => StatedColumns { numbered, ..StatedColumns::default() },
        }
    }
}

impl From<Vec<String>> for StatedColumns {
    fn from(all: Vec<String>) -> StatedColumns {
        StatedColumns { all, ..StatedColumns::default() }
    }
}

impl FromStr for StatedColumns {
    type Err = String;

    /// Reads `id,x,y,z`, or `c_pairs:first,second,_` for the columns `c_pairs[1]` and so on.
    fn from_str(text: &str) -> Result<StatedColumns, String> {
        let list = |text: &str| text.split(',').map(|name| name.trim().to_string()).collect::<Vec<_>>();
        // `Points:0` is a name of ParaView: a name of several columns stands before the first comma, and before the second name.
        let (head, names) = match text.split_once(':') {
            Some((head, names))
                if !head.contains(',') && names.contains(',') && !names.starts_with(char::is_numeric) =>
            {
                (Some(head.trim()), list(names))
            }
            _ => (None, list(text)),
        };
        if names.iter().any(String::is_empty) {
            return Err("a name is empty; write _ for a column that is not wanted".into());
        }
        Ok(match head {
            None => StatedColumns::from(names),
            Some(head) => StatedColumns { numbered: BTreeMap::from([(head.to_string(), names)]), all: Vec::new() },
        })
    }
}

/// Names of a table's columns, and which of them have a meaning.
#[derive(Clone, Debug, Default)]
pub(super) struct Heads {
    names: Vec<String>,
    /// Columns that have a meaning.
    used: Vec<usize>,
    /// Kinds among the used ones, which may be names.
    kinds: Vec<bool>,
}

impl StatedColumns {
    /// Joins lists that are stated one after the other; a later one replaces an earlier one of its kind.
    pub fn joined(all: impl IntoIterator<Item = StatedColumns>) -> StatedColumns {
        all.into_iter().fold(StatedColumns::default(), |mut joined, one| {
            joined.numbered.extend(one.numbered);
            StatedColumns { all: if one.all.is_empty() { joined.all } else { one.all }, numbered: joined.numbered }
        })
    }

    /// Reports whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty() && self.numbered.is_empty()
    }

    /// Names the columns of a table, given those of its file and their line.
    ///
    /// # Errors
    /// [`ImportError`] where a list has more or fewer names than the file has columns, or two columns have one meaning: the second
    /// would be passed over.
    pub(super) fn heads(&self, file: &Path, line: usize, own: Vec<String>) -> Result<Heads, ImportError> {
        let fault = |problem: String| ImportError::new(file, line.max(1), problem);
        let mut names = own;
        if !self.all.is_empty() {
            if self.all.len() != names.len() {
                return Err(fault(format!(
                    "its rows have {} numbers, and {} columns are named; name each, those that are not wanted with _",
                    names.len(),
                    self.all.len()
                )));
            }
            names.clone_from(&self.all);
        }
        for (compute, stated) in &self.numbered {
            let places: Vec<usize> =
                (0..names.len()).filter(|place| numbered(&names[*place]) == Some(compute)).collect();
            if !places.is_empty() && places.len() != stated.len() {
                return Err(fault(format!(
                    "it has {} columns {compute}[...], and {} are named; name each, those that are not wanted with _",
                    places.len(),
                    stated.len()
                )));
            }
            places.into_iter().zip(stated).for_each(|(place, name)| names[place].clone_from(name));
        }
        if let Some([one, other]) = told_twice(&names) {
            let is_one_name = one.trim().eq_ignore_ascii_case(other.trim());
            let named =
                if is_one_name { format!("are named {other}") } else { format!("tell the same, {one} and {other}") };
            return Err(fault(format!("two columns {named}; name each once, those that are not wanted with _")));
        }
        let used: Vec<usize> = (0..names.len()).filter(|place| column_of(&names[*place]).is_some()).collect();
        let kinds = used.iter().map(|place| column_of(&names[*place]) == Some(Column::Kind)).collect();
        Ok(Heads { names, used, kinds })
    }
}

/// The name under which a column is numbered: `c_pairs` of `c_pairs[3]`.
pub(super) fn numbered(name: &str) -> Option<&str> {
    let (compute, number) = name.strip_suffix(']')?.split_once('[')?;
    number.parse::<usize>().ok().map(|_| compute)
}

/// Two columns of one meaning, the second of which would be passed over.
fn told_twice(columns: &[String]) -> Option<[&str; 2]> {
    let meaning = |name: &String| match column_of(name)? {
        Column::Diameter => Some(Column::Radius),
        other => Some(other),
    };
    let meanings: Vec<Option<Column>> = columns.iter().map(meaning).collect();
    (0..columns.len()).find_map(|place| {
        let first = meanings[..place].iter().position(|known| known.is_some() && *known == meanings[place])?;
        Some([&*columns[first], &*columns[place]])
    })
}

impl Heads {
    /// Number of columns in the file.
    pub fn count(&self) -> usize {
        self.names.len()
    }

    /// Columns that have a meaning.
    pub fn used(&self) -> &[usize] {
        &self.used
    }

    /// Makes an empty table of the columns that have a meaning.
    pub fn table(&self, file: &Path) -> FrameTable {
        let is_used = |place: &usize| self.used.binary_search(place).is_ok();
        let (columns, unread): (Vec<usize>, Vec<usize>) = (0..self.names.len()).partition(is_used);
        let named = |places: Vec<usize>| places.into_iter().map(|place| self.names[place].clone()).collect();
        FrameTable {
            file: file.into(),
            line: 1,
            columns: named(columns),
            unread: named(unread),
            ..FrameTable::default()
        }
    }

    /// Adds the cells of a row that have a meaning.
    ///
    /// # Errors
    /// What is wrong with a cell.
    pub fn add_row(&self, table: &mut FrameTable, cells: &[&str]) -> Result<(), String> {
        for (place, is_kind) in self.used.iter().zip(&self.kinds) {
            let cell = cells[*place];
            match (number(cell), is_kind) {
                (Ok(value), _) => table.values.push(value),
                (Err(_), true) => {
                    table.words.insert(table.values.len(), cell.to_string());
                    table.values.push(f64::NAN);
                }
                (Err(problem), false) => return Err(format!("column {}: {problem}", self.names[*place])),
            }
        }
        Ok(())
    }
}

/// A finite number.
pub(super) fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(format!("'{word}' is not finite: the run has blown up")),
        Err(_) => Err(format!("'{word}' is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_names_are_of_all_or_of_one_compute() {
        let read = |text: &str| text.parse::<StatedColumns>();
        assert_eq!(read("id, x,y,_").unwrap().all, ["id", "x", "y", "_"]);
        assert_eq!(read("Points:0,Points:1").unwrap().all, ["Points:0", "Points:1"]);
        let pairs = read("c_pairs:first,second,_").unwrap();
        assert_eq!(pairs.numbered["c_pairs"], ["first", "second", "_"]);
        let joined = StatedColumns::joined([pairs, read("c_walls:wall,first").unwrap(), read("x,y").unwrap()]);
        assert_eq!((joined.numbered.len(), joined.all.len()), (2, 2));
        assert!(read("id,,x").unwrap_err().contains("write _"));
        let own = ["c_pairs[1]", "id", "c_pairs[2]"].map(String::from).to_vec();
        let heads = read("c_pairs:first,second").unwrap().heads(Path::new("a"), 1, own.clone()).unwrap();
        assert_eq!(heads.names, ["first", "id", "second"]);
        let error = read("c_pairs:first,second,_").unwrap().heads(Path::new("a"), 1, own).unwrap_err().to_string();
        assert!(error.contains("2 columns c_pairs[...], and 3 are named"), "{error}");
    }
}
