//! Bad input: the exit code, a message that names file, line and remedy, and what was computed so far kept readable.

use crate::support::changed::changed;
use crate::support::child::{signal, wait_for};
use crate::support::lines::line_of;
use crate::support::makadam;
use crate::support::small_scene::smoke;
use makadam_frames::run_frames::RunFrames;
use std::path::Path;

/// Runs the command and returns its exit code and what it says on standard error.
fn fails(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = makadam(folder).args(arguments).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// Changes the small scene, runs it, and expects exit code 3 with the line and the words.
fn refused(from: &str, to: &str, at: &str, words: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let scene = changed(folder.path(), from, to);
    let (code, message) = fails(folder.path(), &["run", scene.to_str().unwrap(), "--output", "out"]);
    assert_eq!(code, 3, "{message}");
    let place = format!("changed.toml:{}:", line_of(&scene, at));
    assert!(message.contains(&place), "no '{place}' in: {message}");
    for word in words {
        assert!(message.contains(word), "no '{word}' in: {message}");
    }
    assert!(!folder.path().join("out").exists(), "a refused scene leaves nothing behind");
}

#[test]
fn unknown_key() {
    refused("friction = 0.5", "fricton = 0.5", "fricton", &["fricton", "did you mean `friction`"]);
}

#[test]
fn wrong_unit() {
    refused("mean = 0.005", "mean = \"5 mm\"", "5 mm", &["SI units"]);
}

#[test]
fn value_out_of_range() {
    refused("restitution = 0.3", "restitution = 1.3", "restitution = 1.3", &["restitution", "1"]);
    refused("poisson_ratio = 0.3", "poisson_ratio = 0.7", "poisson_ratio = 0.7", &["poisson_ratio"]);
}

#[test]
fn what_nobody_reads() {
    refused("[measure]", "[solver]\nnormal_law = { kind = \"hertz\", zzz = 1 }\n\n[measure]", "zzz", &["zzz", "hertz"]);
    refused("max = [0.03, 0.03, 0.3]", "max = [0.03, 0.03, 0.3, 4.0]", "max = [0.03", &["4 values", "give 3"]);
}

#[test]
fn two_of_one_name_and_names_of_no_file() {
    let rules =
        "[[pair]]\nbetween = [\"grain\", \"wall\"]\n\n[[pair]]\nbetween = [\"wall\", \"grain\"] # again\n\n[measure]";
    refused("[measure]", rules, "# again", &["pair[0]"]);
    refused("name = \"smoke\"", "name = \"..\"", "name = \"..\"", &["'..'"]);
    refused("[measure]", "[solver]\ninner_sweeps = 4294967295\n\n[measure]", "inner_sweeps", &["1000"]);
}

#[test]
fn findings_are_reported_before_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let scene = changed(folder.path(), "friction = 0.5", "friction = 26.6");
    let (code, message) = fails(folder.path(), &["run", scene.to_str().unwrap(), "--steps", "1", "--output", "out"]);
    assert_eq!(code, 0, "{message}");
    let place = format!("changed.toml:{}:", line_of(&scene, "friction = 26.6"));
    for word in [&place, "material.grain.friction: 26.6", "angle in degrees?"] {
        assert!(message.contains(word), "no '{word}' in: {message}");
    }
    let summary: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("out/run.json")).unwrap()).unwrap();
    assert_eq!(summary["findings"][0]["severity"], "warning");
    assert_eq!(summary["findings"].as_array().unwrap().len(), 1);
}

#[test]
fn not_toml() {
    refused("duration = 0.4", "duration = = 0.4", "duration = = 0.4", &[]);
}

#[test]
fn unknown_material() {
    refused("material = \"wall\"", "material = \"gold\"", "material = \"gold\"", &["gold", "grain, wall"]);
}

#[test]
fn too_many_grains() {
    refused("count = 200", "count = 20000", "count = 20000", &["do not fit", "enlarge the region"]);
}

