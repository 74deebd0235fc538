//! Records of engines: written and read back, joined with a campaign, refused where they are damaged or do not fit.

use makadam_validation::compare::MeasuredRun;
use makadam_validation::observables::Measurement;
use makadam_validation::peers::{Code, Makadam};
use makadam_validation::plan::{Scene, physics_hash};
use makadam_validation::provenance::Build;
use makadam_validation::tradeoff::{
    Bound, Configuration, EngineOrigin, EngineRecord, EngineRuns, KeptRun, Knobs, Outcome, Plan, Scope, Study, Terms,
    recorded_engines,
};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn smoke() -> Scene {
    Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml")).unwrap()
}

/// A run of a setting; the second observable is left out of the second seed.
fn run(setting: &str, seed: u64, scene: &Scene) -> KeptRun {
    let measured = |name: &str, value: f64| Measurement {
        observable: name.into(),
        unit: String::new(),
        value,
        standard_error: None,
        frames: 1,
    };
    let mut measurements = vec![measured("packing_fraction", 0.59 + 0.01 * seed as f64)];
    if seed != 2 {
        measurements.push(measured("largest_overlap", 1e-3));
    }
    KeptRun {
        configuration: Configuration {
            code: "Rapier".into(),
            stiffness_factor: 1.0,
            knobs: Knobs::Engine { step: 1e-3, setting: setting.into(), short_setting: "1 ms×4".into() },
        },
        extrapolated: false,
        core_share: Some(0.5),
        run: MeasuredRun {
            code: "Rapier".into(),
            version: "an engine 1.2".into(),
            contact_law: String::new(),
            seed,
            time_step: 1e-3,
            rayleigh_fraction: None,
            wall_seconds: 6.0,
            core_seconds: None,
            simulated_seconds: 1.5,
            processor: Build::here().processor,
            date: "2026-01-02T03:04:05Z".into(),
            scene_hash: physics_hash(scene),
            measurements,
        },
        build: Build::here(),
        command: "drive it".into(),
    }
}

fn record(scene: &Scene) -> EngineRecord {
    let settings = ["1 ms × 4 substeps, 3000 Hz", "1 ms × 4 substeps, 30 Hz"];
    let runs = settings.iter().flat_map(|setting| [1, 2, 7].map(|seed| run(setting, seed, scene)));
    EngineRecord {
        origin: EngineOrigin {
            code: "Rapier".into(),
            engine: "an engine 1.2".into(),
            common: "one thread".into(),
            scene: scene.name.clone(),
            scene_hash: physics_hash(scene),
            date: "2026-01-02T03:04:05Z".into(),
            command: "drive it".into(),
            build: Build::here(),
        },
        runs: runs.collect(),
    }
}

/// A scene file with a record beside it.
fn recorded(folder: &Path, record: &EngineRecord) -> PathBuf {
    let observables = ["packing_fraction", "largest_overlap"].map(String::from);
    record.save(&folder.join("tradeoff/here"), "rapier", &observables).unwrap();
    folder.join("scene.toml")
}

#[test]
fn a_record_is_read_as_it_was_written() {
    let (folder, scene) = (tempfile::tempdir().unwrap(), smoke());
    let written = record(&scene);
    let file = recorded(folder.path(), &written);
    assert_eq!(recorded_engines(&file, &Build::here().processor).unwrap(), [written]);
    assert_eq!(recorded_engines(&file, "another processor").unwrap(), []);
    assert_eq!(recorded_engines(Path::new("/nowhere/scene.toml"), "any").unwrap(), []);
}

#[test]
fn runs_stand_at_the_stiffest_reference_for_the_seeds_that_are_asked_for() {
    let scene = smoke();
    let mut plan = Plan::new(&scene, Scope::Quick, &["Makadam"], &[10.0]);
    let own = plan.configurations.len();
    let mut outcome = Outcome::none(own);
    record(&scene).join(&scene, 2, &mut plan, &mut outcome);
    assert_eq!((plan.configurations.len(), outcome.runs.len()), (own + 2, own + 2));
    for (configuration, runs) in plan.configurations.iter().zip(&outcome.runs).skip(own) {
        assert_eq!((configuration.code.as_str(), configuration.stiffness_factor), ("Rapier", 10.0));
        assert_eq!(runs.iter().map(|kept| kept.run.seed).collect::<Vec<_>>(), [1, 2]);
    }
    let [note] = outcome.notes.as_slice() else { panic!("{:?}", outcome.notes) };
    assert!(note.contains("another run") && note.contains("2026-01-02") && note.contains("an engine 1.2"), "{note}");
}

