//! Impacts against their closed forms (rigid sphere; see Chung & Ooi, Granular Matter 13, 2011, tests 3 and 4).

use crate::common::{CONVERGED_RIGID, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;

const RADIUS: f64 = 0.0025;

/// Velocity and spin after a sphere that touches a wall hits it at an angle (degrees, from the normal), without gravity.
fn oblique(angle: f64, speed: f64, restitution: f64, friction: f64) -> ([f64; 3], [f64; 3]) {
    let (sine, cosine) = angle.to_radians().sin_cos();
    let mut simulation = Setup {
        gravity: [0.0; 3],
        restitution,
        friction,
        wall_friction: friction,
        body: format!(
            "{FLOOR}{}",
            grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [speed * sine, 0.0, -speed * cosine])
        ),
        ..Setup::default()
    }
    .start();
    run_until(&mut simulation, 3e-4);
    let particle = simulation.snapshot().particles[0];
    (particle.velocity, particle.spin)
}

#[test]
fn oblique_impacts_stick_or_slip_as_the_closed_form_says() {
    let speed = 3.9;
    for (restitution, friction) in [(0.98, 0.092), (0.3, 0.5), (0.0, 0.3), (1.0, 0.2)] {
        let (mut sticks, mut slips) = (0, 0);
        for angle in (5..=85).step_by(5).map(f64::from) {
            let (velocity, spin) = oblique(angle, speed, restitution, friction);
            let (sine, cosine) = angle.to_radians().sin_cos();
            let tangent = sine / cosine;
            let (tangential, spun) = if tangent > 3.5 * friction * (1.0 + restitution) {
                slips += 1;
                let lost = friction * (1.0 + restitution) * speed * cosine;
                (speed * sine - lost, 2.5 * lost / RADIUS)
            } else {
                sticks += 1;
                (5.0 / 7.0 * speed * sine, 5.0 / 7.0 * speed * sine / RADIUS)
            };
            assert_relative_eq!(velocity[2], restitution * speed * cosine, max_relative = 1e-6, epsilon = 1e-6);
            assert_relative_eq!(velocity[0], tangential, max_relative = 1e-6);
            assert_relative_eq!(spin[1], spun, max_relative = 1e-6);
            assert_eq!([velocity[1], spin[0], spin[2]], [0.0; 3]);
        }
        assert!(sticks > 0 && slips > 0, "both regimes are met: {sticks} and {slips}");
    }
}

#[test]
fn a_bouncing_ball_reaches_the_height_of_each_bounce() {
    let (radius, start, restitution) = (0.005, 0.105, 0.7);
    let mut simulation = Setup {
        restitution,
        solver: crate::common::CONVERGED_RIGID.replace("1e-4", "1e-5"),
        body: format!("{FLOOR}{}", grain(radius, [0.0, 0.0, start], [0.0; 3])),
        ..Setup::default()
    }
    .start();
    let mut peaks = Vec::new();
    let (mut height, mut rising) = (start, false);
    while peaks.len() < 3 {
        simulation.step();
        let now = simulation.snapshot().particles[0].position[2];
        if rising && now < height {
            peaks.push(height);
        }
        rising = now > height;
        height = now;
    }
    for (bounce, peak) in peaks.into_iter().enumerate() {
        let expected = (start - radius) * restitution.powi(2 * (bounce as i32 + 1)) + radius;
        assert_relative_eq!(peak - radius, expected - radius, max_relative = 2e-3);
    }
}

#[test]
fn head_on_pairs_separate_at_the_restitution_and_keep_momentum() {
    for restitution in [0.0, 0.3, 1.0] {
        let mut simulation = Setup {
            gravity: [0.0; 3],
            restitution,
            body: grain(0.005, [-0.005 + 1e-12, 0.0, 0.0], [1.0, 0.0, 0.0])
                + &grain(0.01, [0.01, 0.0, 0.0], [-0.5, 0.0, 0.0]),
            ..Setup::default()
        }
        .start();
        run_until(&mut simulation, 0.02);
        let after = simulation.snapshot().particles;
        let (v, w) = (after[0].velocity[0], after[1].velocity[0]);
        assert_relative_eq!(w - v, restitution * 1.5, epsilon = 1e-6);
        assert_relative_eq!(v + 8.0 * w, 1.0 - 8.0 * 0.5, epsilon = 1e-12);
    }
}

