//! `makadam run` and its output folder: what an earlier run has left, two runs at once, a stop at the wrong moment, and how much is
//! written.

use crate::support::child::{signal, wait_for};
use crate::support::makadam;
use crate::support::tiny_scene::tiny;
use makadam_frames::run_frames::RunFrames;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// Steps of the tiny scene from one frame to the next.
const STEPS_A_FRAME: u64 = 4;

/// Runs the tiny scene into `out`.
fn run(folder: &Path, arguments: &[&str]) -> Output {
    makadam(folder).args(["run", "tiny.toml", "--output", "out", "--threads", "1"]).args(arguments).output().unwrap()
}

fn start(folder: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_makadam"))
        .args(["run", "tiny.toml", "--output", "out", "--threads", "1"])
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Checks the exit code and the words of the message, which it returns.
fn said(output: &Output, code: i32, words: &[&str]) -> String {
    let message = String::from_utf8_lossy(&output.stderr).to_string();
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(words.iter().all(|word| message.contains(word)), "{message}");
    message
}

/// Number of whole frames of the run in `out`.
fn frame_count(folder: &Path) -> usize {
    RunFrames::open(&folder.join("out")).map_or(0, |run| run.count())
}

/// All files below a folder with what they hold.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap().map(Result::unwrap) {
            match entry.path() {
                path if path.is_dir() => folders.push(path),
                path => drop(found.insert(path.clone(), std::fs::read(path).unwrap())),
            }
        }
    }
    found
}

fn summary(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("out/run.json")).unwrap()).unwrap()
}

#[test]
fn a_finished_run_is_left_alone_unless_it_is_to_be_removed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    tiny(folder);
    said(&run(folder, &["--steps", "40"]), 0, &[]);
    std::fs::write(folder.join("out/notes"), "of somebody else").unwrap();
    let before = files(&folder.join("out"));
    said(&run(folder, &["--steps", "12"]), 2, &["tiny", "--restart", "--output"]);
    said(&run(folder, &["--steps", "40", "--resume", "--seed", "9"]), 2, &["another seed", "--restart"]);
    said(&run(folder, &["--steps", "41", "--resume"]), 2, &["after 40 steps, not 41", "--restart"]);
    said(&run(folder, &["--steps", "39", "--resume"]), 2, &["after 40 steps, not 39"]);
    said(&run(folder, &["--steps", "40", "--resume", "--ledger"]), 2, &["without a ledger"]);
    let ended = run(folder, &["--steps", "40", "--resume"]);
    said(&ended, 0, &["has ended"]);
    assert!(String::from_utf8_lossy(&ended.stdout).contains("40 steps"));
    let ended = run(folder, &["--steps", "40", "--resume", "--json"]);
    assert_eq!(serde_json::from_slice::<Value>(&ended.stdout).unwrap(), summary(folder));
    assert!(files(&folder.join("out")) == before, "nothing was touched");

    // A shorter one: no frame of the longer one stays, and nothing that no run has written goes.
    said(&run(folder, &["--steps", "12", "--restart"]), 0, &[]);
    let after: Vec<_> = files(&folder.join("out")).into_keys().collect();
    let name = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().to_string();
    let mut names: Vec<String> = after.iter().map(name).collect();
    names.sort();
    assert_eq!(names, ["frames.mkd", "notes", "observables.csv", "run.json"]);
    assert_eq!(frame_count(folder), 4);
}

#[test]
fn frames_without_a_summary_are_not_taken_for_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    tiny(folder);
    said(&run(folder, &["--steps", "12"]), 0, &[]);
    std::fs::remove_file(folder.join("out/run.json")).unwrap();
    for arguments in [&["--steps", "12"][..], &["--steps", "12", "--resume"]] {
        said(&run(folder, arguments), 2, &["run.json", "--restart"]);
    }
    said(&run(folder, &["--steps", "12", "--restart"]), 0, &[]);
}

#[test]
fn two_runs_never_write_into_one_folder() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    tiny(folder);
    let mut first = start(folder, &["--steps", "100000000"]);
    wait_for(&mut first, "a frame", || frame_count(folder) > 0);
    for arguments in [&[][..], &["--resume"], &["--restart"]] {
        said(&run(folder, arguments), 2, &[&format!("process {}", first.id()), "--output"]);
    }
    assert!(first.try_wait().unwrap().is_none());
    assert_eq!(summary(folder)["complete"], false);
    // The lock goes with the process, whatever ends it.
    first.kill().unwrap();
    first.wait().unwrap();
    said(&run(folder, &["--steps", "12"]), 2, &["--restart"]);
    said(&run(folder, &["--steps", "12", "--restart"]), 0, &[]);
    assert!(!folder.join("out/run.lock").exists());
}

