//! Walls that a force or a torque drives, against closed forms on one grain and the direct reference on many.

use crate::common::bits::same_bits_everywhere;
use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, DENSITY, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::Simulation;
use makadam::scene::Scene;
use makadam::snapshot::{Particle, Partner, Snapshot};
use nalgebra::Vector3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
const G: f64 = 9.81;
const STEP: f64 = 1e-4;

/// A plane with a motion, seen from below if `down`.
fn plane(name: &str, height: f64, down: bool, motion: &str) -> String {
    let normal = if down { -1 } else { 1 };
    format!(
        "[[wall]]\nname = '{name}'\nmaterial = 'wall'\nshape = {{ kind = 'plane', point = [0, 0, {height:?}], normal = [0, 0, {normal}] }}\n\
         motion = {{ {motion} }}\n"
    )
}

/// A lid at a height, pushed along z by a force (N), of a mass (kg).
fn lid(height: f64, force: f64, mass: f64, more: &str) -> String {
    let motion = format!("kind = 'force-driven', axis = [0, 0, 2], force = {force:?}, mass = {mass:?}{more}");
    plane("lid", height, true, &motion)
}

/// A table at z = 0 that turns about the vertical through the origin.
fn turntable(torque: f64, moment_of_inertia: f64) -> String {
    let motion = format!(
        "kind = 'torque-driven', point = [0, 0, 0], axis = [0, 0, 1], torque = {torque:?}, moment_of_inertia = {moment_of_inertia:?}"
    );
    plane("table", 0.0, false, &motion)
}

/// Normal force between the grains and a wall, N.
fn force_on(frame: &Snapshot, wall: u32) -> f64 {
    let on = frame.contacts.iter().filter(|contact| contact.second == Partner::Wall(wall));
    on.map(|contact| contact.normal_force).sum()
}

#[test]
fn a_lid_that_touches_nothing_moves_as_force_and_weight_have_it() {
    let (force, mass) = (3.0, 0.5);
    let mut simulation = Setup { body: lid(1.0, force, mass, ", start = 0.01"), ..Setup::default() }.start();
    run_until(&mut simulation, 0.01);
    assert_eq!(simulation.snapshot().driven_walls[0].displacement, 0.0, "held until its start");
    run_until(&mut simulation, 0.11);
    let (wall, steps) = (simulation.snapshot().driven_walls[0], 1000.0);
    let acceleration = force / mass - G;
    assert_relative_eq!(wall.rate, acceleration * steps * STEP, max_relative = 1e-12);
    // Semi-implicit Euler sums the velocities at the ends of the steps.
    let way = acceleration * STEP * STEP * steps * (steps + 1.0) / 2.0;
    assert_relative_eq!(wall.displacement, way, max_relative = 1e-12);
}

#[test]
fn a_grain_under_a_lid_bears_weight_and_force_and_sinks_in_as_far_as_they_press() {
    let (force, mass, stiffness) = (-0.2, 0.03, 1e5);
    let linear = CONVERGED_RIGID.replace("kind = 'rigid'", &format!("kind = 'linear', stiffness = {stiffness:e}"));
    for solver in [CONVERGED_RIGID.to_string(), linear] {
        let compliant = solver.contains("linear");
        let body = FLOOR.to_string()
            + &lid(2.0 * RADIUS, force, mass, "")
            + &grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [0.0; 3]);
        let mut simulation = Setup { solver, body, restitution: 0.0, ..Setup::default() }.start();
        run_until(&mut simulation, 1.0);
        let frame = simulation.snapshot();
        let pressed = mass * G - force;
        assert_relative_eq!(force_on(&frame, 1), pressed, max_relative = 1e-6);
        assert_relative_eq!(force_on(&frame, 0), pressed + MASS * G, max_relative = 1e-6);
        if compliant {
            let sunk = (2.0 * pressed + MASS * G) / stiffness;
            assert_relative_eq!(frame.driven_walls[0].displacement, -sunk, max_relative = 1e-3);
        }
    }
}

