//! Unit tests of `src/partition/assignment.rs`.

use super::*;
use crate::partition::{PlannedTask, TaskShares};

/// Places of contacts of random pairs of 60 bodies, packed by two tasks one after the other.
fn places(taken: &mut TakenGroups, pairs: &[[u32; 2]]) -> Vec<(usize, usize, usize)> {
    taken.start(60);
    let mut places = Vec::new();
    for (task, pairs) in pairs.chunks(pairs.len() / 2).enumerate() {
        let (bodies, base, next) = taken.stage();
        let alone = PlannedTask { number: 0, home: 0, pairs: 0..0, first_block: 0, walls: 0..0 };
        // SAFETY: there is no other task.
        let bodies = unsafe { bodies.share(0, &alone) };
        let mut assigner = LaneAssigner::new(bodies, base, pairs.len());
        for &pair in pairs {
            let (group, lane) = assigner.place(pair);
            places.push((task, group, lane));
        }
        *next = assigner.next();
    }
    places
}

#[test]
fn groups_share_no_body_and_numbers_that_begin_anew_change_nothing() {
    let mut state = 1_u64;
    let mut random = |below: u64| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((state >> 33) % below) as u32
    };
    let pairs: Vec<[u32; 2]> = (0..1000)
        .map(|_| {
            let first = random(60);
            [first, (first + 1 + random(59)) % 60]
        })
        .collect();
    let mut taken = TakenGroups::default();
    let first = places(&mut taken, &pairs);
    let mut seen = std::collections::BTreeSet::new();
    for (&(task, group, lane), pair) in first.iter().zip(&pairs) {
        assert!(lane < LANES);
        assert!(pair.iter().all(|&body| seen.insert((task, group, body))), "a group has a body twice");
    }
    assert_eq!(places(&mut taken, &pairs), first, "what the step before left is not seen");
    // What was left names numbers that will be given again.
    taken.next = u32::MAX / 2 + 1;
    assert_eq!(places(&mut taken, &pairs), first);
    assert!(taken.next < u32::MAX / 2);
}
