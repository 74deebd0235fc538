//! `makadam run` over a system that fails it: each write, sync, rename and allocation in turn, and power that is cut.
//!
//! A library of C that is loaded before the system's makes calls fail or writes them down (`support/faults.c`); the compiler's own
//! linker builds it. A sample of all moments is tried; `MAKADAM_FAULTS=all` tries every one.

use crate::support::disk::{CUTS, Record};
use crate::support::tiny_scene::tiny;
use makadam_frames::run_frames::RunFrames;
use serde_json::Value;
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// Two frames after the first one, and one at the end.
const STEPS: &str = "9";

/// Kinds of calls that fail once or from then on, and how many moments of each are left out for one that is tried.
const FAULTS: [(&str, &str, usize); 10] = [
    ("write", "", 5),
    ("write", ":always", 11),
    ("half", "", 7),
    ("fsync", "", 9),
    ("rename", "", 4),
    ("create", "", 6),
    ("unlink", "", 3),
    ("truncate", "", 1),
    ("mkdir", "", 1),
    ("memory", "", 5),
];

/// The library that makes calls fail.
fn library() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/support/faults.c");
        let library = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("faults-{}.so", std::process::id()));
        let mut compiler = Command::new("cc");
        let built = compiler.args(["-shared", "-fPIC", "-O1", "-o"]).arg(&library).arg(source).arg("-ldl").output();
        let built = built.unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        library
    })
}

/// A folder in memory where there is one: hundreds of runs sync after every step.
fn scratch() -> tempfile::TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap()
}

/// Every moment, or one of so many.
fn stride(sampled: usize) -> usize {
    if std::env::var("MAKADAM_FAULTS").is_ok_and(|which| which == "all") { 1 } else { sampled }
}

