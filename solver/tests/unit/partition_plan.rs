//! Unit tests of `src/partition/plan.rs`.

use super::*;

#[test]
fn batches_cover_the_tasks_of_a_stage_once() {
    // Three boxes; stage 0 is full, stage 1 has crumbs, the others have nothing.
    let counts = [[2000, 0, 600], [100, 20, 80]];
    let mut starts = vec![0];
    for number in 0..3 * STAGES {
        let count = counts.get(number / 3).map_or(0, |stage| stage[number % 3]);
        starts.push(starts[number] + count);
    }
    let mut plan = Plan::default();
    plan.set(&starts, &[0, 5, 5, 5]);
    assert_eq!(plan.batches_of(0), [0..1, 1..2]);
    assert_eq!(plan.batches_of(1).len(), 1, "200 candidates of three faces make one batch");
    assert!((2..STAGES).all(|stage| plan.batches_of(stage).is_empty()));
    let covered: Vec<usize> = plan.batches.iter().flat_map(Clone::clone).collect();
    assert_eq!(covered, (0..plan.tasks().len()).collect::<Vec<_>>());
    plan.set_portion(Portion::Boxes);
    let boxes: Vec<_> = (0..plan.tasks().len()).map(|place| place..place + 1).collect();
    assert_eq!(plan.batches, boxes, "each task by itself");
}
