//! Frames on disk, as pictures and as pages, by the modules of the command.

use crate::errors::{exception, warn};
use crate::stepping::beside;
use makadam::snapshot::Snapshot;
use makadam_frames::output::{RunFiles, WriteError, create_folder};
use makadam_frames::plan::{MeasuredScene, Output};
use makadam_frames::run_frames::{RunFrames, StoreWriter};
use makadam_view::pictures::{Content, Style, write_png};
use makadam_view::viewer::{self, Wishes, fields_of};
use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray3};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Smallest and largest side of a picture, pixels: memory suffices for this range.
const SIDES: std::ops::RangeInclusive<usize> = 64..=4096;

/// Frames of a scene, in the order of time.
pub struct Frames {
    pub scene: MeasuredScene,
    pub frames: Vec<Arc<Snapshot>>,
}

/// Picture options of the caller; see `makadam.Simulation.picture`.
pub struct PictureRequest<'a> {
    pub field: Option<String>,
    pub range: Option<[f64; 2]>,
    pub view: &'a str,
    pub clip: Option<&'a str>,
    pub walls: bool,
    pub all_grains: bool,
    pub size: [usize; 2],
}

/// Page options of the caller; see `makadam.Simulation.view`.
pub struct PageRequest {
    pub fields: Option<Vec<String>>,
    pub every: Option<usize>,
    pub megabytes: f64,
    pub contacts: bool,
    pub walls: bool,
    pub all_grains: bool,
}

impl Frames {
    /// Refuses an empty list of frames, or frames that are not in the order of time.
    fn check(&self) -> Result<(), String> {
        if self.frames.is_empty() {
            return Err("there are no frames; give at least one".into());
        }
        match self.frames.windows(2).find(|pair| pair[0].time >= pair[1].time) {
            Some(pair) => Err(format!(
                "a frame at {} s follows one at {} s; give frames in the order of time, each once",
                pair[1].time, pair[0].time
            )),
            None => Ok(()),
        }
    }

    /// Writes the frames into the frame store of a folder, like `makadam run`.
    fn write(&self, folder: &Path) -> Result<(), WriteError> {
        create_folder(folder)?;
        let mut store = StoreWriter::create(&folder.join(RunFiles::FRAMES), &self.scene)?;
        self.frames.iter().try_for_each(|frame| store.append(frame))
    }

    /// Returns the frames with all data for a picture.
    fn run(self, walls: bool) -> RunFrames {
        let scene = MeasuredScene { output: Some(Output { walls, ..Output::default() }), ..self.scene };
        RunFrames::in_memory(&scene, self.frames)
    }

    /// Writes the frames into a folder, which must not contain frames yet.
    pub fn save(mut self, py: Python<'_>, folder: PathBuf, walls: bool) -> PyResult<()> {
        if !walls {
            self.scene.output.get_or_insert_default().walls = false;
        }
        let saved = beside(py, || {
            self.check()?;
            if RunFiles::inside(&folder).any() {
                return Err(format!("{} holds frames already; give another folder", folder.display()));
            }
            self.write(&folder).map_err(|error| error.to_string())
        })?;
        saved.map_err(|problem| exception(py, "JudgeError", &problem))
    }

    /// Draws the last frame and writes the file, if given. Returns its pixels, (height, width, 3).
    pub fn picture<'py>(
        self,
        py: Python<'py>,
        file: Option<PathBuf>,
        request: PictureRequest<'_>,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let refuse = |problem: String| exception(py, "JudgeError", &problem);
        let PictureRequest { field, range, view, clip, walls, all_grains, size } = request;
        if let Some(side) = size.iter().find(|side| !SIDES.contains(side)) {
            let (least, most) = (SIDES.start(), SIDES.end());
            return Err(refuse(format!("size: {side} pixels are not possible; give {least} to {most} for each side")));
        }
        if let Some([low, high]) = range.filter(|[low, high]| !(low.is_finite() && high.is_finite() && low < high)) {
            return Err(refuse(format!(
                "range: {low} to {high} is no range; give two finite numbers, the smaller first"
            )));
        }
        let view = view.parse().map_err(|problem| refuse(format!("view: {problem}")))?;
        let cut = clip.map(str::parse).transpose().map_err(|problem| refuse(format!("clip: {problem}")))?;
        let content = Content { field, range, all_grains };
        let drawn = beside(py, || -> Result<_, String> {
            self.check()?;
            let run = self.run(walls);
            let frame = run.read(run.count() - 1).map_err(|error| error.to_string())?;
            let style = Style { size, view, cut, walls };
            let drawn = content.picture(&run, &frame, &style).map_err(|error| error.to_string())?;
            if let Some(file) = file.filter(|_| !makadam_frames::interrupt::requested()) {
                write_png(&file, &drawn).map_err(|error| error.to_string())?;
            }
            Ok(drawn)
        })?;
        let drawn = drawn.map_err(refuse)?;
        let pixels = Array3::from_shape_vec((drawn.height, drawn.width, 3), drawn.bytes);
        Ok(pixels.expect("three bytes per pixel").into_pyarray(py))
    }

    /// Writes the frames as one HTML file, and warns of omissions.
    pub fn view(self, py: Python<'_>, file: PathBuf, request: PageRequest) -> PyResult<()> {
        let refuse = |problem: String| exception(py, "JudgeError", &problem);
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        if !matches!(ending.as_deref(), Some("html" | "htm")) {
            return Err(refuse(format!("{}: its name must end in .html or .htm", file.display())));
        }
        let PageRequest { fields, every, megabytes, contacts, walls, all_grains } = request;
        if every == Some(0) || !(megabytes > 0.0 && megabytes.is_finite()) {
            return Err(refuse("every and megabytes: give numbers above 0".into()));
        }
        let page = beside(py, || {
            self.check()?;
            let run = self.run(walls);
            let last = run.read(run.count() - 1).map_err(|error| error.to_string())?;
            let fields = fields_of(&last, fields.as_deref());
            let wishes = Wishes { fields, every, most_bytes: 1e6 * megabytes, contacts, all_grains };
            viewer::write(&file, &run, &wishes, &|_| {}).map_err(|error| error.to_string())
        })?;
        match page.map_err(refuse)?.note {
            note if note.is_empty() => Ok(()),
            note => warn(py, &format!("{}: {note}", file.display())),
        }
    }
}
