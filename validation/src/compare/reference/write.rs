//! Writing recorded references.

use super::{
    FORCE_COLUMNS, ForceLine, GRAIN_COLUMNS, MEASUREMENT_COLUMNS, MeasuredRun, MeasurementLine, RUN_COLUMNS, Reference,
    RunLine, SERIES_COLUMNS, SeriesLine, final_state_file,
};
use crate::compare::CodeRuns;
use crate::output::{WriteError, create_folder, write_whole};
use makadam::scene::Scene;
use serde::Serialize;
use std::path::Path;

impl Reference {
    /// Takes in runs of one code, in place of what was recorded of it at the same stiffness. Distribution, series and
    /// final state are taken from runs at the scene's own stiffness only.
    pub fn replace(&mut self, code: CodeRuns, stiffness_factor: f64, physics: String) {
        let name = code.code;
        self.runs.retain(|run| run.code != name || run.stiffness_factor != stiffness_factor);
        self.runs.extend(code.runs);
        self.runs.sort_by(|a, b| {
            (&a.code, a.stiffness_factor, a.seed)
                .partial_cmp(&(&b.code, b.stiffness_factor, b.seed))
                .expect("factors are finite")
        });
        if stiffness_factor == 1.0 {
            self.physics.retain(|(known, _)| *known != name);
            self.physics.push((name.clone(), physics));
            self.forces.retain(|forces| forces.code != name);
            self.forces.extend(code.forces);
            self.series.retain(|series| series.code != name);
            self.series.extend(code.series);
            self.final_states.retain(|state| state.code != name);
            self.final_states.extend(code.final_state);
        } else if !self.physics.iter().any(|(known, _)| *known == name) {
            self.physics.push((name, physics));
        }
    }

    /// Writes the references of a scene into a folder.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; files not yet reached stay as they were.
    pub fn save(&self, scene: &Scene, folder: &Path) -> Result<(), WriteError> {
        create_folder(folder)?;
        let hash =
            |code: &str| self.physics.iter().find(|(known, _)| known == code).map_or("", |(_, hash)| hash.as_str());
        let runs = self.runs.iter().map(|run| run_line(run, hash(&run.code)));
        write_whole(&folder.join("runs.csv"), &to_csv(&RUN_COLUMNS, runs))?;
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
        write_whole(&folder.join("README.md"), self.account(scene).as_bytes())
    }

    /// How the numbers were made, for people.
    fn account(&self, scene: &Scene) -> String {
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
            let date = first.date.split('T').next().unwrap_or_default();
            text += &format!(
                "| {code} | {} | {stiffness} | {} | {:.3e} | {fraction} | {} | {date} |\n",
                first.version,
                runs.len(),
                first.time_step,
                first.processor
            );
        }
        text += "\nMade by\n\n```\n";
        for (code, factor) in &kinds {
            let (first, seeds) = (self.at(code, *factor).next(), self.at(code, *factor).count());
            let fraction = first.and_then(|run| run.rayleigh_fraction).unwrap_or_default();
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

fn run_line(run: &MeasuredRun, scene_hash: &str) -> RunLine {
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
        scene_hash: scene_hash.to_string(),
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

/// Lines below their head, which stands there even if there is no line.
fn to_csv<T: Serialize>(columns: &[&str], lines: impl Iterator<Item = T>) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(columns).expect("text can be written to memory");
    for line in lines {
        writer.serialize(line).expect("numbers and text can be written to memory");
    }
    writer.into_inner().expect("memory can be flushed")
}
