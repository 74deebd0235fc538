//! Files of recorded references; an error of reading names the file and the line.

use super::{
    FORCE_COLUMNS, FinalState, ForceDistribution, ForceLine, GRAIN_COLUMNS, GrainLine, MEASUREMENT_COLUMNS,
    MeasuredRun, MeasurementLine, RUN_COLUMNS, Reference, SERIES_COLUMNS, Series, SeriesLine, final_state_file,
    published,
};
use crate::scenes;
use crate::study::{DocumentError, File, Table, cells};
use makadam::snapshot::Particle;
use makadam_frames::output::cells::as_meant;
use makadam_frames::output::{WriteError, create_folder, write_whole};
use makadam_frames::recording::LARGEST;
use makadam_measure::observables::Measurement;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// Error of reading recorded references.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}; restore it from the repository, or remove its folder and record anew with 'makadam compare SCENE --record'", file.display())]
    Io {
        /// File.
        file: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// A line is invalid.
    #[error("{}:{line}: {problem}; restore the file from the repository, or remove its folder and record anew with 'makadam compare SCENE --record'", file.display())]
    Line {
        /// File.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Fault.
        problem: String,
    },
}

impl Reference {
    /// Reads the references of the scene of a file, on a disk or in the program, if there are any. [`Reference::code_on`] selects those
    /// of a changed scene.
    ///
    /// # Errors
    /// [`Reference::load`] states them.
    pub fn of_scene(scene_file: &Path) -> Result<Option<Reference>, ReferenceError> {
        let scene_file = &scenes::origin(scene_file);
        let folder = Reference::folder(scene_file);
        match scenes::is_built_in(scene_file) {
            true => Reference::read(&folder, &scenes::read),
            false => Reference::load(&folder),
        }
    }

    /// Reads the references in a folder; `None` if there is neither `runs.csv` nor `published.csv`.
    ///
    /// # Errors
    /// [`ReferenceError`] if a file is missing or a line is wrong.
    pub fn load(folder: &Path) -> Result<Option<Reference>, ReferenceError> {
        Reference::read(folder, &|file| std::fs::read(file))
    }

    /// Reads the references in a folder from the contents that `bytes` returns; `None` if there is neither `runs.csv` nor
    /// `published.csv`. Any bytes are either references or an error.
    ///
    /// # Errors
    /// [`Reference::load`] states them.
    pub fn read(folder: &Path, bytes: Bytes<'_>) -> Result<Option<Reference>, ReferenceError> {
        let published = published::read(&folder.join("published.csv"), bytes)?;
        let Some(runs) = lines_if_there::<MeasuredRun>(&folder.join("runs.csv"), RUN_COLUMNS, bytes)? else {
            return Ok(published.map(|published| Reference { published, ..Reference::default() }));
        };
        let file = folder.join("runs.csv");
        if runs.is_empty() {
            return Err(ReferenceError::Line { file, line: 1, problem: "no run is recorded".into() });
        }
        all_alike(&runs).map_err(|(line, problem)| ReferenceError::Line { file, line, problem })?;
        let runs = runs.into_iter().map(|(_, run)| run).collect();
        let mut reference = Reference { runs, published: published.unwrap_or_default(), ..Reference::default() };
        reference.read_measurements(&folder.join("measurements.csv"), bytes)?;
        reference.read_forces(&folder.join("forces.csv"), bytes)?;
        reference.read_series(&folder.join("series.csv"), bytes)?;
        reference.read_final_states(folder, bytes)?;
        Ok(Some(reference))
    }

    fn read_measurements(&mut self, file: &Path, bytes: Bytes<'_>) -> Result<(), ReferenceError> {
        for (at, line) in lines::<MeasurementLine>(file, MEASUREMENT_COLUMNS, bytes)? {
            let run = self.runs.iter_mut().find(|run| run.code == line.code && run.seed == line.seed);
            let Some(run) = run else {
                let problem = format!("{} seed {} has no line in runs.csv", line.code, line.seed);
                return Err(ReferenceError::Line { file: file.to_path_buf(), line: at, problem });
            };
            let refused = |problem: String| Err(ReferenceError::Line { file: file.to_path_buf(), line: at, problem });
            let of_run = format!("{} seed {}", line.code, line.seed);
            if run.value(&line.observable).is_some() {
                return refused(format!("{of_run} has a second value of {}", line.observable));
            }
            if line.value.is_nan() || line.value.abs() >= LARGEST {
                return refused(format!("{} of {of_run} is {}, which nothing measures", line.observable, line.value));
            }
            run.measurements.push(Measurement {
                observable: line.observable,
                unit: line.unit,
                value: line.value,
                standard_error: line.standard_error,
                frames: line.frames,
            });
        }
        Ok(())
    }