/// Restitution of a Hertzian grain that falls on a wall from a given gap, for a time step (s).
fn hertzian_restitution(asked: f64, speed: f64, gap: f64, step: f64) -> f64 {
    let mut simulation = Setup {
        gravity: [0.0; 3],
        restitution: asked,
        solver: crate::common::CONVERGED_HERTZ.replace("1e-4", &format!("{step:e}")),
        body: format!("{FLOOR}{}", grain(0.005, [0.0, 0.0, 0.005 + gap], [0.0, 0.0, -speed])),
        ..Setup::default()
    }
    .start();
    run_until(&mut simulation, gap / speed + 0.02);
    simulation.snapshot().particles[0].velocity[2] / speed
}

#[test]
fn hertzian_impacts_have_the_restitution_where_the_step_resolves_them() {
    for asked in [0.05, 0.1, 0.3, 0.6, 0.9, 0.97, 0.99, 1.0] {
        for speed in [0.1, 0.5] {
            let restitution = hertzian_restitution(asked, speed, 1e-4, 2e-6);
            assert!((restitution - asked).abs() < 3e-3, "asked {asked} at {speed} m/s: {restitution}");
        }
    }
}

/// Without a loss, the two grains behind a row that one hits are not the only ones that move, and at the turn all energy is stored.
#[test]
fn hertzian_impacts_without_loss_are_compliant_at_short_steps() {
    let speed = 0.5;
    let mut simulation = Setup {
        gravity: [0.0; 3],
        restitution: 1.0,
        solver: crate::common::CONVERGED_HERTZ.replace("1e-4", "2e-6"),
        body: (0..6)
            .map(|number| {
                let (place, velocity) = if number == 0 { (-1e-5, speed) } else { (0.0, 0.0) };
                grain(0.005, [0.01 * f64::from(number) + place, 0.0, 0.1], [velocity, 0.0, 0.0])
            })
            .collect(),
        ..Setup::default()
    }
    .start();
    let mass = crate::common::DENSITY * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
    let (mut stored, impact) = (0.0_f64, 0.5 * mass * speed * speed);
    while simulation.time() < 0.012 {
        simulation.step();
        stored = stored.max(simulation.energy().elastic);
    }
    assert!((0.3..0.7).contains(&(stored / impact)), "{stored} J of {impact} J are stored while the pulse passes");
    // By an integration of the same row of soft spheres at steps of 1e-7 s.
    let expected = [-0.071, -0.030, -0.016, -0.007, 0.137, 0.987];
    for (grain, expected) in simulation.snapshot().particles.iter().zip(expected) {
        let found = grain.velocity[0] / speed;
        assert!((found - expected).abs() < 0.006, "grain {} leaves at {found}, not at {expected}", grain.id);
    }
}

#[test]
fn linear_impacts_have_the_restitution_where_the_step_resolves_them() {
    for asked in [0.1, 0.5, 0.9, 0.99, 1.0] {
        let mut simulation = Setup {
            gravity: [0.0; 3],
            restitution: asked,
            solver: crate::common::CONVERGED_HERTZ
                .replace("1e-4", "2e-6")
                .replace("{ kind = 'hertz' }", "{ kind = 'linear', stiffness = 1e4 }"),
            body: format!("{FLOOR}{}", grain(0.005, [0.0, 0.0, 0.0051], [0.0, 0.0, -0.5])),
            ..Setup::default()
        }
        .start();
        run_until(&mut simulation, 0.01);
        let restitution = simulation.snapshot().particles[0].velocity[2] / 0.5;
        assert!((restitution - asked).abs() < 3e-3, "asked {asked}: {restitution}");
    }
}

