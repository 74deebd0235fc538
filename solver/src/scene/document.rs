//! Document of a scene: its text, parsed once, as the source of values and of the lines in errors.

use super::error::{Fault, SceneError, line_at, short, whole_span};
use super::suggestions::remedy;
use super::{Scene, TABLES_OF_WHO_MEASURES};
use serde::Deserialize;
use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue, Deserializer};
use toml::{Spanned, Table, Value};

/// Function that returns the content of a file.
pub type Reader = fn(&Path) -> std::io::Result<Vec<u8>>;

/// Text of a scene with the position of each value, and the folder of the files that it names.
#[derive(Clone)]
pub struct Document<'t> {
    text: &'t str,
    folder: PathBuf,
    reader: Reader,
    root: Spanned<DeTable<'t>>,
}

impl<'t> Document<'t> {
    /// Parses a text.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the line, if the text is not TOML.
    pub fn parse(text: &'t str) -> Result<Document<'t>, SceneError> {
        let root = DeTable::parse(text).map_err(|error| SceneError::from_toml(text, &error))?;
        Ok(Document { text, folder: PathBuf::new(), reader: |path| std::fs::read(path), root })
    }

    /// Sets the folder of the files that the text names by relative paths; default: the current folder.
    pub fn in_folder(self, folder: impl Into<PathBuf>) -> Document<'t> {
        Document { folder: folder.into(), ..self }
    }

    /// Sets the function that reads files; default: from the disk.
    pub fn reading_with(self, reader: Reader) -> Document<'t> {
        Document { reader, ..self }
    }

    /// Returns the path of a file of a kind that the text names at a path, and its content.
    pub(super) fn file(&self, name: &str, kind: &str, at: &DocumentPath) -> Result<(String, Vec<u8>), Fault> {
        let path = self.folder.join(name);
        let remedy = || format!("give the path of {kind} file, relative to the folder of the scene");
        let refuse = |error| at.fault(format!("'{}' cannot be read: {error}", path.display()), &remedy());
        Ok((path.display().to_string(), (self.reader)(&path).map_err(refuse)?))
    }

    /// Reads all tables into a type.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the line.
    pub fn read<T: Deserialize<'t>>(&self) -> Result<T, SceneError> {
        let error = |error| SceneError::from_toml(self.text, &error);
        T::deserialize(Deserializer::from(self.root.clone())).map_err(error)
    }

    /// Returns true if a table of the document has a key.
    pub(super) fn has(&self, table: &str, key: &str) -> bool {
        self.root.get_ref().get(table).is_some_and(|value| value.get_ref().get(key).is_some())
    }

    /// Byte offsets of the steps of a path; shorter than the path if the document lacks a step.
    pub(super) fn offsets(&self, path: &DocumentPath) -> Vec<usize> {
        let mut offsets = Vec::with_capacity(path.0.len());
        let mut value: Option<&DeValue<'_>> = None;
        for step in &path.0 {
            let table = || value.map_or(Some(self.root.get_ref()), |value| value.as_table());
            let key = |key: &str| table()?.get_key_value(key).map(|(name, next)| (name.span().start, next));
            let next = match step {
                Step::Key(name) => key(name),
                Step::Index(index) => value.and_then(|value| value.get(*index)).map(|next| (next.span().start, next)),
            };
            let Some((offset, next)) = next else { break };
            offsets.push(offset);
            value = Some(next.get_ref());
        }
        offsets
    }

    /// Finds a key or an element that was not read into the scene.
    ///
    /// Serde ignores keys of a variant without fields, and elements beyond the length of an array. Both are missing
    /// when the scene is written again; all other unknown keys are read errors.
    pub(super) fn first_unread(&self, scene: &Scene) -> Option<Fault> {
        let written = Table::try_from(scene).ok()?;
        let read = |key: &str| !TABLES_OF_WHO_MEASURES.contains(&key);
        self.root.get_ref().iter().filter(|(key, _)| read(key.get_ref())).find_map(|(key, value)| {
            let mut path = DocumentPath::default().name(key.get_ref());
            unread(&mut path, value.get_ref(), written.get(key.get_ref().as_ref()))
        })
    }
}

/// Compares a value of a document with the value of the rewritten scene, unless that value is omitted as a default.
fn unread(path: &mut DocumentPath, document: &DeValue<'_>, written: Option<&Value>) -> Option<Fault> {
    let mut inner = |step: Step, value: &DeValue<'_>, written: Option<&Value>| {
        path.0.push(step);
        let fault = unread(path, value, written);
        path.0.pop();
        fault
    };
    match (document, written) {
        (DeValue::Table(document), written) => {
            let there = |key: &str| written.and_then(|written| written.get(key));
            let nested = document.iter().find_map(|(key, value)| {
                inner(Step::Key(key.get_ref().to_string().into()), value.get_ref(), there(key.get_ref()))
            });
            // Omitted defaults of a table with a kind have no other key.
            let kind_alone = written.is_none_or(|written| written.as_table().is_some_and(|table| table.len() == 1));
            let kind = document.get("kind").filter(|_| kind_alone).and_then(|kind| kind.get_ref().as_str());
            let other = document.keys().find(|key| *key.get_ref() != "kind");
            nested.or_else(|| Some(no_such_key(path, kind?, other?.get_ref())))
        }
        (DeValue::Array(document), Some(Value::Array(written))) => {
            let nested = document
                .iter()
                .zip(written)
                .enumerate()
                .find_map(|(index, (value, written))| inner(Step::Index(index), value.get_ref(), Some(written)));
            nested.or_else(|| (document.len() > written.len()).then(|| too_long(path, document.len(), written.len())))
        }
        _ => None,
    }
}

