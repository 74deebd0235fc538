//! Discs are thin: they have two sides and a rim, and nothing lies behind them.

use crate::common::{Setup, grain};

/// A wall of one disc about the origin, with a motion or none.
fn disc(radius: f64, motion: &str) -> String {
    format!(
        "[[wall]]\nname = 'disc'\nmaterial = 'wall'\n\
         shape = {{ kind = 'disc', centre = [0, 0, 0], normal = [0, 0, 1], radius = {radius:?} }}\n{motion}\n"
    )
}

const STEP: &str = "step = 5e-4";

#[test]
fn a_grain_that_drifts_past_the_back_of_a_disc_is_left_alone() {
    let mut simulation = Setup {
        gravity: [0.0; 3],
        solver: STEP.into(),
        body: disc(0.04, "") + &grain(0.005, [-0.06, 0.0, -0.03], [0.2, 0.0, 0.0]),
        ..Setup::default()
    }
    .start();
    let energy = simulation.energy().total();
    for _ in 0..1200 {
        simulation.step();
    }
    let particle = simulation.snapshot().particles[0];
    assert_eq!(particle.velocity, [0.2, 0.0, 0.0], "nothing touches it");
    assert_eq!(simulation.energy().total(), energy);
}

#[test]
fn a_grain_bounces_off_the_back_of_a_disc_as_off_its_front() {
    let rebound = |side: f64, speed: f64| {
        let mut simulation = Setup {
            gravity: [0.0; 3],
            solver: crate::common::CONVERGED_RIGID.replace("1e-4", "5e-4"),
            body: disc(0.04, "") + &grain(0.005, [0.01, 0.005, 0.021 * side], [0.0, 0.0, -speed * side]),
            ..Setup::default()
        }
        .start();
        for _ in 0..200 {
            simulation.step();
        }
        simulation.snapshot().particles[0].velocity[2] * side / speed
    };
    for speed in [0.5, 5.0, 50.0] {
        let (front, back) = (rebound(1.0, speed), rebound(-1.0, speed));
        assert!((front - 0.5).abs() < 1e-9 && (back - 0.5).abs() < 1e-9, "{speed} m/s: {front} {back}");
    }
}

/// A grain over the mouth of something narrower than itself: sunk in by `1 - sqrt(1 - (hole/r)^2)` of its radius it touches the rim all
/// round.
fn rests_over(mouth: &str, hole: f64, height: f64) {
    let (radius, gravity) = (0.005_f64, 9.81);
    let rest = height + (radius * radius - hole * hole).sqrt();
    let weight = crate::common::DENSITY * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * gravity;
    for friction in [0.0, 0.5] {
        for [x, y] in [[0.0, 0.0], [0.0003, 0.0], [-0.0005, 0.0008], [1e-9, 2e-9]] {
            let mut simulation = Setup {
                body: format!("{mouth}{}", grain(radius, [x, y, rest + 0.002], [0.0; 3])),
                solver: STEP.into(),
                friction,
                wall_friction: friction,
                restitution: 0.3,
                ..Setup::default()
            }
            .start();
            crate::common::run_until(&mut simulation, 2.0);
            for _ in 0..400 {
                simulation.step();
                let frame = simulation.snapshot();
                let grain = frame.particles[0];
                let speed = grain.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
                assert!(speed < 1e-6, "{speed} m/s from ({x}, {y}) with friction {friction}");
                let force = |touch: &makadam::snapshot::Contact| {
                    -touch.normal_force * touch.normal[2] - touch.tangential_force[2]
                };
                let borne: f64 = frame.contacts.iter().map(force).sum();
                assert!((borne / weight - 1.0).abs() < 1e-3, "{} from ({x}, {y})", borne / weight);
                let [x, y, z] = grain.position;
                assert!(x.hypot(y) < 1e-4 && (z - rest).abs() < 2e-5, "{:?}, not {rest}", grain.position);
            }
        }
    }
}

#[test]
fn grain_rests_on_narrow_hole() {
    let plate = disc(0.05, "").replace("radius = 0.05", "radius = 0.05, hole = 0.003");
    rests_over(&plate, 0.003, 0.0);
}

