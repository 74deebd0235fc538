//! The contract that everything else leans on: a scene and a seed give the same bits on any number of threads, with any
//! scheduler, on any instruction set, and one contact at a time.

use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::scene::{Precision, Scene};
use makadam::schedule::Scheduler;
use std::path::Path;

/// Steps until grains touch, which most runs share.
const SHARED: usize = 300;
/// Steps of each run from there.
const STEPS: usize = 200;

fn reference_scene(name: &str, seed: u64) -> Simulation {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes").join(name).join("scene.toml");
    let scene = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    Simulation::new(&scene, seed).unwrap_or_else(|error| panic!("{error}"))
}

/// Hash of the state after so many steps of a copy that was changed before.
fn hash_after(start: &Simulation, count: usize, change: impl FnOnce(&mut Simulation)) -> u64 {
    let mut simulation = start.clone();
    change(&mut simulation);
    for _ in 0..count {
        simulation.step();
    }
    simulation.state_hash()
}

/// Every available instruction set, scheduler and number of threads.
fn same_bits_everywhere(scene: &str, precision: Precision) {
    let mut start = reference_scene(scene, 1);
    start.use_precision(precision).unwrap();
    let mut shared = start.clone();
    for _ in 0..SHARED {
        shared.step();
    }
    let expected = hash_after(&shared, STEPS, |_| ());
    assert!(shared.layout().contacts > 0, "{scene}");
    let others = InstructionSet::ALL.into_iter().filter(|set| set.is_available());
    for (set, scheduler) in others.zip(Scheduler::ALL) {
        let found = |start: &Simulation, count: usize, scheduler: Scheduler, threads: usize| {
            let found = hash_after(start, count, |simulation| {
                simulation.use_instruction_set(set).unwrap();
                simulation.use_team(scheduler, threads).unwrap();
            });
            assert_eq!(expected, found, "{scene}: {set:?}, {scheduler:?}, {threads} threads, {count} steps");
        };
        found(&start, SHARED + STEPS, scheduler, 3);
        found(&shared, STEPS, Scheduler::Serial, 1);
        found(&shared, STEPS, Scheduler::WorkStealing, 3);
        if set == InstructionSet::detect() {
            for threads in [1, 2, 3, 8] {
                found(&shared, STEPS, Scheduler::CentralQueue, threads);
                found(&shared, STEPS, Scheduler::WorkStealing, threads);
            }
        }
    }
    for groups in [0, 2] {
        let found = hash_after(&shared, STEPS, |simulation| simulation.use_prefetch(Some(groups)));
        assert_eq!(expected, found, "{scene}: {groups} groups prefetched");
    }
    let found = hash_after(&shared, STEPS, |simulation| {
        simulation.use_portion(Portion::Boxes);
        simulation.use_team(Scheduler::CentralQueue, 2).unwrap();
    });
    assert_eq!(expected, found, "{scene}: box by box");
    let other = hash_after(&reference_scene(scene, 2), 1, |_| ());
    assert_ne!(hash_after(&start, 1, |_| ()), other, "{scene}: another seed, another state");
}

#[test]
fn the_drum_has_the_same_bits_everywhere() {
    same_bits_everywhere("drum", Precision::Double);
}

#[test]
fn the_packing_has_the_same_bits_everywhere() {
    same_bits_everywhere("packing", Precision::Double);
}

#[test]
fn the_heap_has_the_same_bits_everywhere() {
    same_bits_everywhere("heap", Precision::Double);
}

#[test]
fn the_drum_in_single_precision_has_the_same_bits_everywhere() {
    same_bits_everywhere("drum", Precision::Single);
}

#[test]
fn single_precision_differs_by_rounding_alone() {
    let mut double = reference_scene("drum", 1);
    for _ in 0..1000 {
        double.step();
    }
    let mut single = double.clone();
    single.use_precision(Precision::Single).unwrap();
    // Divergence is chaotic, so one step is compared.
    let contacts = [double.step().contacts, single.step().contacts];
    assert_eq!(contacts[0], contacts[1]);
    assert!(contacts[0] > 3000, "the drum is full: {} contacts", contacts[0]);
    let [exact, rounded] = [double.snapshot().particles, single.snapshot().particles];
    let fastest = exact.iter().flat_map(|grain| grain.velocity).fold(0.0, |most: f64, v| most.max(v.abs()));
    let furthest = exact.iter().zip(&rounded).flat_map(|(a, b)| (0..3).map(|axis| a.velocity[axis] - b.velocity[axis]));
    let furthest = furthest.fold(0.0, |most: f64, difference| most.max(difference.abs()));
    println!("fastest {fastest:.2e} m/s, largest difference {furthest:.2e} m/s");
    assert!(furthest > 0.0, "nothing was rounded");
    // Ten sweeps of a few contacts a grain, each rounding to 6e-8 of the velocity.
    assert!(furthest < 1e-5 * fastest, "largest difference {furthest:e} m/s, fastest grain {fastest:e} m/s");
}

#[test]
fn a_traced_step_is_a_step() {
    for scheduler in Scheduler::ALL {
        let (mut plain, mut traced) = (reference_scene("drum", 1), reference_scene("drum", 1));
        traced.use_team(scheduler, 2).unwrap();
        for _ in 0..200 {
            plain.step();
            let (report, trace) = traced.trace_step();
            assert!(report.contacts == 0 || trace.regions.iter().any(|region| region.tasks.len() > 1));
        }
        assert_eq!(plain.state_hash(), traced.state_hash(), "{scheduler:?}");
    }
}
