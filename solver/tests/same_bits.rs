//! The contract that everything else leans on: a scene and a seed give the same bits on any number of threads, with any
//! scheduler, on any instruction set, and one contact at a time.

use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::scene::Scene;
use makadam::schedule::Scheduler;
use std::path::Path;

const STEPS: usize = 500;
const CHECK_EVERY: usize = 100;

fn reference_scene(name: &str, seed: u64) -> Simulation {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes").join(name).join("scene.toml");
    let scene = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    Simulation::new(&scene, seed, &file).unwrap_or_else(|error| panic!("{error}"))
}

/// Hashes of the state on the way.
fn hashes(simulation: &mut Simulation) -> Vec<u64> {
    let mut step = |number: usize| {
        simulation.step();
        number.is_multiple_of(CHECK_EVERY).then(|| simulation.state_hash())
    };
    (1..=STEPS).filter_map(&mut step).collect()
}

/// Every available instruction set, scheduler and number of threads.
fn same_bits_everywhere(scene: &str) {
    let start = reference_scene(scene, 1);
    let expected = hashes(&mut start.clone());
    assert_eq!(expected.len(), STEPS / CHECK_EVERY);
    for set in InstructionSet::ALL.into_iter().filter(|set| set.is_available()) {
        for scheduler in Scheduler::ALL {
            let threads: &[usize] = if scheduler == Scheduler::Serial { &[1] } else { &[1, 2, 3, 8] };
            for &threads in threads {
                let mut simulation = start.clone();
                simulation.use_instruction_set(set);
                simulation.use_team(scheduler, threads).unwrap();
                let found = hashes(&mut simulation);
                assert_eq!(expected, found, "{scene}: {set:?}, {scheduler:?}, {threads} threads");
            }
        }
    }
    let mut simulation = start.clone();
    simulation.use_scalar_sweeps(true);
    simulation.use_prefetch(4);
    assert_eq!(expected, hashes(&mut simulation), "{scene}: one contact at a time");
    assert_ne!(expected, hashes(&mut reference_scene(scene, 2)), "{scene}: another seed, another state");
}

#[test]
fn the_drum_has_the_same_bits_everywhere() {
    same_bits_everywhere("drum");
}

#[test]
fn the_packing_has_the_same_bits_everywhere() {
    same_bits_everywhere("packing");
}

#[test]
fn the_heap_has_the_same_bits_everywhere() {
    same_bits_everywhere("heap");
}

#[test]
fn a_traced_step_is_a_step() {
    let (mut plain, mut traced) = (reference_scene("drum", 1), reference_scene("drum", 1));
    for _ in 0..200 {
        plain.step();
        let (report, trace) = traced.trace_step();
        assert!(report.contacts == 0 || trace.regions.iter().any(|region| region.tasks.len() > 1));
    }
    assert_eq!(plain.state_hash(), traced.state_hash());
}
