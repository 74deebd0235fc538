//! Unit tests of `src/parameter_study/mod.rs`.

use super::*;
use makadam_compare::study::Document;

fn smoke() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes/smoke.toml")
}

fn study(ranges: &[&str], seeds: &[u64], folder: &Path) -> Result<Study, ParameterError> {
    let ranges: Vec<Range> = ranges.iter().map(|range| range.parse().unwrap()).collect();
    let announce = |_: &str| -> makadam_compare::compare::Share { Box::new(|_| {}) };
    let file = smoke();
    let scene = scenes::load(&file).unwrap();
    let plan = Plan { file: &file, ranges: &ranges, seeds, folder, again: false, announce: &announce };
    Study::make(&plan, &scene, BTreeMap::new(), Vec::new())
}

#[test]
fn values_are_split_as_toml_does_and_words_as_they_stand() {
    let values = |text: &str| text.parse::<Range>().unwrap().values;
    assert_eq!(values("friction=0.1, 0.3"), ["0.1", "0.3"]);
    assert_eq!(values("gravity=[0,0,-9.81],[0,0,-1.62]").len(), 2);
    assert_eq!(values("wall.box.material=glass,steel"), ["glass", "steel"]);
    for wrong in ["friction", "=1,2", "friction=", "friction=1,1", "friction=0.1,0.10"] {
        assert!(wrong.parse::<Range>().is_err(), "{wrong}");
    }
}

#[test]
fn every_combination_is_run_over_its_seeds_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let ranges = ["duration=0.02,0.03", "solver.step=1e-3,5e-4"];
    let study = study(&ranges, &[1, 2], folder.path()).unwrap();
    let values: Vec<String> = study.points.iter().map(|point| point.values.join(" ")).collect();
    assert_eq!(values, ["0.02 1e-3", "0.02 5e-4", "0.03 1e-3", "0.03 5e-4"]);
    assert!(study.points.iter().all(|point| point.runs.iter().map(|run| run.seed).eq([1, 2])));
    assert_eq!(std::fs::read_dir(folder.path().join("runs")).unwrap().count(), 8);
    let csv = String::from_utf8(study.tables().unwrap()[0].1.clone()).unwrap();
    assert!(csv.starts_with("duration,solver.step,seeds,") && csv.lines().count() == 5, "{csv}");
}

#[test]
fn a_run_that_fails_leaves_the_others_their_table() {
    let folder = tempfile::tempdir().unwrap();
    // Grains that leave the domain end the run, unless nobody watches.
    let ranges = ["duration=0.02", "domain.max=[1,1,1],[0.05,0.05,0.05]"];
    let watched = study(&ranges, &[1, 2], folder.path());
    let found = watched.unwrap_or_else(|error| panic!("{error}"));
    let runs: Vec<usize> = found.points.iter().map(|point| point.runs.len()).collect();
    assert_eq!(runs.iter().sum::<usize>() + found.failed.len(), 4, "{:?}", found.failed);
    for (over, words) in [("seed=1,5", "--seeds"), ("duration=0.02", "twice")] {
        let error = study(&["duration=0.03", over], &[1], folder.path()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn a_combination_that_is_no_scene_is_refused_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let error = study(&["duration=0.02,-1"], &[1], folder.path()).unwrap_err().to_string();
    assert!(error.contains("duration=-1"), "{error}");
    assert!(!folder.path().join("runs").exists());
}
