//! `makadam run` and its watchdogs: no run is too short for them, and invalid numbers are not handed out as sound.

use crate::support::makadam;
use serde_json::Value;

/// A grain that leaves its domain some steps before the end of a run of 127 steps.
const LEAVES: &str = r#"
name = "leaves"
description = "A grain leaves the domain after 80 steps of 127."
duration = 0.0635
domain = { min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }
[material.grain]
density = 2500.0
youngs_modulus = 1e7
poisson_ratio = 0.3
friction = 0.5
restitution = 0.3
[[grain]]
material = "grain"
radius = 0.005
position = [0.02, 0.0, 0.02]
velocity = [2.0, 0.0, 0.0]
[measure]
observables = ["balances"]
"#;

/// Runs the scene with something to watch for; exit code, summary, what was printed for people.
fn run(watch: &str) -> (Option<i32>, Value, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("leaves.toml"), format!("{LEAVES}[watch]\n{watch}\n")).unwrap();
    let output = makadam(folder.path()).args(["run", "leaves.toml", "--output", "out"]).output().unwrap();
    let summary = std::fs::read_to_string(folder.path().join("out/run.json")).unwrap();
    let printed = String::from_utf8_lossy(&output.stdout).to_string();
    (output.status.code(), serde_json::from_str(&summary).unwrap(), printed)
}

#[test]
fn a_run_that_loses_a_grain_in_its_last_steps_fails() {
    let (code, summary, printed) = run("");
    assert_eq!(code, Some(1), "{printed}");
    assert_eq!(summary["complete"], false);
    assert_eq!(summary["alarms"][0]["grave"], true);
    assert!(summary["failure"].as_str().unwrap().contains("left the domain"), "{summary}");
}

#[test]
fn a_scene_that_only_wants_a_warning_gets_its_numbers_with_one_on_top() {
    let (code, summary, printed) = run("on_escape = 'warn'");
    assert_eq!((code, &summary["complete"]), (Some(0), &Value::Bool(true)), "{printed}");
    let head = printed.lines().next().unwrap();
    assert!(head.contains("INVALID") && head.contains("left the domain"), "{printed}");

    let (code, summary, printed) = run("on_escape = 'ignore'");
    assert_eq!((code, summary["alarms"].as_array().unwrap().len()), (Some(0), 0), "{printed}");
    assert!(!printed.contains("INVALID"), "{printed}");
}
