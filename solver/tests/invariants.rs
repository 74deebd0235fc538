//! Invariants of every run: same bits, no energy from nothing, no spin without friction, momentum, lane groups.

use crate::common::{FLOOR, Setup, run_until};
use makadam::Simulation;
use makadam::lanes::LANES;
use makadam::partition::Layout;
use makadam::scene::Scene;
use std::collections::HashSet;
use std::path::Path;

const BOX: &str = "[[wall]]\nname = 'box'\nmaterial = 'wall'\n\
                   shape = { kind = 'box', min = [-0.05, -0.05, 0.0], max = [0.05, 0.05, 0.1] }\n";

fn population(agitation: f64) -> String {
    format!(
        "[[population]]\ncount = 200\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0.2 }}\n\
         region = {{ kind = 'box', min = [-0.05, -0.05, 0.0], max = [0.05, 0.05, 0.1] }}\nagitation = {agitation:?}\n"
    )
}

fn reference_scene(name: &str, seed: u64) -> Simulation {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes").join(name).join("scene.toml");
    let scene = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
    Simulation::new(&scene, seed).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn no_energy_comes_from_nothing() {
    for (law, restitution) in [("rigid", 1.0), ("rigid", 0.5), ("hertz", 0.8), ("hertz", 0.3)] {
        for friction in [0.0, 0.5] {
            let mut simulation = Setup {
                restitution,
                friction,
                wall_friction: friction,
                solver: format!(
                    "step = 2e-4\nnormal_law = {{ kind = '{law}' }}\nstop = {{ kind = 'sweeps', sweeps = 50 }}"
                ),
                body: format!("{BOX}{}", population(0.5)),
                ..Setup::default()
            }
            .start();
            let total = |simulation: &Simulation| {
                let energy = simulation.energy();
                energy.kinetic + energy.potential + energy.elastic
            };
            let start = total(&simulation);
            let mut highest = start;
            for _ in 0..50 {
                let next = simulation.time() + 0.01;
                run_until(&mut simulation, next);
                highest = highest.max(total(&simulation));
            }
            assert!(highest <= start * (1.0 + 1e-3), "{law}, e = {restitution}, mu = {friction}: {start} -> {highest}");
            if restitution < 1.0 {
                assert!(total(&simulation) < 0.9 * start, "{law}: impacts at e = {restitution} dissipate");
            }
        }
    }
}

#[test]
fn grains_without_friction_do_not_spin() {
    let mut simulation = Setup {
        friction: 0.0,
        wall_friction: 0.0,
        body: format!("{BOX}{}", population(0.5)),
        solver: "stop = { kind = 'sweeps', sweeps = 10 }".into(),
        ..Setup::default()
    }
    .start();
    run_until(&mut simulation, 0.2);
    assert!(simulation.snapshot().contacts.len() > 200);
    assert!(simulation.snapshot().particles.iter().all(|particle| particle.spin == [0.0; 3]));
}

#[test]
fn collisions_keep_linear_momentum() {
    let mut simulation = Setup {
        gravity: [0.0; 3],
        body: population(0.5),
        solver: "stop = { kind = 'sweeps', sweeps = 10 }".into(),
        ..Setup::default()
    }
    .start();
    let momentum = |simulation: &Simulation| {
        let particles = simulation.snapshot().particles;
        particles.iter().fold([0.0; 3], |sum: [f64; 3], particle| {
            std::array::from_fn(|axis| sum[axis] + particle.radius.powi(3) * particle.velocity[axis])
        })
    };
    let before = momentum(&simulation);
    let mut contacts = 0;
    for _ in 0..200 {
        contacts += simulation.step().contacts;
    }
    assert!(contacts > 200, "{contacts} contacts are too few to tell");
    let after = momentum(&simulation);
    for axis in 0..3 {
        assert!((after[axis] - before[axis]).abs() < 1e-13 * 200.0 * 0.005_f64.powi(3) * 1e3);
    }
}

/// Lane groups share no body, and tasks of one stage share none either.
fn check_layout(layout: &Layout, grains: u32) {
    let mut seen = (0, HashSet::new());
    let mut contacts = 0;
    for (stage, task) in layout.tasks() {
        if stage != seen.0 {
            seen = (stage, HashSet::new());
        }
        let mut own = HashSet::new();
        for group in task.pairs.iter() {
            let bodies: Vec<u32> = group.first.iter().chain(&group.second).copied().collect();
            assert_eq!(bodies.iter().collect::<HashSet<_>>().len(), 2 * LANES, "a body twice in {bodies:?}");
            contacts += group.first.iter().filter(|&&body| body < grains).count();
            own.extend(bodies);
        }
        for group in &task.walls {
            assert_eq!(group.body.iter().collect::<HashSet<_>>().len(), LANES, "a body twice in {:?}", group.body);
            contacts += group.body.iter().filter(|&&body| body < grains).count();
            own.extend(group.body.iter().copied());
        }
        assert!(seen.1.is_disjoint(&own), "two tasks of stage {stage} share a body, or a dummy");
        seen.1.extend(own);
    }
    assert_eq!(contacts, layout.contacts);
}

#[test]
fn lane_groups_and_stages_share_no_body() {
    let mut simulation = reference_scene("packing", 1);
    for _ in 0..800 {
        simulation.step();
    }
    assert!(simulation.layout().contacts > 4000);
    assert!(simulation.layout().lane_occupancy() > 0.9, "{}", simulation.layout().lane_occupancy());
    check_layout(simulation.layout(), 2000);
}

#[test]
fn one_grain_and_none_are_scenes_too() {
    for body in [String::from(FLOOR), format!("{FLOOR}{}", crate::common::grain(0.005, [0.0, 0.0, 0.1], [0.0; 3]))] {
        let mut simulation = Setup { body, ..Setup::default() }.start();
        run_until(&mut simulation, 0.5);
        assert!(simulation.snapshot().particles.iter().all(|particle| particle.position[2] > 0.0049));
    }
}

#[test]
fn an_effect_that_is_off_takes_no_byte_of_a_contact() {
    // Places, normal, bias, regularisation and normal impulse; friction adds its coefficient and three components.
    for (scene, bytes) in [("frictionless-packing", 56), ("packing", 88)] {
        let mut simulation = reference_scene(scene, 1);
        for _ in 0..600 {
            simulation.step();
        }
        assert!(simulation.layout().contacts > 1000);
        for (_, task) in simulation.layout().tasks() {
            assert_eq!(task.pairs.bytes_of_group(), bytes * LANES, "{scene}");
            assert!(task.pair_torques.is_empty() && task.pair_pulls.is_empty(), "{scene}");
        }
    }
}

#[test]
fn kernels_for_other_effects_sweep_what_is_laid_out_for_them() {
    let mut simulation = reference_scene("packing", 1);
    for _ in 0..600 {
        simulation.step();
    }
    for effects in makadam::effects::EffectSet::COMPILED {
        simulation.compile_effects(effects);
        assert_eq!(simulation.sweep_times(1), 0, "nothing is laid out yet");
        let contacts = simulation.constrain_once();
        assert!(contacts > 1000);
        assert_eq!(simulation.sweep_times(2), 2 * contacts as u64);
    }
}