/// Place and velocity, step by step, of a smooth grain without gravity that moves by several radii a step, past walls.
fn flight(walls: &str, restitution: f64, position: [f64; 3], velocity: [f64; 3], steps: usize) -> Vec<[[f64; 3]; 2]> {
    let mut simulation = Setup {
        gravity: [0.0; 3],
        restitution,
        friction: 0.0,
        wall_friction: 0.0,
        body: format!("{walls}{}", grain(RADIUS, position, velocity)),
        ..Setup::default()
    }
    .start();
    let mut state = || {
        simulation.step();
        let particle = simulation.snapshot().particles[0];
        [particle.position, particle.velocity]
    };
    (0..steps).map(|_| state()).collect()
}

/// The step of `CONVERGED_RIGID`, s.
const STEP: f64 = 1e-4;

#[test]
fn a_grain_too_fast_for_its_step_bounces_off_a_plane_in_the_step_that_would_pass_it() {
    // 3.7 radii a step downwards, and some along the floor.
    let (down, along) = (3.7 * RADIUS / STEP, 11.0);
    for restitution in [0.0, 0.4, 1.0] {
        for start in [0.031, 0.0377, 0.05] {
            let states = flight(FLOOR, restitution, [0.0, 0.0, start], [along, 0.0, -down], 12);
            // The first step from whose start the floor is within reach ends the fall: its velocity is the rebound's, or, where
            // there is none, the one that ends at touch.
            let mut height = start;
            let mut bounced = false;
            for (step, [position, velocity]) in states.into_iter().enumerate() {
                let meets = !bounced && height - RADIUS <= down * STEP;
                let rise = match (bounced || meets, restitution > 0.0) {
                    (false, _) => -down,
                    (true, true) => restitution * down,
                    (true, false) => {
                        if meets {
                            -(height - RADIUS) / STEP
                        } else {
                            0.0
                        }
                    }
                };
                bounced |= meets;
                height += rise * STEP;
                assert_relative_eq!(velocity[2], rise, max_relative = 1e-9, epsilon = 1e-9);
                assert_relative_eq!(position[2], height, max_relative = 1e-9, epsilon = 1e-12);
                assert_relative_eq!(velocity[0], along, max_relative = 1e-12);
                assert!(position[2] >= RADIUS * (1.0 - 1e-9), "step {step}: through the floor at {position:?}");
            }
            assert!(bounced);
        }
    }
}

#[test]
fn a_grain_too_fast_for_its_step_meets_a_disc_or_passes_beside_it() {
    let disc = "[[wall]]\nname = 'plate'\nmaterial = 'wall'\n\
                shape = { kind = 'disc', centre = [0, 0, 0], normal = [0, 0, 1], radius = 0.02 }\n";
    let down = 5.0 * RADIUS / STEP;
    // The path crosses the plane of touch at x = 0.018, or at 0.022: from one and the same height.
    for (crossing, meets) in [(0.018, true), (0.022, false)] {
        let (start, along) = (0.0213, 20.0);
        let x = crossing - along * (start - RADIUS) / down;
        let end = flight(disc, 0.5, [x, 0.0, start], [along, 0.0, -down], 4).pop().unwrap();
        let expected = if meets { 0.5 * down } else { -down };
        assert_relative_eq!(end[1][2], expected, max_relative = 1e-9);
        assert_relative_eq!(end[1][0], along, max_relative = 1e-12);
    }
}

#[test]
fn a_grain_too_fast_for_its_step_is_reflected_where_it_meets_a_shell() {
    let shell = "[[wall]]\nname = 'pipe'\nmaterial = 'wall'\n\
                 shape = { kind = 'cylinder', base = [0, 0, -0.5], axis = [0, 0, 1], radius = 0.05, length = 1.0 }\n";
    let speed = 6.0 * RADIUS / STEP;
    for restitution in [0.3, 1.0] {
        // Inside, off the axis by a third of the radius; and outside, on its way in.
        for (inside, start, offset) in [(true, 0.011, 0.0161), (false, -0.083, 0.0161)] {
            let touch: f64 = if inside { 0.05 - RADIUS } else { 0.05 + RADIUS };
            // With losses it comes to slide round the shell, and then a step along the tangent leads beyond it.
            let steps = if restitution == 1.0 { 40 } else { 5 };
            let states = flight(shell, restitution, [start, offset, 0.1], [speed, 0.0, 3.0], steps);
            // It meets the circle of touch where x^2 + offset^2 = touch^2, ahead: the normal there reflects it.
            let x = (touch * touch - offset * offset).sqrt() * if inside { 1.0 } else { -1.0 };
            let normal = [x / touch, offset / touch];
            let lost = (1.0 + restitution) * speed * normal[0];
            let [_, velocity] = states.iter().find(|[_, velocity]| velocity[0] != speed).unwrap();
            assert_relative_eq!(velocity[0], speed - lost * normal[0], max_relative = 1e-9, epsilon = 1e-9 * speed);
            assert_relative_eq!(velocity[1], -lost * normal[1], max_relative = 1e-9, epsilon = 1e-9 * speed);
            assert_relative_eq!(velocity[2], 3.0, max_relative = 1e-12);
            for (step, [[x, y, _], _]) in states.iter().enumerate() {
                let side = if inside { touch - x.hypot(*y) } else { x.hypot(*y) - touch };
                assert!(side > -1e-9, "step {step}: {side} m beyond the shell");
            }
        }
    }
}

