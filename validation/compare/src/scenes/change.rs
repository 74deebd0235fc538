//! Values that replace those of a scene's text: `--set material.grain.friction=0.3`.
//!
//! The text is changed at the position of the value, so that every other line keeps its number, and then read like any other.

use makadam::scene::{suggestion, wish};
use std::fmt;
use std::path::Path;
use std::str::FromStr;
use toml_edit::{DocumentMut, Item, Key, Table, Value};

/// Optional tables without defaults that could be written out.
const OPTIONAL: [&str; 4] = ["accuracy", "output", "prepare", "watch"];

/// Value for one key.
#[derive(Clone, Debug)]
pub struct Change {
    key: Vec<String>,
    value: Value,
    /// Change as written.
    written: String,
}

/// Error of a change that cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{change}: {problem}")]
pub struct ChangeError {
    /// Change as written.
    pub change: String,
    /// Problem and its remedy.
    pub problem: String,
}

impl FromStr for Change {
    type Err = ChangeError;

    /// Reads `KEY=VALUE`. A value that is not TOML is a text.
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

/// Splits a dotted key into steps; a step with dots or spaces is quoted. `population[0].count`, as messages print it, is
/// `population.0.count`; a key with quotes has dots alone.
pub fn key_of(key: &str) -> Vec<String> {
    let dotted = if key.contains(['"', '\'']) { key.into() } else { key.replace('[', ".").replace(']', "") };
    match Key::parse(&dotted) {
        Ok(steps) => steps.iter().map(|step| step.get().to_string()).collect(),
        Err(_) => dotted.split('.').map(|step| step.trim().to_string()).collect(),
    }
}

impl Change {
    /// Returns the change of a key to a value, in TOML or as a plain text.
    pub fn new(key: &[String], value: &str) -> Change {
        let parsed = value.trim().parse::<Value>().unwrap_or_else(|_| Value::from(value.trim()));
        Change { key: key.to_vec(), value: parsed, written: format!("{}={}", key.join("."), value.trim()) }
    }

    /// Returns the key, with dots between its steps.
    pub fn key(&self) -> String {
        self.key.join(".")
    }

    /// Returns true if the change is of a value of a table of the scene, such as `compare`.
    pub fn is_of(&self, table: &str) -> bool {
        self.key.first().is_some_and(|first| first == table)
    }

    fn refuse(&self, problem: String) -> ChangeError {
        ChangeError { change: self.written.clone(), problem }
    }
}

/// Returns the text of a scene with changes made in turn; `folder` is the folder of its file.
///
/// # Errors
/// [`ChangeError`] if the text is not TOML, or a key names nothing that could be set. Reading the scene reports whether
/// the value is valid.
pub fn changed(text: &str, folder: &Path, changes: &[Change]) -> Result<String, ChangeError> {
    let mut text = text.to_string();
    for change in changes {
        let mut document: DocumentMut =
            text.parse().map_err(|error| change.refuse(format!("the scene is no TOML: {error}")))?;
        set(document.as_item_mut(), change, &change.key, &mut defaults(&text, folder))?;
        text = document.to_string();
    }
    Ok(text)
}

/// Returns the scene with all defaults: the values of a table that the text omits.
fn defaults(text: &str, folder: &Path) -> Option<Item> {
    let scene = super::plan(text, folder).ok()?;
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
            // A single entry needs no index.
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
            // Tables that the text omits are written out, so that one of their values can be changed.
            Some(item) if item.is_table_like() => item.clone(),
            // Materials have names of the scene's own.
            None if (key.len() == change.key.len() && !OPTIONAL.contains(&step.as_str()))
                || (change.is_of("material") && key.len() + 1 == change.key.len()) =>
            {
                let place = change.key[..=change.key.len() - key.len()].join(".");
                let names: Vec<&str> = table.iter().map(|(name, _)| name).collect();
                let listed = || wish(step).map_or_else(|| format!("it has {}", names.join(", ")), String::from);
                let remedy = suggestion(step, names.iter().copied(), &listed());
                return Err(change.refuse(format!("the scene has no '{place}'; {remedy}")));
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

/// Index of an entry, by its number from 0 or by its name.
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
