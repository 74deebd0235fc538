//! Interventions between steps: forces, states that are written, grains that come and go, walls that are moved.

use crate::common::bits::{reference_scene, steps};
use makadam::schedule::Scheduler;
use makadam::wall::WallMotion;
use makadam::{
    Face, GrainEntry, InterventionError, Material, Motion, Population, RadiusDistribution, Region, Scene, Shape,
    Simulation, Wall,
};

const STEP: f64 = 1e-3;

fn grain(position: [f64; 3]) -> GrainEntry {
    GrainEntry { material: "glass".into(), radius: 0.005, position, velocity: [0.0; 3], spin: [0.0; 3] }
}

fn mass() -> f64 {
    Material::default().density * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3)
}

/// A box without a lid, with grains that fall into it.
fn bin(count: usize) -> Scene {
    let [min, max] = [[0.0; 3], [0.06, 0.06, 0.3]];
    let region = Region::cuboid(min, [0.06, 0.06, 0.15]);
    let builder = Scene::builder()
        .name("bin")
        .material("glass", Material { friction: 0.4, ..Material::default() })
        .wall(Wall::new("box", "glass", Shape::cuboid(min, max, &[Face::Top])))
        .population(Population::new(count, "glass", RadiusDistribution::uniform(0.004, 0.1), region));
    builder.build().unwrap()
}

fn start(scene: &Scene) -> Simulation {
    Simulation::builder(scene).time_step(STEP).build().unwrap()
}

/// The scene with the step that [`start`] takes, as reading a checkpoint wants it.
fn stepped(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.solver.step = STEP;
    scene
}

fn in_space(grains: &[GrainEntry]) -> Scene {
    let space = Scene::builder().material("glass", Material::default()).gravity([0.0; 3]).domain([-1.0; 3], [1.0; 3]);
    grains.iter().fold(space, |scene, grain| scene.grain(grain.clone())).build().unwrap()
}

#[test]
fn a_grain_under_a_force_and_a_torque_speeds_up_as_newton_says() {
    let mut simulation = start(&in_space(&[grain([0.0; 3]), grain([0.5, 0.0, 0.0])]));
    let (force, torque) = ([2e-3, -1e-3, 5e-4], [0.0, 3e-6, 1e-6]);
    for _ in 0..200 {
        simulation.apply_forces(&[[0.0; 3], force]).unwrap();
        simulation.apply_torques(&[torque, [0.0; 3]]).unwrap();
        simulation.step();
    }
    simulation.step();
    let frame = simulation.frame();
    let inertia = 0.4 * mass() * 0.005 * 0.005;
    for axis in 0..3 {
        let near = |found: f64, expected: f64| assert!((found - expected).abs() <= 1e-13 * expected.abs().max(1e-12));
        near(frame.velocities()[1][axis], force[axis] * 0.2 / mass());
        near(frame.spins()[0][axis], torque[axis] * 0.2 / inertia);
    }
    assert_eq!((frame.velocities()[0], frame.spins()[1]), ([0.0; 3], [0.0; 3]));
}

#[test]
fn insert_refuses_what_scenes_refuse() {
    let mut scene = in_space(&[grain([0.0; 3])]);
    scene.domain.periodic = vec![makadam::scene::Axis::X];
    let mut simulation = start(&scene);
    let wide = GrainEntry { radius: 0.6 * 2.0, ..grain([0.0, 0.5, 0.5]) };
    let refused = simulation.insert(&scene, &[wide]).unwrap_err();
    let InterventionError::Rule(said) = &refused else { panic!("{refused}") };
    assert!(said.contains("too short a period") && said.contains("at least"), "{said}");
    assert_eq!(simulation.grains(), 1);
    // Restitution that falls with the speed goes with impacts that are over within a step only.
    let mut scene = bin(0);
    let soft = Material { youngs_modulus: 1e4, restitution_speed: Some(0.1), ..Material::default() };
    scene.material.insert("soft".into(), soft);
    let mut simulation = start(&scene);
    let soft = GrainEntry { material: "soft".into(), ..grain([0.03, 0.03, 0.1]) };
    let refused = simulation.insert(&scene, &[soft]).unwrap_err().to_string();
    assert!(refused.contains("restitution_speed"), "{refused}");
    assert_eq!(simulation.insert(&scene, &[grain([0.03, 0.03, 0.1])]), Ok(0..1));
}

