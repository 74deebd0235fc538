//! Reading recorded references; an error names the file and the line.

use super::{
    FinalState, ForceDistribution, ForceLine, GrainLine, MeasuredRun, MeasurementLine, Reference, RunLine, Series,
    SeriesLine, final_state_file,
};
use crate::observables::Measurement;
use makadam::snapshot::Particle;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// Why recorded references could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}; restore it from the repository, or record anew with 'makadam compare SCENE --record'", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line is not what it should be.
    #[error("{}:{line}: {problem}; restore the file from the repository, or record anew with 'makadam compare SCENE --record'", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// What is wrong.
        problem: String,
    },
}

impl Reference {
    /// Reads the references in a folder; `None` if there is no `runs.csv`.
    ///
    /// # Errors
    /// [`ReferenceError`] if a file is missing or a line is wrong.
    pub fn load(folder: &Path) -> Result<Option<Reference>, ReferenceError> {
        let runs_file = folder.join("runs.csv");
        if !runs_file.is_file() {
            return Ok(None);
        }
        let runs = lines::<RunLine>(&runs_file)?.into_iter().map(|(_, line)| run(line)).collect();
        let mut reference = Reference { runs, ..Reference::default() };
        reference.read_measurements(&folder.join("measurements.csv"))?;
        reference.read_forces(&folder.join("forces.csv"))?;
        reference.read_series(&folder.join("series.csv"))?;
        reference.read_final_states(folder)?;
        Ok(Some(reference))
    }

    fn read_measurements(&mut self, file: &Path) -> Result<(), ReferenceError> {
        for (at, line) in lines::<MeasurementLine>(file)? {
            if !line.value.is_finite() {
                let problem = format!("the value of {} is not a finite number", line.observable);
                return Err(ReferenceError::Line { file: file.to_path_buf(), line: at, problem });
            }
            let run = self.runs.iter_mut().find(|run| {
                run.code == line.code && run.seed == line.seed && run.stiffness_factor == line.stiffness_factor
            });
            let Some(run) = run else {
                let problem = format!(
                    "{} seed {} at {} times the stiffness has no line in runs.csv",
                    line.code, line.seed, line.stiffness_factor
                );
                return Err(ReferenceError::Line { file: file.to_path_buf(), line: at, problem });
            };
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

    fn read_forces(&mut self, file: &Path) -> Result<(), ReferenceError> {
        for (_, line) in lines::<ForceLine>(file)? {
            if self.forces.last().is_none_or(|last| last.code != line.code) {
                let (force, density) = (Vec::new(), Vec::new());
                self.forces.push(ForceDistribution { code: line.code, force, density, samples: line.samples });
            }
            let forces = self.forces.last_mut().expect("one was pushed if there was none");
            forces.force.push(line.force_over_mean);
            forces.density.push(line.density);
        }
        Ok(())
    }

    fn read_series(&mut self, file: &Path) -> Result<(), ReferenceError> {
        for (_, line) in lines::<SeriesLine>(file)? {
            let same =
                |last: &Series| last.code == line.code && last.seed == line.seed && last.observable == line.observable;
            if !self.series.last().is_some_and(same) {
                let (time, value) = (Vec::new(), Vec::new());
                self.series.push(Series { code: line.code, seed: line.seed, observable: line.observable, time, value });
            }
            let series = self.series.last_mut().expect("one was pushed if there was none");
            series.time.push(line.time);
            series.value.push(line.value);
        }
        Ok(())
    }

    /// Pictures are welcome, not needed: a code without a file has none.
    fn read_final_states(&mut self, folder: &Path) -> Result<(), ReferenceError> {
        for code in self.codes() {
            let file = folder.join(final_state_file(&code));
            let Some(first) = self.at(&code, 1.0).next().filter(|_| file.is_file()) else {
                continue;
            };
            let (seed, time) = (first.seed, first.simulated_seconds);
            let particles = lines::<GrainLine>(&file)?.into_iter().map(|(_, grain)| particle(&grain)).collect();
            self.final_states.push(FinalState { code, seed, time, particles });
        }
        Ok(())
    }
}

fn run(line: RunLine) -> MeasuredRun {
    MeasuredRun {
        code: line.code,
        version: line.version,
        seed: line.seed,
        time_step: line.time_step,
        rayleigh_fraction: line.rayleigh_fraction,
        stiffness_factor: line.stiffness_factor,
        wall_seconds: line.wall_seconds,
        simulated_seconds: line.simulated_seconds,
        processor: line.processor,
        date: line.date,
        scene_hash: line.scene_hash,
        measurements: Vec::new(),
    }
}

fn particle(grain: &GrainLine) -> Particle {
    Particle {
        id: grain.id,
        position: [grain.x, grain.y, grain.z],
        radius: grain.radius,
        velocity: [grain.vx, grain.vy, grain.vz],
        spin: [grain.wx, grain.wy, grain.wz],
    }
}

/// All lines of a CSV file with their numbers.
fn lines<T: DeserializeOwned>(file: &Path) -> Result<Vec<(u64, T)>, ReferenceError> {
    let failed = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        match error.into_kind() {
            csv::ErrorKind::Io(source) => ReferenceError::Io { file: file.to_path_buf(), source },
            csv::ErrorKind::Deserialize { err, .. } => {
                ReferenceError::Line { file: file.to_path_buf(), line, problem: err.to_string() }
            }
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                let problem = format!("{len} fields where the head has {expected_len}");
                ReferenceError::Line { file: file.to_path_buf(), line, problem }
            }
            other => ReferenceError::Line { file: file.to_path_buf(), line, problem: format!("{other:?}") },
        }
    };
    let mut reader = csv::Reader::from_path(file).map_err(failed)?;
    let headers = reader.headers().map_err(failed)?.clone();
    let mut lines = Vec::new();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(failed)? {
        let line = record.position().map_or(1, csv::Position::line);
        lines.push((line, record.deserialize(Some(&headers)).map_err(failed)?));
    }
    Ok(lines)
}