#[test]
fn a_grain_and_a_free_wall_collide_as_two_bodies() {
    for (mass, restitution) in [(MASS, 1.0), (0.1 * MASS, 0.5), (20.0 * MASS, 0.8)] {
        let speed = 2.0;
        let body = lid(0.1, 0.0, mass, "") + &grain(RADIUS, [0.0, 0.0, 0.05], [0.0, 0.0, speed]);
        let mut simulation = Setup { gravity: [0.0; 3], restitution, body, ..Setup::default() }.start();
        run_until(&mut simulation, 0.04);
        let frame = simulation.snapshot();
        let total = MASS + mass;
        let grain = speed * (MASS - restitution * mass) / total;
        assert_relative_eq!(frame.particles[0].velocity[2], grain, epsilon = 1e-12);
        assert_relative_eq!(frame.driven_walls[0].rate, speed * MASS * (1.0 + restitution) / total, epsilon = 1e-12);
    }
}

#[test]
fn a_torque_turns_a_table_and_friction_hands_on_angular_momentum() {
    let (torque, moment) = (1e-3, 2e-5);
    let mut alone = Setup { body: turntable(torque, moment), ..Setup::default() }.start();
    run_until(&mut alone, 0.1);
    assert_relative_eq!(alone.snapshot().driven_walls[0].rate, torque * 0.1 / moment, max_relative = 1e-12);
    // A grain that lands, slides, rolls and hops on a free table.
    let body = turntable(0.0, moment) + &grain(RADIUS, [0.05, 0.0, 0.02], [0.2, 0.9, 0.0]);
    // Rounding keeps many of these solves above 1e-13.
    let solver = CONVERGED_RIGID.replace("1e-13", "1e-10");
    let mut simulation = Setup { body, solver, ..Setup::default() }.start();
    let angular_momentum = |frame: &Snapshot| {
        let grain = frame.particles[0];
        let orbit = grain.position[0] * grain.velocity[1] - grain.position[1] * grain.velocity[0];
        MASS * (orbit + 0.4 * RADIUS * RADIUS * grain.spin[2]) + moment * frame.driven_walls[0].rate
    };
    let before = angular_momentum(&simulation.snapshot());
    run_until(&mut simulation, 0.5);
    let frame = simulation.snapshot();
    assert!(frame.driven_walls[0].rate.abs() > 0.1, "{:?}", frame.driven_walls);
    // The lever is that of the step's start, the momentum's place that of its end.
    assert_relative_eq!(angular_momentum(&frame), before, max_relative = 1e-3);
}

#[test]
fn a_grain_with_twisting_resistance_brakes_the_table_that_turns_under_it() {
    let body = turntable(1e-5, 1e-7) + &grain(RADIUS, [0.0, 0.0, RADIUS], [0.0; 3]);
    let mut scene = Setup { body, ..Setup::default() }.scene();
    scene.material.values_mut().for_each(|material| material.twisting_friction = 100.0);
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    run_until(&mut simulation, 0.05);
    let frame = simulation.snapshot();
    let rate = 1e-5 * 0.05 / (1e-7 + 0.4 * MASS * RADIUS * RADIUS);
    assert_relative_eq!(frame.driven_walls[0].rate, rate, max_relative = 1e-6);
    assert_relative_eq!(frame.particles[0].spin[2], rate, max_relative = 1e-6);
}

/// Grains in a box under a lid of so many grains' mass that is pressed down, the floor of which is driven sideways.
fn pressed(masses: f64, solver: &str) -> Scene {
    let floor = format!("kind = 'force-driven', axis = [1, 0, 0], force = 0.02, mass = {:?}", 5.0 * MASS);
    let walls = format!(
        "[[wall]]\nname = 'sides'\nmaterial = 'wall'\nshape = {{ kind = 'box', min = [0, 0, -1], max = [0.05, 0.05, 1], open = ['-z', '+z'] }}\n{}{}",
        plane("floor", 0.0, false, &floor),
        lid(0.1, -1.0, masses * MASS, "")
    );
    let grains = "[[population]]\ncount = 100\nmaterial = 'grain'\n\
                  radius = { kind = 'uniform', mean = 0.004, spread = 0.2 }\n\
                  region = { kind = 'box', min = [0, 0, 0], max = [0.05, 0.05, 0.1] }\n";
    Setup { solver: solver.into(), body: walls + grains, ..Setup::default() }.scene()
}

