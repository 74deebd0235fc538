//! `makadam run --resume`: a run that was killed, at whatever moment, ends as if nothing had happened.

use crate::support::changed::changed;
use crate::support::makadam;
use crate::support::small_scene::smoke;
use makadam_frames::run_frames::RunFrames;
use std::fs::read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

const STEPS: &str = "2500";

fn summary(folder: &Path, output: &str) -> serde_json::Value {
    serde_json::from_slice(&read(folder.join(output).join("run.json")).unwrap()).unwrap()
}

/// Results that must not depend on interruptions: the state, the observables, the table, the frames.
fn results(folder: &Path, output: &str) -> (String, String, String, Vec<u8>) {
    let summary = summary(folder, output);
    assert_eq!(summary["complete"], true);
    (
        summary["state_hash"].to_string() + &summary["contact_sweeps"].to_string(),
        summary["observables"].to_string(),
        String::from_utf8(read(folder.join(output).join("observables.csv")).unwrap()).unwrap(),
        read(folder.join(output).join("frames.mkd")).unwrap(),
    )
}

/// The small scene with its frames measured over time, so that frames must outlive interruptions too.
fn scene(folder: &Path) -> std::path::PathBuf {
    changed(folder, "interval = 0.05", "interval = 0.05\nfrom = 0.2")
}

fn undisturbed(folder: &Path) {
    let scene = scene(folder);
    makadam(folder)
        .arg("run")
        .arg(scene)
        .args(["--steps", STEPS, "--output", "undisturbed", "--quiet"])
        .assert()
        .success();
}

#[test]
fn a_hundred_kills_change_no_bit() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    undisturbed(folder);
    let expected = results(folder, "undisturbed");
    // Moments from a generator of Knuth's, MMIX: the same in each run of the test, at random within the program's.
    let mut random = 2026_u64;
    let (mut kills, mut ends, mut goes) = (0, 0, 0);
    while kills < 100 || ends == 0 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // Later and later: on a busy machine a program may take longer than the first moments leave it to get anywhere.
        let latest = 60_000 * (1 + goes / 100);
        let moment = Duration::from_micros(4_000 + (random >> 33) % latest);
        let threads = ["1", "2", "3"][(random >> 20) as usize % 3];
        let mut child = Command::new(env!("CARGO_BIN_EXE_makadam"))
            .arg("run")
            .arg(folder.join("changed.toml"))
            .args(["--steps", STEPS, "--output", "broken", "--resume", "--checkpoint-interval", "0.004", "--quiet"])
            .args(["--threads", threads])
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(moment);
        goes += 1;
        assert!(goes < 2000, "{kills} kills and {ends} ends: no progress");
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
        }
        let output = child.wait_with_output().unwrap();
        match output.status.code() {
            None => kills += 1,
            Some(0) => {
                ends += 1;
                assert_eq!(results(folder, "broken"), expected, "after {kills} kills");
                assert!(
                    !folder.join("broken/run.checkpoint").exists()
                        && !folder.join("broken/measured-frames.mkd").exists()
                );
                std::fs::remove_dir_all(folder.join("broken")).unwrap();
            }
            Some(code) => panic!("exit code {code} after {kills} kills: {}", String::from_utf8_lossy(&output.stderr)),
        }
    }
    println!("{kills} kills, {ends} runs reached their end");
}

