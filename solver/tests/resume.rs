//! Every checkpoint resumes to the same bits, whatever the grains do when it is taken and whatever the caller has done before.
//!
//! `MAKADAM_RESUMED=5000 cargo test --release -p makadam resume` tries as many scenes.

use crate::common::bits::{reference_scene, steps};
use crate::common::parse;
use crate::containment::draw::Drawn;
use makadam::schedule::Scheduler;
use makadam::wall::WallMotion;
use makadam::{GrainEntry, Motion, Scene, Simulation};
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};

/// Scenes of a usual run.
const FEW: u64 = 36;

/// Steps of each, every one of which is a place to resume from.
const STEPS: usize = 30;

/// Steps that an original and its resumed copy go on together.
const TOGETHER: usize = 3;

fn resume(scene: &Scene, simulation: &Simulation, what: &str) -> Simulation {
    let bytes = simulation.checkpoint();
    let resumed = Simulation::resume(scene, &bytes).unwrap_or_else(|error| panic!("{what}: {error}"));
    assert_eq!(resumed.state_hash(), simulation.state_hash(), "{what}");
    assert!(resumed.checkpoint() == bytes, "{what}: what was read is what was written");
    // A frame may be asked for before a step.
    assert_eq!(resumed.snapshot().particles, simulation.snapshot().particles, "{what}");
    resumed
}

/// Does something from outside, or nothing.
fn intervene(simulation: &mut Simulation, scene: &Scene, dice: &mut ChaCha8Rng) {
    let mut below = |count: u64| dice.next_u64() % count;
    match below(12) {
        0 if simulation.grains() > 1 => {
            let id = below(simulation.grains() as u64) as u32;
            simulation.remove(&[id]).unwrap();
        }
        1 => {
            // Where there is no room it is refused.
            let mut entries: Vec<GrainEntry> = simulation.grain_entries(scene);
            if let Some(mut entry) = entries.pop() {
                entry.radius *= 0.5;
                entry.position[below(3) as usize] += 0.015;
                let _ = simulation.insert(scene, &[entry]);
            }
        }
        2 if simulation.grains() > 0 => {
            let row = below(simulation.grains() as u64) as usize;
            let mut states = simulation.states();
            states.velocity(row)[below(3) as usize] *= -2.0;
            states.position(row)[below(3) as usize] += 1e-4;
        }
        3 => {
            let forces = vec![[1e-3, -2e-3, 5e-4]; simulation.grains()];
            simulation.apply_forces(&forces).unwrap();
            simulation.step();
        }
        4 if !scene.wall.is_empty() => {
            let wall = below(scene.wall.len() as u64) as u32;
            if !matches!(scene.wall[wall as usize].motion, Motion::ForceDriven { .. } | Motion::TorqueDriven { .. }) {
                // One that turns is refused.
                let _ = simulation.move_wall(wall, WallMotion::Translation { velocity: [0.1, -0.2, 0.3] });
            }
        }
        _ => {}
    }
}

#[test]
fn every_checkpoint_of_random_scenes_resumes_to_the_same_bits() {
    let asked = std::env::var("MAKADAM_RESUMED").ok().map(|count| count.parse().expect("a whole number"));
    let (mut resumed_from, mut altered) = (0, 0);
    for number in 0..asked.unwrap_or(FEW) {
        let drawn = Drawn::number(number);
        let scene = drawn.scene();
        let mut dice = ChaCha8Rng::seed_from_u64(number);
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        if number % 3 == 0 {
            // Prepared: it begins with the grains and impulses of another run.
            steps(&mut simulation, 10);
            simulation = Simulation::start_from(&scene, &simulation.checkpoint()).unwrap();
        }
        if number % 4 == 1 {
            simulation.open_ledger();
        }
        for step in 0..STEPS {
            let what = format!("scene {number} ({}), step {step}", drawn.summary());
            if number % 2 == 1 {
                intervene(&mut simulation, &scene, &mut dice);
            }
            let mut resumed = resume(&scene, &simulation, &what);
            resumed.use_team(Scheduler::WorkStealing, 1 + step % 2).unwrap();
            let mut original = simulation.clone();
            for _ in 0..TOGETHER {
                original.step();
                resumed.step();
                assert_eq!(resumed.state_hash(), original.state_hash(), "{what}");
            }
            assert_eq!(resumed.balance(), original.balance(), "{what}");
            assert!(resumed.checkpoint() == original.checkpoint(), "{what}: they have the same checkpoints");
            resumed_from += 1;
            altered += usize::from(simulation.checkpoint()[7] != 9);
            simulation.step();
        }
    }
    println!("{resumed_from} checkpoints, {altered} of them with more than the state");
    assert!(altered > 50);
}

