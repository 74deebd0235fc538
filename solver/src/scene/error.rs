//! Errors of scene files: which file, which line, what is wrong, what would be right.

use super::Scene;
use std::path::{Path, PathBuf};

/// Why a scene was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The name is neither a file nor a known scene.
    #[error("no scene '{name}': give a path to a TOML file or one of: {}", known.join(", "))]
    Unknown {
        /// What was asked for.
        name: String,
        /// Scenes that exist.
        known: Vec<String>,
    },
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}; give a path to a readable TOML file", file.display())]
    Missing {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file can be read, but what it says cannot be simulated.
    #[error("{}:{line}: {problem}; {remedy}", file.display())]
    Invalid {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        problem: String,
        /// What would be right.
        remedy: String,
    },
}

impl SceneError {
    pub(super) fn from_toml(file: &Path, text: &str, error: &toml::de::Error) -> SceneError {
        let line = error.span().map_or(1, |span| line_at(text, span.start));
        let problem = error.message().replace('\n', " ");
        let kinds = || error.span().and_then(|span| kinds_at(text, span.start));
        let remedy = if problem.starts_with("unknown field") || problem.starts_with("unknown variant") {
            "use one of the names listed".into()
        } else if let Some(kinds) = problem.starts_with("missing field `kind`").then(kinds).flatten() {
            format!("add that key to the table: {kinds}")
        } else if problem.starts_with("missing field") {
            "add that key to the table".into()
        } else if problem.contains("expected f64") {
            "write a plain number in SI units, such as radius = 0.005 for 5 mm".into()
        } else {
            "see the scenes under reference-scenes/ for the form".into()
        };
        SceneError::Invalid { file: file.to_path_buf(), line, problem, remedy }
    }
}

/// The kinds that a table may have which names none, in the words of its reader: what it says of one that is not there.
fn kinds_at(text: &str, table: usize) -> Option<String> {
    const NONE: &str = "?";
    let (head, rest) = text.split_at_checked(table)?;
    let (opening, key) = match rest.starts_with('{') {
        true => (1, format!("kind = \"{NONE}\", ")),
        false => (rest.find('\n')?, format!("\nkind = \"{NONE}\"")),
    };
    let (opening, body) = rest.split_at_checked(opening)?;
    let error = toml::from_str::<Scene>(&[head, opening, &key, body].concat()).err()?;
    let listed = error.message().strip_prefix(&format!("unknown variant `{NONE}`, expected "))?;
    Some(listed.to_string())
}

/// A value that is wrong: where in the document, what, and what would be right.
pub(super) struct Fault {
    pub path: Vec<Step>,
    pub problem: String,
    pub remedy: String,
}

/// One step of the way to a value in a TOML document.
#[derive(Clone, Debug)]
pub(super) enum Step {
    Key(&'static str),
    Name(String),
    Index(usize),
}

impl Fault {
    /// Finds the line of the value, or of the nearest table around it that the file spells out.
    pub(super) fn locate(self, file: &Path, text: &str) -> SceneError {
        let line = span_start(text, &self.path).map_or(1, |at| line_at(text, at));
        SceneError::Invalid { file: file.to_path_buf(), line, problem: self.problem, remedy: self.remedy }
    }
}

/// Line (from 1) on which a scene's text says what stands at a path such as `["material", "grain", "friction"]` or
/// `["wall", "0", "motion"]`; the nearest table around it, where the text leaves it out; `None` where it says nothing of it.
pub fn line_of(text: &str, path: &[&str]) -> Option<usize> {
    let step = |step: &&str| step.parse().map_or_else(|_| Step::Name(step.to_string()), Step::Index);
    span_start(text, &path.iter().map(step).collect::<Vec<_>>()).map(|at| line_at(text, at))
}

fn span_start(text: &str, path: &[Step]) -> Option<usize> {
    use toml::de::{DeTable, DeValue};
    let document = DeTable::parse(text).ok()?;
    let mut at = None;
    let mut value: Option<&DeValue<'_>> = None;
    for step in path {
        let key = match step {
            Step::Key(key) => *key,
            Step::Name(name) => name.as_str(),
            Step::Index(index) => {
                let Some(next) = value.and_then(|v| v.as_array()).and_then(|a| a.get(*index)) else {
                    break;
                };
                at = Some(next.span().start);
                value = Some(next.get_ref());
                continue;
            }
        };
        let table = match value {
            None => Some(document.get_ref()),
            Some(v) => v.as_table(),
        };
        let Some((name, next)) = table.and_then(|t| t.get_key_value(key)) else {
            break;
        };
        at = Some(name.span().start);
        value = Some(next.get_ref());
    }
    at
}

fn line_at(text: &str, at: usize) -> usize {
    1 + text.as_bytes()[..at.min(text.len())].iter().filter(|&&byte| byte == b'\n').count()
}
