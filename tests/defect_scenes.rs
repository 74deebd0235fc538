//! Regression scenes of earlier defects: each ends correctly, or is refused with its reason.

use crate::support::makadam;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/defects").join(name).with_extension("toml")
}

/// Exit code, standard error and summary (null where there is none) of a run.
fn run(folder: &Path, name: &str) -> (i32, String, Value) {
    let command =
        makadam(folder).arg("run").arg(scene(name)).args(["--json", "--restart", "--output", name]).output().unwrap();
    let summary = std::fs::read(folder.join(name).join("run.json")).ok();
    let summary = summary.map_or(Value::Null, |bytes| serde_json::from_slice(&bytes).unwrap());
    (command.status.code().unwrap(), String::from_utf8(command.stderr).unwrap(), summary)
}

#[test]
fn what_reading_would_pass_over_is_refused_with_its_line() {
    let refused = [
        ("grav4", "grav4.toml:4: gravity: 4 values are listed, and 3 are read"),
        ("pos4", "pos4.toml:29: grain[0].position: 4 values are listed, and 3 are read"),
        ("fixed-with-velocity", "wall[0].motion: unknown key 'velocity' beside kind = 'fixed'"),
        ("wall-name-columns", "wall[1].name: the columns of a driven wall 'driven_wall' would be those of"),
        ("vibration-aliased", "wall[0].motion: a period of wall 'floor' lasts 0.0005 s, 1 steps of 0.0005 s"),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (name, reason) in refused {
        let (code, message, summary) = run(folder.path(), name);
        assert_eq!(code, 3, "{name}: {message}");
        assert!(message.contains(reason), "{name}: {message}");
        assert_eq!(summary, Value::Null, "{name} was refused before anything was written");
    }
}

#[test]
fn grains_stay_in_shells_and_closed_drums_at_any_speed() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["drum-shell-tunnel", "leak1"] {
        let (code, message, summary) = run(folder.path(), name);
        assert_eq!(code, 0, "{name}: {message}");
        assert_eq!((&summary["complete"], &summary["sound"]), (&true.into(), &true.into()), "{name}");
    }
}

#[test]
fn a_grain_that_comes_over_the_rim_of_a_driven_plate_stays_finite() {
    let folder = tempfile::tempdir().unwrap();
    let (code, message, summary) = run(folder.path(), "torque-driven-disc-nan");
    assert_eq!((code, &summary["complete"]), (0, &true.into()), "{message}");
}

#[test]
fn numbers_that_are_worthless_end_a_run() {
    let folder = tempfile::tempdir().unwrap();
    for (name, reason) in
        [("watch-last-steps", "grain 0 left the domain"), ("drum20", "may have passed through each other")]
    {
        let (code, message, summary) = run(folder.path(), name);
        assert_eq!((code, &summary["complete"]), (1, &false.into()), "{name}: {message}");
        assert!(message.contains(reason), "{name}: {message}");
    }
}
