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
    /// There is no room for the grains.
    #[error(
        "{}: the memory for its grains is not there: {:.1} GB more were asked for; lower the count, or use a machine with more",
        file.display(),
        *bytes as f64 * 1e-9
    )]
    Memory {
        /// The file, or what stands for it.
        file: PathBuf,
        /// What was asked for, bytes.
        bytes: usize,
    },
    /// The file can be read, but what it says cannot be simulated.
    #[error("{}{}: {problem}; {remedy}", file.display(), line.map(|line| format!(":{line}")).unwrap_or_default())]
    Invalid {
        /// The file, or what stands for it where the scene was built in code.
        file: PathBuf,
        /// Line, from 1; none where there is no file, and the problem names the field by its path.
        line: Option<usize>,
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
        SceneError::Invalid {
            file: file.to_path_buf(),
            line: Some(line),
            problem: printable(&problem),
            remedy: printable(&remedy),
        }
    }
}

/// Text without characters that steer a terminal: they are shown as escapes.
pub(super) fn printable(text: &str) -> String {
    text.chars().map(|c| if is_printable(c) { c.to_string() } else { c.escape_unicode().to_string() }).collect()
}

/// Whether a character shows as itself: no control, and none that changes the direction of what follows.
pub(super) fn is_printable(c: char) -> bool {
    !c.is_control()
        && !matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// A number for a message: as it is where that is short, else rounded to six digits.
pub(super) fn short(value: f64) -> String {
    const LONGEST: usize = 15;
    let plain = |value: f64| Some(value.to_string()).filter(|text| text.len() <= LONGEST);
    let rounded = || format!("{value:.5e}").parse().ok();
    plain(value).or_else(|| rounded().and_then(plain)).unwrap_or_else(|| match rounded() {
        Some(rounded) => format!("{rounded:e}"),
        None => format!("{value:e}"),
    })
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
    path: Vec<Step>,
    problem: String,
    remedy: String,
    /// Another place that the remedy speaks of.
    see: Option<Vec<Step>>,
}

/// One step of the way to a value in a TOML document.
#[derive(Clone, Debug)]
pub(super) enum Step {
    Key(&'static str),
    Name(String),
    Index(usize),
}

impl Fault {
    pub fn new(path: Vec<Step>, problem: String, remedy: impl Into<String>) -> Fault {
        Fault { path, problem, remedy: remedy.into(), see: None }
    }

    /// The same, with another place that the remedy speaks of.
    pub fn see(self, path: Vec<Step>) -> Fault {
        Fault { see: Some(path), ..self }
    }

    /// What is wrong, and what would be right, with the path of the place where the problem does not begin with it.
    pub fn in_words(&self) -> (String, String) {
        let path = label(&self.path);
        let problem = match self.problem.starts_with(&path) {
            true => printable(&self.problem),
            false => printable(&format!("{path}: {}", self.problem)),
        };
        (problem, printable(&self.remedy))
    }

    /// Line of the value in the text of its document, or of the nearest table around it that the text spells out.
    pub fn line(&self, text: &str) -> usize {
        span_start(text, &self.path).map_or(1, |at| line_at(text, at))
    }

    /// Finds the line, where there is a text; elsewhere the path says where.
    pub(super) fn locate(self, file: &Path, text: Option<&str>) -> SceneError {
        let (problem, remedy) = self.in_words();
        let Some(text) = text else {
            return SceneError::Invalid { file: file.to_path_buf(), line: None, problem, remedy };
        };
        let remedy = match &self.see {
            Some(path) => match whole_span(text, path) {
                Some(at) => format!("{remedy} ({} stands in line {})", label(path), line_at(text, at)),
                None => format!("{remedy} ({} is not in the file: it has its default)", label(path)),
            },
            None => remedy,
        };
        SceneError::Invalid {
            file: file.to_path_buf(),
            line: Some(self.line(text)),
            problem: printable(&self.problem),
            remedy,
        }
    }
}

/// A path in words, such as `wall[0].motion`.
pub(super) fn label(path: &[Step]) -> String {
    let mut label = String::new();
    for step in path {
        match step {
            Step::Key(key) => label += &format!(".{key}"),
            Step::Name(name) => label += &format!(".{name}"),
            Step::Index(index) => label += &format!("[{index}]"),
        }
    }
    label.trim_start_matches('.').to_string()
}

/// Line (from 1) on which a scene's text says what stands at a path such as `["material", "grain", "friction"]` or
/// `["wall", "0", "motion"]`; the nearest table around it, where the text leaves it out; `None` where it says nothing of it.
pub fn line_of(text: &str, path: &[&str]) -> Option<usize> {
    let step = |step: &&str| step.parse().map_or_else(|_| Step::Name(step.to_string()), Step::Index);
    span_start(text, &path.iter().map(step).collect::<Vec<_>>()).map(|at| line_at(text, at))
}

/// Where a value stands, or the nearest table around it.
fn span_start(text: &str, path: &[Step]) -> Option<usize> {
    spans(text, path).last().copied()
}

/// Where a value stands, if the text has it.
fn whole_span(text: &str, path: &[Step]) -> Option<usize> {
    Some(spans(text, path)).filter(|spans| spans.len() == path.len()).and_then(|spans| spans.last().copied())
}

/// Where each step of a path stands, as far as the text has them.
fn spans(text: &str, path: &[Step]) -> Vec<usize> {
    use toml::de::{DeTable, DeValue};
    let Ok(document) = DeTable::parse(text) else { return Vec::new() };
    let mut spans = Vec::with_capacity(path.len());
    let mut value: Option<&DeValue<'_>> = None;
    for step in path {
        let key = match step {
            Step::Key(key) => *key,
            Step::Name(name) => name.as_str(),
            Step::Index(index) => {
                let Some(next) = value.and_then(|v| v.as_array()).and_then(|a| a.get(*index)) else {
                    break;
                };
                spans.push(next.span().start);
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
        spans.push(name.span().start);
        value = Some(next.get_ref());
    }
    spans
}

fn line_at(text: &str, at: usize) -> usize {
    1 + text.as_bytes()[..at.min(text.len())].iter().filter(|&&byte| byte == b'\n').count()
}
