//! Hashes of runs: what must give the same bits, and what must not change any.

use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::scene::{Material, Scene};
use makadam::schedule::Scheduler;
use std::path::Path;

/// A scene of the repository.
pub fn reference_scene(name: &str) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes").join(name).join("scene.toml");
    Scene::load(&file).unwrap_or_else(|error| panic!("{error}"))
}

/// A scene at its start.
pub fn start(scene: &Scene) -> Simulation {
    Simulation::new(scene, 1).unwrap_or_else(|error| panic!("{error}"))
}

/// Steps so often.
pub fn steps(simulation: &mut Simulation, count: usize) {
    for _ in 0..count {
        simulation.step();
    }
}

/// Hash of the state after so many steps.
pub fn hash_after(scene: &Scene, count: usize, adapt: impl Fn(&mut Simulation)) -> u64 {
    let mut simulation = start(scene);
    adapt(&mut simulation);
    steps(&mut simulation, count);
    simulation.state_hash()
}

/// Asserts that a scene has the same bits on every instruction set, by every scheduler, one contact at a time, and after stops;
/// gives their hash.
pub fn same_bits_everywhere(scene: &Scene, count: usize) -> u64 {
    let expected = hash_after(scene, count, |_| ());
    // Tasks are the same on any instruction set, so not every set needs every team.
    let teams = [(Scheduler::CentralQueue, 2), (Scheduler::WorkStealing, 3)];
    let sets = InstructionSet::ALL.into_iter().filter(|set| set.is_available());
    for (set, (scheduler, threads)) in sets.zip(teams.into_iter().cycle()).chain([(InstructionSet::detect(), teams[1])])
    {
        let found = hash_after(scene, count, |simulation| {
            simulation.use_instruction_set(set).unwrap();
            simulation.use_team(scheduler, threads).unwrap();
        });
        assert_eq!(found, expected, "{set:?}, {scheduler:?}, {threads} threads");
    }
    // A run that was stopped goes on as if it had not been.
    let mut broken = start(scene);
    for leg in [count / 3, count / 2 - count / 3, count - count / 2] {
        broken = Simulation::resume(scene, &broken.checkpoint()).unwrap();
        steps(&mut broken, leg);
    }
    assert_eq!(broken.state_hash(), expected, "resumed");
    expected
}

/// Asserts that an effect changes no bit of a scene in which only a material that nothing is made of has it.
pub fn leaves_no_trace(scene: &Scene, count: usize, give: impl Fn(&mut Material)) {
    let expected = hash_after(scene, count, |_| ());
    let mut with = scene.clone();
    let mut bystander = scene.material["grain"].clone();
    give(&mut bystander);
    with.material.insert("bystander".into(), bystander);
    assert_eq!(hash_after(&with, count, |_| ()), expected, "{}", scene.name);
}
