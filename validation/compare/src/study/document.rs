//! Files of a study: tables as CSV, all data as JSON, figures as SVG, one page, the same in Markdown.

use super::report::Report;
use makadam_frames::output::cells::csv;
use makadam_frames::output::{Draft, WriteError, create_folder, write_whole};
use makadam_frames::plan::MeasuredScene;
use makadam_view::draw::figure::Figure;
use makadam_view::draw::svg::standalone;
use serde::Serialize;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Name and content of a file.
pub type File = (String, Vec<u8>);

/// Study that can be written to files.
pub trait Document: Serialize {
    /// Name of its files, without extensions.
    const NAME: &'static str;

    /// Tables as CSV, and the provenance.
    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(Vec::new())
    }

    /// Figures.
    fn figures(&self) -> Vec<Figure> {
        Vec::new()
    }

    /// Content for the terminal, the page and Markdown.
    fn report(&self) -> Report;

    /// Writes all files into a folder, creating it if missing, and returns the path of the page. A failure changes no file.
    fn write(&self, folder: &Path) -> Result<PathBuf, DocumentError> {
        let figures = self.figures();
        let mut files = self.tables()?;
        files.push(json(Self::NAME, self)?);
        files.extend(figures.iter().map(drawn));
        let (report, page) = (self.report(), format!("{}.html", Self::NAME));
        files.push((page.clone(), report.page(&figures)?.into_bytes()));
        files.push((format!("{}.md", Self::NAME), report.markdown().into_bytes()));
        write_together(folder, &files)?;
        Ok(folder.join(page))
    }

    /// Writes the tables alone into a folder, creating it if missing.
    fn write_tables(&self, folder: &Path) -> Result<(), DocumentError> {
        write_together(folder, &self.tables()?)
    }
}

/// Error of writing a document. No file is left half-written.
#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    /// The system refused.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The page's template does not match its data.
    #[error("cannot render the page: {0:#}; this is a fault of the program")]
    Template(#[from] minijinja::Error),
    /// The data cannot be written as JSON.
    #[error("cannot write the data as JSON: {0}; this is a fault of the program")]
    Json(#[from] serde_json::Error),
    /// The rows cannot be written as CSV.
    #[error("cannot write the rows as CSV: {0}; this is a fault of the program")]
    Csv(#[from] csv::Error),
}

/// Returns a CSV file of rows.
///
/// # Errors
/// [`DocumentError`] where a row cannot be written.
pub fn table(name: &str, rows: &[impl Serialize]) -> Result<File, DocumentError> {
    Ok((format!("{name}.csv"), csv(rows)?))
}

/// Returns a JSON file of a value.
///
/// # Errors
/// [`DocumentError`] where the value cannot be written.
pub fn json(name: &str, value: &(impl Serialize + ?Sized)) -> Result<File, DocumentError> {
    Ok((format!("{name}.json"), serde_json::to_vec_pretty(value)?))
}

/// Returns a figure as a file NAME.svg.
fn drawn(figure: &Figure) -> File {
    (format!("{}.svg", figure.name), standalone(&figure.svg).into_bytes())
}

/// Writes scenes to `scenes/NAME.toml` in a folder, for manual runs.
pub fn write_scenes<'a>(scenes: impl IntoIterator<Item = &'a MeasuredScene>, folder: &Path) -> Result<(), WriteError> {
    let folder = folder.join("scenes");
    create_folder(&folder)?;
    scenes.into_iter().try_for_each(|scene| {
        let text = toml::to_string(scene).expect("a scene is made of plain tables");
        write_whole(&folder.join(format!("{}.toml", scene.name)), text.as_bytes())
    })
}

/// Writes files into a folder, creating it if missing. All of them are complete on disk under temporary names before
/// the first is renamed, so that files of an earlier command stay intact if this one fails.
pub fn write_together(folder: &Path, files: &[File]) -> Result<(), DocumentError> {
    create_folder(folder)?;
    let mut drafts = Vec::new();
    for (name, bytes) in files {
        let path = folder.join(name);
        let draft = Draft::of(&path);
        write_and_sync(draft.name(), bytes).map_err(|source| WriteError::new(&path, source))?;
        drafts.push(draft);
    }
    Ok(drafts.into_iter().try_for_each(Draft::finish)?)
}

fn write_and_sync(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = std::fs::File::create(path)?;
    file.write_all(bytes)?;
    // Without this a full disk may show only after the rename.
    file.sync_all()
}