    fn read_forces(&mut self, file: &Path, bytes: Bytes<'_>) -> Result<(), ReferenceError> {
        let lines: Vec<ForceLine> = lines(file, FORCE_COLUMNS, bytes)?.into_iter().map(|(_, line)| line).collect();
        let of_code = |lines: &[ForceLine]| ForceDistribution {
            code: lines[0].0.clone(),
            force: lines.iter().map(|(_, force, ..)| *force).collect(),
            density: lines.iter().map(|(_, _, density, _)| *density).collect(),
            samples: lines[0].3,
        };
        self.forces.extend(lines.chunk_by(|one, next| one.0 == next.0).map(of_code));
        Ok(())
    }

    fn read_series(&mut self, file: &Path, bytes: Bytes<'_>) -> Result<(), ReferenceError> {
        for (_, (code, seed, observable, time, value)) in lines::<SeriesLine>(file, SERIES_COLUMNS, bytes)? {
            let same = |last: &Series| last.code == code && last.seed == seed && last.observable == observable;
            if !self.series.last().is_some_and(same) {
                self.series.push(Series { code, seed, observable, time: Vec::new(), value: Vec::new() });
            }
            let series = self.series.last_mut().expect("one was pushed if there was none");
            series.time.push(time);
            series.value.push(value);
        }
        Ok(())
    }

    /// Pictures are optional: a code without a file has none.
    fn read_final_states(&mut self, folder: &Path, bytes: Bytes<'_>) -> Result<(), ReferenceError> {
        for code in self.codes() {
            let file = folder.join(final_state_file(&code));
            let Some((seed, time)) = self.of(&code).next().map(|first| (first.seed, first.simulated_seconds)) else {
                continue;
            };
            let Some(grains) = lines_if_there::<GrainLine>(&file, GRAIN_COLUMNS, bytes)? else {
                continue;
            };
            let particle =
                |(_, (id, radius, position, velocity, spin))| Particle { id, position, radius, velocity, spin };
            self.final_states.push(FinalState {
                code,
                seed,
                time,
                particles: grains.into_iter().map(particle).collect(),
            });
        }
        Ok(())
    }
}

/// Checks that the runs of a code differ by their seeds alone; the error is a line and its fault.
fn all_alike(runs: &[(u64, MeasuredRun)]) -> Result<(), (u64, String)> {
    for (place, (line, run)) in runs.iter().enumerate() {
        let above_zero = run.time_step > 0.0 && run.rayleigh_fraction.is_none_or(|fraction| fraction > 0.0);
        if !above_zero || run.wall_seconds < 0.0 || run.simulated_seconds < 0.0 {
            let (code, seed) = (&run.code, run.seed);
            return Err((*line, format!("seed {seed} of {code} has a step or a time below zero")));
        }
        let before = runs[..place].iter().map(|(_, before)| before);
        for before in before.filter(|before| before.code == run.code) {
            let differs = [
                ("version", before.version != run.version),
                ("contact law", before.contact_law != run.contact_law),
                ("share of the Rayleigh step", before.rayleigh_fraction != run.rayleigh_fraction),
                ("scene", before.scene_hash != run.scene_hash),
            ];
            let (code, seed) = (&run.code, run.seed);
            if before.seed == seed {
                return Err((*line, format!("{code} has a second run of seed {seed}")));
            }
            if let Some((what, _)) = differs.iter().find(|(_, differs)| *differs) {
                return Err((*line, format!("seed {seed} of {code} has another {what} than seed {}", before.seed)));
            }
        }
    }
    Ok(())
}

/// Returns the bytes of a file.
pub(super) type Bytes<'a> = &'a dyn Fn(&Path) -> std::io::Result<Vec<u8>>;

/// Reads all lines of a CSV file of these columns with their numbers.
fn lines<T: DeserializeOwned>(file: &Path, columns: &str, bytes: Bytes<'_>) -> Result<Vec<(u64, T)>, ReferenceError> {
    let bytes = bytes(file).map_err(|source| ReferenceError::Io { file: file.to_path_buf(), source })?;
    parse(columns, &bytes).map_err(|(line, problem)| ReferenceError::Line { file: file.to_path_buf(), line, problem })
}

