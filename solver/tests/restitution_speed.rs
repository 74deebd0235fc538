//! Restitution that falls with the speed of impact against closed forms on one grain and on two, and that its absence leaves
//! no trace.

use crate::common::bits::{hash_after, leaves_no_trace, reference_scene, same_bits_everywhere, start};
use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::Simulation;
use makadam::scene::Scene;

const RADIUS: f64 = 0.005;
const G: f64 = 9.81;
const RESTITUTION: f64 = 0.8;
/// Speed up to which restitution does not fall, m/s.
const SPEED: f64 = 1.0;

/// The restitution that it should be.
fn expected(speed: f64) -> f64 {
    RESTITUTION * if speed > SPEED { (SPEED / speed).powf(0.25) } else { 1.0 }
}

fn falling(setup: &Setup) -> Scene {
    let mut scene =
        Setup { restitution: RESTITUTION, body: setup.body.clone(), solver: setup.solver.clone(), ..*setup }.scene();
    scene.material.values_mut().for_each(|material| material.restitution_speed = Some(SPEED));
    scene
}

/// Speed after a grain has hit the floor at a speed, m/s.
fn after_the_floor(solver: &str, speed: f64) -> f64 {
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, 0.006], [0.0, 0.0, -speed]));
    let setup = Setup { gravity: [0.0; 3], solver: solver.into(), body, ..Setup::default() };
    let mut simulation = start(&falling(&setup));
    run_until(&mut simulation, 0.02);
    simulation.snapshot().particles[0].velocity[2]
}

#[test]
fn a_rigid_impact_leaves_with_the_fourth_root_of_its_speed() {
    // The last passes the floor within a step.
    for speed in [0.1, 0.5, 1.0, 1.5, 16.0, 81.0] {
        assert_relative_eq!(after_the_floor(CONVERGED_RIGID, speed), expected(speed) * speed, max_relative = 1e-9);
    }
    // 16 times the speed halves it.
    assert_relative_eq!(expected(16.0), 0.5 * RESTITUTION, max_relative = 1e-12);
}

#[test]
fn an_impact_that_a_compliant_step_does_not_resolve_does_the_same() {
    let solver = CONVERGED_HERTZ.replace("1e-4", "2e-3");
    for speed in [1.5, 4.0] {
        assert_relative_eq!(after_the_floor(&solver, speed), expected(speed) * speed, max_relative = 1e-9);
    }
}

#[test]
fn where_the_step_resolves_impacts_it_is_refused() {
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, 0.006], [0.0, 0.0, -2.0]));
    let setup = Setup { solver: CONVERGED_HERTZ.replace("1e-4", "1e-5"), body, ..Setup::default() };
    let message = Simulation::new(&falling(&setup), 1).unwrap_err().to_string();
    assert!(message.contains("restitution_speed") && message.contains("rigid"), "{message}");
    let rigid = Setup { solver: CONVERGED_RIGID.into(), ..setup };
    assert!(Simulation::new(&falling(&rigid), 1).is_ok());
}

#[test]
fn two_grains_go_by_the_speed_at_which_they_close_along_the_normal() {
    for speed in [0.4, 4.0] {
        let body = format!(
            "{}{}",
            grain(RADIUS, [-RADIUS * (1.0 - 1e-9), 0.0, 1.0], [0.75 * speed, 0.0, 3.0]),
            grain(RADIUS, [RADIUS * (1.0 - 1e-9), 0.0, 1.0], [-0.25 * speed, 0.0, 3.0])
        );
        let setup = Setup { gravity: [0.0; 3], body, ..Setup::default() };
        let mut simulation = start(&falling(&setup));
        simulation.step();
        let grains = simulation.snapshot().particles;
        let leaves = grains[1].velocity[0] - grains[0].velocity[0];
        assert_relative_eq!(leaves, expected(speed) * speed, max_relative = 1e-9);
    }
}

#[test]
fn a_bouncing_ball_rises_to_the_heights_of_its_impacts() {
    // Impacts at 3.1 m/s and more slowly each time, the last below the speed.
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, 0.5 + RADIUS], [0.0; 3]));
    let setup = Setup { solver: CONVERGED_RIGID.replace("1e-4", "5e-6"), body, ..Setup::default() };
    let mut simulation = start(&falling(&setup));
    let mut height = 0.5_f64;
    let mut slow = 0;
    for _ in 0..5 {
        let speed = (2.0 * G * height).sqrt();
        slow += u32::from(speed < SPEED);
        height *= expected(speed) * expected(speed);
        // Down to the floor, and up again as far as it goes.
        while simulation.snapshot().particles[0].velocity[2] <= 0.0 {
            simulation.step();
        }
        while simulation.snapshot().particles[0].velocity[2] > 0.0 {
            simulation.step();
        }
        let top = simulation.snapshot().particles[0].position[2] - RADIUS;
        assert_relative_eq!(top, height, max_relative = 2e-3);
    }
    assert!((1..5).contains(&slow), "{slow} impacts below the speed");
}

/// A reference scene none of whose impacts is resolved.
fn rigid_scene(name: &str) -> Scene {
    let mut scene = reference_scene(name);
    scene.solver.normal_law = makadam::scene::NormalLaw::Rigid;
    scene
}

#[test]
fn a_speed_that_no_contact_has_leaves_no_trace() {
    for name in ["drum", "packing"] {
        let plain = rigid_scene(name);
        leaves_no_trace(&plain, 300, |bystander| bystander.restitution_speed = Some(1e-3));
        // Nothing is as fast as that.
        let mut scene = plain.clone();
        scene.material.values_mut().for_each(|material| material.restitution_speed = Some(1e6));
        assert_eq!(hash_after(&scene, 300, |_| ()), hash_after(&plain, 300, |_| ()), "{name}: another speed");
        assert!(!toml::to_string(&plain).unwrap().contains("restitution_speed"), "{name}");
    }
}

#[test]
fn a_bed_has_the_same_bits_everywhere() {
    let mut scene = rigid_scene("drum");
    scene.material.values_mut().for_each(|material| material.restitution_speed = Some(0.06));
    let without = hash_after(&rigid_scene("drum"), 400, |_| ());
    assert_ne!(same_bits_everywhere(&scene, 400), without, "the effect changes the result");
}

#[test]
fn a_pair_rule_decides_and_wrong_speeds_are_refused() {
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, 0.006], [0.0, 0.0, -16.0]));
    let mut text = toml::to_string(&Setup { gravity: [0.0; 3], body, ..Setup::default() }.scene()).unwrap();
    text = text.replace("pair = []\n", "");
    let rule = |speed: &str| format!("{text}\n[[pair]]\nbetween = ['wall', 'grain']\nrestitution_speed = {speed}\n");
    let scene = Scene::parse(&rule("1.0")).unwrap();
    let mut simulation = start(&scene);
    run_until(&mut simulation, 0.01);
    assert_relative_eq!(simulation.snapshot().particles[0].velocity[2], 0.5 * 0.5 * 16.0, max_relative = 1e-9);
    for wrong in ["0.0", "-1.0", "nan"] {
        let message = Scene::parse(&rule(wrong)).unwrap_err().to_string();
        assert!(message.contains("pair[0].restitution_speed"), "{message}");
    }
}