#[test]
fn grain_outside_its_container() {
    let grain = "[[grain]]\nmaterial = \"grain\"\nradius = 0.005\nposition = [0.024, 0.0, 0.2]\n\n[measure]";
    refused("[measure]", grain, "position = [0.024", &[]);
}

#[test]
fn overlapping_grains() {
    let pair = "[[grain]]\nmaterial = \"grain\"\nradius = 0.002\nposition = [0.0, 0.0, 0.23]\n\n\
        [[grain]]\nmaterial = \"grain\"\nradius = 0.002\nposition = [0.0, 0.0, 0.23398]\n\n[measure]";
    let folder = tempfile::tempdir().unwrap();
    // Half a hundredth of the radius is accepted.
    let scene = changed(folder.path(), "[measure]", &pair.replace("0.23398", "0.23399"));
    let accepted = fails(folder.path(), &["run", scene.to_str().unwrap(), "--steps", "1", "--output", "out"]);
    assert_eq!(accepted.0, 0, "{}", accepted.1);
    refused("[measure]", &pair.replace("0.23398", "0.23395"), "position = [0.0, 0.0, 0.23395]", &["overlap"]);
}

#[test]
fn missing_file_and_unknown_scene() {
    let folder = tempfile::tempdir().unwrap();
    let (code, message) = fails(folder.path(), &["run", "nowhere.toml"]);
    assert_eq!(code, 3);
    assert!(message.contains("nowhere.toml") && message.contains("cannot be read"), "{message}");
    let (code, message) = fails(folder.path(), &["compare", "drumm"]);
    assert_eq!(code, 3);
    assert!(message.contains("drumm") && message.contains("did you mean drum"), "{message}");
}

#[test]
fn usage() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["run"][..],
        &["run", "packing", "--threads", "0"],
        &["run", "packing", "--seed", "one"],
        &["compare", "packing", "--codes", "chrono"],
        &["compare", "packing", "--rayleigh-fraction", "3"],
        &["compare", "packing", "--restart"],
        &["fly"],
    ] {
        assert_eq!(fails(folder.path(), arguments).0, 2, "{arguments:?}");
    }
}

#[test]
fn a_precision_that_a_scene_cannot_have_is_refused_before_anything_is_prepared() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["drum-rolling", "oedometer"] {
        let (code, message) = fails(folder.path(), &["run", scene, "--precision", "single", "--steps", "1"]);
        assert_eq!(code, 2, "{message}");
        assert!(message.contains("--precision single") && message.contains("leave it out"), "{message}");
        assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none(), "nothing was written");
    }
}

#[test]
fn output_that_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let scene = smoke();
    let (code, message) =
        fails(folder.path(), &["run", scene.to_str().unwrap(), "--steps", "5", "--output", "file/out"]);
    assert_eq!(code, 1);
    assert!(message.contains("file/out") && message.contains("a file is there: name a folder"), "{message}");
}

#[test]
fn full_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_makadam"))
        .arg("run")
        .arg(smoke())
        .args(["--steps", "5", "--output", "out"])
        .current_dir(folder.path())
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("standard output"));
}

#[test]
fn an_interrupted_run_stays_readable() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_makadam"))
        .arg("run")
        .arg(smoke())
        .args(["--steps", "100000000", "--output", "out"])
        .current_dir(folder.path())
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let frames = || RunFrames::open(&folder.path().join("out")).map_or(0, |run| run.count());
    wait_for(&mut child, "a second frame", || frames() > 1);
    signal(&child, "-TERM");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("interrupted"));
    let summary: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("out/run.json")).unwrap()).unwrap();
    assert_eq!(summary["complete"], false);
    assert!(summary["steps"].as_u64().unwrap() > 0);
    assert_eq!(frames() as u64, summary["frames"].as_u64().unwrap());
}

/// Returns true once a process catches termination.
fn catches_termination(process: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(caught.trim(), 16).unwrap() & (1 << (15 - 1)) != 0
}