#[test]
fn an_interrupted_run_is_taken_up_or_thrown_away_only_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    undisturbed(folder);
    let scene = folder.join("changed.toml");
    let run = |more: &[&str]| {
        let arguments = ["--steps", STEPS, "--output", "broken"];
        makadam(folder).arg("run").arg(&scene).args(arguments).args(more).output().unwrap()
    };
    let mut child = Command::new(env!("CARGO_BIN_EXE_makadam"))
        .arg("run")
        .arg(&scene)
        .args(["--steps", "100000000", "--output", "broken", "--quiet"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while RunFrames::open(&folder.join("broken")).map_or(0, |run| run.count()) < 3 {
        assert!(child.try_wait().unwrap().is_none(), "the run ended by itself");
        std::thread::sleep(Duration::from_millis(2));
    }
    Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let checkpoint = folder.join("broken/run.checkpoint");
    let written = read(&checkpoint).unwrap();
    assert_eq!(summary(folder, "broken")["complete"], false);

    let said = |output: &std::process::Output, code: i32, words: &[&str]| {
        let message = String::from_utf8_lossy(&output.stderr).to_string();
        assert_eq!(output.status.code(), Some(code), "{message}");
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    said(&run(&[]), 2, &["run.checkpoint", "--resume", "--restart"]);
    said(&run(&["--resume", "--seed", "7"]), 2, &["seed 1", "seed 7", "--restart"]);
    said(&run(&["--resume", "--precision", "single"]), 2, &["other settings"]);
    std::fs::write(&checkpoint, &written[..written.len() / 2]).unwrap();
    said(&run(&["--resume"]), 1, &["run.checkpoint", "cut off", "--restart"]);
    let mut altered = written.clone();
    altered[written.len() / 3] ^= 0x10;
    std::fs::write(&checkpoint, &altered).unwrap();
    said(&run(&["--resume"]), 1, &["run.checkpoint", "damaged"]);
    assert_eq!(read(&checkpoint).unwrap(), altered, "what is refused is not touched");
    std::fs::write(&checkpoint, &written).unwrap();
    said(&run(&["--resume"]), 0, &[]);
    assert_eq!(results(folder, "broken"), results(folder, "undisturbed"));
    assert_eq!(summary(folder, "broken")["continued_at"].as_array().unwrap().len(), 1);

    said(&run(&["--restart"]), 0, &[]);
    assert_eq!(results(folder, "broken"), results(folder, "undisturbed"));
}

#[test]
fn trouble_is_named_and_leaves_a_checkpoint_from_before() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = std::fs::read_to_string(smoke()).unwrap();
    let run = |watch: &str, more: &[&str]| {
        std::fs::write(folder.join("watched.toml"), format!("{text}\n[watch]\n{watch}\n")).unwrap();
        let output = makadam(folder)
            .args(["run", "watched.toml", "--steps", "1500", "--output", "out", "--json"])
            .args(more)
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).to_string(), summary(folder, "out"))
    };
    // At rest grains overlap by some thousandths; a fall of 0.25 m ends in more.
    let (code, message, summary) = run("every = 64\noverlap = 0.002\non_overlap = 'stop'", &["--restart"]);
    assert_eq!(code, Some(1), "{message}");
    assert!(
        message.contains("overlaps its partner by 0.0")
            && message.contains("step")
            && message.contains("youngs_modulus"),
        "{message}"
    );
    assert_eq!(summary["complete"], false);
    assert_eq!(summary["alarms"][0]["count"], 1);
    assert!(summary["steps"].as_u64().unwrap().is_multiple_of(64));

    let (code, message, summary) = run("overlap = 0.002", &["--restart"]);
    assert_eq!(code, Some(0), "{message}");
    assert!(message.contains("overlaps its partner"), "{message}");
    assert!(
        summary["alarms"][0]["count"].as_u64().unwrap() > 1 && message.matches("overlaps").count() == 1,
        "{message}"
    );

    let (code, message, summary) = run("", &["--restart"]);
    assert_eq!((code, summary["alarms"].as_array().unwrap().len()), (Some(0), 0), "{message}");

    // Late enough for a state to be held; it can be taken up again.
    let (code, message, _) = run("residual = 1e-9\non_stagnation = 'stop'\nevery = 520", &["--restart"]);
    assert_eq!(code, Some(1), "{message}");
    assert!(message.contains(" g h, more than 1.0e-9 g h") && !message.contains("0.00 g h"), "{message}");
    let (code, message, _) = run("every = 0", &["--restart"]);
    assert_eq!(code, Some(0), "{message}");
    let (code, message, _) = run("overlap = -1", &["--restart"]);
    assert_eq!(code, Some(3), "{message}");
    assert!(message.contains("watched.toml:") && message.contains("overlap"), "{message}");
}