#[test]
fn written_and_inserted_states_close_angular_momentum() {
    let scene = bin(40);
    let mut simulation = start(&scene);
    simulation.open_ledger();
    steps(&mut simulation, 50);
    {
        let mut states = simulation.states();
        states.velocity(3)[0] += 0.3;
        states.position(4)[2] += 1e-4;
        states.scaled_spin(5)[1] += 0.1;
    }
    steps(&mut simulation, 5);
    simulation.insert(&scene, &[grain([0.03, 0.03, 0.28])]).unwrap();
    steps(&mut simulation, 5);
    simulation.remove(&[7]).unwrap();
    let forces = vec![[1e-3, 0.0, 2e-3]; simulation.grains()];
    simulation.apply_forces(&forces).unwrap();
    simulation.apply_torques(&forces).unwrap();
    steps(&mut simulation, 5);
    let balance = simulation.balance().unwrap();
    assert!(balance.outside_angular_impulse.iter().any(|given| given.abs() > 1e-6), "{balance:#?}");
    assert!(balance.angular_momentum_closure.iter().all(|open| open.abs() < 1e-13), "{balance:#?}");
}

#[test]
fn forces_that_carry_the_weight_are_gravity_and_their_work_is_in_the_ledger() {
    let scene = bin(60);
    let (mut falling, mut weightless) = (start(&scene), scene.clone());
    weightless.gravity = [0.0; 3];
    let mut pushed = start(&weightless);
    pushed.open_ledger();
    for _ in 0..400 {
        let entries = pushed.grain_entries(&weightless);
        let weight: Vec<[f64; 3]> = entries
            .iter()
            .map(|grain| {
                let volume = 4.0 / 3.0 * std::f64::consts::PI * grain.radius.powi(3);
                [0.0, 0.0, -9.81 * Material::default().density * volume]
            })
            .collect();
        pushed.apply_forces(&weight).unwrap();
        pushed.step();
        falling.step();
    }
    // Until grains land the two differ by rounding; a bed at rest has the same height.
    let height = |simulation: &Simulation| {
        let frame = simulation.frame();
        frame.positions().iter().map(|position| position[2]).sum::<f64>() / frame.grains() as f64
    };
    assert!((height(&falling) - height(&pushed)).abs() < 5e-4, "{} {}", height(&falling), height(&pushed));
    let balance = pushed.balance().unwrap();
    assert!(balance.outside > 1e-3 && balance.outside_impulse[2] < -0.01, "{balance:#?}");
    assert!(balance.closure.abs() < 1e-11 * balance.exchanged(), "{balance:#?}");
    assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-13), "{balance:#?}");
}

#[test]
fn the_contact_problem_of_a_step_knows_the_forces_of_the_caller() {
    let mut simulation = start(&bin(30));
    steps(&mut simulation, 300);
    let without = simulation.contact_problem();
    let force = [0.01, 0.0, -0.02];
    simulation.apply_forces(&[force; 30]).unwrap();
    let with = simulation.contact_problem();
    for (one, other) in with.bodies.iter().zip(&without.bodies) {
        let gained = one.velocity - other.velocity;
        let expected = other.inverse_mass * nalgebra::Vector3::from(force) * STEP;
        assert!((gained - expected).norm() < 1e-15, "{gained} {expected}");
    }
    // A step that was given up is taken again with the same forces.
    let (mut stopped, mut slow) = (simulation.clone(), simulation.clone());
    for one in [&mut stopped, &mut slow] {
        one.use_stop(makadam::Stop::Sweeps { sweeps: 200 });
        one.apply_torques(&[[1e-5, 0.0, 0.0]; 30]).unwrap();
    }
    stopped.set_interrupt(makadam::Interrupt::new());
    stopped.interrupt_handle().request();
    let before = stopped.state_hash();
    stopped.step();
    assert_eq!((stopped.state_hash(), stopped.steps_taken()), (before, 300));
    stopped.interrupt_handle().clear();
    stopped.step();
    slow.step();
    assert_eq!(stopped.state_hash(), slow.state_hash());
}