#[test]
fn a_resting_contact_that_opens_while_it_bears_does_the_work_that_the_laws_give_it() {
    // Three equal grains in a row, in touch: A comes at 1 m/s and rebounds (e = 1), C parts from B at 0.04 m/s, which is slower than
    // an impact. The impulses on B and on C follow from v_B - v_A = 1 and v_C - v_B = 0.04 / 5, the share that damping leaves; the
    // second does work while its contact opens, and kinetic energy grows by 3%. This is the price of Newton's law for impacts in
    // one step with contacts at rest; no solve can do better.
    let row = [(-1.0, 1.0), (0.0, 0.0), (1.0, 0.04)];
    let grains = row.map(|(place, speed)| grain(RADIUS, [place * (2.0 * RADIUS - 1e-12), 0.0, 0.0], [speed, 0.0, 0.0]));
    let solver = format!("{CONVERGED_RIGID}\nrestitution_threshold = 0.05");
    let body = grains.concat();
    let mut simulation =
        Setup { gravity: [0.0; 3], restitution: 1.0, friction: 0.0, solver, body, ..Setup::default() }.start();
    let before = simulation.energy().kinetic;
    simulation.step();
    let (parting, left) = (0.04, 0.04 / 5.0);
    let second = (1.0 - parting + left) / 1.5;
    let first = 1.0 + 0.5 * second;
    let after = simulation.snapshot().particles;
    let expected = [1.0 - first, first - second, parting + second];
    for (particle, velocity) in after.iter().zip(expected) {
        assert_relative_eq!(particle.velocity[0], velocity, epsilon = 1e-6);
    }
    let gain = simulation.energy().kinetic / before - 1.0;
    assert_relative_eq!(gain, second * (parting + left) / (1.0 + parting * parting), max_relative = 1e-5);
    assert!(gain > 0.03, "{gain}");
}

#[test]
fn a_grain_on_the_axis_of_a_tube_meets_the_side_that_it_falls_to() {
    // All points of a circle are nearest: the one below decides, wherever below is. The gap is shorter than the way of a step.
    let (gap, step) = (4e-5, 5e-3);
    let tube = format!(
        "[[wall]]\nname = 'tube'\nmaterial = 'wall'\n\
         shape = {{ kind = 'cylinder', base = [0, 0, -0.5], axis = [0, 0, 1], radius = {}, length = 1.0 }}\n",
        RADIUS + gap
    );
    for gravity in [[0.0, 9.81, 0.0], [-9.81, 0.0, 0.0], [5.886, -7.848, 0.0]] {
        let body = format!("{tube}{}", grain(RADIUS, [0.0; 3], [0.0; 3]));
        let solver = CONVERGED_RIGID.replace("step = 1e-4", &format!("step = {step:?}"));
        let setup =
            Setup { gravity, restitution: 0.0, friction: 0.0, wall_friction: 0.0, solver, body, ..Setup::default() };
        let mut simulation = setup.start();
        simulation.step();
        let velocity = simulation.snapshot().particles[0].velocity;
        for axis in 0..3 {
            assert_relative_eq!(
                velocity[axis],
                gravity[axis] / 9.81 * gap / step,
                max_relative = 1e-9,
                epsilon = 1e-15
            );
        }
    }
}
