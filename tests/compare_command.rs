//! `makadam compare`: the JSON contract, recorded references, live reference codes where they are installed.

use crate::support::changed::changed;
use crate::support::invented::record;
use crate::support::makadam;
use crate::support::small_scene::{compared_once, smoke};
use makadam_compare::codes::{Code, Liggghts, Yade};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Writes references of the small scene by hand: two codes, three seeds, one observable, which alone is compared.
pub fn with_references(folder: &Path) -> PathBuf {
    let scene = changed(folder, "name = \"smoke\"", "name = \"changed\"");
    let text = compared_once(&std::fs::read_to_string(&scene).unwrap());
    std::fs::write(&scene, text).unwrap();
    record(&folder.join("changed-reference"), &scene);
    scene
}

#[test]
fn recorded_references_are_used_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let scene = with_references(folder.path());
    let output =
        makadam(folder.path()).arg("compare").arg(&scene).args(["--json", "--output", "out"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["version"], 1);
    assert_eq!(document["verdict"]["standing"], "agree");
    let rows = document["rows"].as_array().unwrap();
    let row = &rows[0];
    for field in [
        "scene",
        "observable",
        "code",
        "mean",
        "standard_deviation",
        "seeds",
        "reference_code",
        "difference",
        "interval90",
        "margin",
        "outcome",
    ] {
        assert!(!row[field].is_null(), "{field}");
    }
    assert_eq!(row["code"], "Makadam");
    assert_eq!(row["reference_code"], "YADE");
    assert_eq!(row["seeds"], 3);
    assert_eq!(row["outcome"], "agree");
    // The difference between the two references stands beside ours.
    assert!(rows.iter().any(|row| row["code"] == "YADE" && row["reference_code"] == "LIGGGHTS"));
    for code in document["codes"].as_array().unwrap() {
        assert!(code["wall_seconds_per_simulated_second"].as_f64().unwrap() > 0.0);
        assert!(code["time_step"].as_f64().unwrap() > 0.0);
    }
    let notes = document["notes"].to_string();
    assert!(notes.contains("YADE was not run") && notes.contains("recorded 2026-01-01 on invented"), "{notes}");
    let report = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(report.contains("Makadam"));
}

/// Agreement is that of the seeds that the scene has registered: others are exploratory, and so is a change of what is compared.
#[test]
fn unregistered_seeds_are_exploratory() {
    let folder = tempfile::tempdir().unwrap();
    let scene = with_references(folder.path());
    let compare = |more: &[&str]| {
        let output = makadam(folder.path()).arg("compare").arg(&scene).args(more).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (code, table) = compare(&[]);
    assert!(code == Some(0) && table.contains("agrees with YADE and LIGGGHTS"), "{table}");
    let (code, table) = compare(&["--seeds", "4"]);
    assert!(code == Some(4) && table.contains("exploratory: within the margin"), "{table}");
    assert!(table.contains("No verdict: of 2 tests of 1 scene") && !table.contains("agrees with"), "{table}");
    assert!(table.contains("changed registers 3 seeds (measure.seeds), and 4 seeds were run"), "{table}");
    for change in ["measure.seeds=4", "compare.margin=0.06"] {
        let (code, table) = compare(&["--set", change]);
        assert!(code == Some(4) && table.contains("--set has changed that"), "{change}: {table}");
    }
    let (code, table) = compare(&["--set", "solver.step=4e-4"]);
    assert!(code == Some(0) && table.contains("agrees with YADE and LIGGGHTS"), "{table}");
}

#[test]
fn an_output_is_refused_before_anything_runs_and_no_verdict_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let scene = with_references(folder.path());
    let compare = || {
        let output = makadam(folder.path()).arg("compare").arg(&scene).args(["--output", "out"]).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let refused = |words: &str| {
        let (code, table, errors) = compare();
        assert!(code == Some(2) && table.is_empty() && errors.contains(words), "{code:?} {table}{errors}");
    };
    let out = folder.path().join("out");
    std::fs::write(&out, "mine").unwrap();
    refused("out is a file, and a report takes a folder");
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "mine");
    std::fs::remove_file(&out).unwrap();
    std::fs::create_dir(&out).unwrap();
    // A folder that a table cannot be written into.
    std::fs::create_dir_all(out.join("rows.csv/in-the-way")).unwrap();
    let (code, table, errors) = compare();
    assert!(code == Some(1) && errors.contains("rows.csv"), "{code:?}: {errors}");
    assert!(table.contains("agrees with YADE and LIGGGHTS"), "{table}");
    std::fs::remove_dir_all(out.join("rows.csv")).unwrap();
    for _ in 0..2 {
        let (code, table, errors) = compare();
        assert!(code == Some(0) && table.contains("report: out/report.html"), "{table}{errors}");
    }
}

