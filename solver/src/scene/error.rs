//! What is wrong with a scene: where in its document, what is wrong, what would be right.
//!
//! The solver knows no files. Who has read the document from one turns the place into a file and a line: [`SceneError::in_file`].

use super::Scene;
use super::file::SceneFileError;
use super::wishes::remedy;
use std::fmt;
use std::path::Path;

/// Why a scene was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// What it says cannot be simulated.
    #[error(transparent)]
    Invalid(#[from] Fault),
    /// There is no room for the grains.
    #[error(
        "the memory for its grains is not there: {:.1} GB more were asked for; lower the count, or use a machine with more",
        *bytes as f64 * 1e-9
    )]
    Memory {
        /// What was asked for, bytes.
        bytes: usize,
    },
}

impl SceneError {
    /// The same as an error of a file. `text` is what the file holds, which tells the line; without it the problem names the value by
    /// its path.
    pub fn in_file(self, file: &Path, text: Option<&str>) -> SceneFileError {
        match self {
            SceneError::Invalid(fault) => fault.locate(file, text),
            SceneError::Memory { bytes } => SceneFileError::Memory { file: file.to_path_buf(), bytes },
        }
    }

    /// What the reader of TOML says of a text.
    pub fn from_toml(text: &str, error: &toml::de::Error) -> SceneError {
        let line = error.span().map_or(1, |span| line_at(text, span.start));
        let problem = in_the_words_of_scenes(&error.message().replace('\n', " "));
        let kinds = || error.span().and_then(|span| kinds_at(text, span.start));
        let advice = if problem.starts_with("unknown field") || problem.starts_with("unknown variant") {
            meant(&problem)
        } else if let Some(kinds) = problem.starts_with("missing field `kind`").then(kinds).flatten() {
            format!("add that key to the table: {kinds}")
        } else if problem.starts_with("missing field") {
            "add that key to the table".into()
        } else if problem.contains(KIND_WANTED) {
            "write it as { kind = \"...\" }; see the scene reference for the kinds".into()
        } else if problem.contains("expected f64") {
            "write a plain number in SI units, such as radius = 0.005 for 5 mm".into()
        } else {
            "see the scenes under reference-scenes/ for the form".into()
        };
        SceneError::Invalid(Fault { line: Some(line), ..Fault::new(Vec::new(), problem, advice) })
    }
}

/// What stands in a message where a value is no table with a kind.
const KIND_WANTED: &str = "a table with a kind";

/// A message without the types that read the document.
fn in_the_words_of_scenes(message: &str) -> String {
    match message.split_once("expected internally tagged enum ") {
        Some((before, _)) => format!("{before}expected {KIND_WANTED}"),
        None => match message.split_once("expected struct ") {
            Some((before, _)) => format!("{before}expected a table"),
            None => message.into(),
        },
    }
}

/// Remedy for a name that the reader of TOML does not know, from its message: the names that it lists stand behind that one.
fn meant(problem: &str) -> String {
    let mut quoted = problem.split('`').skip(1).step_by(2);
    let unknown = quoted.next().unwrap_or_default();
    remedy(unknown, quoted).unwrap_or("use one of the names listed".into())
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

/// A value that is wrong: its place in the scene's document, what is wrong with it, and what would be right.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    path: Vec<Step>,
    problem: String,
    remedy: String,
    /// Another place that the remedy speaks of.
    see: Option<Vec<Step>>,
    /// Line, where the reader of the text has told it.
    line: Option<usize>,
}

/// One step of the way to a value in a TOML document.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    Key(&'static str),
    Name(String),
    Index(usize),
}

impl Fault {
    pub(super) fn new(path: Vec<Step>, problem: String, remedy: impl Into<String>) -> Fault {
        Fault { path, problem, remedy: remedy.into(), see: None, line: None }
    }

    /// The same, with another place that the remedy speaks of.
    pub(super) fn see(self, path: Vec<Step>) -> Fault {
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

    /// Its place in the document in words, such as `wall[0].motion`; empty where the reader of the text has told no more than a line.
    pub fn place(&self) -> String {
        label(&self.path)
    }

    /// Line of the value in the text of its document, or of the nearest table around it that the text spells out.
    pub fn line(&self, text: &str) -> usize {
        self.line.unwrap_or_else(|| span_start(text, &self.path).map_or(1, |at| line_at(text, at)))
    }

    /// Finds the line, where there is a text; elsewhere the path says where.
    fn locate(self, file: &Path, text: Option<&str>) -> SceneFileError {
        let (problem, remedy) = self.in_words();
        let Some(text) = text else {
            return SceneFileError::Invalid { file: file.to_path_buf(), line: self.line, problem, remedy };
        };
        let remedy = match &self.see {
            Some(path) => match whole_span(text, path) {
                Some(at) => format!("{remedy} ({} stands in line {})", label(path), line_at(text, at)),
                None => format!("{remedy} ({} is not in the file: it has its default)", label(path)),
            },
            None => remedy,
        };
        SceneFileError::Invalid {
            file: file.to_path_buf(),
            line: Some(self.line(text)),
            problem: printable(&self.problem),
            remedy,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (problem, remedy) = self.in_words();
        let line = self.line.map(|line| format!("line {line}: ")).unwrap_or_default();
        write!(out, "{line}{problem}; {remedy}")
    }
}

impl std::error::Error for Fault {}

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
pub(super) fn whole_span(text: &str, path: &[Step]) -> Option<usize> {
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

pub(super) fn line_at(text: &str, at: usize) -> usize {
    1 + text.as_bytes()[..at.min(text.len())].iter().filter(|&&byte| byte == b'\n').count()
}