/// Runs the tiny scene into `out` with a checkpoint after each step.
fn run(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_makadam"))
        .args(["run", "tiny.toml", "--output", "out", "--threads", "1", "--quiet", "--steps", STEPS])
        .args(["--checkpoint-interval", "0"])
        .args(arguments)
        .envs(environment.iter().copied())
        .env("RUST_BACKTRACE", "0")
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Files of a finished run without the summary, and the part of the summary that depends on the scene alone.
type Results = (BTreeMap<String, Vec<u8>>, String);

fn results(folder: &Path) -> Option<Results> {
    let summary: Value = serde_json::from_slice(&std::fs::read(folder.join("out/run.json")).ok()?).unwrap();
    (summary["complete"] == true).then_some(())?;
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(folder.join("out")).ok()?.map(Result::unwrap) {
        let name = entry.file_name().to_str().unwrap().to_string();
        let passing = ["run.lock", "run.checkpoint", "run.json"].contains(&name.as_str()) || name.contains(".part");
        if !passing {
            files.insert(name, std::fs::read(entry.path()).unwrap());
        }
    }
    let told = ["state_hash", "contact_sweeps", "observables", "frames"].map(|field| summary[field].to_string());
    Some((files, told.join(" ")))
}

/// A folder of scenes and runs to begin from.
struct Bench {
    folder: tempfile::TempDir,
    /// Results of an undisturbed run.
    expected: Results,
    /// And of one with another seed.
    other: Results,
}

impl Bench {
    fn new() -> Bench {
        let folder = scratch();
        let place = |name: &str| {
            let place = folder.path().join(name);
            std::fs::create_dir_all(&place).unwrap();
            tiny(&place);
            place
        };
        let undisturbed = |name: &str, seed: &str| {
            let place = place(name);
            let output = run(&place, &["--seed", seed], &[]);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            results(&place).unwrap()
        };
        let (expected, other) = (undisturbed("expected", "1"), undisturbed("other", "2"));
        assert!(expected != other && expected.0.len() == 2, "{:?}", expected.0.keys());
        // Stopped after some checkpoints, with frames and rows beyond the last one.
        let stopped = place("stopped");
        let fault = [("LD_PRELOAD", library().to_str().unwrap()), ("FAULT", "rename:8:always")];
        assert_eq!(run(&stopped, &[], &fault).status.code(), Some(1));
        assert!(stopped.join("out/run.checkpoint").exists());
        Bench { folder, expected, other }
    }

    /// A copy of one of its folders.
    fn copy(&self, from: &str) -> tempfile::TempDir {
        let copy = scratch();
        let from = self.folder.path().join(from);
        assert!(Command::new("cp").arg("-r").arg(from.join(".")).arg(copy.path()).status().unwrap().success());
        copy
    }

    /// A summary that says complete stands beside all that it speaks of.
    fn check_claim(&self, folder: &Path, what: &str) {
        if let Some(found) = results(folder) {
            assert!(found == self.expected || found == self.other, "{what}: complete, with files missing or mixed");
        }
    }

    /// Goes on or begins anew, whichever is possible, and must come to the bits of an undisturbed run.
    fn recover(&self, folder: &Path, what: &str) {
        let unfinished = folder.join("out/run.checkpoint").exists() && results(folder).is_none();
        let resumed = run(folder, &["--resume"], &[]);
        let message = String::from_utf8_lossy(&resumed.stderr);
        if !resumed.status.success() {
            assert!(!unfinished, "{what}: the checkpoint cannot be gone on from: {message}");
            assert_eq!(resumed.status.code(), Some(2), "{what}: {message}");
            assert!(message.contains("--restart"), "{what}: {message}");
            let anew = run(folder, &["--restart"], &[]);
            assert!(anew.status.success(), "{what}: {}", String::from_utf8_lossy(&anew.stderr));
        }
        assert!(results(folder).unwrap() == self.expected, "{what}: other bits");
        let mut left: Vec<_> = std::fs::read_dir(folder.join("out")).unwrap().map(|e| e.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, ["frames.mkd", "observables.csv", "run.json"], "{what}");
    }
}

/// Checks that all whole frames and the table can be read.
fn check_readable(folder: &Path, what: &str) {
    if let Ok(run) = RunFrames::open(&folder.join("out")) {
        (0..run.count())
            .for_each(|number| drop(run.snapshot(number).unwrap_or_else(|error| panic!("{what}: {error}"))));
    }
    if let Ok(mut table) = csv::Reader::from_path(folder.join("out/observables.csv")) {
        assert!(table.records().all(|row| row.is_ok()), "{what}: a row is cut off");
    }
}

/// Tries faults where a run takes the place of another one, or goes on.
fn try_faults(from: &str, arguments: &[&str], scale: usize) {
    let bench = Bench::new();
    let mut met_any = 0;
    for (kind, lasting, sampled) in FAULTS {
        for number in (1..).step_by(stride(sampled * scale)) {
            let what = format!("{arguments:?}, {kind} {number}{lasting}");
            let copy = bench.copy(from);
            let folder = copy.path();
            let (fault, met) = (format!("{kind}:{number}{lasting}"), folder.join("met"));
            let environment =
                [("LD_PRELOAD", library().to_str().unwrap()), ("FAULT", &fault), ("FAULT_MET", met.to_str().unwrap())];
            let output = run(folder, arguments, &environment);
            let message = String::from_utf8_lossy(&output.stderr);
            if !met.exists() {
                assert!(output.status.success(), "{what}: {message}");
                break;
            }
            met_any += 1;
            match output.status.code() {
                Some(0) => assert!(results(folder).unwrap() == bench.expected, "{what}"),
                Some(1) if kind == "memory" => {}
                Some(1) => {
                    let named = message.contains("out/") || message.contains("error: out:");
                    assert!(named && !message.contains("panicked"), "{what}: {message}");
                }
                // Memory that is refused may end a process at once.
                code => assert!(kind == "memory" && code.is_none(), "{what}: {code:?} {message}"),
            }
            check_readable(folder, &what);
            bench.check_claim(folder, &what);
            bench.recover(folder, &what);
        }
    }
    assert!(met_any > 10, "only {met_any} faults were met");
}

#[test]
fn no_fault_of_a_run_that_begins_leaves_what_cannot_be_gone_on_from_or_begun_anew() {
    try_faults("other", &["--restart"], 1);
}

#[test]
fn no_fault_of_a_run_that_goes_on_leaves_what_cannot_be_gone_on_from_or_begun_anew() {
    try_faults("stopped", &["--resume"], 2);
}

#[test]
fn no_cut_of_power_shows_a_complete_run_with_something_missing() {
    let bench = Bench::new();
    for (from, arguments, sampled) in [("other", "--restart", 29), ("stopped", "--resume", 41)] {
        let recorded = bench.copy(from);
        let record = recorded.path().join("record");
        let environment = [("LD_PRELOAD", library().to_str().unwrap()), ("RECORD", record.to_str().unwrap())];
        assert!(run(recorded.path(), &[arguments], &environment).status.success());
        assert!(results(recorded.path()).unwrap() == bench.expected);
        let record = Record::parse(&std::fs::read(record).unwrap());
        assert!(record.len() > 50, "{} calls", record.len());
        let before = bench.folder.path().join(from);
        let mut seen = HashSet::new();
        for calls in 0..=record.len() {
            for (kind, cut) in CUTS.into_iter().enumerate() {
                let what = format!("{arguments}, {cut:?} after {calls} of {} calls", record.len());
                let found = record.cut_after(calls, &before, cut);
                if !seen.insert(found.clone()) {
                    continue;
                }
                let folder = scratch();
                tiny(folder.path());
                for (path, bytes) in &found {
                    match bytes {
                        None => std::fs::create_dir_all(folder.path().join(path)).unwrap(),
                        Some(bytes) => std::fs::write(folder.path().join(path), bytes).unwrap(),
                    }
                }
                // Each state is looked at, a sample of them is run on from.
                bench.check_claim(folder.path(), &what);
                if (calls + 7 * kind).is_multiple_of(stride(sampled)) {
                    bench.recover(folder.path(), &what);
                }
            }
        }
    }
}