#[test]
fn options_that_would_do_nothing_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = with_references(folder.path());
    let refused = |more: &[&str], words: &str| {
        let output = makadam(folder.path()).arg("compare").arg(&scene).args(more).output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && errors.contains(words), "{more:?}: {errors}");
    };
    refused(&["--rayleigh-fraction", "0.2"], "recorded numbers have their own: add --live or --record");
    refused(&["--record", "--codes", "makadam"], "--record keeps what other codes measure");
    refused(&["--record", "--output", "out"], "cannot be used with");
    refused(&["--record", "--live"], "cannot be used with");
}

#[cfg(unix)]
#[test]
fn a_path_may_be_no_text() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let scene = with_references(folder.path());
    let output = std::ffi::OsStr::from_bytes(b"o\xffut");
    let run = makadam(folder.path()).arg("compare").arg(&scene).arg("--output").arg(output).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    assert!(folder.path().join(output).join("report.json").is_file());
}

/// Records of another scene would agree or not by chance.
#[test]
fn records_of_the_scene_as_it_was_are_compared_with_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let scene = with_references(folder.path());
    let text = std::fs::read_to_string(&scene).unwrap().replacen("duration = 0.4", "duration = 0.39", 1);
    std::fs::write(&scene, text).unwrap();
    let output = makadam(folder.path()).arg("compare").arg(&scene).arg("--json").output().unwrap();
    assert_eq!(output.status.code(), Some(4));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["verdict"]["standing"], "not-measured");
    let missing = "YADE was recorded on another scene than this one, so record it anew with --record";
    assert_eq!((&document["rows"][0]["missing"], &document["rows"][0]["difference"]), (&missing.into(), &Value::Null));
    let notes = document["notes"].to_string();
    assert!(notes.contains("the scene has changed since YADE was recorded"), "{notes}");
}

#[test]
fn outside_the_margin_is_exit_code_4() {
    let folder = tempfile::tempdir().unwrap();
    let scene = with_references(folder.path());
    let file = folder.path().join("changed-reference/measurements.csv");
    let text = std::fs::read_to_string(&file).unwrap().replace(",1.00", ",2.00");
    std::fs::write(&file, text).unwrap();
    let output = makadam(folder.path()).arg("compare").arg(&scene).output().unwrap();
    assert_eq!(output.status.code(), Some(4));
    assert!(String::from_utf8_lossy(&output.stdout).contains("disagree"));
}

