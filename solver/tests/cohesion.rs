//! Cohesion against closed forms on one grain and on two.

use crate::common::bits::{hash_after, reference_scene, same_bits_everywhere, start};
use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, DENSITY, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::effects::cohesion::{Cohesion, Pull};
use makadam::scene::Scene;
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
const G: f64 = 9.81;

fn cohesive(setup: &Setup, cohesion: Cohesion) -> Scene {
    let mut scene = setup.scene();
    scene.material.values_mut().for_each(|material| material.cohesion = Some(cohesion));
    scene
}

#[test]
fn a_grain_hangs_from_a_ceiling_up_to_its_pull_off_force() {
    for solver in [CONVERGED_RIGID, CONVERGED_HERTZ] {
        for (share, hangs) in [(1.01, true), (0.99, false)] {
            let setup = Setup {
                // Down is away from the plane, which thereby is a ceiling.
                gravity: [0.0, 0.0, G],
                solver: solver.into(),
                body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [0.0; 3])),
                ..Setup::default()
            };
            let cohesion = Cohesion::Constant { force: share * MASS * G, range: 1e-5 };
            let mut simulation = start(&cohesive(&setup, cohesion));
            run_until(&mut simulation, 0.1);
            let height = simulation.snapshot().particles[0].position[2] - RADIUS;
            assert_eq!(height < 1e-5, hangs, "{solver}: pull {share} of the weight, {height} m away");
        }
    }
}

#[test]
fn a_contact_tells_its_net_force() {
    let pull = 3.0 * MASS * G;
    let setup = Setup {
        gravity: [0.0, 0.0, G],
        body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [0.0; 3])),
        ..Setup::default()
    };
    let mut simulation = start(&cohesive(&setup, Cohesion::Constant { force: pull, range: 0.0 }));
    run_until(&mut simulation, 0.01);
    let contacts = simulation.snapshot().contacts;
    assert_relative_eq!(contacts[0].normal_force, -MASS * G, max_relative = 1e-6);
}

#[test]
fn friction_bears_on_the_pull_as_on_a_load() {
    // Without gravity along the normal: the pull alone lets friction hold a force along the plane of mu F.
    let friction = 0.5;
    for (share, slides) in [(0.99, false), (1.05, true)] {
        let pull = 2.0 * MASS * G;
        let along = share * friction * pull / MASS;
        let setup = Setup {
            gravity: [along, 0.0, 0.0],
            wall_friction: friction,
            body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [0.0; 3])),
            ..Setup::default()
        };
        let mut scene = cohesive(&setup, Cohesion::Constant { force: pull, range: 0.0 });
        // So that it cannot roll.
        scene.material.get_mut("wall").unwrap().rolling_friction = 10.0;
        let mut simulation = start(&scene);
        run_until(&mut simulation, 0.05);
        let velocity = simulation.snapshot().particles[0].velocity[0];
        let expected = if slides { (along - friction * pull / MASS) * simulation.time() } else { 0.0 };
        assert_relative_eq!(velocity, expected, max_relative = 1e-6, epsilon = 1e-9);
    }
}

#[test]
fn grains_within_the_range_meet_and_those_beyond_do_not() {
    let (force, range) = (1e-3, 2e-4);
    for (gap, meets) in [(0.9 * range, true), (1.1 * range, false)] {
        let setup = Setup {
            gravity: [0.0; 3],
            body: format!(
                "{}{}",
                grain(RADIUS, [0.0, 0.0, 1.0], [0.0; 3]),
                grain(RADIUS, [2.0 * RADIUS + gap, 0.0, 1.0], [0.0; 3])
            ),
            ..Setup::default()
        };
        let mut simulation = start(&cohesive(&setup, Cohesion::Constant { force, range }));
        // Half of the time to meet: each has gone a quarter of its half of the gap.
        let meet = (gap * MASS / force).sqrt();
        run_until(&mut simulation, 0.5 * meet);
        let grains = simulation.snapshot().particles;
        let speed = if meets { force / MASS * simulation.time() } else { 0.0 };
        assert_relative_eq!(grains[0].velocity[0], speed, max_relative = 1e-9);
        assert_relative_eq!(grains[1].velocity[0], -speed, max_relative = 1e-9);
        run_until(&mut simulation, 3.0 * meet);
        let grains = simulation.snapshot().particles;
        let left = grains[1].position[0] - grains[0].position[0] - 2.0 * RADIUS;
        assert_eq!(left < 1e-6, meets, "gap {left}");
    }
}

#[test]
fn the_work_of_adhesion_gives_the_pull_and_range_of_johnson_kendall_and_roberts() {
    let (work, radius, modulus) = (0.05, 0.002, 1e7);
    let Pull { force, range } = Cohesion::SurfaceEnergy { work, range: None }.pull(radius, modulus);
    assert_relative_eq!(force, 1.5 * PI * work * radius, max_relative = 1e-14);
    // The equation of their equilibrium at the torn neck: delta = a^2/R - sqrt(2 pi w a/E*), smallest over a.
    let separation = |neck: f64| (2.0 * PI * work * neck / modulus).sqrt() - neck * neck / radius;
    let largest = (1..100_000).map(|step| separation(1e-9 * f64::from(step) * 10.0)).fold(0.0, f64::max);
    assert_relative_eq!(range, largest, max_relative = 1e-4);
    // A range of its own changes no pull; none at all is touch.
    let short = Cohesion::SurfaceEnergy { work, range: Some(0.0) }.pull(radius, modulus);
    assert_eq!(short, Pull { force, range: 1e-6 * radius });
    assert_eq!(Cohesion::SurfaceEnergy { work, range: Some(3e-6) }.pull(radius, modulus).range, 3e-6);
}

#[test]
fn energy_and_momentum_are_accounted_for() {
    // Two smooth grains drawn together stick: what their pull gave is lost in the impact, or stored.
    let cohesion = Cohesion::Constant { force: 1e-3, range: 2e-4 };
    let body = format!(
        "{}{}",
        grain(RADIUS, [0.0, 0.0, 1.0], [0.0; 3]),
        grain(RADIUS, [2.0 * RADIUS + 1e-4, 0.0, 1.0], [0.0; 3])
    );
    let setup = Setup { gravity: [0.0; 3], restitution: 0.0, body, ..Setup::default() };
    let mut simulation = start(&cohesive(&setup, cohesion));
    // The ledger opens once the list knows the two.
    simulation.step();
    simulation.open_ledger();
    run_until(&mut simulation, 0.1);
    let balance = simulation.balance().unwrap();
    assert_relative_eq!(balance.end.cohesive, -1e-3 * 2e-4, max_relative = 1e-3);
    let released = balance.start.cohesive - balance.end.cohesive;
    assert_relative_eq!(balance.restitution + balance.stabilisation, released, max_relative = 2e-2);
    assert!(balance.closure.abs() < 2e-2 * released, "{balance:?}");
    assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-15), "{balance:?}");
}

#[test]
fn a_cohesive_bed_has_the_same_bits_everywhere() {
    let mut scene = reference_scene("packing");
    scene.material.values_mut().for_each(|one| one.cohesion = Some(Cohesion::SurfaceEnergy { work: 0.5, range: None }));
    let without = hash_after(&reference_scene("packing"), 500, |_| ());
    assert_ne!(same_bits_everywhere(&scene, 500), without, "cohesion changes the result");
}
