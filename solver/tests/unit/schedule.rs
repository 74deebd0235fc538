use super::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

#[test]
fn every_scheduler_does_every_task_once() {
    for scheduler in Scheduler::ALL {
        // Miri is some thousand times slower.
        for threads in if cfg!(miri) { &[1, 2][..] } else { &[1, 2, 3, 8] } {
            let team = Team::new(scheduler, *threads).unwrap();
            for count in [0, 1, 2, 7, if cfg!(miri) { 20 } else { 1000 }] {
                let done: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
                team.enter(|| {
                    team.each(Phase::Sweep, count, |task| {
                        done[task].fetch_add(1, Ordering::Relaxed);
                    });
                });
                assert!(
                    done.iter().all(|times| times.load(Ordering::Relaxed) == 1),
                    "{scheduler:?}, {threads} threads"
                );
            }
        }
    }
}

#[test]
fn a_trace_has_a_duration_for_every_task() {
    for scheduler in Scheduler::ALL {
        let team = Team::new(scheduler, 2).unwrap().traced();
        team.enter(|| {
            team.each(Phase::Detect, 3, |_| std::thread::sleep(Duration::from_millis(1)));
            team.alone(Phase::Integrate, || {});
        });
        let trace = team.take_trace();
        let sizes: Vec<_> = trace.regions.iter().map(|region| (region.phase, region.tasks.len())).collect();
        assert_eq!(sizes, [(Phase::Detect, 3), (Phase::Integrate, 1)]);
        assert!(trace.regions[0].tasks.iter().all(|&seconds| seconds >= 1e-3), "{:?}", trace.regions[0]);
        assert!(team.take_trace().regions.is_empty());
    }
}

#[test]
fn a_team_traces_only_when_it_is_asked_to() {
    let team = Team::default();
    team.each(Phase::Detect, 3, |_| {});
    assert!(team.take_trace().regions.is_empty());
}

#[test]
fn a_team_has_threads_of_its_own_in_a_process_that_was_forked_off() {
    let parent = Team::new(Scheduler::WorkStealing, 2).unwrap();
    // As a child finds it, in which none of the threads runs: to wait for one, or to end it, would take for ever.
    let threads = Some(ThreadPoolBuilder::new().num_threads(2).build().unwrap());
    let pool = Arc::new(Pool { threads, process: std::process::id().wrapping_add(1) });
    let forked = Team { scheduler: Scheduler::WorkStealing, pool: Some(pool), tracer: None };
    let here = forked.here();
    assert_eq!((here.threads(), here.scheduler()), (2, Scheduler::WorkStealing));
    assert!(here.pool.as_ref().is_some_and(|pool| pool.is_here()));
    let done = AtomicUsize::new(0);
    here.enter(|| {
        here.each(Phase::Sweep, 10, |_| {
            done.fetch_add(1, Ordering::Relaxed);
        });
    });
    assert_eq!(done.into_inner(), 10);
    assert!(
        Arc::ptr_eq(parent.here().pool.as_ref().unwrap(), parent.pool.as_ref().unwrap()),
        "no fork, no new threads"
    );
}
