//! The replay against schedules that can be worked out by hand, and a study made of invented traces.

use crate::support::scaling_sample as sample;
use approx::assert_relative_eq;
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::{Phase, Region, Scheduler};
use makadam_compare::study::Document;
use makadam_studies::scaling::{Costs, Machine, MeasuredRow, Replayed, ReplayedRow, replay};

const NOTHING: Costs = Costs { pop_alone: 0.0, pop_contended: 0.0, task_start: 0.0, steal: 0.0, region: 0.0 };

/// Cores that are all alike.
fn machine(costs: Costs) -> Machine {
    Machine::here(costs, (1e9, 256), 0)
}

fn region(tasks: &[f64]) -> Region {
    Region { phase: Phase::Sweep, tasks: tasks.to_vec() }
}

fn both(regions: &[Region], costs: Costs, workers: usize) -> [Replayed; 2] {
    [Scheduler::CentralQueue, Scheduler::WorkStealing]
        .map(|scheduler| replay(regions, scheduler, &machine(costs), 0.0, workers))
}

/// Durations that look irregular and are the same every time, 1 to 10.
fn irregular(count: usize) -> Vec<f64> {
    let mut state = 12_345_u64;
    (0..count)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            1.0 + 9.0 * (state >> 11) as f64 / (1_u64 << 53) as f64
        })
        .collect()
}

#[test]
fn one_worker_takes_the_sum_and_the_costs() {
    let regions = [region(&[1.0, 2.0, 3.0]), region(&[4.0]), region(&[5.0, 6.0])];
    let serial = replay(&regions, Scheduler::Serial, &machine(NOTHING), 0.0, 1);
    assert_relative_eq!(serial.seconds, 21.0);
    let costs = Costs { pop_alone: 0.1, pop_contended: 9.0, task_start: 0.2, steal: 9.0, region: 0.5 };
    let [queue, stealing] = both(&regions, costs, 1);
    assert_relative_eq!(queue.waiting, 0.0);
    // Five tasks are popped; the lone task is serial work. Nobody is there to steal from.
    assert_relative_eq!(queue.seconds, 21.0 + 5.0 * 0.1, epsilon = 1e-12);
    assert_relative_eq!(stealing.seconds, 21.0, epsilon = 1e-12);
    // Two workers pay for the region, the start of each task, and two steals (the second worker's arrival, its last task).
    let [queue, stealing] = both(&regions[..2], Costs { steal: 0.1, ..costs }, 2);
    // Pops end at 9.5 and 18.5: 9.5 + 1, 18.5 + 2 and 27.5 + 3.
    assert_relative_eq!(queue.seconds, 30.5 + 4.0, epsilon = 1e-12);
    // The first worker has the task of 1, the second those of 2 and 3; the first steals the 3 while the second is at 2.
    assert_relative_eq!(stealing.seconds, 0.5 + (0.2 + 1.0) + (0.1 + 0.2 + 3.0) + 4.0, epsilon = 1e-12);
    // The second worker comes at 0.6 and waits until 9.5; the first comes back at 10.5 and waits until 18.5.
    assert_relative_eq!(queue.waiting, 8.9 + 8.0, epsilon = 1e-12);
}

#[test]
fn many_workers_take_the_longest_task_of_each_region() {
    let regions = [region(&irregular(40)), region(&[4.0]), region(&irregular(17))];
    let longest = |region: &Region| region.tasks.iter().copied().fold(0.0, f64::max);
    let expected: f64 = regions.iter().map(longest).sum();
    for replayed in both(&regions, NOTHING, 256) {
        assert_relative_eq!(replayed.seconds, expected, epsilon = 1e-12);
        assert_relative_eq!(replayed.sweep_seconds, expected, epsilon = 1e-12);
    }
}

#[test]
fn two_workers_share_by_hand() {
    // The queue hands out 3 and 1, then 2 to the second worker, then 2 to either: ends at 3, 1, 3, 5.
    let [queue, _] = both(&[region(&[3.0, 1.0, 2.0, 2.0])], NOTHING, 2);
    assert_relative_eq!(queue.seconds, 5.0);
    // The second worker begins after one steal, with a stretch of two tasks: 0.5 + 1 + 1. The first would need 8, so the
    // second takes its last task at 2.5, for another 0.5: it ends at 7.
    let costs = Costs { steal: 0.5, ..NOTHING };
    let [_, stealing] = both(&[region(&[4.0, 4.0, 1.0, 1.0])], costs, 2);
    assert_relative_eq!(stealing.seconds, 7.0);
}

