//! Errors of scenes: path in the document, problem and remedy.
//!
//! The solver is independent of files. The reader of a file converts the path to a file and a line: [`SceneError::in_file`].

use super::Scene;
use super::document::{Document, DocumentPath};
use super::suggestions::remedy;
use std::fmt;
use std::path::{Path, PathBuf};

/// Error of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A value cannot be simulated.
    #[error(transparent)]
    Invalid(#[from] Fault),
    /// The memory for the grains cannot be allocated.
    #[error(
        "the memory for its grains is not there: {:.1} GB more were asked for; lower the count, or use a machine with more",
        *bytes as f64 * 1e-9
    )]
    Memory {
        /// Requested memory, bytes.
        bytes: usize,
    },
}

impl SceneError {
    /// Converts the error to that of a file. The line is taken from `text`, the text of the file; without the text, the
    /// problem names the value by its path.
    pub fn in_file(self, file: &Path, text: Option<&str>) -> SceneFileError {
        match self {
            SceneError::Invalid(fault) => fault.locate(file, text),
            SceneError::Memory { bytes } => SceneFileError::Memory { file: file.to_path_buf(), bytes },
        }
    }

    /// Converts an error of the TOML reader.
    pub(super) fn from_toml(text: &str, error: &toml::de::Error) -> SceneError {
        let line = error.span().map_or(1, |span| line_at(text, span.start));
        let problem = in_the_words_of_scenes(&error.message().replace('\n', " "));
        let kinds = || error.span().and_then(|span| kinds_at(text, span.start));
        let advice = if problem.starts_with("unknown field") || problem.starts_with("unknown variant") {
            meant(&problem)
        } else if let Some(kinds) = problem.starts_with("missing field `kind`").then(kinds).flatten() {
            format!("add that key to the table: {kinds}")
        } else {
            let known = ADVICE.iter().find(|(words, _)| problem.contains(words));
            known.map_or("see the scene reference for the form of each key", |(_, advice)| advice).into()
        };
        SceneError::Invalid(Fault { line: Some(line), ..Fault::new(DocumentPath::default(), problem, advice) })
    }
}

/// Remedies for messages of the TOML reader that contain the words.
const ADVICE: [(&str, &str); 7] = [
    ("missing field", "add that key to the table"),
    ("a table with a kind", "write it as { kind = \"...\" }; see the scene reference for the kinds"),
    ("a number", "write a plain number in SI units, such as radius = 0.005 for 5 mm"),
    (COUNT, "write it without a sign, a point or an exponent, such as count = 1000"),
    ("list of length", "write as many values in brackets, such as [0.0, 0.0, 1.0] for 3"),
    ("exactly 1 element", "give one of the keys of this table, and no other"),
    ("duplicate key", "keep one of the two lines"),
];
const COUNT: &str = "a whole number from 0";

/// Removes the names of Rust types from a message.
fn in_the_words_of_scenes(message: &str) -> String {
    let until = |words: &str| message.split_once(words).map(|(before, _)| before.to_string());
    let table = until("internally tagged enum ").map(|before| before + "a table with a kind");
    let words = [("f64", "a number"), ("usize", COUNT), ("u64", COUNT), ("u32", COUNT), ("an array of", "a list of")];
    let of = |word: &str| format!("expected {word}");
    let plain = || words.iter().fold(message.to_string(), |text, (name, new)| text.replace(&of(name), &of(new)));
    table.or_else(|| until("struct ").map(|before| before + "a table")).unwrap_or_else(plain)
}

/// Returns the remedy for an unknown name in a message of the TOML reader; the message lists the known names after the unknown one.
fn meant(problem: &str) -> String {
    let mut quoted = problem.split('`').skip(1).step_by(2);
    let unknown = quoted.next().unwrap_or_default();
    remedy(unknown, quoted).unwrap_or("use one of the names listed".into())
}

/// Escapes terminal control characters.
pub(super) fn printable(text: &str) -> String {
    text.chars().map(|c| if is_printable(c) { c.to_string() } else { c.escape_unicode().to_string() }).collect()
}

/// Returns true if a character is printable: neither a control character nor one that changes the text direction.
pub(super) fn is_printable(c: char) -> bool {
    !c.is_control()
        && !matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// Formats a number for a message: exact if short, otherwise rounded to six digits.
pub(super) fn short(value: f64) -> String {
    const LONGEST: usize = 15;
    let plain = |value: f64| Some(value.to_string()).filter(|text| text.len() <= LONGEST);
    let rounded = || format!("{value:.5e}").parse().ok();
    plain(value).or_else(|| rounded().and_then(plain)).unwrap_or_else(|| match rounded() {
        Some(rounded) => format!("{rounded:e}"),
        None => format!("{value:e}"),
    })
}

/// Rounds a positive number down to a number of digits.
pub(super) fn rounded_down(value: f64, digits: usize) -> f64 {
    let scale = 10_f64.powf(value.log10().floor() - (digits as f64 - 1.0));
    format!("{:.*e}", digits - 1, (value / scale).floor() * scale).parse().unwrap_or(value)
}

/// Returns the kinds of a table without a kind, from the error message of the reader for an unknown kind.
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

/// Invalid value: its path in the document of the scene, the problem and the remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    pub(super) path: DocumentPath,
    problem: String,
    remedy: String,
    /// Path of another value that the remedy mentions.
    see: Option<DocumentPath>,
    /// Line, if the reader of the text reported the line.
    line: Option<usize>,
}

