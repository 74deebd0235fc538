//! What a document says and nobody reads: a key or an element that reading passes over without a word.
//!
//! Serde passes over keys beside the `kind` of a variant without fields, and over elements beyond the length of an array. There is
//! no list of such cases here, but one rule for any document:
//!
//! 1. The scene that was read is written again. What stands in both was read.
//! 2. What stands in the document alone was either read and left out again, for being the default, or not read at all. It is read if
//!    a value that nothing accepts makes reading fail in its place; if reading does not mind, nobody looks there.

use super::error::{Fault, Step, label};
use super::wishes::remedy;
use super::{Scene, TABLES_OF_WHO_MEASURES};
use toml::{Table, Value};

/// The first place of a document that was not read into the scene.
pub(super) fn first_unread(text: &str, scene: &Scene) -> Option<Fault> {
    let (Ok(document), Ok(written)) = (toml::from_str::<Table>(text), Table::try_from(scene)) else { return None };
    let mut walk = Walk { document: Value::Table(document.clone()), path: Vec::new() };
    walk.table(&document, &written)
}

/// A way down the document and the scene beside it.
struct Walk {
    /// All of it, to be tried with one value replaced.
    document: Value,
    path: Vec<Step>,
}

impl Walk {
    fn table(&mut self, document: &Table, written: &Table) -> Option<Fault> {
        let top = self.path.is_empty();
        let ours = |key: &str| !(top && TABLES_OF_WHO_MEASURES.contains(&key));
        document.iter().filter(|(key, _)| ours(key)).find_map(|(key, value)| {
            self.path.push(Step::Name(key.clone()));
            let fault = match written.get(key) {
                Some(there) => self.value(value, there),
                None if self.is_read() => self.value(value, &nothing_of(value)),
                None => Some(self.key_fault(key, document, written)),
            };
            self.path.pop();
            fault
        })
    }

    fn value(&mut self, document: &Value, written: &Value) -> Option<Fault> {
        match (document, written) {
            (Value::Table(document), Value::Table(written)) => self.table(document, written),
            (Value::Array(document), Value::Array(written)) => {
                document.iter().enumerate().find_map(|(index, value)| {
                    self.path.push(Step::Index(index));
                    let fault = match written.get(index) {
                        Some(there) => self.value(value, there),
                        None if self.is_read() => self.value(value, &nothing_of(value)),
                        None => Some(self.element_fault(document.len())),
                    };
                    self.path.pop();
                    fault
                })
            }
            _ => None,
        }
    }

    /// Whether reading minds what stands at the path.
    fn is_read(&mut self) -> bool {
        // No key of a scene holds a date.
        let nothing_accepts = "1979-05-27".parse().map(Value::Datetime).expect("a date");
        let Some(place) = at(&mut self.document, &self.path) else { return true };
        let sound = std::mem::replace(place, nothing_accepts);
        // As a text, which is read as the scene was; other readers of tables mind other things.
        let read = toml::to_string(&self.document).is_ok_and(|text| toml::from_str::<Scene>(&text).is_err());
        if let Some(place) = at(&mut self.document, &self.path) {
            *place = sound;
        }
        read
    }

    fn key_fault(&mut self, key: &str, document: &Table, written: &Table) -> Fault {
        let mut known: Vec<&str> = written.keys().map(String::as_str).collect();
        // Keys that were read, but are not written since they hold their default.
        let unwritten: Vec<&String> =
            document.keys().filter(|other| *other != key && !written.contains_key(*other)).collect();
        let last = self.path.pop();
        for other in unwritten {
            self.path.push(Step::Name(other.clone()));
            if self.is_read() {
                known.push(other);
            }
            self.path.pop();
        }
        let kind = match document.get("kind") {
            Some(Value::String(kind)) => format!(" beside kind = '{kind}'"),
            _ => String::new(),
        };
        let place = label(&self.path);
        self.path.extend(last);
        Fault::new(
            self.path.clone(),
            format!("{place}: unknown key '{key}'{kind}"),
            remedy(key, known.iter().copied())
                .unwrap_or_else(|| format!("leave it out, or use one of the known keys: {}", known.join(", "))),
        )
    }

    fn element_fault(&mut self, listed: usize) -> Fault {
        // The first one that is not read: those before it are.
        let read = match self.path.last() {
            Some(Step::Index(index)) => *index,
            _ => 0,
        };
        let whole = label(&self.path[..self.path.len() - 1]);
        let problem = format!("{whole}: {listed} values are listed, and {read} are read");
        Fault::new(self.path.clone(), problem, format!("give {read} values"))
    }
}

/// A table or a list of the same kind that holds nothing, so that each of its entries is tried.
fn nothing_of(value: &Value) -> Value {
    match value {
        Value::Table(_) => Value::Table(Table::new()),
        _ => Value::Array(Vec::new()),
    }
}

/// The value at a path.
fn at<'v>(document: &'v mut Value, path: &[Step]) -> Option<&'v mut Value> {
    path.iter().try_fold(document, |value, step| match step {
        Step::Key(key) => value.get_mut(*key),
        Step::Name(name) => value.get_mut(name.as_str()),
        Step::Index(index) => value.get_mut(*index),
    })
}
