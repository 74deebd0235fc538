//! Values in place of those that a scene's text says: `--set material.grain.friction=0.3`.
//!
//! The text is changed where the value stands, so that every other line keeps its number, and read as if it had been written so.

use makadam::scene::{suggestion, wish};
use makadam_frames::plan::MeasuredScene;
use std::fmt;
use std::str::FromStr;
use toml_edit::{DocumentMut, Item, Key, Table, Value};

/// Tables that a scene may leave out, and that have no defaults to be spelt out.
const OPTIONAL: [&str; 4] = ["accuracy", "output", "prepare", "watch"];

/// A value for one key.
#[derive(Clone, Debug)]
pub struct Change {
    key: Vec<String>,
    value: Value,
    /// As it was written.
    written: String,
}

/// Error of a change that cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{change}: {problem}")]
pub struct ChangeError {
    /// The change, as it was written.
    pub change: String,
    /// The problem and its remedy.
    pub problem: String,
}

impl FromStr for Change {
    type Err = ChangeError;

    /// Reads `KEY=VALUE`. A value that is no TOML is a text.
    fn from_str(written: &str) -> Result<Change, ChangeError> {
        let refuse = |problem: &str| ChangeError { change: written.into(), problem: problem.into() };
        let form = "give KEY=VALUE, such as material.grain.friction=0.3";
        let (key, value) = written.split_once('=').ok_or_else(|| refuse(form))?;
        let key = key_of(key.trim());
        if key.iter().any(String::is_empty) || value.trim().is_empty() {
            return Err(refuse(form));
        }
        Ok(Change { written: written.into(), ..Change::new(&key, value) })
    }
}

impl fmt::Display for Change {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.written)
    }
}

/// The steps of a dotted key; quotes hold what has dots or blanks of its own. `population[0].count`, as messages print it, is
/// `population.0.count`; a key with quotes has dots alone.
pub fn key_of(key: &str) -> Vec<String> {
    let dotted = if key.contains(['"', '\'']) { key.into() } else { key.replace('[', ".").replace(']', "") };
    match Key::parse(&dotted) {
        Ok(steps) => steps.iter().map(|step| step.get().to_string()).collect(),
        Err(_) => dotted.split('.').map(|step| step.trim().to_string()).collect(),
    }
}

impl Change {
    /// A value, in TOML or as a plain text, for a key.
    pub fn new(key: &[String], value: &str) -> Change {
        let parsed = value.trim().parse::<Value>().unwrap_or_else(|_| Value::from(value.trim()));
        Change { key: key.to_vec(), value: parsed, written: format!("{}={}", key.join("."), value.trim()) }
    }

    /// The key, with dots between its steps.
    pub fn key(&self) -> String {
        self.key.join(".")
    }

    /// Reports whether it changes a value of a table of the scene, such as `compare`.
    pub fn is_of(&self, table: &str) -> bool {
        self.key.first().is_some_and(|first| first == table)
    }

    fn refuse(&self, problem: String) -> ChangeError {
        ChangeError { change: self.written.clone(), problem }
    }
}

/// The text of a scene with changes made, one after the other.
///
/// # Errors
/// [`ChangeError`] if the text is no TOML, or a key leads to nothing that could be set. Whether the scene takes the value is told when
/// it is read.
pub fn changed(text: &str, changes: &[Change]) -> Result<String, ChangeError> {
    let mut text = text.to_string();
    for change in changes {
        let mut document: DocumentMut =
            text.parse().map_err(|error| change.refuse(format!("the scene is no TOML: {error}")))?;
        set(document.as_item_mut(), change, &change.key, &mut defaults(&text))?;
        text = document.to_string();
    }
    Ok(text)
}

/// All that the scene says, defaults included: what stands for a table that the text leaves out.
fn defaults(text: &str) -> Option<Item> {
    let scene = MeasuredScene::parse(text).ok()?;
    let written = toml::to_string(&scene).ok()?;
    Some(written.parse::<DocumentMut>().ok()?.as_item().clone())
}

fn set(at: &mut Item, change: &Change, key: &[String], full: &mut Option<Item>) -> Result<(), ChangeError> {
    let [step, rest @ ..] = key else {
        let decor = at.as_value().map(|value| value.decor().clone());
        let mut value = change.value.clone();
        if let Some(decor) = decor {
            *value.decor_mut() = decor;
        }
        *at = Item::Value(value);
        return Ok(());
    };
    if let Some(length) = length_of(at) {
        let place = place_in(at, step, length);
        let (place, rest) = match place {
            Some(place) => (place, rest),
            // The only one need not be told from others.
            None if length == 1 && step.parse::<usize>().is_err() => (0, key),
            None => {
                let names: Vec<String> =
                    (0..length).map(|place| name_of(at, place).unwrap_or(place.to_string())).collect();
                let before = change.key[..change.key.len() - key.len()].join(".");
                let problem =
                    format!("{before} has {length} entries: say which, such as {before}.{}", names.join(", "));
                return Err(change.refuse(problem));
            }
        };
        let mut inner = full.take().and_then(|mut full| full.get_mut(place).map(std::mem::take));
        let entry = at.get_mut(place).expect("it is one of them");
        return set(entry, change, rest, &mut inner);
    }
    if at.as_table_like().is_none() {
        let known = change.key[..change.key.len() - key.len()].join(".");
        return Err(change.refuse(format!("{known} is a value, which has no '{step}' of its own")));
    }
    let mut inner =
        full.take().and_then(|mut full| full.get_mut(step.as_str()).map(std::mem::take)).filter(|item| !item.is_none());
    let table = at.as_table_like_mut().expect("it is one");
    if !table.contains_key(step) && !rest.is_empty() {
        let entry = match &inner {
            // What the text leaves out is spelt out, so that one of its values can be another.
            Some(item) if item.is_table_like() => item.clone(),
            None if key.len() == change.key.len() && !OPTIONAL.contains(&step.as_str()) => {
                let names: Vec<&str> = table.iter().map(|(name, _)| name).collect();
                let listed = || wish(step).map_or_else(|| format!("it has {}", names.join(", ")), String::from);
                let remedy = suggestion(step, names.iter().copied(), &listed());
                return Err(change.refuse(format!("the scene has no '{step}'; {remedy}")));
            }
            _ => Item::Table(Table::new()),
        };
        table.insert(step, entry);
    }
    match table.get_mut(step) {
        Some(entry) => set(entry, change, rest, &mut inner),
        None => {
            table.insert(step, Item::Value(change.value.clone()));
            Ok(())
        }
    }
}

/// Number of entries of a list.
fn length_of(item: &Item) -> Option<usize> {
    item.as_array_of_tables().map(|tables| tables.len()).or_else(|| item.as_array().map(|array| array.len()))
}

/// The place of an entry, by its number from 0 or by its name.
fn place_in(list: &Item, step: &str, length: usize) -> Option<usize> {
    let by_name = (0..length).find(|&place| name_of(list, place).as_deref() == Some(step));
    by_name.or_else(|| step.parse().ok().filter(|place| *place < length))
}

/// Returns the name of an entry, or that of its observable.
fn name_of(list: &Item, place: usize) -> Option<String> {
    let text = |key: &str| Some(list.get(place)?.get(key)?.as_str()?.to_string());
    text("name").or_else(|| text("observable"))
}

#[cfg(test)]
#[path = "../../tests/unit/scenes_change.rs"]
mod tests;
