//! A frame of a run as a picture: field, colour scale, camera and caption.

use super::{Picture, Scale, Style, Subject, camera, draw, telling};
use makadam_frames::run_frames::{RunFolderError, RunFrame, RunFrames};

/// Content of a picture, next to its [`Style`].
#[derive(Clone, Debug, Default)]
pub struct Content {
    /// Field that grains are coloured by; [`telling`] chooses one, if absent.
    pub field: Option<String>,
    /// Values at the ends of the colour scale, in the field's unit; taken from the frames, if absent.
    pub range: Option<[f64; 2]>,
    /// Shows grains far from the walls, too.
    pub all_grains: bool,
}

impl Content {
    /// Returns the field that grains of a frame are coloured by.
    pub fn field_of(&self, frame: &RunFrame) -> String {
        self.field.clone().unwrap_or_else(|| telling(frame).into())
    }

    /// Returns the colour scale of a field with these values.
    pub fn scale_of(&self, title: &str, values: &[f64]) -> Scale {
        self.range.map_or_else(|| Scale::of(title, values), Scale::Range)
    }

    /// Draws a frame of a run.
    ///
    /// # Errors
    /// [`RunFolderError::Unknown`] for a field that cannot be drawn.
    pub fn picture(&self, run: &RunFrames, frame: &RunFrame, style: &Style) -> Result<Picture, RunFolderError> {
        let quantity = run.field(frame, &self.field_of(frame))?;
        let scale = self.scale_of(&quantity.title, &quantity.values);
        let camera = camera(&Subject::of(std::iter::once(frame), self.all_grains), frame, style);
        Ok(draw(frame, &quantity, &scale, &camera, style, &caption(run, frame)))
    }
}

/// Returns the line above a picture: scene and time.
pub fn caption(run: &RunFrames, frame: &RunFrame) -> String {
    format!("{}   t = {:.3} s", run.scene(), frame.time)
}
