//! Unit tests of `src/codes/process.rs`.

use super::{last_words, *};
use std::time::Duration;

/// Log of LIGGGHTS for a mesh that it refuses: the reason is in its own log alone, the terminal has the abort.
const PRINTED: &str = "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0)\n\
        --------------------------------------------------------------------------\n\
        MPI_ABORT was invoked on rank 0 in communicator MPI_COMM_WORLD\nwith errorcode 1.\n";
const OWN: &str = "Reading STL file 'wall1.stl'\n\
        ERROR: Mesh wall1: contains highly skewed element, see above (surface_mesh_I.h:512)\nLast input line: fix wall1\n";

#[test]
fn the_reason_goes_before_the_words_of_who_aborts() {
    let words = last_words(PRINTED, &[OWN.to_string()]);
    assert!(words.starts_with("ERROR: Mesh wall1: contains highly skewed element"), "{words}");
    assert!(words.contains("MPI_ABORT was invoked"), "{words}");
    // Printed by the program itself it is found there, and the last one counts.
    let twice = format!("ERROR: an earlier one\nERROR on proc 0: Lost atoms\n{PRINTED}");
    assert!(last_words(&twice, &[]).starts_with("ERROR on proc 0: Lost atoms"));
    assert_eq!(last_words("Segmentation fault\n", &[]), "Segmentation fault");
    assert_eq!(last_words("a\x1b[2Jb", &[]), r"a\u001b[2Jb", "a terminal is told nothing");
    let long = "\u{e9}".repeat(1000);
    assert!(last_words(&long, &[]).len() <= 601);
}

#[test]
fn sleeping_takes_no_core() {
    // Of this thread alone: other tests may wait for children meanwhile.
    let before = own_seconds();
    std::thread::sleep(Duration::from_millis(200));
    assert!(own_seconds() - before < 0.1);
}

#[test]
fn a_thread_is_asked_for_its_own_time_alone() {
    let clock = ThreadClock::start();
    std::thread::sleep(Duration::from_millis(100));
    assert!(clock.core_seconds(Duration::from_secs(1)).unwrap() < 0.5, "it slept");
}

#[test]
fn a_process_that_sleeps_gets_no_core() {
    let (started, mut child) = (Instant::now(), std::process::Command::new("sleep").arg("5").spawn().unwrap());
    assert_eq!(share_of(child.id(), started), None, "in the first moments");
    std::thread::sleep(SHORTEST);
    assert!(share_of(child.id(), started).unwrap() < 0.1);
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(share_of(child.id(), started), None, "it is gone");
}

#[test]
fn a_process_that_works_gets_a_core() {
    let busy = std::process::Command::new("sh").args(["-c", "while :; do :; done"]).spawn();
    let (started, mut child) = (Instant::now(), busy.unwrap());
    std::thread::sleep(2 * SHORTEST);
    assert!(share_of(child.id(), started).unwrap() > 0.02);
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn patterns_stay_below_the_folder() {
    for pattern in ["out.csv", "./out.csv", "out/*.csv", "**/grains_*.csv", "..csv", "a..b"] {
        assert_eq!(check_pattern(pattern), Ok(()));
    }
    for pattern in ["", "/tmp/out.csv", "../out.csv", "out/../../out.csv"] {
        let problem = check_pattern(pattern).unwrap_err();
        assert!(problem.contains("leads out of the folder of a run; name files below"), "{problem}");
    }
    assert!(check_pattern("out[.csv").unwrap_err().contains("is no pattern of files"));
}
