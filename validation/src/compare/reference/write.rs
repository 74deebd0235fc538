//! Writing recorded references.

use super::{
    FORCE_COLUMNS, ForceLine, GRAIN_COLUMNS, MEASUREMENT_COLUMNS, MeasuredRun, MeasurementLine, RUN_COLUMNS, Reference,
    RunLine, SERIES_COLUMNS, SeriesLine, days, final_state_file, processors,
};
use crate::output::cells::csv_below;
use crate::output::{WriteError, create_folder, write_whole};
use crate::plan::Scene;
use serde::Serialize;
use std::path::Path;

impl Reference {
    /// Writes the references of a scene into a folder.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; files not yet reached stay as they were.
    pub fn save(&self, scene: &Scene, folder: &Path) -> Result<(), WriteError> {
        create_folder(folder)?;
        write_whole(&folder.join("runs.csv"), &to_csv(&RUN_COLUMNS, self.runs.iter().map(run_line)))?;
        let measurements = self.runs.iter().flat_map(measurement_lines);
        write_whole(&folder.join("measurements.csv"), &to_csv(&MEASUREMENT_COLUMNS, measurements))?;
        let forces = self.forces.iter().flat_map(|forces| {
            forces.force.iter().zip(&forces.density).map(|(&force_over_mean, &density)| ForceLine {
                code: forces.code.clone(),
                force_over_mean,
                density: rounded(density),
                samples: forces.samples,
            })
        });
        write_whole(&folder.join("forces.csv"), &to_csv(&FORCE_COLUMNS, forces))?;
        let series = self.series.iter().flat_map(|series| {
            series.time.iter().zip(&series.value).map(|(&time, &value)| SeriesLine {
                code: series.code.clone(),
                seed: series.seed,
                observable: series.observable.clone(),
                time: rounded(time),
                value: rounded(value),
            })
        });
        write_whole(&folder.join("series.csv"), &to_csv(&SERIES_COLUMNS, series))?;
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

    /// How the numbers were made, for people.
    pub(super) fn account(&self, scene: &Scene) -> String {
        let mut text = format!(
            "# Recorded references of `{}`\n\nWhat YADE and LIGGGHTS measured on this scene. Every run started from the \
             grains that Makadam places for its seed, ran on one core, and was measured by the same code that measures \
             Makadam.\n\n| code | version | stiffness | seeds | time step (s) | of the Rayleigh step | processor | date |\n\
             | --- | --- | --- | --- | --- | --- | --- | --- |\n",
            scene.name
        );
        let mut kinds: Vec<(&str, f64)> =
            self.runs.iter().map(|run| (run.code.as_str(), run.stiffness_factor)).collect();
        kinds.dedup();
        for &(code, factor) in &kinds {
            let runs: Vec<&MeasuredRun> = self.at(code, factor).collect();
            let first = runs[0];
            let stiffness = if factor == 1.0 { "E".to_string() } else { format!("{factor} E") };
            let fraction = first.rayleigh_fraction.map_or("-".to_string(), |f| format!("{:.0}%", 100.0 * f));
            text += &format!(
                "| {code} | {} | {stiffness} | {} | {:.3e} | {fraction} | {} | {} |\n",
                first.version,
                runs.len(),
                first.time_step,
                processors(&runs),
                days(&runs)
            );
        }
        text += "\nMade by\n\n```\n";
        for (code, factor) in &kinds {
            // The last seed and not their number: seeds whose run failed leave holes.
            let last = self.at(code, *factor).last();
            let seeds = last.map_or(0, |run| run.seed);
            let fraction = last.and_then(|run| run.rayleigh_fraction).unwrap_or_default();
            let stiffness = if *factor == 1.0 { String::new() } else { format!(" --stiffness-factor {factor}") };
            text += &format!(
                "makadam compare {} --record --codes {} --seeds {seeds} --rayleigh-fraction {fraction}{stiffness}\n",
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

fn run_line(run: &MeasuredRun) -> RunLine {
    RunLine {
        code: run.code.clone(),
        version: run.version.clone(),
        seed: run.seed,
        time_step: rounded(run.time_step),
        rayleigh_fraction: run.rayleigh_fraction,
        stiffness_factor: run.stiffness_factor,
        wall_seconds: rounded(run.wall_seconds),
        simulated_seconds: rounded(run.simulated_seconds),
        processor: run.processor.clone(),
        date: run.date.clone(),
        scene_hash: run.scene_hash.clone(),
    }
}

fn measurement_lines(run: &MeasuredRun) -> impl Iterator<Item = MeasurementLine> {
    run.measurements.iter().filter(|measurement| measurement.value.is_finite()).map(|measurement| MeasurementLine {
        code: run.code.clone(),
        version: run.version.clone(),
        seed: run.seed,
        time_step: rounded(run.time_step),
        rayleigh_fraction: run.rayleigh_fraction,
        stiffness_factor: run.stiffness_factor,
        observable: measurement.observable.clone(),
        unit: measurement.unit.clone(),
        value: measurement.value,
        standard_error: measurement.standard_error.map(rounded),
        frames: measurement.frames,
    })
}

/// Six significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Lines below their head.
fn to_csv<T: Serialize>(columns: &[&str], lines: impl Iterator<Item = T>) -> Vec<u8> {
    csv_below(columns, lines).expect("numbers and text can be written to memory")
}
