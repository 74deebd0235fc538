//! Scenes small enough for Miri that go through all code which leaves the compiler's checks: shared slices, reordering, lane groups,
//! sweeps of every kind and with every effect, checkpoints. `scripts/miri` runs them there, on the lanes of plain Rust and on those of
//! AVX2; `scripts/memcheck` runs them under valgrind, on the widest lanes that it knows.

use makadam::Simulation;
use makadam::lanes::{InstructionSet, PREFETCH};
use makadam::scene::{Precision, Scene, SolverMethod};
use makadam::schedule::Scheduler;

/// Miri is some thousand times slower.
const STEPS: usize = if cfg!(miri) { 2 } else { 40 };

fn scene() -> Scene {
    scene_with("", "friction = 0.5", "")
}

/// Grains that touch from the start, on both sides of the border between two boxes, on a floor; with further keys of the domain and of
/// the material, and further walls.
fn scene_with(domain: &str, material: &str, walls: &str) -> Scene {
    let mut text = format!(
        "name = 'small'\ndescription = 'small'\nduration = 1.0\n\
         domain = {{ min = [-0.16, -0.06, -0.02], max = [0.16, 0.06, 0.1]{domain} }}\n\
         [material.stone]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nrestitution = 0.3\n{material}\n\
         [solver]\nstop = {{ kind = 'sweeps', sweeps = 3 }}\n{walls}\
         [[wall]]\nname = 'floor'\nmaterial = 'stone'\n\
         shape = {{ kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }}\n",
    );
    for number in 0..24 {
        let [x, y, z] = [number % 6, number / 6 % 2, number / 12].map(|place| f64::from(place) * 0.00998);
        let [x, z] = [x - 0.025, z + 0.00499];
        text += &format!("[[grain]]\nmaterial = 'stone'\nradius = 0.005\nposition = [{x:?}, {y:?}, {z:?}]\n");
        text += &format!("velocity = [{:?}, 0.0, -0.01]\n", 0.01 * f64::from(12 - number));
    }
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn start(scene: &Scene) -> Simulation {
    let mut simulation = Simulation::new(scene, 1).unwrap_or_else(|error| panic!("{error}"));
    simulation.use_instruction_set(InstructionSet::Generic).unwrap();
    simulation
}

/// Steps, and returns the hash of the state at the end.
fn hash_after(mut simulation: Simulation) -> u64 {
    let contacts: Vec<usize> = (0..STEPS).map(|_| simulation.step().contacts).collect();
    assert!(contacts.iter().all(|&contacts| contacts > 10), "{contacts:?}");
    simulation.state_hash()
}

/// A lid that a force drives, on top of the grains.
const LID: &str = "[[wall]]\nname = 'lid'\nmaterial = 'stone'\n\
                   shape = { kind = 'plane', point = [0, 0, 0.01993], normal = [0, 0, -1] }\n\
                   motion = { kind = 'force-driven', axis = [0, 0, 1], force = -1.0, mass = 0.1 }\n";

#[test]
fn every_effect_steps_with_the_same_bits_on_vector_lanes() {
    let periodic = ", periodic = ['x', 'y']";
    let torques = "friction = 0.5\nrolling_friction = 0.1\ntwisting_friction = 0.1";
    let cohesive = "friction = 0.5\ncohesion = { kind = 'surface-energy', work = 0.05 }";
    for (domain, material, walls) in [
        ("", "friction = 0.0", ""),
        (periodic, "friction = 0.5\nkinetic_friction = 0.3", ""),
        (periodic, torques, ""),
        ("", cohesive, LID),
        ("", torques, LID),
    ] {
        let scene = scene_with(domain, material, walls);
        let generic = hash_after(start(&scene));
        // Miri knows AVX2 where the program is built for it.
        let mut simulation = start(&scene);
        simulation.use_instruction_set(InstructionSet::detect()).unwrap();
        assert_eq!(hash_after(simulation), generic, "{material} {domain} {walls}");
    }
}

#[test]
fn one_thread_and_several_give_the_same_bits() {
    let scene = scene();
    let serial = hash_after(start(&scene));
    for scheduler in [Scheduler::CentralQueue, Scheduler::WorkStealing] {
        let mut simulation = start(&scene);
        simulation.use_team(scheduler, 2).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(hash_after(simulation), serial, "{scheduler:?}");
    }
}

#[test]
fn prefetching_gives_the_same_bits() {
    let scene = scene();
    let usual = hash_after(start(&scene));
    let mut simulation = start(&scene);
    simulation.use_prefetch(Some(PREFETCH));
    assert_eq!(hash_after(simulation), usual);
}

#[test]
fn every_method_and_precision_steps() {
    let scene = scene();
    for method in SolverMethod::ALL {
        let mut simulation = start(&scene);
        simulation.use_method(method).unwrap();
        hash_after(simulation);
    }
    let mut simulation = start(&scene);
    simulation.use_precision(Precision::Single).unwrap();
    hash_after(simulation);
}

#[test]
fn a_checkpoint_goes_on() {
    let scene = scene();
    let mut simulation = start(&scene);
    simulation.step();
    let mut resumed = Simulation::resume(&scene, &simulation.checkpoint()).unwrap_or_else(|error| panic!("{error}"));
    resumed.use_instruction_set(InstructionSet::Generic).unwrap();
    assert_eq!(hash_after(resumed), hash_after(simulation));
}