#[test]
fn a_run_that_is_killed_leaves_no_summary_of_an_earlier_one_and_its_drafts_go() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    tiny(folder);
    said(&run(folder, &["--steps", "12"]), 0, &[]);
    let mut child = start(folder, &["--steps", "100000000", "--restart", "--seed", "5"]);
    wait_for(&mut child, "a frame", || {
        std::fs::read_to_string(folder.join("out/observables.csv")).is_ok_and(|table| table.lines().count() > 6)
    });
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(summary(folder)["complete"], false);
    assert_eq!(summary(folder)["provenance"]["seed"], 5);
    for draft in ["run.json.part77-1", "frames.mkd.part77-2", "observables.csv.part77"] {
        std::fs::write(folder.join("out").join(draft), "half").unwrap();
    }
    said(&run(folder, &["--steps", "12", "--resume"]), 2, &["another"]);
    // No checkpoint was written yet, so that it begins anew.
    said(&run(folder, &["--steps", "12", "--resume", "--seed", "5"]), 0, &["beginning anew"]);
    assert!(files(&folder.join("out")).keys().all(|file| !file.display().to_string().contains(".part")));
    assert_eq!(frame_count(folder), 4);
}

#[test]
fn a_checkpoint_outlasts_what_cannot_be_done_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    tiny(folder);
    said(&run(folder, &["--steps", "60"]), 0, &[]);
    let expected = files(&folder.join("out"));
    let mut child = start(folder, &["--steps", "100000000", "--restart"]);
    wait_for(&mut child, "a later frame", || frame_count(folder) > 30);
    signal(&child, "-TERM");
    let stopped = child.wait_with_output().unwrap();
    said(&stopped, 1, &["--resume goes on from there"]);
    let steps = summary(folder)["steps"].as_u64().unwrap();
    let checkpoint = std::fs::read(folder.join("out/run.checkpoint")).unwrap();
    for fewer in [1, steps - 1] {
        let fewer = fewer.to_string();
        said(&run(folder, &["--resume", "--steps", &fewer]), 2, &[&format!("{steps} steps"), "--steps", "stays"]);
    }
    said(&run(folder, &["--resume", "--ledger"]), 2, &["--ledger", "--restart"]);
    assert_eq!(std::fs::read(folder.join("out/run.checkpoint")).unwrap(), checkpoint);
    assert_eq!(summary(folder)["complete"], false);
    // One step more: the last frame of the interrupted run is followed by that of this one's end, and none beyond.
    let more = (steps + 1).to_string();
    said(&run(folder, &["--resume", "--steps", &more]), 0, &[]);
    let found = files(&folder.join("out"));
    said(&run(folder, &["--restart", "--steps", &more]), 0, &[]);
    let bits = |files: &BTreeMap<PathBuf, Vec<u8>>| -> Vec<_> {
        files.iter().filter(|(path, _)| !path.ends_with("run.json")).map(|(p, b)| (p.clone(), b.clone())).collect()
    };
    assert!(bits(&files(&folder.join("out"))) == bits(&found));
    said(&run(folder, &["--restart", "--steps", "60"]), 0, &[]);
    assert!(bits(&files(&folder.join("out"))) == bits(&expected));
}

#[test]
fn a_signal_that_was_ignored_before_stays_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    tiny(folder);
    let command = format!(
        "trap '' HUP INT; exec '{}' run tiny.toml --output out --threads 1 --steps 100000000",
        env!("CARGO_BIN_EXE_makadam")
    );
    let mut child = Command::new("sh")
        .args(["-c", &command])
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for(&mut child, "a frame", || frame_count(folder) > 0);
    // The second of a kind would end a process that had not ignored the first.
    for name in ["-HUP", "-INT", "-HUP", "-INT"] {
        signal(&child, name);
    }
    let now = frame_count(folder);
    wait_for(&mut child, "a later frame", || frame_count(folder) > now + 3);
    signal(&child, "-TERM");
    said(&child.wait_with_output().unwrap(), 1, &["interrupted"]);
}