/// Reads the lines of a file; `None` where there is none.
pub(super) fn lines_if_there<T: DeserializeOwned>(
    file: &Path,
    columns: &str,
    bytes: Bytes<'_>,
) -> Result<Option<Vec<(u64, T)>>, ReferenceError> {
    match lines(file, columns, bytes) {
        Err(ReferenceError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
        other => other.map(Some),
    }
}

/// Returns all lines of a CSV document with their numbers, or the number of a line and its fault.
fn parse<T: DeserializeOwned>(columns: &str, bytes: &[u8]) -> Result<Vec<(u64, T)>, (u64, String)> {
    let failed = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        match error.into_kind() {
            csv::ErrorKind::Deserialize { err, .. } => (line, err.to_string()),
            csv::ErrorKind::Utf8 { err, .. } => (line, err.to_string()),
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                (line, format!("{len} fields where the head has {expected_len}"))
            }
            other => (line, format!("{other:?}")),
        }
    };
    let mut reader = csv::Reader::from_reader(bytes);
    let headers = reader.headers().map_err(failed)?.clone();
    if !headers.iter().eq(columns.split(' ')) {
        return Err((1, format!("its columns are not {}", columns.replace(' ', ","))));
    }
    let mut lines = Vec::new();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(failed)? {
        let line = record.position().map_or(1, csv::Position::line);
        // No name or unit reads as "inf" or "NaN", so such a field is always meant as a number.
        for (name, field) in headers.iter().zip(&record) {
            if field.parse::<f64>().is_ok_and(|number| !number.is_finite()) {
                return Err((line, format!("'{field}' in column {name} is not a finite number")));
            }
        }
        let mut meant: csv::StringRecord = record.iter().map(as_meant).collect();
        meant.set_position(record.position().cloned());
        lines.push((line, meant.deserialize(Some(&headers)).map_err(failed)?));
    }
    Ok(lines)
}

impl Reference {
    /// Writes the recorded references into a folder; returns false if its files are already equal, and leaves them unchanged.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; files not yet written are unchanged.
    pub fn save(&self, folder: &Path) -> Result<bool, WriteError> {
        create_folder(folder)?;
        let tables = [self.run_lines(), self.measurement_lines(), self.force_lines(), self.series_lines()];
        let mut files = tables.map(|table| table.expect("numbers and text can be written to memory")).to_vec();
        for state in &self.final_states {
            let mut text = GRAIN_COLUMNS.replace(' ', ",") + "\n";
            for grain in &state.particles {
                text += &grain.id.to_string();
                let numbers = [grain.radius].into_iter().chain(grain.position).chain(grain.velocity).chain(grain.spin);
                for number in numbers {
                    text += &format!(",{:?}", rounded(number));
                }
                text.push('\n');
            }
            files.push((final_state_file(&state.code), text.into_bytes()));
        }
        files.retain(|(name, bytes)| std::fs::read(folder.join(name)).ok().as_ref() != Some(bytes));
        files.iter().try_for_each(|(name, bytes)| write_whole(&folder.join(name), bytes))?;
        Ok(!files.is_empty())
    }

    fn run_lines(&self) -> Result<File, DocumentError> {
        let cells = |run: &MeasuredRun| {
            cells![
                &run.code,
                &run.version,
                &run.contact_law,
                run.seed,
                rounded(run.time_step),
                run.rayleigh_fraction,
                rounded(run.wall_seconds),
                rounded(run.simulated_seconds),
                &run.processor,
                &run.date,
                &run.scene_hash,
            ]
        };
        Table::named(RUN_COLUMNS).of(&self.runs, cells).csv("runs")
    }

    fn measurement_lines(&self) -> Result<File, DocumentError> {
        let rows = self.runs.iter().flat_map(|run| {
            let finite = run.measurements.iter().filter(|measured| measured.value.is_finite());
            finite.map(move |measured| (run, measured))
        });
        let cells = |(run, measured): (&MeasuredRun, &Measurement)| {
            cells![
                &run.code,
                &run.version,
                run.seed,
                rounded(run.time_step),
                run.rayleigh_fraction,
                &measured.observable,
                &measured.unit,
                measured.value,
                measured.standard_error.map(rounded),
                measured.frames,
            ]
        };
        Table::named(MEASUREMENT_COLUMNS).of(rows, cells).csv("measurements")
    }

    fn force_lines(&self) -> Result<File, DocumentError> {
        let mut table = Table::named(FORCE_COLUMNS);
        for forces in &self.forces {
            for (&force, &density) in forces.force.iter().zip(&forces.density) {
                table.row(cells![&forces.code, force, rounded(density), forces.samples]);
            }
        }
        table.csv("forces")
    }

    fn series_lines(&self) -> Result<File, DocumentError> {
        let mut table = Table::named(SERIES_COLUMNS);
        for series in &self.series {
            for (&time, &value) in series.time.iter().zip(&series.value) {
                table.row(cells![&series.code, series.seed, &series.observable, rounded(time), rounded(value)]);
            }
        }
        table.csv("series")
    }
}

/// Rounds to six significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
