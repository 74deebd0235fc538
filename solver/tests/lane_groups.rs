//! Order in which contacts are relaxed: lane groups, stages and batches of tasks.

use crate::common::bits::{reference_scene, start, steps};
use makadam::partition::STAGES;
use makadam::schedule::{Phase, StepTrace};
use makadam::{Portion, Simulation};

/// The drum after so many steps.
fn drum(count: usize) -> Simulation {
    let mut simulation = start(&reference_scene("drum"));
    steps(&mut simulation, count);
    simulation
}

#[test]
fn batches_join_small_tasks_of_a_stage() {
    let sizes = |trace: &StepTrace| -> Vec<usize> {
        let sweeps = trace.regions.iter().filter(|region| region.phase == Phase::Sweep);
        sweeps.map(|region| region.tasks.len()).collect()
    };
    let mut simulation = drum(1000);
    let mut boxes = simulation.clone();
    boxes.use_portion(Portion::Boxes);
    let (batches, alone) = (sizes(&simulation.trace_step().1), sizes(&boxes.trace_step().1));
    assert_eq!(simulation.state_hash(), boxes.state_hash());
    let plan = &boxes.layout().plan;
    let stages: Vec<usize> = (0..STAGES).map(|stage| plan.stage(stage).len()).collect();
    // Regions of each sweep, stage after stage.
    assert!(alone.len() > stages.len() && alone.len().is_multiple_of(stages.len()), "{alone:?}");
    assert!(alone.chunks(stages.len()).all(|sweep| sweep == stages), "each task by itself: {alone:?}, {stages:?}");
    assert_eq!(batches.len(), alone.len());
    assert!(batches.iter().zip(&alone).all(|(&some, &all)| some <= all && (some > 0) == (all > 0)), "{batches:?}");
    // Batches but the last of a stage hold as many candidates as pay, and 12 more a task.
    for (stage, &found) in batches[..STAGES].iter().enumerate() {
        let sizes = plan.stage(stage).iter().map(|task| task.pairs.len() + task.walls.len());
        let (full, all) =
            (sizes.clone().filter(|&size| size >= 256).count(), sizes.map(|size| size + 12).sum::<usize>());
        assert!((full..=all / 256 + 1).contains(&found), "stage {stage}: {found} batches of {all} candidates");
    }
    let sums = [&batches, &alone].map(|sizes| sizes.iter().sum::<usize>());
    assert!(3 * sums[0] < 2 * sums[1], "{sums:?}");
}
