//! A scene in the engine Rapier at many settings, measured as all codes are:
//! `cargo run --release -p makadam-rapier -- SCENE SEEDS FOLDER [SETTINGS...]`.
//!
//! Writes `rapier.csv` (one row a run) and `rapier.json` (where they came from) to the folder; `makadam tradeoff` shows them
//! where they lie beside the scene, in `tradeoff/MACHINE`. SETTINGS, as the first column of `rapier.csv` has them, picks some;
//! runs that the folder holds are not made again.

mod engine;

use engine::{NAME, Rapier, Settings};
use makadam_validation::peers::Code;
use makadam_validation::plan::Scene;
use makadam_validation::scenes;
use makadam_validation::tradeoff::{EngineRuns, KeptRun, Knobs};
use std::path::{Path, PathBuf};

/// Observables beside those that the scene compares.
const FURTHER: [&str; 4] = ["mean_overlap", "largest_overlap", "kinetic_energy", "mechanical_coordination_number"];

/// What all settings share.
const COMMON: &str = "one thread, f64; friction and restitution by the smaller value of the two; no sleep, no continuous \
                      collision detection; walls are cuboids; unless a setting says otherwise Coulomb friction, damping \
                      ratio 10, length unit 0.01 m, one sweep over soft and one over rigid contacts in a substep, \
                      contacts determined anew in every step";

/// The settings: steps, substeps and stiffness of contacts, then one further setting at a time.
fn settings() -> Vec<Settings> {
    let rigid = Settings::RIGID;
    let grid = |step: f64, substeps: usize| Settings { step, substeps, ..rigid.clone() };
    let frequency = |natural_frequency: Option<f64>| Settings { natural_frequency, ..rigid.clone() };
    vec![
        rigid.clone(),
        frequency(None),
        // As it comes, but for the length unit.
        Settings { natural_frequency: None, coulomb: false, recycling: true, ..rigid.clone() },
        Settings { step: 1.0 / 60.0, natural_frequency: None, coulomb: false, recycling: true, ..rigid.clone() },
        grid(4e-3, 4),
        grid(2e-3, 4),
        grid(5e-4, 4),
        frequency(Some(300.0)),
        frequency(Some(1000.0)),
        Settings { recycling: true, ..rigid.clone() },
        Settings { coulomb: false, ..rigid.clone() },
        Settings { length_unit: 1.0, ..rigid.clone() },
        grid(1e-3, 1),
        grid(1e-3, 10),
        grid(2e-3, 10),
        Settings { damping_ratio: 1.0, ..rigid.clone() },
        Settings { iterations: 4, ..rigid.clone() },
        Settings { friction_in_soft_sweeps: true, ..rigid.clone() },
        frequency(Some(100.0)),
        frequency(Some(10_000.0)),
        grid(2.5e-4, 4),
    ]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, seeds, folder, picked @ ..] = arguments.as_slice() else {
        return Err("usage: rapier SCENE SEEDS FOLDER [SETTINGS...]".into());
    };
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = scenes::find(name, std::slice::from_ref(&root))?;
    let scene = Scene::load(&file)?;
    let seeds: u64 = seeds.parse().map_err(|_| format!("'{seeds}' is no number of seeds"))?;
    let version = crate_version(&root.join("Cargo.lock"))?;
    let chosen: Vec<Settings> =
        settings().into_iter().filter(|one| picked.is_empty() || picked.contains(&one.words())).collect();
    if chosen.is_empty() || seeds == 0 {
        return Err(format!("nothing to run: {} settings, {seeds} seeds", chosen.len()).into());
    }

    let chosen: Vec<(Knobs, Box<dyn Code>)> = chosen
        .into_iter()
        .map(|settings| {
            let (setting, short_setting) = (settings.words(), settings.short_words());
            let knobs = Knobs::Engine { step: settings.step, setting, short_setting };
            let code: Box<dyn Code> = Box::new(Rapier { settings, version: version.clone() });
            (knobs, code)
        })
        .collect();
    EngineRuns {
        code: NAME,
        engine: &version,
        common: COMMON,
        stem: "rapier",
        scene: &scene,
        scene_file: &file,
        seeds,
        further: &FURTHER,
        folder: Path::new(folder),
        command: &command(&arguments),
    }
    .carry_out(&chosen, |kept| {
        let (setting, seed, pace) = (kept.configuration.setting(), kept.run.seed, kept.pace());
        println!("{setting}, seed {seed}: {pace:.2} s a simulated second{}", brief(kept));
    })?;
    Ok(())
}

fn command(arguments: &[String]) -> String {
    let quoted = arguments.iter().map(|word| if word.contains(' ') { format!("'{word}'") } else { word.clone() });
    ["cargo run --release -p makadam-rapier --".to_string()].into_iter().chain(quoted).collect::<Vec<_>>().join(" ")
}

/// A few observables of a run.
fn brief(kept: &KeptRun) -> String {
    let names =
        ["packing_fraction", "coordination_number", "mean_overlap", "largest_overlap", "wall_force_over_weight"];
    let known = names.iter().filter_map(|name| Some(format!(", {name} {:.4}", kept.run.value(name)?)));
    known.collect()
}

/// Crate and version that the lock file pins.
fn crate_version(lock: &Path) -> Result<String, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(lock)?;
    let (_, after) =
        text.split_once("name = \"rapier3d-f64\"\nversion = \"").ok_or("Cargo.lock names no rapier3d-f64")?;
    let version = after.split('"').next().unwrap_or_default();
    Ok(format!("rapier3d-f64 {version}"))
}
