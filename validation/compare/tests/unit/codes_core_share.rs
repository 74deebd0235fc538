//! Unit tests of `src/codes/core_share.rs`.

use super::*;
use std::time::Duration;

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
fn children_count() {
    let before = children_seconds().unwrap();
    let busy = "i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done";
    assert!(std::process::Command::new("sh").args(["-c", busy]).status().unwrap().success());
    assert!(children_seconds().unwrap() > before + 0.02, "the loop takes some hundredths of a second");
}