#[test]
fn every_intervention_is_in_the_ledger() {
    let scene = bin(80);
    let mut simulation = start(&scene);
    simulation.open_ledger();
    steps(&mut simulation, 300);
    let check = |simulation: &Simulation, what: &str| {
        let balance = simulation.balance().unwrap();
        assert!(balance.closure.abs() < 1e-10 * balance.exchanged(), "{what}: {balance:#?}");
        assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-12), "{what}: {balance:#?}");
        balance.outside
    };
    assert_eq!(check(&simulation, "nothing"), 0.0);
    let mut states = simulation.states();
    for row in 0..states.grains() {
        states.velocity(row)[0] += 0.3;
        states.position(row)[2] += 1e-4;
        states.scaled_spin(row)[1] -= 0.2;
    }
    drop(states);
    let written = check(&simulation, "written");
    assert!(written > 0.0);
    steps(&mut simulation, 50);
    check(&simulation, "steps after it was written");
    simulation.insert(&scene, &[grain([0.03, 0.03, 0.28])]).unwrap();
    check(&simulation, "inserted");
    // The next list finds the overlaps of contacts that have not borne an impulse yet.
    simulation.step();
    let inserted = check(&simulation, "a step after the insertion");
    assert!((inserted - written - mass() * 9.81 * 0.28).abs() < 1e-12);
    steps(&mut simulation, 49);
    check(&simulation, "steps after the insertion");
    simulation.remove(&[0, 5, 80]).unwrap();
    check(&simulation, "removed");
    steps(&mut simulation, 50);
    check(&simulation, "steps after the removal");
    let bytes = simulation.checkpoint();
    let resumed = Simulation::resume(&stepped(&scene), &bytes).unwrap();
    assert_eq!(resumed.balance().unwrap(), simulation.balance().unwrap());
}

#[test]
fn what_comes_and_goes_is_as_if_it_had_been_read_from_a_checkpoint() {
    let scene = bin(100);
    let mut simulation = start(&scene);
    steps(&mut simulation, 250);
    assert_eq!(simulation.insert(&scene, &[grain([0.02, 0.02, 0.28]), grain([0.04, 0.02, 0.28])]).unwrap(), 100..102);
    let new_ids = simulation.remove(&[3, 100, 3]).unwrap();
    assert_eq!(
        (new_ids[2], new_ids[3], new_ids[4], new_ids[100], new_ids[101]),
        (Some(2), None, Some(3), None, Some(99))
    );
    let frame = simulation.frame();
    assert_eq!((frame.grains(), frame.contacts().len()), (100, 0));
    assert_eq!(frame.positions()[99], [0.04, 0.02, 0.28]);
    assert_eq!((simulation.steps_taken(), simulation.time()), (250, 0.25));
    let bytes = simulation.checkpoint();
    let mut resumed = Simulation::resume(&stepped(&scene), &bytes).unwrap();
    assert_eq!(resumed.checkpoint(), bytes);
    let mut threaded = simulation.clone();
    threaded.use_team(Scheduler::WorkStealing, 3).unwrap();
    for leg in 0..5 {
        steps(&mut simulation, 61);
        steps(&mut threaded, 61);
        steps(&mut resumed, 61);
        assert_eq!(resumed.state_hash(), simulation.state_hash(), "leg {leg}");
        assert_eq!(threaded.state_hash(), simulation.state_hash(), "leg {leg}");
        resumed = Simulation::resume(&stepped(&scene), &resumed.checkpoint()).unwrap();
    }
    assert!(simulation.frame().coordination_number() > 3.0, "they lie on each other");
}