#[test]
fn what_was_noticed_stands_before_the_numbers_and_what_was_not_reached_is_not_measured() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = tiny(folder);
    let text = std::fs::read_to_string(&scene).unwrap();
    let output = run(folder, &["--steps", "3"]);
    said(&output, 0, &[]);
    let text_of = |output: &Output| String::from_utf8_lossy(&output.stdout).to_string();
    assert!(text_of(&output).contains("not measured: the run ended after 0.0015 s, before measure.from = 0.002 s"));
    assert!(!text_of(&output).contains("largest_overlap"));
    assert_eq!((&summary(folder)["observables"], &summary(folder)["sound"]), (&serde_json::json!({}), &true.into()));

    std::fs::write(&scene, text.clone() + "\n[watch]\nevery = 1\noverlap = 0.0001\non_overlap = 'warn'\n").unwrap();
    let output = run(folder, &["--steps", "600", "--restart"]);
    said(&output, 0, &["warning"]);
    assert!(text_of(&output).starts_with("NOT SOUND"), "{}", text_of(&output));
    assert!(text_of(&output).contains("largest_overlap"));
    assert_eq!(summary(folder)["sound"], false);
    assert_eq!(summary(folder)["alarms"].as_array().unwrap().len(), text_of(&output).matches("; noticed in").count());
    assert!(summary(folder)["alarms"][0]["kind"].is_string());
}

#[test]
fn a_run_that_its_watch_has_stopped_goes_on_under_another_watch_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = tiny(folder);
    let text = std::fs::read_to_string(&scene).unwrap();
    let watched = |on: &str| {
        let watch = format!(
            "\n[solver]\nstop = {{ kind = 'sweeps', sweeps = 1 }}\n[watch]\nevery = 520\nresidual = 1e-9\non_stagnation = '{on}'\n"
        );
        std::fs::write(&scene, text.clone() + &watch).unwrap();
    };
    watched("ignore");
    said(&run(folder, &["--steps", "1500"]), 0, &[]);
    let expected = summary(folder)["state_hash"].clone();
    // The first look finds nothing, and holds a state; the second one meets solves of one sweep each.
    watched("stop");
    let stopped = run(folder, &["--steps", "1500", "--restart"]);
    said(&stopped, 1, &["residual", "run.checkpoint", "--resume", "another [watch]", "--restart"]);
    said(&run(folder, &["--steps", "1500", "--resume", "--precision", "single"]), 2, &["other settings"]);
    watched("ignore");
    said(&run(folder, &["--steps", "1500", "--resume"]), 0, &["going on from step 520"]);
    assert_eq!(summary(folder)["state_hash"], expected);
}

#[test]
fn frames_are_written_once() {
    const FRAMES: u64 = 200;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = tiny(folder);
    // Measured at the end alone: no frame is kept for later.
    let text = std::fs::read_to_string(&scene).unwrap().replace("\nfrom = 0.002", "");
    std::fs::write(&scene, text).unwrap();
    // A shell's account of what was written holds that of its children.
    let command = format!(
        "'{}' run tiny.toml --output out --threads 1 --quiet --steps {} >/dev/null && grep wchar /proc/$$/io",
        env!("CARGO_BIN_EXE_makadam"),
        FRAMES * STEPS_A_FRAME
    );
    let output = Command::new("sh").args(["-c", &command]).current_dir(folder).output().unwrap();
    let written = String::from_utf8_lossy(&output.stdout).to_string();
    let written: f64 = written.trim().rsplit(' ').next().unwrap().parse().unwrap();
    let left: usize = files(&folder.join("out")).values().map(Vec::len).sum();
    assert_eq!(summary(folder)["frames"], FRAMES + 1);
    assert!(written < 1.2 * left as f64, "{written} bytes written for {left}");
}

#[test]
fn a_wall_time_that_no_clock_can_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    tiny(folder.path());
    for command in [
        &["compare", "tiny.toml", "--time-limit", "1e20"][..],
        &["qualify", "--time-limit", "1e20"],
        &["tradeoff", "tiny.toml", "--time-limit", "1e300"],
        &["stability", "--time-limit", "inf"],
        &["effects", "tiny.toml", "--time-limit", "1e20"],
        &["run", "tiny.toml", "--checkpoint-interval", "1e20"],
    ] {
        said(&makadam(folder.path()).args(command).output().unwrap(), 2, &["1e9"]);
    }
}

#[test]
fn a_scene_named_after_a_folder_writes_into_one_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = tiny(folder);
    let text = std::fs::read_to_string(&scene).unwrap();
    let here = folder.join("measured-frames.mkd");
    std::fs::write(&here, "of somebody else").unwrap();
    for (name, code) in [("..", Some(0)), (".", Some(0)), (&"n".repeat(300), Some(0))] {
        std::fs::write(&scene, text.replacen("name = \"tiny\"", &format!("name = \"{name}\""), 1)).unwrap();
        let output = makadam(folder).args(["run", "tiny.toml", "--steps", "4"]).output().unwrap();
        // A scene may be refused for such a name, which is as good.
        let refused = output.status.code() == Some(3);
        assert!(refused || output.status.code() == code, "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert_eq!(std::fs::read_to_string(here).unwrap(), "of somebody else");
    assert!(!folder.join("run.json").exists() && !folder.join("results/run.json").exists());
}
