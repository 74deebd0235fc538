//! A scene in Siconos over its tolerance, measured as all codes are:
//! `cargo run --release -p makadam-siconos -- SCENE SEEDS FOLDER [SETTINGS...]`.
//!
//! Writes `siconos.csv` (one row per run) and `siconos.json` (scene, engine, machine and date) to the folder. SETTINGS, as in the
//! first column of `siconos.csv`, selects some of them. Runs that the folder holds are not repeated.

mod engine;

use engine::{NAME, Settings, Siconos, installed};
use makadam_validation::compare::{MeasuredRun, Runs, Share};
use makadam_validation::output::{create_folder, write_whole};
use makadam_validation::peers::{CoreClock, Purpose};
use makadam_validation::plan::{Scene, physics_hash};
use makadam_validation::provenance::{Build, utc};
use makadam_validation::scenes;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Observables in addition to those that the scene compares.
const FURTHER: [&str; 4] = ["mean_overlap", "largest_overlap", "kinetic_energy", "mechanical_coordination_number"];

/// Description of the parts that all settings share.
const COMMON: &str = "one thread; Moreau and Jean's scheme, theta 0.50001, no correction of overlaps; projected Gauss-Seidel \
                      (NSGS) with its default local solver, from the last step's impulses, at most 10,000 iterations; sparse \
                      block storage; contacts by Bullet, lengths in centimetres; walls are planes";

/// Steps, s, and tolerances.
const STEPS: [f64; 3] = [4e-3, 2e-3, 1e-3];
const TOLERANCES: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6];
/// Setting that is also run with assertions, to measure their cost.
const PACKAGED: Settings = Settings { step: 2e-3, tolerance: 1e-3, assertions: true };

/// Columns before the observables.
const COLUMNS: [&str; 8] = [
    "setting",
    "short_setting",
    "time_step",
    "seed",
    "wall_seconds_per_simulated_second",
    "core_share",
    "simulated_seconds",
    "date",
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, seeds, folder, selected @ ..] = arguments.as_slice() else {
        return Err("usage: makadam-siconos SCENE SEEDS FOLDER [SETTINGS...]".into());
    };
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = scenes::find(name, std::slice::from_ref(&root))?;
    let scene = Scene::load(&file)?;
    let seeds: u64 = seeds.parse().map_err(|_| format!("SEEDS = '{seeds}': must be a whole number"))?;
    let version = installed()?;
    let grid =
        STEPS.into_iter().flat_map(|step| TOLERANCES.map(|tolerance| Settings { step, tolerance, assertions: false }));
    let settings: Vec<Settings> =
        grid.chain([PACKAGED]).filter(|settings| selected.is_empty() || selected.contains(&settings.words())).collect();
    if settings.is_empty() || seeds == 0 {
        return Err(format!("nothing to run: {} settings, {seeds} seeds", settings.len()).into());
    }
    let mut observables: Vec<String> = scene.compare.iter().map(|one| one.observable.clone()).collect();
    for name in FURTHER {
        if !observables.iter().any(|known| known == name) {
            observables.push(name.into());
        }
    }
    let mut record = Record::open(Path::new(folder), &scene, &version, &arguments, observables)?;
    // All settings with one seed before the next seed: an interrupted study holds runs of every setting.
    for (seed, settings) in (1..=seeds).flat_map(|seed| settings.iter().map(move |settings| (seed, settings))) {
        if record.holds(settings, seed) {
            continue;
        }
        let runs = Runs {
            scene: &scene,
            scene_file: &file,
            purpose: Purpose::Timing,
            seeds: vec![seed],
            rayleigh_fraction: 0.0,
            stiffness_factor: 1.0,
            time_limit: Duration::MAX,
            recordings: None,
            announce: &|_| -> Share { Box::new(|_| {}) },
        };
        let clock = CoreClock::start();
        let code = Siconos { settings: settings.clone(), version: version.clone() };
        let run = runs.one(&code, &scene, seed)?.run;
        let pace = record.add(settings, &run, clock.share())?;
        println!("{}, seed {seed}: {pace:.2} s per simulated second{}", settings.words(), brief(&run));
    }
    Ok(())
}

