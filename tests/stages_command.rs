//! Scenes in stages, from the file to the summary, tables, frames and exports.

use crate::support::makadam;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::run_frames::RunFrames;
use serde_json::Value;
use std::path::Path;

const TEXT: &str = include_str!("../validation/templates/stages.toml");

/// Writes the shear cell of `makadam new`, smaller and with changes.
fn cell(folder: &Path, changes: &[(&str, &str)]) {
    let small = [
        ("count = 600", "count = 100"),
        ("[0.06, 0.04, 0.18]", "[0.03, 0.02, 0.18]"),
        ("[0.06, 0.04, 0.1]", "[0.03, 0.02, 0.1]"),
    ];
    let mut text = TEXT.to_string();
    for (from, to) in small.iter().chain(changes) {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    std::fs::write(folder.join("cell.toml"), text).unwrap();
}

/// Runs a command, and returns its standard output and error.
fn carried_out(folder: &Path, arguments: &[&str], succeeds: bool) -> (String, String) {
    let output = makadam(folder).args(arguments).output().unwrap();
    let texts = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert_eq!(output.status.success(), succeeds, "{arguments:?}: {}", texts[1]);
    let [said, told] = texts;
    (said, told)
}

fn summary(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&carried_out(folder, arguments, true).0).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn stages_are_in_all_that_a_run_leaves() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    cell(folder, &[("observables = [", "observables = [\"contact-forces\", ")]);
    let run = ["run", "cell.toml", "--ledger", "--json", "--output", "out"];
    let all = summary(folder, &run);
    let stages = all["stages"].as_array().unwrap();
    let names: Vec<&str> = stages.iter().map(|stage| stage["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["fill", "settle", "compress", "shear"]);
    assert!(stages.iter().all(|stage| stage["ended"] == true), "{stages:?}");
    assert_eq!(number(&all["simulated_seconds"]), number(&stages[3]["end"]));
    let steps: u64 = stages.iter().map(|stage| stage["steps"].as_u64().unwrap()).sum();
    assert_eq!(all["steps"].as_u64(), Some(steps));
    let balance = &all["balance"];
    assert!(number(&balance["closure"]).abs() < 1e-9 * number(&balance["walls"]).abs(), "{balance}");

    let table = std::fs::read_to_string(folder.join("out/observables.csv")).unwrap();
    let head: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| head.iter().position(|known| *known == name).unwrap();
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|line| ["time", "stage"].map(|name| line.split(',').nth(column(name)).unwrap().parse().unwrap()).to_vec())
        .collect();
    for row in &rows {
        let own = &stages[row[1] as usize];
        assert!(row[0] >= number(&own["start"]) && row[0] <= number(&own["end"]), "{row:?}: {own}");
    }
    // Each stage ends with a frame.
    for stage in stages {
        assert!(rows.iter().any(|row| row[0] == number(&stage["end"])), "{stage}: {rows:?}");
    }
    let frames = RunFrames::open(&folder.join("out")).unwrap();
    let last = frames.read(frames.count() - 1).unwrap();
    assert_eq!(last.stage.as_deref(), Some("shear"));
    assert_eq!(frames.step(frames.count() - 1), steps);
    // The lid is drawn where it has gone: down, then along x.
    let lid = last.walls.unwrap();
    let height = |walls: &makadam_frames::run_frames::Walls| {
        let of_lid = walls.triangles.iter().zip(&walls.wall).filter(|(_, wall)| **wall == 1);
        of_lid.map(|(triangle, _)| walls.points[triangle[0] as usize][2]).fold(f64::INFINITY, f64::min)
    };
    let down = 0.12 - 0.1 * (number(&stages[2]["end"]) - number(&stages[2]["start"]));
    assert!((height(&lid) - down).abs() < 1e-6, "{} and not {down} m", height(&lid));
    // Frames of the last stage are closer in time, and only they are measured.
    let times: Vec<f64> = (0..frames.count()).map(|number| frames.time(number)).collect();
    let late = times.iter().filter(|time| **time > number(&stages[3]["start"])).count();
    assert_eq!(late, 15, "{times:?}");
    let measured =
        summary(folder, &["measure", "out", "--scene", "cell.toml", "--set", "measure.interval=0.02", "--json"]);
    assert_eq!(measured["measured_frames"].as_u64(), Some(11), "{measured}");
    let every = ("interval = 0.02 ", "interval = 0.05 ");
    cell(folder, &[every]);
    let run = summary(folder, &["run", "cell.toml", "--json", "--output", "even"]);
    let again = summary(folder, &["measure", "even", "--scene", "cell.toml", "--json"]);
    for one in again["measurements"].as_array().unwrap() {
        let name = one["observable"].as_str().unwrap();
        assert_eq!(one["value"], run["observables"][name]["value"], "{name}");
    }
    assert_eq!(run["state_hash"], all["state_hash"]);

    carried_out(folder, &["export", "even", "--format", "vtp", "--output", "vtp"], true);
    let grains = std::fs::read_dir(folder.join("vtp/frames")).unwrap().map(|entry| entry.unwrap().path());
    let some = grains
        .filter(|path| path.to_string_lossy().contains("grains"))
        .find(|path| path.extension().is_some_and(|e| e == "vtp"));
    let text = String::from_utf8_lossy(&std::fs::read(some.unwrap()).unwrap()).into_owned();
    assert!(text.contains("\"stage\"") && text.contains("stage_names"), "{}", &text[..2000.min(text.len())]);
}

#[test]
fn a_run_is_resumed_in_any_stage() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    cell(folder, &[]);
    let whole = summary(folder, &["run", "cell.toml", "--json", "--output", "whole"]);
    let taken = |number: usize| whole["stages"][number]["steps"].as_u64().unwrap();
    let changes = [taken(0), taken(0) + 1, taken(0) + taken(1) + 1, taken(0) + taken(1) + taken(2)];
    // A run of fewer steps has no checkpoint; its library does.
    let scene = MeasuredScene::load(&folder.join("cell.toml")).unwrap();
    let mut simulation = makadam::Simulation::new(&scene, scene.seed).unwrap();
    for count in changes {
        while simulation.steps_taken() < count {
            simulation.step();
        }
        simulation = makadam::Simulation::resume(&scene, &simulation.checkpoint()).unwrap();
    }
    while !simulation.has_ended() {
        simulation.step();
    }
    assert_eq!(whole["state_hash"], format!("{:016x}", simulation.state_hash()));
}

