//! `makadam tradeoff`: what it measures, what it writes, and that it goes on where it was stopped.

use crate::support::changed::changed;
use crate::support::makadam;
use crate::support::small_scene::smoke;
use serde_json::Value;
use std::collections::BTreeMap;
use std::hash::{BuildHasher, RandomState};
use std::path::Path;
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

/// Few settings of Makadam alone.
const SHORT: [&str; 8] =
    ["--codes", "makadam", "--seeds", "2", "--json", "--bound", "coordination_number=0.5", "--output"];

fn tradeoff(folder: &Path, output: &str) -> assert_cmd::Command {
    let mut command = makadam(folder);
    command.arg("tradeoff").arg(smoke()).args(SHORT).arg(output);
    command
}

/// The document of a run that ended well, or with settings beyond their bounds.
fn document(output: &Output) -> Value {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 4)), "{errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Finished runs by file name.
fn kept(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = std::fs::read_dir(folder.join("runs")) else { return BTreeMap::new() };
    let files = entries.map(|entry| entry.unwrap().path()).filter(|path| path.extension().is_some_and(|e| e == "json"));
    files.map(|path| (path.file_name().unwrap().to_string_lossy().into(), std::fs::read(&path).unwrap())).collect()
}

/// Points and references without wall times and what follows from them.
fn table(document: &Value) -> Value {
    let mut points = document["points"].clone();
    for point in points.as_array_mut().unwrap() {
        point.as_object_mut().unwrap().retain(|name, _| !name.starts_with("wall_seconds"));
        for deviation in point["deviations"].as_array_mut().unwrap() {
            deviation.as_object_mut().unwrap().remove("on_front");
        }
    }
    serde_json::json!({ "points": points, "references": document["references"], "bounds": document["bounds"] })
}

/// A number below `limit` that differs from run to run of the test.
fn random(limit: u64) -> u64 {
    RandomState::new().hash_one(0) % limit
}

/// Starts the command and waits until so many more runs are kept.
fn start(folder: &Path, output: &str, more: usize) -> Child {
    let enough = kept(&folder.join(output)).len() + more;
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_makadam"));
    command.env("XDG_CACHE_HOME", folder.join("cache")).current_dir(folder).arg("tradeoff").arg(smoke());
    let mut child =
        command.args(SHORT).arg(output).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let clock = Instant::now();
    while kept(&folder.join(output)).len() < enough {
        assert!(clock.elapsed() < Duration::from_secs(120), "no {more} runs in two minutes");
        assert!(child.try_wait().unwrap().is_none(), "the command ended before {more} more runs were kept");
        std::thread::sleep(Duration::from_millis(2));
    }
    child
}

#[test]
fn killed_five_times_it_ends_with_the_same_table() {
    let folder = tempfile::tempdir().unwrap();
    let undisturbed = document(&tradeoff(folder.path(), "undisturbed").output().unwrap());

    let mut before: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    for _ in 0..5 {
        let mut child = start(folder.path(), "killed", random(4) as usize);
        std::thread::sleep(Duration::from_millis(random(60)));
        child.kill().unwrap();
        child.wait().unwrap();
        before.extend(kept(&folder.path().join("killed")));
    }
    let killed = document(&tradeoff(folder.path(), "killed").output().unwrap());
    assert_eq!(table(&killed), table(&undisturbed));
    let after = kept(&folder.path().join("killed"));
    for (name, bytes) in &before {
        assert!(after.get(name) == Some(bytes), "{name} has changed: its wall time is no longer what was measured");
    }
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&after), names(&kept(&folder.path().join("undisturbed"))));

    // Nothing is missing: nothing is run, and the wall times are those of the files.
    let again = tradeoff(folder.path(), "killed").output().unwrap();
    assert!(String::from_utf8_lossy(&again.stderr).contains("0 runs made"));
    let again = document(&again);
    for part in ["points", "references", "fastest", "findings"] {
        assert_eq!(again[part], killed[part], "{part}");
    }
}

