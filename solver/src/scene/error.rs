//! Errors of scenes: place in the document, problem and remedy.
//!
//! The solver knows no files. Who has read the document from one turns the place into a file and a line: [`SceneError::in_file`].

use super::Scene;
use super::document::Document;
use super::suggestions::remedy;
use std::fmt;
use std::path::{Path, PathBuf};

/// Error of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A value cannot be simulated.
    #[error(transparent)]
    Invalid(#[from] Fault),
    /// There is no room for the grains.
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
    /// Converts the error to that of a file. `text` is the file's, for the line; without it the problem names the value by
    /// its path.
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

/// Phrase in a message for a value that is not a table with a kind.
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

/// Returns true if a character shows as itself: no control, and none that changes the direction of what follows.
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

    /// Adds another place that the remedy mentions.
    pub(super) fn see(self, path: Vec<Step>) -> Fault {
        Fault { see: Some(path), ..self }
    }

    /// Problem, which begins with the path of the value, and remedy.
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

/// Offset of a value, or of the nearest table around it.
fn span_start(text: &str, path: &[Step]) -> Option<usize> {
    Document::parse(text).ok()?.offsets(path).last().copied()
}

/// Offset of a value, if the text has it.
pub(super) fn whole_span(text: &str, path: &[Step]) -> Option<usize> {
    let offsets = Document::parse(text).ok()?.offsets(path);
    offsets.last().copied().filter(|_| offsets.len() == path.len())
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
    /// There is no room for the grains.
    #[error(
        "{}: the memory for its grains is not there: {:.1} GB more were asked for; lower the count, or use a machine with more",
        file.display(),
        *bytes as f64 * 1e-9
    )]
    Memory {
        /// The file, or what stands for it.
        file: PathBuf,
        /// Requested memory, bytes.
        bytes: usize,
    },
    /// The file can be read, but what it says cannot be simulated.
    #[error("{}{}: {problem}; {remedy}", file.display(), line.map(|line| format!(":{line}")).unwrap_or_default())]
    Invalid {
        /// The file, or what stands for it where the scene was built in code.
        file: PathBuf,
        /// Line, from 1; none where there is no file, and the problem names the field by its path.
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
    /// [`SceneFileError`] if the file is missing, is not TOML, says something that is not read, holds a value out of range, or prescribes
    /// a motion that its step passes over.
    pub fn load(file: impl AsRef<Path>) -> Result<Scene, SceneFileError> {
        let file = file.as_ref();
        let missing = |source| SceneFileError::Missing { file: file.to_path_buf(), source };
        let text = std::fs::read_to_string(file).map_err(missing)?;
        Scene::parse(&text).map_err(|error| error.in_file(file, Some(&text)))
    }
}
