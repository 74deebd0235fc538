//! Memory that tasks share: the source file itself is compiled into these tests, since no scene can ask for a part that is not there.

#[allow(dead_code, reason = "the tests use a part of the file")]
#[path = "../src/schedule/shares.rs"]
mod shares;

use shares::{Disjoint, Runs, Shares};

#[test]
fn parts_are_those_of_the_slice() {
    let mut numbers = [1, 2, 3];
    let parts = Disjoint::new(&mut numbers);
    // SAFETY: no other thread uses the numbers.
    unsafe {
        *parts.at(2) += 10;
        parts.range(0..2)[0] += 20;
    }
    assert_eq!(numbers, [21, 2, 13]);
}

#[test]
#[should_panic(expected = "a task asked for part 3 of 3")]
fn a_part_beyond_the_slice_is_refused_in_every_build() {
    let mut numbers = [1, 2, 3];
    let parts = Disjoint::new(&mut numbers);
    // SAFETY: no other thread uses the numbers.
    unsafe { *parts.at(3) = 0 };
}

#[test]
fn runs_cover_a_slice_once() {
    let mut numbers = [0; 7];
    let runs = Runs::of(&mut numbers, 3);
    for (number, length) in [3, 3, 1, 0].into_iter().enumerate() {
        // SAFETY: each number is asked for once.
        let run = unsafe { runs.share(number) };
        assert_eq!(run.len(), length);
        run.iter_mut().for_each(|one| *one += number + 1);
    }
    assert_eq!(numbers, [1, 1, 1, 2, 2, 2, 3]);
}