#[test]
fn grain_rests_on_narrow_tube() {
    let tube = "[[wall]]\nname = 'tube'\nmaterial = 'wall'\n\
                shape = { kind = 'cylinder', base = [0, 0, -0.1], axis = [0, 0, 1], radius = 0.004, length = 0.1 }\n";
    rests_over(tube, 0.004, 0.0);
}

#[test]
fn grain_falls_through_wide_hole() {
    let plate = disc(0.05, "").replace("radius = 0.05", "radius = 0.05, hole = 0.0051");
    let body = plate + &grain(0.005, [0.00005, 0.0, 0.02], [0.0; 3]);
    let mut simulation = Setup { solver: STEP.into(), body, ..Setup::default() }.start();
    crate::common::run_until(&mut simulation, 0.2);
    let z = simulation.snapshot().particles[0].position[2];
    assert!((z - (0.02 - 0.5 * 9.81 * 0.04)).abs() < 1e-3, "{z}");
}

#[test]
fn grains_roll_over_the_rim_of_a_disc() {
    // Beside the disc by half a radius: the rim pushes it outwards and holds it up until it has rolled off.
    let mut simulation = Setup {
        body: disc(0.04, "") + &grain(0.005, [0.0425, 0.0, 0.0049], [0.0; 3]),
        solver: STEP.into(),
        friction: 0.0,
        wall_friction: 0.0,
        restitution: 0.0,
        ..Setup::default()
    }
    .start();
    let energy = simulation.energy().total();
    for _ in 0..400 {
        simulation.step();
    }
    let particle = simulation.snapshot().particles[0];
    assert!(particle.velocity[0] > 0.02 && particle.position[2] < 0.0, "{particle:?}");
    assert!(simulation.energy().total() < energy + 1e-9, "nothing gives it energy");
}

#[test]
fn a_blade_between_grains_takes_no_energy_from_nowhere() {
    // A disc that stands still while it can turn, with grains on both sides of it, some across its plane beside the rim.
    let mut body =
        disc(0.04, "motion = { kind = 'rotating', point = [0, 0, 0], axis = [0, 1, 0], rate = 1.0, start = 10.0 }");
    for number in 0..12 {
        let angle = std::f64::consts::TAU * f64::from(number) / 12.0;
        let (x, y) = (angle.cos(), angle.sin());
        body += &grain(0.004, [0.02 * x, 0.02 * y, -0.0045], [0.0; 3]);
        body += &grain(0.004, [0.045 * x, 0.045 * y, 0.0], [0.0; 3]);
    }
    let mut simulation = Setup { gravity: [0.0; 3], solver: STEP.into(), body, ..Setup::default() }.start();
    for _ in 0..200 {
        simulation.step();
    }
    assert_eq!(simulation.energy().kinetic, 0.0);
}

#[test]
fn a_grain_that_comes_over_the_rim_of_a_plate_tips_it_with_the_lever_that_it_has() {
    let motion = "motion = { kind = 'torque-driven', point = [0, 0, 0], axis = [0, 1, 0], torque = 0.0, \
                  moment_of_inertia = 1e-3 }";
    let mut simulation = Setup {
        gravity: [0.0; 3],
        solver: STEP.into(),
        body: disc(0.04, motion) + &grain(0.001, [0.0405, 0.0, 0.0015], [-3.0, 0.0, -2.0]),
        ..Setup::default()
    }
    .start();
    for _ in 0..100 {
        simulation.step();
        let frame = simulation.snapshot();
        assert!(simulation.not_finite().is_none() && frame.driven_walls[0].rate.is_finite());
    }
    let (mass, rate) =
        (crate::common::DENSITY * 4.0 / 3.0 * std::f64::consts::PI * 1e-9, simulation.snapshot().driven_walls[0].rate);
    // The impulse is at most that of an elastic impact, at a lever of at most the plate's radius.
    assert!(rate > 0.0 && rate < mass * 2.0 * 3.7 * 0.042 / 1e-3, "{rate} rad/s");
}