#[test]
fn a_grain_that_is_inserted_is_one_that_the_scene_had_listed() {
    let [first, second] = [grain([0.0; 3]), grain([0.1, 0.0, 0.0])];
    let scene = in_space(std::slice::from_ref(&first));
    let mut grown = start(&scene);
    grown.insert(&scene, std::slice::from_ref(&second)).unwrap();
    let mut listed = start(&in_space(&[first, second]));
    assert_eq!(grown.state_hash(), listed.state_hash());
    for simulation in [&mut grown, &mut listed] {
        *simulation.states().velocity(1) = [-1.0, 0.01, 0.0];
        steps(simulation, 200);
    }
    assert_eq!(grown.state_hash(), listed.state_hash());
    assert!(grown.frame().velocities()[0][0] < -0.1, "they have met");
    let entries = grown.grain_entries(&scene);
    assert_eq!(entries[1].position, grown.frame().positions()[1]);
}

#[test]
fn what_cannot_be_inserted_removed_applied_or_moved_is_refused_and_nothing_changes() {
    let scene = bin(20);
    let mut simulation = start(&scene);
    steps(&mut simulation, 300);
    let (before, bytes) = (simulation.state_hash(), simulation.checkpoint());
    let there = simulation.frame().positions()[7];
    let refused = |simulation: &mut Simulation, grain: GrainEntry, words: &str| {
        let fine = self::grain([0.03, 0.03, 0.28]);
        let message = simulation.insert(&scene, &[fine, grain]).unwrap_err().to_string();
        assert!(message.contains("grain 1 of those to insert") && message.contains(words), "{message}");
    };
    refused(&mut simulation, GrainEntry { material: "steel".into(), ..grain([0.03; 3]) }, "the scene has glass");
    refused(&mut simulation, GrainEntry { radius: 0.0, ..grain([0.03; 3]) }, "radius of 0 m");
    refused(&mut simulation, GrainEntry { velocity: [f64::NAN, 0.0, 0.0], ..grain([0.03; 3]) }, "NaN");
    refused(&mut simulation, grain([0.03, 0.03, 0.4]), "outside the domain");
    refused(&mut simulation, grain([0.002, 0.03, 0.28]), "wall 'box'");
    refused(&mut simulation, GrainEntry { radius: 0.001, ..grain(there) }, "overlaps grain 7 by");
    refused(&mut simulation, grain([0.03, 0.031, 0.28]), "grain 0 of those to insert overlaps");
    assert_eq!(simulation.remove(&[20]), Err(InterventionError::NoGrain { id: 20, grains: 20 }));
    let message = simulation.apply_forces(&[[0.0; 3]; 19]).unwrap_err().to_string();
    assert!(message.contains("19 rows where there are 20"), "{message}");
    let mut forces = [[0.0; 3]; 20];
    forces[4][1] = f64::INFINITY;
    let message = simulation.apply_torques(&forces).unwrap_err().to_string();
    assert!(message.contains("torque of grain 4"), "{message}");
    let along = WallMotion::Translation { velocity: [0.0; 3] };
    assert_eq!(simulation.move_wall(1, along), Err(InterventionError::NoWall { wall: 1, walls: 1 }));
    let turn = WallMotion::Rotation { rate: 1.0, about: None };
    assert!(simulation.move_wall(0, turn).unwrap_err().to_string().contains("gives it no axis"));
    let fast = WallMotion::Translation { velocity: [f64::NAN; 3] };
    assert!(simulation.move_wall(0, fast).unwrap_err().to_string().contains("no velocity"));
    assert_eq!((simulation.state_hash(), simulation.checkpoint()), (before, bytes));
}

#[test]
fn a_grain_that_was_moved_far_is_seen_by_its_new_neighbours_and_by_walls() {
    // Two at rest far from each other: the list knows no pair.
    let mut simulation = start(&in_space(&[grain([0.0; 3]), grain([0.5, 0.0, 0.0])]));
    steps(&mut simulation, 3);
    *simulation.states().position(1) = [0.0105, 0.0, 0.0];
    *simulation.states().velocity(1) = [-0.5, 0.0, 0.0];
    steps(&mut simulation, 10);
    let frame = simulation.frame();
    assert!(frame.velocities()[0][0] < -0.1, "{:?}", frame.velocities());
    // One that is made so fast that it would pass through the wall within a step.
    let scene = bin(1);
    let mut simulation = start(&scene);
    steps(&mut simulation, 2);
    let mut states = simulation.states();
    *states.position(0) = [0.03, 0.03, 0.1];
    *states.velocity(0) = [200.0, 0.0, 0.0];
    drop(states);
    steps(&mut simulation, 20);
    let [x, y, z] = simulation.frame().positions()[0];
    assert!([x, y].iter().all(|at| (0.0..0.06).contains(at)) && z > 0.0, "{:?}", [x, y, z]);
    assert_eq!(simulation.crossing(), None);
}