/// Compares the small scene with references after a change of its text.
fn compare_changed(from: &str, to: &str) -> (Option<i32>, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let scene = with_references(folder.path());
    let text = std::fs::read_to_string(&scene).unwrap();
    assert!(text.contains(from), "{from}");
    std::fs::write(&scene, text.replacen(from, to, 1)).unwrap();
    let output = makadam(folder.path()).arg("compare").arg(&scene).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn an_observable_that_nothing_measures_is_an_error_with_its_line_and_the_nearest_name() {
    let (code, _, message) = compare_changed("\"wall_force_over_weight\"", "\"wall_force_over_wieght\"");
    assert_eq!(code, Some(3), "{message}");
    for words in ["changed.toml:", "wall_force_over_wieght", "did you mean wall_force_over_weight"] {
        assert!(message.contains(words), "no '{words}' in: {message}");
    }
    // A known one whose group the scene does not measure.
    let (code, _, message) = compare_changed("\"wall_force_over_weight\"", "\"packing_fraction\"");
    assert_eq!(code, Some(3), "{message}");
    assert!(message.contains("add \"packing-fraction\" to measure.observables"), "{message}");
}

#[test]
fn hyphens_and_underscores_are_one_spelling() {
    for (from, to) in [
        ("\"wall_force_over_weight\"", "\"wall-force-over-weight\""),
        ("\"coordination-number\"", "\"coordination_number\""),
    ] {
        let (code, results, message) = compare_changed(from, to);
        assert_eq!(code, Some(0), "{message}");
        assert!(results.contains("agrees with YADE and LIGGGHTS within the margins in all 2 tests"), "{results}");
    }
}

#[test]
fn an_expectation_without_a_recorded_value_is_not_measured_and_does_not_pass() {
    let more = "[[compare]]\nobservable = \"gini\"\nmargin = 0.02\n\n[[compare]]";
    let (code, results, message) = compare_changed("[[compare]]", more);
    assert_eq!(code, Some(4), "{results}{message}");
    assert!(results.contains("not measured: YADE has no value"), "{results}");
    assert!(results.contains("Not measured: of 4 tests of 1 scene against YADE and LIGGGHTS, 2 agree"), "{results}");
    assert!(!results.contains("times)"), "{results}");
}

#[test]
fn the_default_of_codes_can_be_typed_as_it_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let help = makadam(folder.path()).args(["compare", "--help"]).output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    assert!(help.contains("--live makadam,yade,liggghts"), "{help}");
    assert!(help.contains("report.html, report.json, rows.csv, and") && !help.contains("comparison.json"), "{help}");
    let scene = with_references(folder.path());
    let output =
        makadam(folder.path()).arg("compare").arg(&scene).args(["--codes", "makadam,yade,liggghts"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn help_that_cannot_be_printed_is_a_failure() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for words in [&["--help"][..], &["--version"], &["compare", "--help"]] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_makadam"));
        let output = command.args(words).stdout(full.try_clone().unwrap()).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{words:?}: {message}");
        assert!(message.contains("standard output") && message.contains("room"), "{message}");
    }
    let shown = std::process::Command::new(env!("CARGO_BIN_EXE_makadam")).arg("--help").output().unwrap();
    assert!(shown.status.success() && String::from_utf8_lossy(&shown.stdout).contains("Exit codes:"));
}

/// The program alone in a folder, run from another one: the sources that it was built from are not on the way.
#[test]
fn the_program_alone_knows_the_reference_scenes() {
    let (bin, empty) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let program = bin.path().join("makadam");
    // Copied by another process: see `stand_in` in bad_input.rs.
    let mut copy = std::process::Command::new("cp");
    assert!(copy.arg(env!("CARGO_BIN_EXE_makadam")).arg(&program).status().unwrap().success());
    let run = |words: &[&str]| {
        let mut command = std::process::Command::new(&program);
        command.current_dir(empty.path()).env_clear().env("HOME", empty.path()).args(words).output().unwrap()
    };
    let output = run(&["run", "packing", "--steps", "1", "--json", "-q"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["provenance"]["scene_file"], "<built-in>/packing/scene.toml");
    assert!(document["provenance"]["prepared"].is_null());
    let output = run(&["run", "drumm", "--steps", "1"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(3) && message.contains("did you mean drum"), "{message}");
    let output = run(&["compare", "packing", "--record", "--codes", "yade"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && message.contains("no folder to record into"), "{message}");
    // With its references: what is wanting here is the reference code alone.
    let output = run(&["compare", "packing", "--codes", "yade,liggghts", "-q"]);
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && table.contains("packing fraction"), "{table}");
}

#[test]
fn a_flowing_state_is_announced_before_it_is_prepared() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(smoke()).unwrap();
    let scene = folder.path().join("prepared.toml");
    std::fs::write(&scene, format!("{text}\n[prepare]\nduration = 0.01\nstep = 1e-3\n")).unwrap();
    let run = |json: &[&str]| {
        let mut command = makadam(folder.path());
        command.env("HOME", folder.path()).env_remove("XDG_CACHE_HOME");
        command.arg("run").arg(&scene).args(["--steps", "1"]).args(json).output().unwrap()
    };
    let output = run(&["--json"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    assert!(message.contains("10 steps of 1e-3 s") && message.contains(".cache/makadam/prepared"), "{message}");
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["provenance"]["prepared"]["steps"], 10);
    // Not a second time.
    let output = run(&["--restart"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !message.contains("prepared first"), "{message}");
}

#[test]
fn a_bad_reference_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let scene = with_references(folder.path());
    let file = folder.path().join("changed-reference/measurements.csv");
    let text = std::fs::read_to_string(&file).unwrap().replacen("1.002,", "lots,", 1);
    std::fs::write(&file, text).unwrap();
    let output = makadam(folder.path()).arg("compare").arg(&scene).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("measurements.csv:3:") && message.contains("--record"), "{message}");
}

#[test]
fn live_peers_agree_on_the_small_scene() {
    for reference_code in [&Yade::default() as &dyn Code, &Liggghts::default()] {
        if reference_code.version().is_none() {
            eprintln!("skipped: {} is not installed (scripts/install-codes)", reference_code.name());
            return;
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let output = makadam(folder.path())
        .arg("compare")
        .arg(smoke())
        .args(["--live", "--seeds", "3", "--rayleigh-fraction", "0.2", "--json"])
        .output()
        .unwrap();
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{document:#}");
    assert_eq!(document["verdict"]["agree"], 4);
    assert!(document["codes"].as_array().unwrap().iter().all(|code| code["source"] == "live"));
}

#[test]
fn recording_reads_kept_recordings_and_writes_references() {
    if Liggghts::default().version().is_none() {
        eprintln!("skipped: LIGGGHTS is not installed (scripts/install-codes)");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let scene = changed(folder.path(), "duration = 0.4", "duration = 0.1");
    let record = |program: Option<&str>| {
        let mut command = makadam(folder.path());
        command.arg("compare").arg(&scene).args(["--record", "--seeds", "2", "--codes", "liggghts"]);
        command.args(["--recordings", "kept", "--rayleigh-fraction", "0.2"]);
        if let Some(program) = program {
            command.env("MAKADAM_LIGGGHTS", program);
        }
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        std::fs::read_to_string(folder.path().join("changed-reference/measurements.csv")).unwrap()
    };
    let first = record(None);
    let kept = std::fs::read_dir(folder.path().join("kept")).unwrap();
    let mut kept: Vec<_> = kept.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    kept.sort();
    assert!(
        kept.len() == 2 && kept[1].starts_with("smoke-liggghts-s2-f0.2-e1-") && kept[1].ends_with(".rec"),
        "{kept:?}"
    );
    // From then on nothing is run, the program is not even there: raw recordings are measured.
    assert_eq!(record(Some("/nowhere/liggghts")), first);
}

#[cfg(unix)]
#[test]
fn recording_refuses_an_unknown_version() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (scene, program) = (changed(folder.path(), "duration = 0.4", "duration = 0.1"), folder.path().join("nameless"));
    std::fs::write(&program, "#!/bin/sh\necho built by hand\n").unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = makadam(folder.path());
    command.arg("compare").arg(&scene).args(["--record", "--codes", "liggghts"]).env("MAKADAM_LIGGGHTS", &program);
    let output = command.output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("version of LIGGGHTS is unknown"), "{message}");
    assert!(!folder.path().join("changed-reference").exists());
}