fn no_such_key(path: &DocumentPath, kind: &str, key: &str) -> Fault {
    let problem = format!("{path}: unknown key '{key}' beside kind = '{kind}'");
    let leave_out = || "leave it out, or use one of the known keys: kind".into();
    Fault::new(path.name(key), problem, remedy(key, ["kind"]).unwrap_or_else(leave_out))
}

fn too_long(path: &DocumentPath, listed: usize, read: usize) -> Fault {
    let problem = format!("{path}: {listed} values are listed, and {read} are read");
    Fault::new(path.index(read), problem, format!("give {read} values"))
}

/// Result of a check: the fault of a value that breaks a rule.
pub type Checked = Result<(), Fault>;

/// Path in the document, extended at each level of a check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DocumentPath(pub(super) Vec<Step>);

/// Step of the path to a value in a TOML document.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    Key(Cow<'static, str>),
    Index(usize),
}

/// Path as text, such as `wall[0].motion`.
impl fmt::Display for DocumentPath {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if number == 0 => write!(out, "{key}")?,
                Step::Key(key) => write!(out, ".{key}")?,
                Step::Index(index) => write!(out, "[{index}]")?,
            }
        }
        Ok(())
    }
}

impl DocumentPath {
    /// Returns the path of a key in this table.
    pub fn key(&self, key: &'static str) -> DocumentPath {
        self.with(Step::Key(key.into()))
    }

    /// Returns the path of an entry whose name the document defines.
    pub fn name(&self, name: &str) -> DocumentPath {
        self.with(Step::Key(name.to_string().into()))
    }

    /// Returns the path of an entry in this list, from 0.
    pub fn index(&self, index: usize) -> DocumentPath {
        self.with(Step::Index(index))
    }

    fn with(&self, step: Step) -> DocumentPath {
        let mut path = self.0.clone();
        path.push(step);
        DocumentPath(path)
    }

    /// Returns the line (from 1) of the value at this path in the text of a scene; `None` if the text does not have the value.
    pub fn line(&self, text: &str) -> Option<usize> {
        whole_span(text, self).map(|at| line_at(text, at))
    }

    /// Returns the path with `to` in place of `from`, if it begins so.
    pub(super) fn moved(&self, from: &DocumentPath, to: &DocumentPath) -> Option<DocumentPath> {
        let rest = self.0.strip_prefix(&from.0[..])?;
        Some(DocumentPath([&to.0, rest].concat()))
    }

    /// Returns true if a value has the first two keys of the path.
    pub(super) fn is_in(&self, value: &Value) -> bool {
        let get = |value: &'_ Value, step: &Step| match step {
            Step::Key(key) => value.get(&**key).cloned(),
            Step::Index(index) => value.get(*index).cloned(),
        };
        !self.0.is_empty() && self.0.iter().take(2).try_fold(value.clone(), |value, step| get(&value, step)).is_some()
    }

    /// Returns the fault of the value at this path.
    pub fn fault(&self, problem: String, remedy: &str) -> Fault {
        Fault::new(self.clone(), format!("{self}: {problem}"), remedy)
    }

    /// Rejects a value with a problem.
    pub(super) fn refuse(&self, problem: Option<String>, remedy: &str) -> Checked {
        problem.map_or(Ok(()), |problem| Err(self.fault(problem, remedy)))
    }

    /// Rejects a value that breaks a rule.
    pub(super) fn require(&self, holds: bool, problem: impl FnOnce() -> String, remedy: &str) -> Checked {
        self.refuse((!holds).then(problem), remedy)
    }

    /// Rejects a number outside a range. The remedy names `unit`.
    pub fn range(&self, value: f64, low: f64, high: f64, unit: &str) -> Checked {
        if value.is_finite() && value >= low && value <= high {
            return Ok(());
        }
        let [value, low, high] = [value, low, high].map(short);
        Err(self.fault(format!("{value} is out of range"), &format!("give a number from {low} to {high} {unit}")))
    }

    /// Rejects a number outside the usual range or, if the scene accepts unusual values, outside the range of valid
    /// computations. The remedy names `unit`.
    pub fn usual(&self, value: f64, usual: [f64; 2], possible: [f64; 2], unusual_values: bool, unit: &str) -> Checked {
        let [low, high] = if unusual_values { possible } else { usual };
        let [least, most] = possible.map(short);
        let accepted = format!(
            "{unit}; if it is meant, unusual_values = true at the top of the scene accepts {least} to {most} {unit}"
        );
        self.range(value, low, high, if unusual_values { unit } else { &accepted })
    }

    /// Rejects a vector unless it has three components with magnitudes below 1e6, SI units.
    pub fn finite(&self, vector: &[f64; 3]) -> Checked {
        let usable = vector.iter().all(|x| x.is_finite() && x.abs() < 1e6);
        self.require(usable, || format!("{vector:?} is not usable"), "give three finite SI numbers below 1e6")
    }

    /// Rejects a zero vector.
    pub fn direction(&self, vector: &[f64; 3]) -> Checked {
        self.finite(vector)?;
        let square: f64 = vector.iter().map(|x| x * x).sum();
        self.require(square > 1e-24, || "has no direction".into(), "give a vector that is not zero")
    }
}
