//! Published numbers of other codes: values of a run, or a curve over time. They have no seeds and no spread.

use super::files::{Bytes, ReferenceError, lines_if_there};
use super::{CodeRuns, MeasuredRun, Reference, Series, Source, Timing, distinct};
use crate::scenes;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::Measurement;
use makadam_measure::observables::catalogue::definition;
use serde::Deserialize;
use std::path::Path;

/// Columns of `published.csv`; the time (s after `measure.from`) is empty for a value of the run.
const COLUMNS: &str = "code source observable time value";

/// A line of `published.csv`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(super) struct PublishedLine {
    code: String,
    source: String,
    observable: String,
    time: Option<f64>,
    value: f64,
}

impl PublishedLine {
    /// Returns the name of the compared number, `grain_count(bed) at 0.5 s` for a value at a time.
    fn name(&self) -> String {
        self.time.map_or(self.observable.clone(), |time| format!("{} at {time} s", self.observable))
    }

    /// Returns the name of the code, which differs from that of its recorded runs.
    fn code(&self) -> String {
        format!("{} (published)", self.code)
    }
}

/// Reads published numbers; `None` without the file.
pub(super) fn read(file: &Path, bytes: Bytes<'_>) -> Result<Option<Vec<PublishedLine>>, ReferenceError> {
    let Some(numbered) = lines_if_there::<PublishedLine>(file, COLUMNS, bytes)? else { return Ok(None) };
    for (place, (line, published)) in numbered.iter().enumerate() {
        let fault = match definition(&published.observable) {
            None => Some(format!("nothing measures '{}'", published.observable)),
            Some(_) => {
                let is_second = |(_, before): &(u64, PublishedLine)| {
                    (&before.code, before.name()) == (&published.code, published.name())
                };
                let is_known = numbered[..place].iter().any(is_second);
                is_known.then(|| format!("{} has a second value of {}", published.code, published.name()))
            }
        };
        if let Some(problem) = fault {
            return Err(ReferenceError::Line { file: file.to_path_buf(), line: *line, problem });
        }
    }
    Ok(Some(numbered.into_iter().map(|(_, line)| line).collect()))
}

impl Reference {
    /// Returns true if numbers are published on a scene, on a disk or in the program.
    pub fn is_published(scene_file: &Path) -> bool {
        scenes::read(&Reference::folder(&scenes::origin(scene_file)).join("published.csv")).is_ok()
    }

    /// Returns the published numbers of each code on a scene, without seeds.
    pub fn published(&self, scene: &MeasuredScene) -> Vec<CodeRuns> {
        let codes = self.published.iter().map(PublishedLine::code).collect::<Vec<_>>();
        distinct(codes.iter().map(String::as_str)).into_iter().map(|code| self.published_of(code, scene)).collect()
    }

    fn published_of(&self, code: &str, scene: &MeasuredScene) -> CodeRuns {
        let lines: Vec<&PublishedLine> = self.published.iter().filter(|line| line.code() == code).collect();
        let sources = distinct(lines.iter().map(|line| line.source.as_str())).join("; ");
        let measurement = |line: &&PublishedLine| Measurement {
            observable: line.name(),
            unit: definition(&line.observable).map_or("", |definition| definition.unit).into(),
            value: line.value,
            standard_error: None,
            frames: 1,
        };
        let run = MeasuredRun {
            code: code.into(),
            version: String::new(),
            seed: 1,
            contact_law: String::new(),
            time_step: 0.0,
            rayleigh_fraction: None,
            wall_seconds: 0.0,
            core_seconds: None,
            simulated_seconds: scene.duration,
            processor: String::new(),
            date: String::new(),
            scene_hash: String::new(),
            measurements: lines.iter().map(measurement).collect(),
        };
        CodeRuns {
            code: code.into(),
            source: Source::Published,
            timing: Timing::Published,
            provenance: sources,
            runs: vec![run],
            failed: Vec::new(),
            discarded: None,
            forces: None,
            series: distinct(lines.iter().map(|line| line.observable.as_str()))
                .into_iter()
                .map(|observable| curve(&lines, code, observable, scene.measure.from.unwrap_or(0.0)))
                .filter(|curve| !curve.time.is_empty())
                .collect(),
            final_state: None,
        }
    }

    /// Returns the published numbers that a scene does not compare: code and name.
    pub fn not_compared(&self, scene: &MeasuredScene) -> Vec<String> {
        let is_compared =
            |line: &&PublishedLine| scene.compare.iter().any(|expectation| expectation.observable == line.name());
        let left = self.published.iter().filter(|line| !is_compared(line));
        left.map(|line| format!("{}: {}", line.code(), line.name())).collect()
    }
}

/// Returns the curve of an observable; its times are those of the run, s.
fn curve(lines: &[&PublishedLine], code: &str, observable: &str, from: f64) -> Series {
    let points = lines.iter().filter(|line| line.observable == observable);
    let (time, value) = points.filter_map(|line| Some((line.time? + from, line.value))).unzip();
    Series { code: code.into(), seed: 1, observable: observable.into(), time, value }
}

#[cfg(test)]
#[path = "../../../tests/unit/compare_published.rs"]
mod tests;