#[test]
fn the_queue_saturates_at_duration_over_service() {
    // Tasks of 10 and pops of 1: ten workers keep up, and more get no task sooner.
    let regions = [region(&vec![10.0; 1000])];
    let costs = Costs { pop_alone: 1.0, pop_contended: 1.0, ..NOTHING };
    let queue = |workers| replay(&regions, Scheduler::CentralQueue, &machine(costs), 0.0, workers);
    assert_relative_eq!(queue(5).seconds, 1000.0 * 11.0 / 5.0, max_relative = 0.01);
    for workers in [11, 20, 100] {
        assert_relative_eq!(queue(workers).seconds, 1010.0, max_relative = 1e-9);
    }
    // Beyond that the workers wait for the lock; below they hardly do.
    assert!(queue(5).waiting < 15.0 && queue(100).waiting > 10_000.0);
    // A thief needs no lock.
    let stealing = replay(&regions, Scheduler::WorkStealing, &machine(costs), 0.0, 100);
    assert_relative_eq!(stealing.seconds, 100.0);
}

#[test]
fn the_memory_ceiling_holds() {
    // The memory needs half a second for the bytes of a task of one: two workers run freely, four at half speed.
    let regions = [region(&vec![1.0; 64])];
    let memory = 0.5;
    for scheduler in [Scheduler::CentralQueue, Scheduler::WorkStealing] {
        let seconds = |workers| replay(&regions, scheduler, &machine(NOTHING), memory, workers).seconds;
        assert_relative_eq!(seconds(1), 64.0, max_relative = 1e-9);
        assert_relative_eq!(seconds(2), 32.0, max_relative = 1e-9);
        for workers in [4, 16, 64] {
            assert_relative_eq!(seconds(workers), 32.0, max_relative = 1e-9);
        }
    }
    // Other phases carry no traffic.
    let other = [Region { phase: Phase::Integrate, tasks: vec![1.0; 64] }];
    let free = replay(&other, Scheduler::WorkStealing, &machine(NOTHING), memory, 64);
    assert_relative_eq!(free.seconds, 1.0);
    // Irregular tasks: the bytes moved over the time never exceed the ceiling.
    let tasks = irregular(200);
    let least = memory * tasks.iter().sum::<f64>();
    for workers in [3, 7, 50] {
        let replayed = replay(&[region(&tasks)], Scheduler::CentralQueue, &machine(NOTHING), memory, workers);
        assert!(replayed.seconds >= least * (1.0 - 1e-9));
    }
}

#[test]
fn more_workers_are_never_slower_where_handing_out_is_free() {
    let regions = [region(&irregular(300)), region(&irregular(31)), region(&irregular(7))];
    let mut last = [f64::INFINITY; 2];
    for workers in 1..=256 {
        let now = both(&regions, NOTHING, workers).map(|replayed| replayed.seconds);
        assert!(now[0] <= last[0] + 1e-9, "the queue at {workers}: {} after {}", now[0], last[0]);
        // Whom a thief meets may cost it a task or two; on the whole it gains.
        assert!(now[1] <= last[1] + 20.0, "stealing at {workers}: {} after {}", now[1], last[1]);
        // No schedule beats the work over the workers.
        let work: f64 = regions.iter().flat_map(|region| &region.tasks).sum();
        assert!(now.iter().all(|&seconds| seconds >= work / workers as f64 - 1e-9));
        last = now;
    }
}

#[test]
fn threads_of_one_core_share_it() {
    let costs = Costs { pop_alone: 1e-8, pop_contended: 5e-8, task_start: 3e-8, steal: 1e-6, region: 4e-8 };
    let phi = Machine { costs: NOTHING, ..Machine::xeon_phi_3120(&costs, 2.2e9) };
    // 228 tasks of 1 s: four times as long there (half the clock, every other cycle).
    let regions = [region(&[1.0; 228])];
    let seconds = |workers| replay(&regions, Scheduler::WorkStealing, &phi, 0.0, workers).seconds;
    assert_relative_eq!(seconds(1), 4.0 * 228.0, max_relative = 1e-9);
    assert_relative_eq!(seconds(57), 16.0, max_relative = 1e-9);
    assert_relative_eq!(seconds(114), 8.0, max_relative = 1e-9);
    // Three and four threads of a core do no more than two.
    assert_relative_eq!(seconds(228), 8.0, max_relative = 1e-9);
    assert_eq!(phi.most_workers(), 228);
}