#[test]
fn runs_of_another_scene_are_left_out_with_a_note() {
    let scene = smoke();
    let mut plan = Plan::new(&scene, Scope::Quick, &["Makadam"], &[]);
    let own = plan.configurations.len();
    let mut outcome = Outcome::none(own);
    record(&scene.with_stiffness_factor(2.0)).join(&scene, 2, &mut plan, &mut outcome);
    assert_eq!((plan.configurations.len(), outcome.runs.len()), (own, own));
    assert!(outcome.notes[0].contains("another version of this scene"), "{:?}", outcome.notes);
}

#[test]
fn a_setting_that_failed_with_a_seed_keeps_no_bound() {
    let scene = smoke();
    let plan = Plan::new(&scene, Scope::Quick, &["Makadam"], &[]);
    let reference = plan.refinements[0].grids[2];
    let other = (0..plan.configurations.len()).find(|place| !plan.is_grid(*place)).unwrap();
    let mut outcome = Outcome::none(plan.configurations.len());
    for place in [reference, other] {
        let configuration = || plan.configurations[place].clone();
        let runs = [1, 2].map(|seed| KeptRun { configuration: configuration(), ..run("", seed, &scene) });
        outcome.runs[place] = runs.to_vec();
    }
    let study = |outcome: &Outcome| {
        let bounds = vec![Bound { observable: "packing_fraction".into(), value: 0.01 }];
        let terms = Terms { quick: true, seeds: 2, bounds, time_limit: 1.0, provenance: BTreeMap::new() };
        Study::new(&scene, &plan, outcome, terms)
    };
    let setting = plan.configurations[other].setting();
    let point = |study: &Study| study.points.iter().find(|point| point.setting == setting).unwrap().clone();
    assert_eq!(point(&study(&outcome)).within_bounds, Some(true));
    assert!(study(&outcome).notes.is_empty());
    outcome.failures.insert(other, (3, "it fell over".into()));
    let failed = study(&outcome);
    assert_eq!((point(&failed).failed, point(&failed).within_bounds), (true, Some(false)));
    assert_ne!(failed.fastest[0].setting.as_ref(), Some(&setting));
    let [note] = failed.notes.as_slice() else { panic!("{:?}", failed.notes) };
    assert!(note.contains(&setting) && note.contains("failed with seed 3") && note.ends_with("it fell over"), "{note}");
}

#[test]
fn a_damaged_record_is_told_with_its_file_line_and_remedy() {
    let (folder, scene) = (tempfile::tempdir().unwrap(), smoke());
    let file = recorded(folder.path(), &record(&scene));
    let table = folder.path().join("tradeoff/here/rapier.csv");
    let whole = std::fs::read_to_string(&table).unwrap();
    let damages: [(&str, &str, &[&str]); 5] = [
        ("0.001,", "soon,", &["line 2", "'soon' is no number for time_step"]),
        ("0.001,", "-0.001,", &["line 2", "time_step must be positive"]),
        ("0.001,1,", "0.001,one,", &["line 2", "'one' is no seed"]),
        ("0.6,", "NaN,", &["line 2", "packing_fraction"]),
        ("short_setting,", "", &["line 1", "columns"]),
    ];
    for (before, after, words) in damages {
        let damaged = whole.replacen(before, after, 1);
        assert_ne!(damaged, whole, "{before}");
        std::fs::write(&table, damaged).unwrap();
        let error = recorded_engines(&file, "any").unwrap_err().to_string();
        for word in words.iter().chain(&["rapier.csv", "delete it to leave the engine out"]) {
            assert!(error.contains(word), "{error}");
        }
    }
    std::fs::write(&table, whole.lines().next().unwrap()).unwrap();
    assert!(recorded_engines(&file, "any").unwrap_err().to_string().contains("holds no run"));
    std::fs::write(&table, whole).unwrap();
    std::fs::remove_file(folder.path().join("tradeoff/here/rapier.json")).unwrap();
    assert!(recorded_engines(&file, "any").unwrap_err().to_string().contains("rapier.json"));
}

