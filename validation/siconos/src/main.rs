//! A scene in Siconos over its tolerance, measured as all codes are:
//! `cargo run --release -p makadam-siconos -- SCENE SEEDS FOLDER [SETTINGS...]`.
//!
//! Writes `siconos.csv` (one row a run) and `siconos.json` (where they came from) to the folder; `makadam tradeoff` shows them
//! where they lie beside the scene, in `tradeoff/MACHINE`. SETTINGS, as the first column of `siconos.csv` has them, picks some;
//! runs that the folder holds are not made again.

mod engine;

use engine::{NAME, Settings, Siconos, installed};
use makadam_validation::peers::Code;
use makadam_validation::plan::Scene;
use makadam_validation::scenes;
use makadam_validation::tradeoff::{EngineRuns, KeptRun, Knobs};
use std::path::{Path, PathBuf};

/// Observables beside those that the scene compares.
const FURTHER: [&str; 4] = ["mean_overlap", "largest_overlap", "kinetic_energy", "mechanical_coordination_number"];

/// What all settings share.
const COMMON: &str = "one thread; Moreau and Jean's scheme, theta 0.50001, no correction of overlaps; projected Gauss-Seidel \
                      (NSGS) with its default local solver, from the last step's impulses, at most 10,000 iterations; sparse \
                      block storage; contacts by Bullet, lengths in centimetres; walls are planes";

/// Steps, s, and tolerances.
const STEPS: [f64; 3] = [4e-3, 2e-3, 1e-3];
const TOLERANCES: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6];
/// The setting that is run with assertions too, to tell what they cost.
const PACKAGED: Settings = Settings { step: 2e-3, tolerance: 1e-3, assertions: true };

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, seeds, folder, picked @ ..] = arguments.as_slice() else {
        return Err("usage: siconos SCENE SEEDS FOLDER [SETTINGS...]".into());
    };
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = scenes::find(name, std::slice::from_ref(&root))?;
    let scene = Scene::load(&file)?;
    let seeds: u64 = seeds.parse().map_err(|_| format!("'{seeds}' is no number of seeds"))?;
    let version = installed()?;
    let grid =
        STEPS.into_iter().flat_map(|step| TOLERANCES.map(|tolerance| Settings { step, tolerance, assertions: false }));
    let chosen: Vec<(Knobs, Box<dyn Code>)> = grid
        .chain([PACKAGED])
        .filter(|settings| picked.is_empty() || picked.contains(&settings.words()))
        .map(|settings| {
            let (setting, short_setting) = (settings.words(), settings.short_words());
            let knobs = Knobs::Engine { step: settings.step, setting, short_setting };
            let code: Box<dyn Code> = Box::new(Siconos { settings, version: version.clone() });
            (knobs, code)
        })
        .collect();
    if chosen.is_empty() || seeds == 0 {
        return Err(format!("nothing to run: {} settings, {seeds} seeds", chosen.len()).into());
    }
    let quoted = arguments.iter().map(|word| if word.contains(' ') { format!("'{word}'") } else { word.clone() });
    let command: Vec<String> =
        ["cargo run --release -p makadam-siconos --".to_string()].into_iter().chain(quoted).collect();
    EngineRuns {
        code: NAME,
        engine: &format!("Siconos {version}"),
        common: COMMON,
        stem: "siconos",
        scene: &scene,
        scene_file: &file,
        seeds,
        further: &FURTHER,
        folder: Path::new(folder),
        command: &command.join(" "),
    }
    .carry_out(&chosen, |kept| {
        let (setting, seed, pace) = (kept.configuration.setting(), kept.run.seed, kept.pace());
        println!("{setting}, seed {seed}: {pace:.2} s a simulated second{}", brief(kept));
    })?;
    Ok(())
}

/// A few observables of a run.
fn brief(kept: &KeptRun) -> String {
    let names =
        ["packing_fraction", "coordination_number", "mean_overlap", "largest_overlap", "wall_force_over_weight"];
    let known = names.iter().filter_map(|name| Some(format!(", {name} {:.4}", kept.run.value(name)?)));
    known.collect()
}
