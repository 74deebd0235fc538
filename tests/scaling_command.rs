//! `makadam lab scaling`: the same bits everywhere, the JSON contract, what is written.

use crate::support::changed::changed;
use crate::support::makadam;
use crate::support::small_scene::smoke;
use serde_json::Value;

/// A study of the small scene that takes a second.
const SHORT: [&str; 8] = ["--steps", "3", "--repetitions", "2", "--settle", "0.1", "--threads-list", "1,2"];

#[test]
fn a_small_scene_is_measured_and_replayed() {
    let folder = tempfile::tempdir().unwrap();
    let output = makadam(folder.path())
        .args(["lab", "scaling"])
        .arg(smoke())
        .args(SHORT)
        .args(["--json", "--output", "out"])
        .output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((study["version"].as_u64(), study["command"].as_str()), (Some(1), Some("scaling")));
    assert_eq!(study["same_bits"], true);
    assert_eq!(study["particles"], 200);
    assert!(study["contacts"].as_f64().unwrap() > 0.0);
    let measured = study["measured"].as_array().unwrap();
    // Serial, then two schedulers on one and on two threads, for each instruction set.
    assert_eq!(measured.len() % 5, 0);
    assert!(measured.iter().all(|row| row["state_hash"] == measured[0]["state_hash"]));
    for row in measured {
        for field in ["step_seconds", "sweep_seconds", "speedup", "sweep_speedup", "nanoseconds_per_contact_sweep"] {
            assert!(row[field].as_f64().unwrap() > 0.0, "{field} of {row}");
        }
    }
    assert!(measured.iter().all(|row| row["deviation_percent"].is_number()));
    let replayed = study["replayed"].as_array().unwrap();
    assert!(replayed.iter().all(|row| row["source"] == "replayed"));
    assert!(replayed.iter().any(|row| row["machine"] == "xeon-phi-3120" && row["workers"] == 228));
    for name in ["measured.csv", "replayed.csv", "machine.csv", "scaling.json", "scaling.html"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn tables_are_recorded_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene = changed(folder.path(), "name = \"smoke\"", "name = \"changed\"");
    let output =
        makadam(folder.path()).args(["lab", "scaling"]).arg(&scene).args(SHORT).arg("--record").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.path().join("results/scaling/changed/scaling.html").is_file());
    let recorded = scene.with_file_name("changed-scaling");
    let machine = std::fs::read_dir(recorded).unwrap().next().unwrap().unwrap().path();
    assert!(machine.join("measured.csv").is_file() && machine.join("provenance.json").is_file());
    assert!(String::from_utf8_lossy(&output.stdout).contains("bit for bit"));
}

#[test]
fn solves_that_watch_the_clock_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let budget = "[solver]\nstop = { kind = \"time-budget\", seconds = 0.001, max_sweeps = 10 }\n\n[measure]";
    let scene = changed(folder.path(), "[measure]", budget);
    let output = makadam(folder.path()).args(["lab", "scaling"]).arg(&scene).args(SHORT).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("wall time"));
}