/// Elastic grains at four diameters a step between two walls: lists are built with one velocity and asked for with another.
#[test]
fn a_checkpoint_after_a_fast_impact_is_accepted() {
    let mut text = String::from(
        "name = 'fast'\ndescription = ''\nduration = 10.0\ngravity = [0.0, 0.0, 0.0]\n\
         domain = { min = [-1, -1, -1], max = [1, 1, 1] }\n\
         [material.a]\ndensity = 2500.0\nyoungs_modulus = 1e9\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 1.0\n\
         [[wall]]\nname = 'box'\nmaterial = 'a'\n\
         shape = { kind = 'box', min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }\n[solver]\nstep = 1e-3\n",
    );
    for number in 0..12 {
        let at =
            [-0.04 + 0.0065 * f64::from(number), -0.04 + 0.015 * f64::from(number % 6), 0.02 * f64::from(number / 6)];
        text += &format!("[[grain]]\nmaterial = 'a'\nradius = 0.005\nposition = {at:?}\nvelocity = [40.0, 0.0, 0.0]\n");
    }
    let scene = parse(&text).unwrap();
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    for step in 0..100 {
        simulation.step();
        let mut resumed = resume(&scene, &simulation, &format!("step {step}"));
        let mut original = simulation.clone();
        steps(&mut original, 5);
        steps(&mut resumed, 5);
        assert_eq!(resumed.state_hash(), original.state_hash(), "step {step}");
    }
}

/// Grains that lie together in a domain that is much wider: boxes follow them, and there are none before the first step.
fn heap_in_a_wide_domain() -> Scene {
    parse(
        "name = 'wide'\ndescription = ''\nduration = 0.1\n\
         domain = { min = [-0.3, -0.3, -0.3], max = [0.3, 0.3, 0.3] }\n\
         [material.a]\ndensity = 2500.0\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
         [[wall]]\nname = 'box'\nmaterial = 'a'\n\
         shape = { kind = 'box', min = [-0.05, -0.05, 0.0], max = [0.05, 0.05, 0.28] }\n\
         [[population]]\ncount = 1500\nmaterial = 'a'\nradius = { kind = 'uniform', mean = 0.003, spread = 0.2 }\n\
         region = { kind = 'box', min = [-0.05, -0.05, 0.0], max = [0.05, 0.05, 0.2] }\n",
    )
    .unwrap()
}

#[test]
fn frames_can_be_asked_for_before_the_first_step() {
    let scene = heap_in_a_wide_domain();
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    assert_eq!(simulation.snapshot().particles.len(), 1500);
    steps(&mut simulation, 150);
    let bytes = simulation.checkpoint();
    let prepared = Simulation::start_from(&scene, &bytes).unwrap();
    assert_eq!(prepared.snapshot().particles, simulation.snapshot().particles);
    assert_eq!(prepared.snapshot().contacts, []);
    assert_eq!(prepared.contact_problem().grains, 1500);
    let resumed = Simulation::resume(&scene, &bytes).unwrap();
    assert_eq!(resumed.snapshot().particles, simulation.snapshot().particles);
    let entry = GrainEntry { position: [0.0, 0.0, 0.26], ..simulation.grain_entries(&scene)[0].clone() };
    simulation.insert(&scene, &[entry]).unwrap();
    assert_eq!(simulation.snapshot().particles.len(), 1501);
    simulation.remove(&[3]).unwrap();
    assert_eq!(simulation.snapshot().particles.len(), 1500);
    simulation.energy();
    simulation.largest_overlap();
    resume(&scene, &simulation, "after grains have come and gone");
    steps(&mut simulation, 5);
}

#[test]
fn a_flowing_drum_resumes_at_every_step() {
    let scene = reference_scene("drum");
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    steps(&mut simulation, 400);
    for step in 0..10 {
        let mut resumed = resume(&scene, &simulation, &format!("step {step}"));
        simulation.step();
        resumed.step();
        assert_eq!(resumed.state_hash(), simulation.state_hash());
    }
}