/// Selected observables of a run.
fn brief(run: &MeasuredRun) -> String {
    let names =
        ["packing_fraction", "coordination_number", "mean_overlap", "largest_overlap", "wall_force_over_weight"];
    names.iter().filter_map(|name| Some(format!(", {name} {:.4}", run.value(name)?))).collect()
}

/// Runs of one scene on one machine: `siconos.csv` and `siconos.json` in a folder.
struct Record {
    folder: PathBuf,
    origin: Value,
    observables: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

impl Record {
    /// Opens the record of a folder, or begins one.
    ///
    /// # Errors
    /// A record of another scene, engine or processor, or with other columns.
    fn open(
        folder: &Path,
        scene: &Scene,
        version: &str,
        arguments: &[String],
        observables: Vec<String>,
    ) -> Result<Record, Box<dyn std::error::Error>> {
        let quoted = arguments.iter().map(|word| if word.contains(' ') { format!("'{word}'") } else { word.clone() });
        let command: Vec<String> =
            ["cargo run --release -p makadam-siconos --".into()].into_iter().chain(quoted).collect();
        let mut origin = json!({
            "code": NAME,
            "engine": format!("Siconos {version}"),
            "common": COMMON,
            "scene": scene.name,
            "scene_hash": physics_hash(scene),
            "command": command.join(" "),
        });
        let build = serde_json::to_value(Build::here())?;
        origin.as_object_mut().into_iter().for_each(|all| all.extend(build.as_object().cloned().unwrap_or_default()));
        let mut record = Record { folder: folder.into(), origin, observables, rows: Vec::new() };
        let table = folder.join("siconos.csv");
        if !table.exists() {
            create_folder(folder)?;
            return Ok(record);
        }
        let known: Value = serde_json::from_slice(&std::fs::read(folder.join("siconos.json"))?)?;
        for key in ["engine", "common", "scene", "scene_hash", "processor"] {
            let (there, here) = (&known[key], &record.origin[key]);
            if there != here {
                let file = folder.join("siconos.json");
                let problem = format!("{}: {key} = {there}, and these runs have {here}", file.display());
                return Err(format!("{problem}; move the record away, or name another folder").into());
            }
        }
        let mut reader = csv::Reader::from_path(&table)?;
        if !reader.headers()?.iter().eq(record.columns()) {
            let columns = record.columns().collect::<Vec<_>>().join(",");
            return Err(format!("{}:1: the columns must be {columns}", table.display()).into());
        }
        record.rows = reader.records().collect::<Result<_, _>>()?;
        Ok(record)
    }

    fn columns(&self) -> impl Iterator<Item = &str> {
        COLUMNS.into_iter().chain(self.observables.iter().map(String::as_str))
    }

    fn holds(&self, settings: &Settings, seed: u64) -> bool {
        let (words, seed) = (settings.words(), seed.to_string());
        self.rows.iter().any(|row| row.get(0) == Some(&words) && row.get(3) == Some(&seed))
    }

    /// Adds a run, writes both files, and returns the processor time per simulated second.
    fn add(
        &mut self,
        settings: &Settings,
        run: &MeasuredRun,
        share: Option<f64>,
    ) -> Result<f64, Box<dyn std::error::Error>> {
        let core_seconds = run.core_seconds.unwrap_or(run.wall_seconds * share.unwrap_or(1.0));
        let pace = core_seconds / run.simulated_seconds;
        let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let mut row = csv::StringRecord::from(vec![
            settings.words(),
            settings.short_words(),
            run.time_step.to_string(),
            run.seed.to_string(),
            pace.to_string(),
            number(share),
            run.simulated_seconds.to_string(),
            run.date.clone(),
        ]);
        self.observables.iter().for_each(|name| row.push_field(&number(run.value(name))));
        self.rows.push(row);
        self.origin["date"] = utc(SystemTime::now()).into();
        let mut table = csv::Writer::from_writer(Vec::new());
        table.write_record(self.columns())?;
        self.rows.iter().try_for_each(|row| table.write_record(row))?;
        write_whole(&self.folder.join("siconos.json"), &serde_json::to_vec_pretty(&self.origin)?)?;
        write_whole(&self.folder.join("siconos.csv"), &table.into_inner()?)?;
        Ok(pace)
    }
}
