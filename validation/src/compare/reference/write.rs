//! Writing recorded references.

use super::{GRAIN_COLUMNS, MeasuredRun, Reference, days, final_state_file, processors};
use crate::observables::Measurement;
use crate::output::{WriteError, create_folder, write_whole};
use crate::plan::Scene;
use crate::study::{DocumentError, File, Table, cells};
use std::path::Path;

impl Reference {
    /// Writes the references of a scene into a folder.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; files not yet reached stay as they were.
    pub fn save(&self, scene: &Scene, folder: &Path) -> Result<(), WriteError> {
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
        write_whole(&folder.join("README.md"), self.account(scene).as_bytes())?;
        super::checksums::write(folder)
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

    /// How the numbers were made, for people.
    pub(super) fn account(&self, scene: &Scene) -> String {
        let mut text = format!(
            "# Recorded references of `{}`\n\nWhat other codes measured on this scene. Every run started from the \
             grains that Makadam places for its seed, ran on one core, and was measured by the same code that measures \
             Makadam.\n\n| code | version | contact law | seeds | time step (s) | of the Rayleigh step | processor | date |\n\
             | --- | --- | --- | --- | --- | --- | --- | --- |\n",
            scene.name
        );
        let codes = self.codes();
        for code in &codes {
            let runs: Vec<&MeasuredRun> = self.of(code).collect();
            let first = runs[0];
            let fraction = first.rayleigh_fraction.map_or("-".to_string(), |f| format!("{:.0}%", 100.0 * f));
            text += &format!(
                "| {code} | {} | {} | {} | {:.3e} | {fraction} | {} | {} |\n",
                first.version,
                first.contact_law,
                runs.len(),
                first.time_step,
                processors(&runs),
                days(&runs)
            );
        }
        text += "\nMade by\n\n```\n";
        for code in &codes {
            // The last seed and not their number: seeds whose run failed leave holes.
            let last = self.of(code).last();
            let seeds = last.map_or(0, |run| run.seed);
            let fraction = last.and_then(|run| run.rayleigh_fraction).unwrap_or_default();
            text += &format!(
                "makadam compare {} --record --codes {} --seeds {seeds} --rayleigh-fraction {fraction}\n",
                scene.name,
                code.to_lowercase()
            );
        }
        text += "```\n\n`runs.csv` lists the runs, `measurements.csv` what was measured of each, `forces.csv` the \
                 distribution of normal forces over their mean (all seeds), `series.csv` observables over time (first \
                 seed), `final-state-*.csv` the grains at the end (first seed, six significant digits; metres, m/s, rad/s). \
                 Wall times were taken while other work shared the machine; speeds are compared only within one run of \
                 `makadam qualify --live`.\n";
        text
    }
}

/// Six significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
