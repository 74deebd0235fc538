//! Writing recorded references.

use super::{GRAIN_COLUMNS, MeasuredRun, Reference, final_state_file};
use crate::study::{DocumentError, File, Table, cells};
use makadam_frames::output::{WriteError, create_folder, write_whole};
use makadam_measure::observables::Measurement;
use std::path::Path;

impl Reference {
    /// Writes the recorded references into a folder.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; files not yet reached stay as they were.
    pub fn save(&self, folder: &Path) -> Result<(), WriteError> {
        create_folder(folder)?;
        for table in [self.run_lines(), self.measurement_lines(), self.force_lines(), self.series_lines()] {
            let (name, bytes) = table.expect("numbers and text can be written to memory");
            write_whole(&folder.join(name), &bytes)?;
        }
        for state in &self.final_states {
            let mut text = GRAIN_COLUMNS.join(",") + "\n";
            for grain in &state.particles {
                text += &grain.id.to_string();
                let numbers = [grain.radius].into_iter().chain(grain.position).chain(grain.velocity).chain(grain.spin);
                for number in numbers {
                    text += &format!(",{:?}", rounded(number));
                }
                text.push('\n');
            }
            write_whole(&folder.join(final_state_file(&state.code)), text.as_bytes())?;
        }
        Ok(())
    }

    fn run_lines(&self) -> Result<File, DocumentError> {
        let columns = "code version contact_law seed time_step rayleigh_fraction wall_seconds simulated_seconds processor date scene_hash";
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
        Table::named(columns).of(&self.runs, cells).csv("runs")
    }

    fn measurement_lines(&self) -> Result<File, DocumentError> {
        let columns = "code version seed time_step rayleigh_fraction observable unit value standard_error frames";
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
        Table::named(columns).of(rows, cells).csv("measurements")
    }

    fn force_lines(&self) -> Result<File, DocumentError> {
        let mut table = Table::named("code force_over_mean density samples");
        for forces in &self.forces {
            for (&force, &density) in forces.force.iter().zip(&forces.density) {
                table.row(cells![&forces.code, force, rounded(density), forces.samples]);
            }
        }
        table.csv("forces")
    }

    fn series_lines(&self) -> Result<File, DocumentError> {
        let mut table = Table::named("code seed observable time value");
        for series in &self.series {
            for (&time, &value) in series.time.iter().zip(&series.value) {
                table.row(cells![&series.code, series.seed, &series.observable, rounded(time), rounded(value)]);
            }
        }
        table.csv("series")
    }
}

/// Six significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