#[test]
fn a_study_says_what_is_replayed() {
    let study = sample::study();
    assert!(study.same_bits, "{:?}", study.differing);
    assert!(study.replayed.iter().all(|row| row.source == "replayed"));
    // The sample's measured times are replays with a known factor.
    for row in &study.measured {
        assert!((row.deviation_percent.unwrap() + 100.0 * (1.0 - 1.0 / sample::SLOWER)).abs() < 1e-6, "{row:?}");
    }
    for row in study.measured.iter().filter(|row| row.threads == 1) {
        assert!((0.8..=1.0 + 1e-9).contains(&row.speedup), "{row:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let page = study.write(folder.path()).unwrap();
    let html = std::fs::read_to_string(page).unwrap();
    assert!(html.contains("Replayed on the model xeon-phi-3120") && html.contains("The thesis"), "{html}");
    let widest = |row: &&MeasuredRow| row.threads > 1 && row.instruction_set == InstructionSet::Avx512;
    // The page opens with the answer, and so does the terminal.
    let best = study.measured.iter().filter(widest).max_by(|a, b| a.speedup.total_cmp(&b.speedup));
    let best = best.expect("more than one thread was measured");
    let head = html.split_once("</h1>").unwrap().1.trim_start();
    assert!(head.starts_with("<p class=\"verdict agree\"><strong>"), "{head}");
    let answer = format!(" times as fast on {} threads.</strong> A step takes ", best.threads);
    assert!(head.split_once("</p>").unwrap().0.contains(&answer), "{head}");
    assert!(
        study.report().text().lines().nth(1).unwrap().contains(&format!("times as fast on {} threads.", best.threads))
    );
    assert!(study.findings[1].contains("on more than one thread by at most 3.8%"), "{:?}", study.findings);
    for name in ["here-time", "here-speedup", "xeon-phi-3120-time", "xeon-phi-3120-speedup", "instruction-sets-time"] {
        let svg = std::fs::read_to_string(folder.path().join(format!("{name}.svg"))).unwrap();
        roxmltree::Document::parse(&svg).unwrap();
    }
    let machine = std::fs::read_to_string(folder.path().join("machine.csv")).unwrap();
    assert_eq!(machine.lines().count(), 2, "{machine}");
    assert!(machine.lines().nth(1).unwrap().starts_with("16,"), "{machine}");
    let replayed = std::fs::read_to_string(folder.path().join("replayed.csv")).unwrap();
    assert!(
        replayed.starts_with("source,machine,instruction_set,scheduler,workers,portion,step_seconds"),
        "{replayed}"
    );
    assert!(study.report().text().contains("work-stealing"));
    // Box by box the queue hands out six times as many tasks, so it feeds fewer workers; a thief hardly minds.
    let best = |scheduler, portion| {
        let own = |row: &&ReplayedRow| {
            row.machine == Machine::XEON_PHI && (row.scheduler, row.portion) == (scheduler, portion)
        };
        study.replayed.iter().filter(own).map(|row| row.sweep_speedup).fold(0.0, f64::max)
    };
    let [batches, boxes] = [Portion::Batches, Portion::Boxes].map(|portion| best(Scheduler::CentralQueue, portion));
    assert!(boxes < 0.5 * batches, "{boxes} of {batches}");
    let [batches, boxes] = [Portion::Batches, Portion::Boxes].map(|portion| best(Scheduler::WorkStealing, portion));
    assert!(boxes > 0.8 * batches, "{boxes} of {batches}");
}

#[test]
fn different_bits_are_said() {
    let study = sample::study_of(|measurement| measurement.timings[2].hashes[0] += 1);
    assert!(!study.same_bits);
    assert_eq!(study.differing.len(), 1);
    assert!(study.findings[0].contains("Not all configurations"), "{}", study.findings[0]);
}