#[test]
fn a_stage_that_does_not_end_leaves_a_state() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let limit = |time: &str| [("force = 5.0 } }, at_most = 2.0", format!("force = 5.0 }} }}, at_most = {time}"))];
    let given = |time: &str| cell(folder, &limit(time).each_ref().map(|(from, to)| (*from, to.as_str())));
    given("0.01");
    let (_, told) = carried_out(folder, &["run", "cell.toml", "--output", "out"], false);
    assert!(told.contains("stage[2] has not ended within at_most") && told.contains("--resume"), "{told}");
    assert!(folder.join("out/observables.csv").is_file() && folder.join("out/frames.mkd").is_file());
    given("2.0");
    let resumed = summary(folder, &["run", "cell.toml", "--resume", "--json", "--output", "out"]);
    let whole = summary(folder, &["run", "cell.toml", "--json", "--output", "whole"]);
    assert_eq!(resumed["state_hash"], whole["state_hash"]);
    assert_eq!(resumed["observables"], whole["observables"]);
    assert_eq!(resumed["sound"], true);
}

#[test]
fn other_codes_get_fixed_stages_as_one_scene() {
    let text = TEXT
        .replace(", material = { glass = { friction = 0.1 } }", "")
        .replace("until = { kinetic_energy = 1e-8 }", "duration = 0.4")
        .replace(
            "until = { wall_force = { wall = \"lid\", force = 5.0 } }",
            "duration = 0.2, gravity = [0.0, 0.0, -5.0]",
        )
        .replace(", at_most = 2.0", "");
    let refused = MeasuredScene::parse(TEXT).unwrap().without_stages().unwrap_err();
    assert!(refused.contains("stage 'fill' changes materials"), "{refused}");
    let twice = MeasuredScene::parse(&text).unwrap().without_stages().unwrap_err();
    assert!(twice.contains("stage 'shear' gives wall 'lid' another motion"), "{twice}");
    let once = text.replace(
        "motion = { lid = { kind = \"translating\", velocity = [0.05, 0.0, 0.0] } }",
        "motion = { lid = { kind = \"fixed\" } }",
    );
    let plain = MeasuredScene::parse(&once).unwrap().without_stages().unwrap();
    assert!((plain.duration - 1.1).abs() < 1e-12 && plain.stage.is_empty(), "{}", plain.duration);
    assert!((plain.measure.from.unwrap() - 0.9).abs() < 1e-12);
    let makadam::Motion::Translating { start, stop: Some(stop), .. } = plain.wall[1].motion else {
        panic!("{:?}", plain.wall[1])
    };
    assert!((start - 0.6).abs() < 1e-12 && (stop - 0.8).abs() < 1e-12);
    assert_eq!(
        plain.gravity_changes.iter().map(|change| change.gravity[2]).collect::<Vec<_>>(),
        [-9.81, -5.0, -5.0, -9.81]
    );
    plain.check().unwrap();
    let until = text.replace("duration = 0.4", "until = { kinetic_energy = 1e-8 }, at_most = 1.0");
    let refused = MeasuredScene::parse(&until).unwrap().without_stages().unwrap_err();
    assert!(refused.contains("stage 'settle' ends by a condition; give it the duration"), "{refused}");
}

#[test]
fn a_comparison_refuses_solver_settings_of_a_stage() {
    let folder = tempfile::tempdir().unwrap();
    cell(folder.path(), &[]);
    let words = ["compare", "cell.toml", "--codes", "makadam"];
    let (_, told) = carried_out(folder.path(), &words, false);
    assert!(told.contains("stage 'shear' has a solver table of its own"), "{told}");
}

#[test]
fn errors_of_measured_stages_name_the_key() {
    for (from, to, expected) in [
        (
            "stage = \"shear\"",
            "stage = \"sheer\"",
            "measure.stage: there is no stage 'sheer'; name one of: fill, settle, compress, shear",
        ),
        ("from = 0.1 ", "from = 0.5 ", "measure.from: 0.5 is out of range; give a number from 0 to 0.3 s"),
        ("[measure]", "[prepare]\nduration = 1.0\nstep = 1e-3\n[measure]", "prepare: given in addition to stages"),
    ] {
        let error = MeasuredScene::parse(&TEXT.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}
