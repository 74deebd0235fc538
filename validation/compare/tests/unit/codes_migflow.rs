//! Unit tests of `src/codes/migflow.rs`.

use super::unfinished;

#[test]
fn unfinished_solves_become_a_note() {
    let log = |count: u64| format!("Warning\n7 contact relaxations in 0.1 s, {count} steps not converged\n");
    assert_eq!(unfinished(&log(0), 40), None);
    assert_eq!(unfinished("", 40), None);
    assert!(unfinished(&log(3), 40).unwrap().starts_with("3 of 40 solves"));
}
