//! Unit tests of `src/scaling/measure.rs`.

use super::*;
use makadam::schedule::Phase;

#[test]
fn disturbances_stay_in_the_total() {
    // Another task is disturbed each time: 10 s of work, 2 s of other load.
    let runs = [[6.0, 2.0, 4.0], [4.0, 4.0, 4.0], [4.0, 2.0, 6.0]].map(|durations| {
        let regions = vec![Region { phase: Phase::Sweep, tasks: durations.to_vec() }];
        vec![StepTrace { regions }]
    });
    let steps = medians(&runs, clock_seconds());
    let tasks = &steps[0].regions[0].tasks;
    let total: f64 = tasks.iter().sum();
    assert!((total - 12.0).abs() < 1e-4, "the median of the totals, less the clock: {total}");
    assert!((tasks[0] / tasks[1] - 2.0).abs() < 1e-4, "{tasks:?}");
    assert!((tasks[2] / tasks[1] - 2.0).abs() < 1e-4, "{tasks:?}");
}