#[test]
fn a_wall_moved_by_the_caller_moves_as_one_of_the_scene() {
    let plane = Shape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    let vibrating = Motion::Vibrating { amplitude: [0.0, 0.0, 5e-4], frequency: 20.0, start: 0.0, stop: None };
    let scene = |motion: Motion| {
        let floor = Wall { motion, ..Wall::new("floor", "glass", plane.clone()) };
        let scene = Scene::builder().material("glass", Material::default()).domain([-1.0; 3], [1.0; 3]).wall(floor);
        scene.grain(grain([0.0, 0.0, 0.00502])).build().unwrap()
    };
    let mut of_scene = start(&scene(vibrating));
    let mut by_caller = start(&scene(Motion::Fixed));
    let height = |time: f64| 5e-4 * (2.0 * std::f64::consts::PI * 20.0 * time).sin();
    for step in 0..400 {
        let now = by_caller.time();
        let velocity = [0.0, 0.0, (height(now + STEP) - height(now)) / STEP];
        by_caller.move_wall(0, WallMotion::Translation { velocity }).unwrap();
        by_caller.step();
        of_scene.step();
        let [a, b] = [&of_scene, &by_caller].map(|one| one.frame().positions()[0][2]);
        assert!((a - b).abs() < 1e-9, "step {step}: {a} {b}");
        if step == 200 {
            let bytes = by_caller.checkpoint();
            let resumed = Simulation::resume(&stepped(&scene(Motion::Fixed)), &bytes).unwrap();
            assert_eq!((resumed.state_hash(), resumed.checkpoint()), (by_caller.state_hash(), bytes));
            assert_eq!(resumed.moved_by(0), by_caller.moved_by(0));
            by_caller = resumed;
        }
    }
    assert!((by_caller.moved_by(0).unwrap().0[2] - height(0.4)).abs() < 1e-12);
}

#[test]
fn a_drum_turned_by_the_caller_has_the_bits_of_the_scene() {
    let scene = reference_scene("drum");
    let shell = scene.wall.iter().position(|wall| matches!(wall.motion, Motion::Rotating { .. })).unwrap();
    let Motion::Rotating { rate, .. } = scene.wall[shell].motion else { unreachable!() };
    let [mut of_scene, mut by_caller] = [(); 2].map(|()| Simulation::new(&scene, 1).unwrap());
    for _ in 0..300 {
        for (wall, one) in scene.wall.iter().enumerate() {
            if matches!(one.motion, Motion::Rotating { .. }) {
                by_caller.move_wall(wall as u32, WallMotion::Rotation { rate, about: None }).unwrap();
            }
        }
        by_caller.step();
        of_scene.step();
    }
    assert_eq!(by_caller.state_hash(), of_scene.state_hash());
    // The other way round it carries grains to the other side.
    by_caller.move_wall(shell as u32, WallMotion::Rotation { rate: -rate, about: None }).unwrap();
    steps(&mut by_caller, 10);
    steps(&mut of_scene, 10);
    assert_ne!(by_caller.state_hash(), of_scene.state_hash());
}

