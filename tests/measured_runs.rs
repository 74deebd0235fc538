//! Measuring the folder of a run gives the numbers of the run, and a run has those of its table.

use crate::support::makadam;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const MATERIAL: &str =
    "[material.a]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.3\n";

/// Grains in a box under a lid that a force drives, without gravity.
const LID: &str = "name = 'lid'\nduration = 1.0\ngravity = [0.0, 0.0, 0.0]\n\
    domain = { min = [-0.1, -0.1, -0.05], max = [0.1, 0.1, 0.3] }\n\
    [[wall]]\nname = 'box'\nmaterial = 'a'\nshape = { kind = 'box', min = [-0.03, -0.03, 0], max = [0.03, 0.03, 0.3], open = ['+z'] }\n\
    [[wall]]\nname = 'lid'\nmaterial = 'a'\nshape = { kind = 'plane', point = [0, 0, 0.2], normal = [0, 0, -1] }\n\
    motion = { kind = 'force-driven', axis = [0, 0, -1], force = 5.0, mass = 0.05 }\n\
    [[population]]\ncount = 300\nmaterial = 'a'\nradius = { kind = 'uniform', mean = 0.005, spread = 0.1 }\n\
    region = { kind = 'box', min = [-0.03, -0.03, 0], max = [0.03, 0.03, 0.2] }\nspacing = 1.02\n\
    [measure]\ninterval = 0.1\nfrom = 0.6\nobservables = ['packing-fraction', 'coordination-number', 'driven-wall', 'balances']\n\
    [output]\nfields = ['velocity', 'angular-velocity']\n";

/// A bed in a box, with periodic sides, while gravity grows.
const BED: &str = "name = 'bed'\nduration = 0.8\ngravity_changes = [{ time = 0.4, gravity = [0, 0, -9.81] }, { time = 0.8, gravity = [0, 0, -19.62] }]\n\
    domain = { min = [0, 0, -0.01], max = [0.06, 0.06, 0.3], periodic = ['x', 'y'] }\n\
    [[wall]]\nname = 'floor'\nmaterial = 'a'\nshape = { kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }\n\
    [[population]]\ncount = 300\nmaterial = 'a'\nradius = { kind = 'uniform', mean = 0.005, spread = 0.1 }\n\
    region = { kind = 'box', min = [0, 0, 0], max = [0.06, 0.06, 0.2] }\nspacing = 1.02\n\
    [measure]\ninterval = 0.05\nfrom = 0.4\nobservables = ['packing-fraction', 'coordination-number', 'contact-forces', 'balances']\n\
    [output]\nfields = ['velocity', 'angular-velocity']\n";

/// Standard output of a command that ends well.
fn output(folder: &Path, arguments: &[&str]) -> Vec<u8> {
    let output = makadam(folder).args(arguments).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {errors}");
    output.stdout
}

/// Runs a scene into the folder `run`, and gives what its summary has measured.
fn run(folder: &Path, scene: &str) -> BTreeMap<String, f64> {
    fs::write(folder.join("scene.toml"), format!("{scene}{MATERIAL}")).unwrap();
    output(folder, &["run", "scene.toml", "-o", "run", "-q"]);
    let summary: Value = serde_json::from_slice(&fs::read(folder.join("run/run.json")).unwrap()).unwrap();
    let observables = summary["observables"].as_object().unwrap().iter();
    observables.map(|(name, measured)| (name.clone(), measured["value"].as_f64().unwrap())).collect()
}

/// Measures files by the scene: numbers, and reasons of those that have none.
fn measure(folder: &Path, files: &[&str]) -> (BTreeMap<String, f64>, BTreeMap<String, String>) {
    let arguments = [&["measure"], files, &["--scene", "scene.toml", "--json"]].concat();
    let document: Value = serde_json::from_slice(&output(folder, &arguments)).unwrap();
    let named = |one: &Value| one["observable"].as_str().unwrap().to_string();
    let numbers = document["measurements"].as_array().unwrap().iter();
    let reasons = document["not_measured"].as_array().unwrap().iter();
    (
        numbers.map(|one| (named(one), one["value"].as_f64().unwrap())).collect(),
        reasons.map(|one| (named(one), one["reason"].as_str().unwrap().to_string())).collect(),
    )
}

/// Asserts that numbers of files with six digits are those of a run.
fn assert_close(found: &BTreeMap<String, f64>, expected: &BTreeMap<String, f64>) {
    for (name, value) in found {
        let expected = expected[name];
        let slack = match name.as_str() {
            "largest_overlap" | "mean_overlap" | "coulomb_excess" => 2e-5,
            // A gap may come to lie on the other side of what counts as touching.
            name if name.contains("coordination") || name.contains("rattler") => 0.02,
            _ => 1e-4 * expected.abs() + 1e-12,
        };
        assert!((value - expected).abs() <= slack, "{name}: {value} for {expected}");
    }
}

/// Mean of a column of the table of a run from a time on; its maximum for some.
fn of_table(folder: &Path, from: f64) -> BTreeMap<String, f64> {
    let mut table = csv::Reader::from_path(folder.join("run/observables.csv")).unwrap();
    let names: Vec<String> = table.headers().unwrap().iter().map(String::from).collect();
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.unwrap()).collect();
    let column = |place: usize| -> f64 {
        let late = rows.iter().filter(|row| row[0].parse::<f64>().unwrap() > from - 1e-6);
        let values: Vec<f64> = late.filter_map(|row| row[place].parse().ok()).collect();
        match names[place].as_str() {
            "largest_overlap" | "coulomb_excess" => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            _ => values.iter().sum::<f64>() / values.len() as f64,
        }
    };
    names.iter().enumerate().map(|(place, name)| (name.clone(), column(place))).collect()
}

#[test]
fn a_run_is_measured_alike_from_its_table_and_its_folder() {
    for (scene, from, names) in [
        (BED, 0.4, &["packing_fraction", "gini", "wall_force_over_weight", "kinetic_energy"][..]),
        (LID, 0.6, &["packing_fraction", "driven_wall_displacement", "mechanical_coordination_number"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let expected = run(folder.path(), scene);
        let table = of_table(folder.path(), from);
        for (name, value) in &expected {
            assert!(
                (table[name] / value - 1.0).abs() < 1e-9 || table[name] == *value,
                "{name}: {} {value}",
                table[name]
            );
        }
        let (found, _) = measure(folder.path(), &["run"]);
        assert!(names.iter().all(|name| found.contains_key(*name)), "{found:?}");
        assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
        assert_close(&found, &expected);
    }
}

#[test]
fn an_export_is_measured_as_its_run() {
    for (scene, names) in [
        (BED, &["packing_fraction", "gini", "wall_force_over_weight"][..]),
        (LID, &["packing_fraction", "driven_wall_displacement", "mechanical_coordination_number"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let expected = run(folder.path(), scene);
        output(folder.path(), &["export", "run", "--format", "vtkhdf"]);
        let files = ["run/grains.vtkhdf", "--contacts", "run/contacts.vtkhdf"];
        let (found, reasons) = measure(folder.path(), &files);
        assert!(names.iter().all(|name| found.contains_key(*name)), "{found:?} {reasons:?}");
        assert_close(&found, &expected);
    }
}