#[test]
fn the_first_signal_ends_a_command_that_waits_for_a_scene() {
    for words in [&["check", "-"][..], &["run", "-"], &["compare", "-"]] {
        let folder = tempfile::tempdir().unwrap();
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_makadam"))
            .args(words)
            .current_dir(folder.path())
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        let patience = std::time::Instant::now() + std::time::Duration::from_secs(60);
        let pause = || std::thread::sleep(std::time::Duration::from_millis(5));
        while !catches_termination(child.id()) {
            assert!(std::time::Instant::now() < patience, "{words:?}: it does not listen");
            pause();
        }
        signal(&child, "-TERM");
        // Its standard input stays open all the time.
        let ended = loop {
            match child.try_wait().unwrap() {
                Some(ended) => break Some(ended),
                None if std::time::Instant::now() > patience => break None,
                None => pause(),
            }
        };
        if ended.is_none() {
            child.kill().unwrap();
        }
        assert_eq!(ended.and_then(|ended| ended.code()), Some(1), "{words:?}");
    }
}

/// A program that stands in for a reference code: it tells a version, and then does what `body` says.
fn stand_in(folder: &Path, body: &str) -> String {
    let file = folder.join("stand-in");
    let text = format!(
        "#!/bin/sh\ncase \"$1\" in --version|-v|-help|-h) echo 'stand-in version 1.0'; exit 0;; esac\n{body}\n"
    );
    // Written by another process: held open for writing in this one, children of the tests beside it would inherit it so,
    // and the system runs no file that someone may still write (`ETXTBSY`).
    let draft = folder.join("stand-in.draft");
    std::fs::write(&draft, text).unwrap();
    assert!(
        std::process::Command::new("install").args(["-m", "755"]).args([&draft, &file]).status().unwrap().success()
    );
    file.to_str().unwrap().to_string()
}

/// Compares the small scene live with a stand-in for one reference code.
fn compare_with(reference_code: &str, body: &str, limit: &str) -> (i32, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let program = stand_in(folder.path(), body);
    let output = makadam(folder.path())
        .env(format!("MAKADAM_{}", reference_code.to_uppercase()), program)
        .args(["compare", smoke().to_str().unwrap(), "--live", "--seeds", "1", "--time-limit", limit])
        .args(["--codes", &format!("makadam,{reference_code}")])
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_peer_that_crashes() {
    for reference_code in ["yade", "liggghts", "lammps"] {
        let (code, results, message) = compare_with(reference_code, "echo 'Segmentation fault'; exit 139", "60");
        assert_eq!(code, 1, "{message}");
        for word in ["failed", "Segmentation fault", "log"] {
            assert!(message.contains(word), "no '{word}' in: {message}");
        }
        // Makadam's own numbers are not lost.
        assert!(results.contains("Makadam") && results.contains("mean overlap"), "{results}");
    }
}

#[test]
fn a_peer_that_hangs() {
    for reference_code in ["yade", "liggghts", "lammps"] {
        let clock = std::time::Instant::now();
        let (code, results, message) = compare_with(reference_code, "sleep 600", "1");
        assert_eq!(code, 1, "{message}");
        assert!(message.contains("stopped after 1 s") && message.contains("--time-limit"), "{message}");
        assert!(results.contains("Makadam"), "{results}");
        assert!(clock.elapsed().as_secs() < 60);
    }
}

#[test]
fn a_peer_that_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let scene = smoke();
    let compare = |live: bool| {
        let mut command = makadam(folder.path());
        command.env("MAKADAM_YADE", "/nowhere/yade").args(["compare", scene.to_str().unwrap(), "--seeds", "1"]);
        if live {
            command.arg("--live");
        }
        let output = command.output().unwrap();
        (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, message) = compare(true);
    assert_eq!(code, 5);
    assert!(message.contains("MAKADAM_YADE names /nowhere/yade, which is no program"), "{message}");
    // The small scene has no recorded references either.
    let (code, message) = compare(false);
    assert_eq!(code, 5);
    assert!(message.contains("nothing is recorded") && message.contains("--live"), "{message}");
}