#[test]
fn arrays_that_are_kept_in_place_stay_where_they_are() {
    // Grains that fly apart in a domain whose boxes follow them.
    let sites = (0..1331).map(|n| [n % 11, n / 11 % 11, n / 121].map(|at| 0.011 * at as f64));
    let grains: Vec<GrainEntry> = sites
        .map(|at| GrainEntry { velocity: at.map(|x| 60.0 * (x - 0.055)), ..grain(at.map(|x| x - 0.055)) })
        .collect();
    let space = Scene::builder().material("glass", Material::default()).gravity([0.0; 3]).domain([-3.0; 3], [3.0; 3]);
    let scene = grains.iter().fold(space, |scene, grain| scene.grain(grain.clone())).build().unwrap();
    let mut simulation = start(&scene);
    simulation.keep_arrays_in_place().unwrap();
    let places = |simulation: &mut Simulation| {
        let (spheres, bodies, ids) = simulation.arrays();
        (spheres.as_ptr() as usize, bodies.as_ptr() as usize, ids.as_ptr() as usize)
    };
    let before = places(&mut simulation);
    let boxes = |simulation: &Simulation| simulation.memory_bytes();
    let start = boxes(&simulation);
    for _ in 0..400 {
        simulation.step();
        assert_eq!(places(&mut simulation), before);
    }
    assert!(simulation.rebuilds() > 3 && boxes(&simulation) > start, "more boxes came");
    let mut undisturbed = Simulation::builder(&scene).time_step(STEP).build().unwrap();
    steps(&mut undisturbed, 400);
    assert_eq!(simulation.state_hash(), undisturbed.state_hash());
}

#[test]
fn a_frame_states_who_its_grains_are() {
    let scene = bin(20);
    let mut simulation = start(&scene);
    assert_eq!(simulation.snapshot().origins, []);
    let numbers =
        |simulation: &Simulation| simulation.snapshot().origins.iter().map(|origin| origin.number).collect::<Vec<_>>();
    simulation.remove(&[0, 7]).unwrap();
    simulation.step();
    let kept: Vec<u64> = (0..20).filter(|number| ![0, 7].contains(number)).collect();
    assert_eq!(numbers(&simulation), kept);
    // A number is never given twice, though the grain that had it is gone.
    simulation.insert(&scene, &[grain([0.03, 0.03, 0.25])]).unwrap();
    assert_eq!(numbers(&simulation), [&kept[..], &[20]].concat());
    simulation.remove(&[18]).unwrap();
    simulation.insert(&scene, &[grain([0.03, 0.03, 0.25])]).unwrap();
    let expected = [&kept[..], &[21]].concat();
    assert_eq!(numbers(&simulation), expected);
    let resumed = Simulation::resume(&stepped(&scene), &simulation.checkpoint()).unwrap();
    assert_eq!(numbers(&resumed), expected);
    assert_eq!(resumed.snapshot().origins, simulation.snapshot().origins);
}

/// Grains rain into a bin and are taken out of it again, so that contacts open and close from outside all the time.
#[test]
fn the_ledger_closes_while_grains_come_and_go() {
    let mut scene = bin(60);
    scene.material.values_mut().for_each(|one| one.youngs_modulus = 1e6);
    let mut simulation = start(&scene);
    simulation.open_ledger();
    for event in 0..30 {
        steps(&mut simulation, 7 + event % 5);
        match event % 3 {
            0 => {
                let at = |x: f64| [x, 0.01 + 0.02 * (event / 3 % 3) as f64, 0.28];
                simulation.insert(&scene, &[grain(at(0.01)), grain(at(0.03)), grain(at(0.05))]).unwrap();
            }
            1 => drop(simulation.remove(&[event as u32, 2 * event as u32]).unwrap()),
            _ => {
                // Onto the bed, a little inside another grain.
                let top =
                    simulation.grain_entries(&scene).into_iter().max_by(|a, b| a.position[2].total_cmp(&b.position[2]));
                let [x, y, z] = top.as_ref().unwrap().position;
                let on_top = grain([x, y, z + 0.99 * (top.unwrap().radius + 0.005)]);
                let _ = simulation.insert(&scene, &[on_top]);
            }
        }
        let balance = simulation.balance().unwrap();
        assert!(balance.closure.abs() < 1e-10 * balance.exchanged(), "event {event}: {balance:#?}");
        simulation.step();
        let balance = simulation.balance().unwrap();
        assert!(balance.closure.abs() < 1e-10 * balance.exchanged(), "a step after event {event}: {balance:#?}");
        assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-12), "event {event}: {balance:#?}");
    }
    let balance = simulation.balance().unwrap();
    assert!(balance.end.elastic > 0.0 && balance.outside > 0.0, "{balance:#?}");
}