#[test]
fn a_pressed_packing_has_the_direct_solution_on_its_way_to_rest() {
    for (masses, friction) in [(10.0, 0.0), (0.5, 0.2), (10.0, 0.5)] {
        let mut scene = pressed(masses, CONVERGED_HERTZ);
        scene.material.values_mut().for_each(|material| material.friction = friction);
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        for look in 1..=4 {
            run_until(&mut simulation, 0.04 * f64::from(look));
            let direct = simulation.direct_solution().unwrap();
            simulation.step();
            let frame = simulation.snapshot();
            for (grain, velocity) in frame.particles.iter().zip(&direct.velocities) {
                for (one, other) in grain.velocity.iter().zip(velocity) {
                    assert_relative_eq!(one, other, epsilon = 1e-8);
                }
            }
            assert_eq!(direct.wall_rates.len(), 2);
            for (wall, rate) in frame.driven_walls.iter().zip(&direct.wall_rates) {
                assert_relative_eq!(wall.rate, *rate, epsilon = 1e-8);
            }
        }
    }
}

const FEW_SWEEPS: &str = "step = 1e-4\nstop = { kind = 'sweeps', sweeps = 12 }";

#[test]
fn a_pressed_packing_has_the_same_bits_everywhere() {
    same_bits_everywhere(&pressed(10.0, FEW_SWEEPS), 600);
}

#[test]
fn a_drum_that_a_torque_turns_has_the_same_bits_everywhere_and_hangs_askew() {
    // Half a drum of grains and a torque too small to turn it over: it hangs where their weight balances it.
    let (radius, length, torque) = (0.03, 0.03, 0.002);
    let body = format!(
        "[[wall]]\nname = 'shell'\nmaterial = 'wall'\n\
         shape = {{ kind = 'cylinder', base = [0, 0, 0], axis = [0, 1, 0], radius = {radius}, length = {length} }}\n\
         motion = {{ kind = 'torque-driven', point = [0, 0, 0], axis = [0, 1, 0], torque = {torque}, moment_of_inertia = 1e-4, start = 0.2 }}\n\
         [[wall]]\nname = 'ends'\nmaterial = 'ends'\n\
         shape = {{ kind = 'box', min = [-1, 0, -1], max = [1, {length}, 1], open = ['-x', '+x', '-z', '+z'] }}\n\
         [material.ends]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.0\nrestitution = 0.5\n\
         [[pair]]\nbetween = ['grain', 'ends']\nfriction = 0.0\n\
         [[population]]\ncount = 60\nmaterial = 'grain'\nradius = {{ kind = 'fixed', value = 0.004 }}\n\
         region = {{ kind = 'cylinder', base = [0, 0, 0], axis = [0, 1, 0], radius = {radius}, length = {length} }}\n"
    );
    let setup = Setup { solver: FEW_SWEEPS.into(), wall_friction: 0.9, body, ..Setup::default() };
    same_bits_everywhere(&setup.scene(), 1500);
    let mut simulation = setup.start();
    // Grains that stick to the shell swing with it like a pendulum; in the mean their weight balances the torque.
    run_until(&mut simulation, 2.0);
    let (mut sum, mut steps) = (0.0, 0.0);
    while simulation.time() < 8.0 {
        simulation.step();
        let torque = |grain: &Particle| DENSITY * 4.0 / 3.0 * PI * grain.radius.powi(3) * -G * grain.position[0];
        sum += simulation.snapshot().particles.iter().map(torque).sum::<f64>();
        steps += 1.0;
    }
    let wall = simulation.snapshot().driven_walls[0];
    assert!(wall.displacement > 0.1 && wall.displacement < PI, "{wall:?}");
    assert_relative_eq!(sum / steps, torque, max_relative = 0.02);
}