#[test]
fn runs_that_a_record_holds_are_not_made_again() {
    let (folder, scene) = (tempfile::tempdir().unwrap(), smoke());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let knobs = |setting: &str| Knobs::Engine { step: 5e-4, setting: setting.into(), short_setting: setting.into() };
    let made = |settings: &[&str], seeds: u64| {
        let settings: Vec<(Knobs, Box<dyn Code>)> =
            settings.iter().map(|setting| (knobs(setting), Box::new(Makadam) as Box<dyn Code>)).collect();
        let told = RefCell::new(Vec::new());
        let runs = EngineRuns {
            code: "An engine",
            engine: "an engine 1.2",
            common: "one thread",
            stem: "rapier",
            scene: &scene,
            scene_file: &file,
            seeds,
            // One that the scene compares, which has its column already, and one that it does not.
            further: &["mean_overlap", "kinetic_energy"],
            folder: folder.path(),
            command: "drive it",
        };
        let record = runs
            .carry_out(&settings, |kept| told.borrow_mut().push((kept.configuration.setting(), kept.run.seed)))
            .unwrap();
        (record.runs.len(), told.into_inner())
    };
    let run = |setting: &str, seed: u64| (setting.to_string(), seed);
    assert_eq!(made(&["fast"], 1), (1, vec![run("fast", 1)]));
    // Seed by seed, and what is there is left alone.
    let new = vec![run("slow", 1), run("fast", 2), run("slow", 2)];
    assert_eq!(made(&["fast", "slow"], 2), (4, new));
    assert_eq!(made(&["fast", "slow"], 2), (4, Vec::new()));
    let record = EngineRecord::load(folder.path(), "rapier").unwrap();
    assert_eq!(record.runs.len(), 4);
    assert!(record.runs.iter().all(|kept| kept.run.value("kinetic_energy").is_some()));
    let head = std::fs::read_to_string(folder.path().join("rapier.csv")).unwrap();
    assert_eq!(head.lines().next().unwrap().matches("mean_overlap").count(), 1);
}

#[test]
fn a_record_that_is_damaged_or_of_something_else_is_not_written_over() {
    let (folder, scene) = (tempfile::tempdir().unwrap(), smoke());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/smoke.toml");
    let refused = |engine: &str| {
        let runs = EngineRuns {
            code: "Rapier",
            engine,
            common: "one thread",
            stem: "rapier",
            scene: &scene,
            scene_file: &file,
            seeds: 1,
            further: &[],
            folder: folder.path(),
            command: "drive it",
        };
        let knobs = Knobs::Engine { step: 5e-4, setting: "any".into(), short_setting: "any".into() };
        let settings: [(Knobs, Box<dyn Code>); 1] = [(knobs, Box::new(Makadam))];
        runs.carry_out(&settings, |_| panic!("nothing is run")).unwrap_err().to_string()
    };
    record(&scene).save(folder.path(), "rapier", &["packing_fraction".into()]).unwrap();
    let (origin, table) = (folder.path().join("rapier.json"), folder.path().join("rapier.csv"));
    let kept = [&origin, &table].map(|file| std::fs::read(file).unwrap());
    let told = refused("an engine 1.3");
    for word in ["rapier.json", "an engine 1.2 (one thread)", "an engine 1.3 (one thread)", "move it away"] {
        assert!(told.contains(word), "{told}");
    }
    assert_eq!([&origin, &table].map(|file| std::fs::read(file).unwrap()), kept);
    std::fs::write(&table, &kept[1][..40]).unwrap();
    assert!(refused("an engine 1.2").contains("rapier.csv"), "a table that is cut short");
    std::fs::remove_file(&origin).unwrap();
    assert!(refused("an engine 1.2").contains("rapier.json"), "a table without its origin");
    assert_eq!(std::fs::read(&table).unwrap(), &kept[1][..40]);
}
