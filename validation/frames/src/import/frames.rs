//! Times of frames: grains in the order of time, each frame with the contacts of its time.

use super::Tables;
use super::columns::Column;
use super::manifest::{Manifest, Missing};
use super::table::{FrameTable, ImportError};
use crate::plan::MeasuredScene;
use crate::recording::Content;
use std::path::Path;

/// Relative tolerance of equal times: files have six digits.
const SAME_TIME: f64 = 1e-6;

/// Frame of grains with its time.
pub(super) struct Frame<'t> {
    /// Simulated time, s.
    pub time: f64,
    pub grains: &'t FrameTable,
    pub contacts: Vec<&'t FrameTable>,
    /// True if the scene measures the frame.
    pub is_measured: bool,
}

/// Files of a run during assembly; missing statements are reported together.
pub(super) struct Assembly<'a> {
    pub scene: &'a MeasuredScene,
    pub manifest: &'a Manifest,
    pub tables: &'a Tables,
    pub missing: Missing,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

impl<'a> Assembly<'a> {
    /// Sorts the frames of all files by time.
    ///
    /// # Errors
    /// [`ImportError`] for two frames of one time, for more grains than the scene has, and for measured frames without contacts if other frames
    /// have contacts.
    pub fn frames(&mut self) -> Result<Vec<Frame<'a>>, ImportError> {
        let tables = &self.tables.grains;
        let (mut frames, mut has_times) = (Vec::with_capacity(tables.len()), true);
        for grains in tables {
            let time = self.time_of(grains, "grains");
            match (self.manifest.time, time) {
                (Some(_), _) if tables.len() > 1 => {
                    let problem = format!("time states the time of one frame, and the files have {}", tables.len());
                    return Err(grains.fault(0, problem));
                }
                (Some(stated), Some(own)) if !is_same_time(own, stated) => {
                    return Err(grains.fault(0, format!("the frame is at {own} s, and time states {stated} s")));
                }
                _ => {}
            }
            has_times &= time.is_some();
            let time = time.unwrap_or(0.0);
            frames.push(Frame { time, grains, contacts: Vec::new(), is_measured: false });
        }
        if has_times {
            self.sort(&mut frames)?;
            self.count(&frames)?;
        }
        self.add_contacts(&mut frames)?;
        Ok(frames)
    }

    /// Returns the time of a frame, s, from its file or the manifest; adds the manifest lines for a missing time.
    fn time_of(&mut self, table: &FrameTable, key: &str) -> Option<f64> {
        let by_step = || Some(table.step? as f64 * self.manifest.time_step?);
        let time = table.time.or_else(by_step).or(self.manifest.time);
        if time.is_some() {
            return time;
        }
        let is_single = self.tables.grains.len() == 1;
        if table.step.is_none() && is_single {
            self.missing.add(table, 0, "time = SECONDS", "time of the only frame");
            return None;
        }
        if table.step.is_none() {
            let line = format!("{key} = [\"{}\"]", numbered_pattern(&table.file));
            let meaning = "the number of a step, or {time} for a time in seconds; a column time or step states it, too";
            self.missing.add(table, 0, line, meaning);
        }
        let meaning = "time between frames whose numbers differ by one: the time step of the run";
        self.missing.add(table, 0, "time-step = SECONDS", meaning);
        None
    }

    /// Sorts frames by time, each time once, and finds the measured frames.
    ///
    /// # Errors
    /// [`ImportError`] for two frames of one time.
    fn sort(&mut self, frames: &mut Vec<Frame<'a>>) -> Result<(), ImportError> {
        let all = frames.len();
        frames.sort_by(|a, b| a.time.total_cmp(&b.time));
        // A restarted code writes the frame at the restart twice.
        frames.dedup_by(|later, earlier| {
            let same = |frame: &Frame<'a>| (&frame.grains.columns, &frame.grains.values);
            is_same_time(earlier.time, later.time) && same(later) == same(earlier)
        });
        if frames.len() < all {
            self.notes.push(format!("{} frames are the same as another one at their time", all - frames.len()));
        }
        if let Some([one, other]) = frames.array_windows().find(|[one, other]| is_same_time(one.time, other.time)) {
            let problem = format!(
                "it has a frame at {} s, as {} has (line {}); leave one frame at each time, with all grains",
                one.time,
                one.grains.file.display(),
                one.grains.line
            );
            return Err(other.grains.fault(0, problem));
        }
        let last = frames.iter().rposition(|frame| !frame.grains.values.is_empty());
        for (index, frame) in frames.iter_mut().enumerate() {
            frame.is_measured = match self.scene.measure.from {
                Some(_) => self.scene.covers(frame.time, None),
                None => Some(index) == last,
            };
        }
        Ok(())
    }

    /// Adds a note on frames with fewer grains than the scene.
    ///
    /// # Errors
    /// [`ImportError`] for a frame with more grains than the scene.
    fn count(&mut self, frames: &[Frame<'_>]) -> Result<(), ImportError> {
        let wanted = self.scene.grain_count();
        if let Some(frame) = frames.iter().find(|frame| frame.grains.rows().len() > wanted) {
            let problem = format!(
                "a frame has {} grains, and the scene has {wanted}; leave one frame at each time, in files of its own or told apart by a \
                 column time or step",
                frame.grains.rows().len()
            );
            return Err(frame.grains.fault(0, problem));
        }
        let counts = || frames.iter().map(|frame| frame.grains.rows().len());
        let (fewest, most) = (counts().min().unwrap_or(0), counts().max().unwrap_or(0));
        if (fewest, most) != (wanted, wanted) {
            let found = if fewest == most { format!("{most}") } else { format!("{fewest} to {most}") };
            self.notes.push(format!("the frames have {found} grains, and the scene has {wanted}: these are measured"));
        }
        Ok(())
    }

    /// Adds contact tables to the frames of their times.
    fn add_contacts(&mut self, frames: &mut [Frame<'a>]) -> Result<(), ImportError> {
        let tables = &self.tables.contacts;
        let mut strangers = 0;
        for table in tables {
            let Some(time) = self.time_of(table, "contacts") else { continue };
            let after = frames.partition_point(|frame| frame.time < time);
            let near = [after.checked_sub(1), Some(after)].into_iter().flatten();
            let mut near = near.filter(|index| frames.get(*index).is_some_and(|frame| is_same_time(frame.time, time)));
            let Some(frame) = near.next().map(|index| &mut frames[index]) else {
                strangers += 1;
                continue;
            };
            let steps = table.step.zip(frame.grains.step).filter(|_| self.manifest.time_step.is_none());
            if let Some((own, other)) = steps.filter(|(own, other)| own != other) {
                return Err(table.fault(0, format!("its contacts are of step {own}, and the grains of step {other}")));
            }
            match frame.contacts.iter().find(|known| known.file == table.file) {
                Some(known) if known.values == table.values => {}
                Some(_) => {
                    let problem = format!("it has two frames of contacts at {} s; leave one at each time", frame.time);
                    return Err(table.fault(0, problem));
                }
                None => frame.contacts.push(table),
            }
        }
        if strangers > 0 {
            self.notes.push(format!(
                "{strangers} frames of contacts have no frame of grains at their time: they are not measured"
            ));
        }
        // A frame missing from all contact files would count as a frame without contacts.
        for (column, content) in [(Column::Second, Content::Contacts), (Column::Wall, Content::WallContacts)] {
            let has = |table: &&FrameTable| table.find(column).is_some();
            let lists = |frame: &Frame<'_>| frame.contacts.iter().any(&has);
            let Some(first) = tables.iter().find(has) else { continue };
            if let Some(frame) = frames.iter().find(|frame| frame.is_measured && !lists(frame)) {
                let problem = format!(
                    "no file lists {} of the frame at {} s; list those of each measured frame, or measure others (--set measure.from=TIME); \
                     where there are none, leave a file of that frame with the names of its columns alone",
                    content.words(),
                    frame.time
                );
                return Err(first.fault(0, problem));
            }
        }
        Ok(())
    }
}

/// Returns true if two times are equal within the digits of files.
fn is_same_time(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME_TIME * one.abs().max(other.abs())
}

/// Returns the name of a file with `{step}` instead of its last number, which may be its extension (`grains.100`).
fn numbered_pattern(file: &Path) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let is_digit = |letter: char| letter.is_ascii_digit();
    let (stem, extension) = match name.rfind('.') {
        Some(dot) if !name[dot + 1..].chars().all(is_digit) => name.split_at(dot),
        _ => (&*name, ""),
    };
    let head = stem.trim_end_matches(|letter| !is_digit(letter));
    match head.is_empty() {
        true => format!("NAME_{{step}}{extension}"),
        false => format!("{}{{step}}{}{extension}", head.trim_end_matches(is_digit), &stem[head.len()..]),
    }
}