#[test]
fn a_run_that_starts_from_a_state_finds_its_driven_walls_there() {
    let scene = pressed(10.0, FEW_SWEEPS);
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    run_until(&mut simulation, 0.3);
    let mut started = Simulation::start_from(&scene, &simulation.checkpoint()).unwrap();
    let (last, first) = (simulation.snapshot(), started.snapshot());
    assert_eq!((first.time, &first.driven_walls), (0.0, &last.driven_walls));
    simulation.step();
    started.step();
    let [gone_on, started] = [simulation, started].map(|simulation| simulation.snapshot().driven_walls[1].rate);
    assert_relative_eq!(gone_on, started, epsilon = 1e-3);
    // Other walls: the grains alone.
    let mut other = scene.clone();
    other.wall[1].motion = Default::default();
    let other = Simulation::start_from(&other, &Simulation::new(&scene, 1).unwrap().checkpoint()).unwrap();
    assert_eq!(other.snapshot().driven_walls[0].displacement, 0.0);
    let refused = Simulation::resume(&scene, &other.checkpoint()).unwrap_err().to_string();
    assert!(refused.contains("driven walls"), "{refused}");
}

#[test]
fn a_lid_presses_with_its_weight_and_force_whatever_its_mass() {
    for masses in [0.01, 1.0, 100.0] {
        let mut simulation = Simulation::new(&pressed(masses, FEW_SWEEPS), 1).unwrap();
        run_until(&mut simulation, 0.6);
        let frame = simulation.snapshot();
        assert!(frame.driven_walls[1].rate.abs() < 1e-3, "{masses} masses: {:?}", frame.driven_walls);
        assert_relative_eq!(force_on(&frame, 2), 1.0 + masses * MASS * G, max_relative = 1e-3);
    }
}

#[test]
fn the_ledger_closes_with_the_work_of_driven_walls() {
    let mut simulation = Simulation::new(&pressed(10.0, CONVERGED_RIGID), 1).unwrap();
    simulation.step();
    simulation.open_ledger();
    run_until(&mut simulation, 0.1);
    let balance = simulation.balance().unwrap();
    assert!(balance.walls.abs() > 1e-3 * balance.friction, "{balance:?}");
    assert!(balance.closure.abs() < 1e-2 * (balance.walls.abs() + balance.friction), "{balance:?}");
    assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-9), "{balance:?}");
}

#[test]
fn what_cannot_be_driven_is_refused_with_a_remedy() {
    let setup = Setup { body: lid(1.0, 1.0, 1.0, "") + &turntable(1.0, 1.0), ..Setup::default() };
    let text = toml::to_string(&setup.scene()).unwrap();
    for (sound, wrong, word) in [
        ("mass = 1.0", "mass = 0.0", "mass"),
        ("force = 1.0", "force = nan", "force"),
        ("axis = [0.0, 0.0, 2.0]", "axis = [0.0, 0.0, 0.0]", "axis"),
        ("moment_of_inertia = 1.0", "moment_of_inertia = -1.0", "moment_of_inertia"),
        ("torque = 1.0", "torque = 1.0\nforce = 1.0", "force"),
        ("start = 0.0", "start = -1.0", "start"),
    ] {
        assert!(text.contains(sound), "{text}");
        let message = crate::common::parse(&text.replacen(sound, wrong, 1)).unwrap_err();
        assert!(message.contains(word) && message.contains("test.toml:"), "{message}");
    }
    for (key, line) in
        [("precision", "precision = 'single'"), ("method", "method = { kind = 'jacobi', damping = 0.5 }")]
    {
        let wrong = text.replace("[solver]\n", &format!("[solver]\n{line}\n"));
        let message = crate::common::parse(&wrong).unwrap_err();
        assert!(message.contains(key) && message.contains("lid"), "{message}");
    }
}

