//! Slipping contacts against their closed forms on one grain and on two: those of LAMMPS's verification of granular styles (2026),
//! for a solid sphere with I = 2/5 m r^2.

use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::Simulation;
use makadam::snapshot::Particle;

const RADIUS: f64 = 0.005;
const G: f64 = 9.81;

fn first(simulation: &Simulation) -> Particle {
    simulation.snapshot().particles[0]
}

/// A grain that touches the floor, with a velocity and a spin.
fn on_the_floor(friction: f64, velocity: [f64; 3], spin: [f64; 3]) -> Setup {
    let grain = grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], velocity);
    Setup { friction, wall_friction: friction, body: format!("{FLOOR}{grain}spin = {spin:?}\n"), ..Setup::default() }
}

#[test]
fn a_ball_slips_until_it_rolls_and_then_keeps_its_speed() {
    let friction = 0.3;
    // Sliding without spin, with topspin, and with a backspin that brings it back.
    for (speed, surface) in [(1.0, 0.0), (0.2, 1.0), (0.5, -2.0)] {
        let mut ball = on_the_floor(friction, [speed, 0.0, 0.0], [0.0, surface / RADIUS, 0.0]).start();
        // Friction mu m g ends slip v - r w, which it changes by 7/2 mu g a second.
        let slip: f64 = speed - surface;
        let ends = slip.abs() / (3.5 * friction * G);
        for share in [0.2, 0.5, 0.9] {
            run_until(&mut ball, share * ends);
            let change = friction * G * ball.time() * slip.signum();
            let found = first(&ball);
            assert_relative_eq!(found.velocity[0], speed - change, max_relative = 1e-6, epsilon = 1e-9);
            assert_relative_eq!(found.spin[1] * RADIUS, surface + 2.5 * change, max_relative = 1e-6, epsilon = 1e-9);
        }
        for share in [1.1, 2.0] {
            run_until(&mut ball, share * ends);
            let found = first(&ball);
            // The angular momentum about the contact is kept.
            let rolls = (5.0 * speed + 2.0 * surface) / 7.0;
            assert_relative_eq!(found.velocity[0], rolls, max_relative = 1e-6, epsilon = 1e-9);
            assert_relative_eq!(found.spin[1] * RADIUS, rolls, max_relative = 1e-6, epsilon = 1e-9);
        }
    }
}

#[test]
fn a_ball_that_spins_and_falls_takes_two_sevenths_of_its_surface_speed_or_what_friction_gives() {
    let (fall, restitution, friction) = (1.0, 0.6, 0.2);
    let most = friction * (1.0 + restitution) * fall;
    for surface in [0.1, 0.5, 1.0, 1.2, 3.0, -2.0] {
        let spin = [0.0, surface / RADIUS, 7.0];
        let setup = on_the_floor(friction, [0.0, 0.0, -fall], spin);
        let mut ball = Setup { gravity: [0.0; 3], restitution, ..setup }.start();
        run_until(&mut ball, 3e-4);
        let found = first(&ball);
        let gained = (2.0 / 7.0 * surface).clamp(-most, most);
        assert_relative_eq!(found.velocity[2], restitution * fall, max_relative = 1e-6);
        assert_relative_eq!(found.velocity[0], gained, max_relative = 1e-6);
        assert_relative_eq!(found.spin[1] * RADIUS, surface - 2.5 * gained, max_relative = 1e-6);
        // A contact is a point.
        assert_relative_eq!(found.spin[2], 7.0, max_relative = 1e-14);
        assert_eq!(found.velocity[1], 0.0);
    }
}

#[test]
fn without_friction_spin_is_kept_through_impacts_bit_for_bit() {
    let spin = [30.0, -200.0, 11.0];
    for solver in [CONVERGED_RIGID, CONVERGED_HERTZ] {
        let setup = on_the_floor(0.0, [0.3, -0.1, -1.0], spin);
        let mut ball = Setup { solver: solver.into(), restitution: 0.8, ..setup }.start();
        run_until(&mut ball, 0.2);
        let found = first(&ball);
        assert_eq!((found.spin, found.velocity[0], found.velocity[1]), (spin, 0.3, -0.1));
    }
}

/// Kinetic energy over mass of two like grains.
fn energy(simulation: &Simulation) -> f64 {
    let of = |vector: [f64; 3]| vector.iter().map(|x| x * x).sum::<f64>();
    let grains = &simulation.snapshot().particles;
    grains.iter().map(|grain| 0.5 * of(grain.velocity) + 0.2 * grain.radius * grain.radius * of(grain.spin)).sum()
}

#[test]
fn grazing_impacts_of_spinning_pairs_gain_no_energy() {
    let hertz = CONVERGED_HERTZ.replace("1e-4", "1e-6");
    for (solver, time, margin) in [(CONVERGED_RIGID, 0.01, 1e-9), (hertz.as_str(), 0.004, 1e-3)] {
        for angle in [30.0_f64, 60.0, 76.0, 85.0] {
            for friction in [0.1, 0.5, 2.0] {
                for surface in [-2.0, 0.0, 2.0] {
                    let (sine, cosine) = angle.to_radians().sin_cos();
                    let gap = 2.0 * RADIUS * (1.0 + 1e-6);
                    let pair = grain(RADIUS, [0.0, 0.0, 1.0], [0.0; 3])
                        + &format!("spin = [0.0, {:?}, 0.0]\n", surface / RADIUS)
                        + &grain(RADIUS, [0.0, 0.0, 1.0 + gap], [sine, 0.0, -cosine]);
                    let setup = Setup { gravity: [0.0; 3], restitution: 1.0, friction, ..Setup::default() };
                    let mut pair = Setup { solver: solver.into(), body: pair, ..setup }.start();
                    let before = energy(&pair);
                    run_until(&mut pair, time);
                    let after = energy(&pair);
                    assert!(pair.snapshot().contacts.is_empty(), "{angle} {friction} {surface}: they have not parted");
                    assert!(after <= before * (1.0 + margin), "{angle} {friction} {surface}: {before} to {after}");
                }
            }
        }
    }
}