/// Energy that contacts of an inserted grain store comes from outside, and so does that of contacts that touched without an impulse.
#[test]
fn an_inserted_grain_that_touches_stores_energy_from_outside() {
    let floor = Wall::new("floor", "glass", Shape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] });
    let soft = Material { youngs_modulus: 1e6, ..Material::default() };
    let scene = Scene::builder().material("glass", soft).domain([-1.0; 3], [1.0; 3]).wall(floor);
    let scene = (0..4).fold(scene, |scene, k| scene.grain(grain([0.02 * f64::from(k), 0.0, 0.005]))).build().unwrap();
    let mut simulation = Simulation::builder(&scene).time_step(5e-4).build().unwrap();
    simulation.open_ledger();
    simulation.step();
    let before = simulation.balance().unwrap();
    simulation.insert(&scene, &[grain([0.0, 0.0, 0.015 - 4e-5])]).unwrap();
    simulation.step();
    let after = simulation.balance().unwrap();
    assert!(after.closure.abs() < 1e-12 * after.exchanged(), "{after:#?}");
    assert!((after.first_touch - before.first_touch).abs() < 1e-3 * after.end.elastic, "{after:#?}");
    assert!(after.outside > mass() * 9.81 * 0.014, "{after:#?}");
}

#[test]
fn loads_are_taken_both_or_neither_and_add_up() {
    let mut simulation = start(&in_space(&[grain([0.0; 3])]));
    let (force, other) = ([1e-3, 0.0, 0.0], [0.0, 2e-3, 0.0]);
    // Refused for its torques: the forces do not act either.
    assert!(simulation.apply_loads(&[force], &[[f64::NAN, 0.0, 0.0]]).is_err());
    simulation.step();
    assert_eq!(simulation.frame().velocities()[0], [0.0; 3]);
    simulation.apply_loads(&[force], &[]).unwrap();
    simulation.add_loads(&[other], &[]).unwrap();
    // What is on top is replaced by what is put on top, and what is applied stays.
    simulation.add_loads(&[other], &[]).unwrap();
    simulation.step();
    let [x, y, z] = simulation.frame().velocities()[0];
    assert!((x - 1e-3 * STEP / mass()).abs() < 1e-15 && (y - 2e-3 * STEP / mass()).abs() < 1e-15 && z == 0.0);
    simulation.step();
    assert_eq!(simulation.frame().velocities()[0], [x, y, z], "they act in one step");
}

/// The exported problem begins with the velocities that the step begins with, to the bit.
#[test]
fn the_contact_problem_has_the_free_velocities_of_the_step() {
    let spread = (0..20).map(|k| {
        let at = f64::from(k);
        GrainEntry {
            velocity: [0.1 * at, -0.3, 0.07 * at],
            spin: [at, 2.0, -0.5 * at],
            ..grain([0.02 * at - 0.2, 0.0, 0.0])
        }
    });
    let mut scene = in_space(&spread.collect::<Vec<_>>());
    scene.gravity = [0.3, -0.1, -9.81];
    let mut simulation = start(&scene);
    let push = |scale: f64| (0..20).map(|k| [scale * f64::from(k), 0.3 * scale, -scale / 7.0]).collect::<Vec<_>>();
    for step in 0..20 {
        simulation.apply_loads(&push(1e-3), &push(1e-6)).unwrap();
        simulation.add_loads(&push(3e-4), &[]).unwrap();
        let problem = simulation.contact_problem();
        simulation.step();
        let particles = simulation.snapshot().particles;
        for (body, particle) in problem.bodies.iter().zip(&particles) {
            // Nothing touches: the step ends with its free velocities.
            assert_eq!(<[f64; 3]>::from(body.velocity), particle.velocity, "step {step}, grain {}", particle.id);
            let spin: [f64; 3] = body.spin.into();
            assert!(
                (0..3).all(|axis| (spin[axis] - particle.spin[axis]).abs() <= 1e-15 * spin[axis].abs()),
                "{spin:?}"
            );
        }
    }
}
