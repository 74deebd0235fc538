//! `makadam effects`: which effects a scene calls for and by which line, costs, ablation.

use crate::support::changed::changed;
use crate::support::lines::line_of;
use crate::support::makadam;
use crate::support::small_scene::smoke;
use serde_json::Value;
use std::path::Path;

fn study(folder: &Path, scene: &Path, arguments: &[&str]) -> Value {
    let output = makadam(folder).arg("effects").arg(scene).args(arguments).arg("--json").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn effect<'a>(study: &'a Value, name: &str) -> &'a Value {
    study["effects"].as_array().unwrap().iter().find(|effect| effect["effect"] == name).unwrap()
}

#[test]
fn a_scene_tells_its_effects_their_lines_and_their_cost() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), &smoke(), &["--settle", "0.3"]);
    assert_eq!((study["version"].as_u64(), study["command"].as_str()), (Some(1), Some("effects")));
    let friction = effect(&study, "Coulomb friction");
    assert_eq!(friction["on"], true);
    assert_eq!(friction["line"].as_u64().unwrap() as usize, line_of(&smoke(), "friction = "));
    for name in ["rolling resistance", "twisting resistance"] {
        assert_eq!((&effect(&study, name)["on"], &effect(&study, name)["line"]), (&Value::Bool(false), &Value::Null));
    }
    let kernels = study["costs"]["kernels"].as_array().unwrap();
    assert_eq!(kernels.len(), 7);
    let called: Vec<_> = kernels.iter().filter(|kernel| kernel["called"] == true).collect();
    assert_eq!(called.len(), 1);
    assert_eq!(called[0]["effects"], "friction");
    assert_eq!(called[0]["over_friction"], 1.0);
    assert!(kernels.iter().all(|kernel| kernel["nanoseconds"].as_f64().unwrap() > 0.0));
    // Five numbers a contact: two levers and an angular impulse.
    let bytes = |number: usize| kernels[number]["bytes"].as_u64().unwrap();
    assert_eq!((bytes(4) - bytes(1), bytes(2) - bytes(1)), (40, 40));
    // Four of a tangential spring: its compliance and its bias.
    assert_eq!((bytes(5) - bytes(1), bytes(6) - bytes(4)), (32, 32));
    assert_eq!(study["ablation"], Value::Null);
    assert!(folder.path().join("results/effects/smoke/effects.json").is_file());
}

#[test]
fn what_changes_in_time_or_with_speed_is_told_by_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let effects = [
        ("kinetic friction", "kinetic_friction"),
        ("falling restitution", "restitution_speed"),
        ("changing gravity", "gravity_changes"),
        ("wall motion", "vibrating"),
        ("driven walls", "force-driven"),
    ];
    let plain = study(folder.path(), &smoke(), &["--settle", "0.05"]);
    assert!(effects.iter().all(|(name, _)| effect(&plain, name)["on"] == false), "{plain}");
    let coefficients = "friction = 0.5\nkinetic_friction = 0.4\nrestitution_speed = 1.0\n";
    let scene = changed(folder.path(), "friction = 0.5\n", coefficients);
    let text = std::fs::read_to_string(&scene).unwrap();
    let motion = "motion = { kind = 'vibrating', amplitude = [0.0, 0.0, 0.0001], frequency = 10.0 }";
    let lid = "[[wall]]\nname = 'lid'\nmaterial = 'grain'\n\
               shape = { kind = 'plane', point = [0.0, 0.0, 0.5], normal = [0.0, 0.0, -1.0] }\n\
               motion = { kind = 'force-driven', axis = [0, 0, 1], force = 0.1, mass = 0.1 }";
    let text = text.replacen("[[population]]", &format!("{motion}\n\n{lid}\n\n[[population]]"), 1);
    let changes = "gravity_changes = [{ time = 0.05, gravity = [0.0, 0.0, -12.0] }]";
    std::fs::write(&scene, format!("{changes}\n{text}")).unwrap();
    let study = study(folder.path(), &scene, &["--settle", "0.05"]);
    for (name, word) in effects {
        let row = effect(&study, name);
        assert_eq!(
            (&row["on"], row["line"].as_u64()),
            (&Value::Bool(true), Some(line_of(&scene, word) as u64)),
            "{name}"
        );
    }
}

#[test]
fn ablation_says_which_observables_need_an_effect() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--settle", "0.1", "--ablate", "--seeds", "2"];
    let first = study(folder.path(), &smoke(), &arguments);
    let rows = first["ablation"]["rows"].as_array().unwrap();
    for effect in ["Coulomb friction", "restitution", "rolling resistance", "twisting resistance"] {
        let row = rows.iter().find(|row| row["effect"] == effect).unwrap_or_else(|| panic!("{effect}: {rows:#?}"));
        let known = ["needed", "not-needed", "undecided", "not-measurable"];
        assert!(known.contains(&row["need"].as_str().unwrap()), "{row}");
    }
    // The walls bear the weight with or without friction, and rigid grains do not overlap: two seeds may be too few to tell, but
    // never so few as to say the contrary.
    let need = |effect: &str, observable: &str| {
        let named = |row: &&Value| row["effect"] == effect && row["observable"] == observable;
        rows.iter().find(named).unwrap_or_else(|| panic!("{effect}, {observable}: {rows:#?}"))["need"].clone()
    };
    assert_ne!(need("Coulomb friction", "wall_force_over_weight"), "needed");
    assert_ne!(need("elastic compliance", "mean_overlap"), "not-needed");
    let results = folder.path().join("results/effects/smoke");
    let tables = std::fs::read_to_string(results.join("effects.md")).unwrap();
    let table = tables.split("## Ablation, 2 seeds each").nth(1).unwrap();
    assert_eq!(table.lines().filter(|line| line.starts_with("| ")).count(), 2 + rows.len(), "{table}");

    // A second start takes up what the first one kept, and makes again what is no longer there.
    let runs = std::fs::read_dir(results.join("runs")).unwrap().map(|entry| entry.unwrap().path());
    let mut runs: Vec<_> = runs.collect();
    runs.sort();
    let [kept, .., lost] = &runs[..] else { panic!("{runs:?}") };
    let whole = std::fs::read(lost).unwrap();
    std::fs::write(lost, &whole[..whole.len() / 2]).unwrap();
    let before = std::fs::metadata(kept).unwrap().modified().unwrap();
    let second = study(folder.path(), &smoke(), &arguments);
    assert_eq!(second["ablation"], first["ablation"]);
    assert_eq!(std::fs::metadata(kept).unwrap().modified().unwrap(), before);
    serde_json::from_slice::<Value>(&std::fs::read(lost).unwrap()).unwrap();
}

#[test]
fn an_unknown_scene_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let output = makadam(folder.path()).args(["effects", "no-such-scene"]).output().unwrap();
    assert_eq!(output.status.code(), Some(3));
}