#[test]
fn points_have_errors_and_the_reference_has_none() {
    let folder = tempfile::tempdir().unwrap();
    let study = document(&tradeoff(folder.path(), "out").output().unwrap());
    assert_eq!((study["version"].as_u64(), study["command"].as_str()), (Some(1), Some("tradeoff")));
    assert_eq!((study["complete"].as_bool(), study["particles"].as_u64()), (Some(true), Some(200)));
    let points = study["points"].as_array().unwrap();
    let references: Vec<&Value> = points.iter().filter(|point| point["reference"] == true).collect();
    assert_eq!(references.len(), 1);
    let least = points.iter().map(|point| point["time_step"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!(references[0]["time_step"].as_f64(), Some(least));
    for point in points {
        assert!(point["wall_seconds_per_simulated_second"].as_f64().unwrap() > 0.0);
        assert_eq!(point["seeds"], serde_json::json!([1, 2]));
        let deviations = point["deviations"].as_array().unwrap();
        assert!(deviations.iter().any(|deviation| deviation["observable"] == "coordination_number"));
        for deviation in deviations {
            let zero = deviation["deviation"].as_f64() == Some(0.0);
            assert_eq!(zero, point["reference"] == true, "{deviation}");
        }
    }
    let fastest = study["fastest"].as_array().unwrap();
    assert_eq!(fastest.len(), 1, "one code at one stiffness");
    let within = points.iter().filter(|point| point["within_bounds"] == true);
    let least = within.map(|p| p["wall_seconds_per_simulated_second"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!(fastest[0]["wall_seconds_per_simulated_second"].as_f64(), Some(least));
    // What is varied beside step and sweeps is named.
    for name in ["residual 0.1", "residual 0.03", "single precision", "Anderson", "calm contacts, residual 0.1"] {
        let of = |point: &&Value| point["variation"] == name;
        let setting = points.iter().find(of).unwrap()["setting"].as_str().unwrap();
        assert!(setting.ends_with(name), "{setting}");
    }
    assert!(points.iter().filter(|point| point["variation"].is_null()).count() >= 9);
    let page = std::fs::read_to_string(folder.path().join("out/tradeoff.html")).unwrap();
    assert!(page.contains("Makadam, solver varied"), "{page}");
    for name in ["points.csv", "references.csv", "fastest.csv", "provenance.json", "tradeoff.json", "tradeoff.html"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
    let rows = csv::Reader::from_path(folder.path().join("out/points.csv")).unwrap().into_records().count();
    let deviations: usize = points.iter().map(|point| point["deviations"].as_array().unwrap().len()).sum();
    assert_eq!(rows, deviations);
}

#[test]
fn a_damaged_file_is_kept_aside_and_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let whole = document(&tradeoff(folder.path(), "out").output().unwrap());
    let (name, bytes) = kept(&folder.path().join("out")).pop_first().unwrap();
    let file = folder.path().join("out/runs").join(name);
    // One digit of a number is enough: still JSON, no longer what was measured. The build tells which file comes
    // first, and a run's step how long it lasted exactly.
    let text = String::from_utf8(bytes).unwrap();
    let damaged = text.replacen("\"simulated_seconds\": 0.", "\"simulated_seconds\": 1.", 1);
    assert_ne!(text, damaged);
    std::fs::write(&file, &damaged).unwrap();

    let output = tradeoff(folder.path(), "out").output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(errors.contains("1 runs made"), "{errors}");
    assert_eq!(table(&document(&output)), table(&whole));
}

#[test]
fn an_interruption_leaves_a_table_of_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let child = start(folder.path(), "out", 3);
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("continues from there"));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(study["complete"], false);
    let points = study["points"].as_array().unwrap();
    assert!(points.len() >= 3);
    // The reference runs first, so that whatever else there is has an error.
    assert!(points.iter().all(|point| !point["deviations"].as_array().unwrap().is_empty()));
    assert!(folder.path().join("out/tradeoff.html").is_file());
}

#[test]
fn no_setting_within_the_bounds_is_told_by_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let output = tradeoff(folder.path(), "out").args(["--bound", "mean_overlap=1e-15"]).output().unwrap();
    assert_eq!(output.status.code(), Some(4));
    // Only the reference keeps such a bound.
    assert_eq!(document(&output)["fastest"][0]["setting"], "0.25 ms × 20 sweeps");
}

/// A study of settings of LIGGGHTS, of which a script takes the place that does these commands in each run; folders of its runs are
/// listed in a file.
#[cfg(unix)]
fn study_of_a_script(folder: &Path, commands: &str, more: &[&str]) -> (Value, usize) {
    let tried = folder.join("tried");
    let (draft, fake) = (folder.join("draft"), folder.join("liggghts"));
    let words = format!(
        "#!/bin/sh\ncase \"$*\" in *-help*) echo 'LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled)'; exit 0;; esac\npwd >> {}\n{commands}\n",
        tried.display()
    );
    std::fs::write(&draft, words).unwrap();
    // By another process: the system runs no file that this one may still hold open for writing.
    assert!(
        std::process::Command::new("install").args(["-m", "755"]).args([&draft, &fake]).status().unwrap().success()
    );
    let mut command = makadam(folder);
    command.env("MAKADAM_LIGGGHTS", fake).arg("tradeoff").arg(smoke());
    command.args(["--codes", "liggghts", "--seeds", "2", "--json", "--output", "out"]).args(more);
    let study = document(&command.output().unwrap());
    (study, std::fs::read_to_string(tried).unwrap().lines().count())
}

#[cfg(unix)]
#[test]
fn a_setting_that_fails_is_not_tried_with_further_seeds_and_is_told_once() {
    let folder = tempfile::tempdir().unwrap();
    let (study, settings) = study_of_a_script(folder.path(), "echo 'it fell over'\nexit 1", &[]);
    let told = study["notes"].as_array().unwrap();
    assert_eq!((settings, told.len()), (4, 4), "{told:?}");
    assert!(told.iter().all(|note| note.as_str().unwrap().contains("failed with seed 1")), "{told:?}");
    let page = std::fs::read_to_string(folder.path().join("out/tradeoff.html")).unwrap();
    assert!(page.find("All settings") < page.find("it fell over"), "tables come before what failed");
}

#[cfg(unix)]
#[test]
fn a_run_beyond_the_limit_is_stopped_and_listed() {
    let folder = tempfile::tempdir().unwrap();
    let (study, settings) = study_of_a_script(folder.path(), "exec sleep 100", &["--time-limit", "0.5"]);
    let told = study["notes"].as_array().unwrap();
    assert_eq!((settings, told.len()), (4, 4), "{told:?}");
    assert!(told.iter().all(|note| note.as_str().unwrap().contains("failed with seed 1")), "{told:?}");
    assert_eq!(study["points"].as_array().unwrap().len(), 3, "the three grids of the reference");
}

#[test]
fn bad_arguments_and_missing_codes_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let mut command = makadam(folder.path());
        command.env("MAKADAM_YADE", "/nowhere/yade").arg("tradeoff").arg(smoke()).args(arguments).output().unwrap()
    };
    for (arguments, code, words) in [
        (&["--bound", "coordination_number"][..], 2, "packing_fraction=0.002"),
        (&["--bound", "coordination_number=0"], 2, "above 0"),
        (&["--bound", "gini=0.1", "--bound", "gini=0.2"], 2, "two bounds on one observable"),
        (&["--codes", "makadam,yade"], 5, "--codes"),
    ] {
        let output = run(arguments);
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{errors}");
        assert!(errors.contains(words), "{errors}");
    }
    assert!(!folder.path().join("results").exists(), "nothing is made before the arguments are known to be right");
    let budget = "[solver]\nstop = { kind = \"time-budget\", seconds = 0.001, max_sweeps = 10 }\n\n[measure]";
    let scene = changed(folder.path(), "[measure]", budget);
    let output = makadam(folder.path()).arg("tradeoff").arg(scene).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("wall time"));
}