impl Fault {
    pub(super) fn new(path: DocumentPath, problem: String, remedy: impl Into<String>) -> Fault {
        Fault { path, problem, remedy: remedy.into(), see: None, line: None }
    }

    /// Replaces the start of the path, if the path begins so.
    pub(super) fn moved(mut self, (from, to): (DocumentPath, DocumentPath)) -> Fault {
        if let Some(path) = self.path.moved(&from, &to) {
            let rest = self.problem.strip_prefix(&self.path.to_string());
            self.problem = rest.map_or(self.problem.clone(), |rest| format!("{path}{rest}"));
            self.path = path;
        }
        self
    }

    /// Adds the path of another value that the remedy mentions.
    pub(super) fn see(self, path: DocumentPath) -> Fault {
        Fault { see: Some(path), ..self }
    }

    /// Returns the problem, which begins with the path of the value, and the remedy.
    pub fn in_words(&self) -> (String, String) {
        let path = self.path.to_string();
        let problem = match self.problem.starts_with(&path) {
            true => printable(&self.problem),
            false => printable(&format!("{path}: {}", self.problem)),
        };
        (problem, printable(&self.remedy))
    }

    /// Returns the path in the document as text, such as `wall[0].motion`; empty if the reader of the text reported only a line.
    pub fn place(&self) -> String {
        self.path.to_string()
    }

    /// Returns the line of the value in the text of its document, or of the nearest enclosing table in the text.
    pub fn line(&self, text: &str) -> usize {
        self.line.unwrap_or_else(|| span_start(text, &self.path).map_or(1, |at| line_at(text, at)))
    }

    /// Adds the line if there is a text; otherwise the message names the value by its path.
    fn locate(self, file: &Path, text: Option<&str>) -> SceneFileError {
        let (problem, remedy) = self.in_words();
        let Some(text) = text else {
            return SceneFileError::Invalid { file: file.to_path_buf(), line: self.line, problem, remedy };
        };
        let remedy = match &self.see {
            Some(path) => match whole_span(text, path) {
                Some(at) => format!("{remedy} ({path} stands in line {})", line_at(text, at)),
                None => format!("{remedy} ({path} is not in the file: it has its default)"),
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

/// Returns the line (from 1) of the value at a path such as `["material", "grain", "friction"]` or `["wall", "0", "motion"]` in
/// the text of a scene. Absent values have the line of the nearest enclosing table; `None` if the text has neither.
pub fn line_of(text: &str, path: &[&str]) -> Option<usize> {
    let root = DocumentPath::default();
    let path =
        path.iter().fold(root, |path, step| step.parse().map_or_else(|_| path.name(step), |index| path.index(index)));
    span_start(text, &path).map(|at| line_at(text, at))
}

/// Offset of a value, or of the nearest enclosing table.
fn span_start(text: &str, path: &DocumentPath) -> Option<usize> {
    Document::parse(text).ok()?.offsets(path).last().copied()
}

/// Offset of a value, if the text has it.
pub(super) fn whole_span(text: &str, path: &DocumentPath) -> Option<usize> {
    let offsets = Document::parse(text).ok()?.offsets(path);
    offsets.last().copied().filter(|_| offsets.len() == path.0.len())
}

pub(super) fn line_at(text: &str, at: usize) -> usize {
    1 + text.as_bytes()[..at.min(text.len())].iter().filter(|&&byte| byte == b'\n').count()
}

/// Error of a scene file.
#[derive(Debug, thiserror::Error)]
pub enum SceneFileError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}; give a path to a readable TOML file", file.display())]
    Missing {
        /// The file.
        file: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The memory for the grains cannot be allocated.
    #[error("{}: {}", file.display(), SceneError::Memory { bytes: *bytes })]
    Memory {
        /// File name, or a substitute for a scene without a file.
        file: PathBuf,
        /// Requested memory, bytes.
        bytes: usize,
    },
    /// The file can be read, but its content cannot be simulated.
    #[error("{}{}: {problem}; {remedy}", file.display(), line.map(|line| format!(":{line}")).unwrap_or_default())]
    Invalid {
        /// File name, or a substitute for a scene built in code.
        file: PathBuf,
        /// Line, from 1; none without a file, where the problem names the field by its path.
        line: Option<usize>,
        /// Problem.
        problem: String,
        /// Remedy.
        remedy: String,
    },
}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`SceneFileError`] if the file is missing, is not TOML, has unknown keys, has a value out of range, or
    /// prescribes a motion that the step does not resolve.
    pub fn load(file: impl AsRef<Path>) -> Result<Scene, SceneFileError> {
        let file = file.as_ref();
        let missing = |source| SceneFileError::Missing { file: file.to_path_buf(), source };
        let text = std::fs::read_to_string(file).map_err(missing)?;
        let scene = Scene::parse_in(&text, file.parent().unwrap_or(Path::new("")));
        scene.map_err(|error| error.in_file(file, Some(&text)))
    }
}