/// A number between two others, even on a logarithmic scale.
fn log_uniform(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

fn components() -> impl Strategy<Value = Vector3<f64>> {
    [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64].prop_map(Vector3::from)
}

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    components().prop_filter_map("a direction", |vector| vector.try_normalize(0.1))
}

/// Kinetic energy of driven walls, J, and momentum of grains and walls along an axis, kg m/s.
fn energy_and_momentum(frame: &Snapshot, inertias: [f64; 2], axis: &Vector3<f64>) -> (f64, f64) {
    let of_grain =
        |grain: &Particle| DENSITY * 4.0 / 3.0 * PI * grain.radius.powi(3) * Vector3::from(grain.velocity).dot(axis);
    let grains: f64 = frame.particles.iter().map(of_grain).sum();
    let walls = frame.driven_walls.iter().zip(inertias);
    walls.fold((0.0, grains), |(energy, momentum), (wall, inertia)| {
        (energy + 0.5 * inertia * wall.rate * wall.rate, momentum + inertia * wall.rate)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::with_cases(64) })]

    #[test]
    fn free_walls_have_the_energy_and_momentum_that_grains_gave_them(
        normal in direction(), axis in direction(), point in components(), turns in any::<bool>(),
        masses in [log_uniform(0.01, 100.0), log_uniform(0.01, 100.0)], friction in 0.0..1.0, restitution in 0.0..1.0,
        velocities in prop::collection::vec(components(), 1..6),
    ) {
        // A row of grains between two walls that only its impulses move, each along or about its axis.
        let inertias = masses.map(|mass| mass * MASS * if turns { 1e-2_f64.powi(2) } else { 1.0 });
        let motion = |inertia: f64| match turns {
            true => format!(
                "kind = 'torque-driven', point = {:?}, axis = {:?}, torque = 0.0, moment_of_inertia = {inertia:?}",
                (point * 0.02).as_slice(), axis.as_slice()
            ),
            false => format!("kind = 'force-driven', axis = {:?}, force = 0.0, mass = {inertia:?}", axis.as_slice()),
        };
        let length = 2.002 * RADIUS * velocities.len() as f64;
        let wall = |number: usize, along: f64, inward: f64| format!(
            "[[wall]]\nname = 'wall {number}'\nmaterial = 'wall'\nshape = {{ kind = 'plane', point = {:?}, normal = {:?} }}\nmotion = {{ {} }}\n",
            (normal * along).as_slice(), (normal * inward).as_slice(), motion(inertias[number])
        );
        let grains = (0..).zip(&velocities).map(|(number, velocity)| {
            let along = 2.002 * RADIUS * (f64::from(number) + 0.5);
            grain(RADIUS, (normal * along).into(), (*velocity).into())
        });
        let body = wall(0, 0.0, 1.0) + &wall(1, length, -1.0) + &grains.collect::<String>();
        let setup = Setup { gravity: [0.0; 3], friction, wall_friction: friction, restitution, body, ..Setup::default() };
        let mut simulation = setup.start();
        let (_, momentum) = energy_and_momentum(&simulation.snapshot(), inertias, &axis);
        simulation.open_ledger();
        for _ in 0..200 {
            simulation.step();
            let (of_walls, present) = energy_and_momentum(&simulation.snapshot(), inertias, &axis);
            let balance = simulation.balance().unwrap();
            let scale = balance.start.total();
            // What walls have, grains gave.
            prop_assert!((of_walls + balance.walls).abs() < 1e-9 * scale, "walls {of_walls} J, {balance:?}");
            prop_assert!(balance.closure.abs() < 1e-9 * scale, "{balance:?}");
            if !turns {
                prop_assert!((present - momentum).abs() < 1e-9 * (scale * MASS).sqrt(), "{momentum}, then {present}");
            }
        }
    }
}
