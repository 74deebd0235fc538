//! Grains at rest, sliding and rolling, against their closed forms.

use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, DENSITY, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::Simulation;
use makadam::snapshot::Partner;
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const GRAVITY: f64 = 9.81;

fn mass(radius: f64) -> f64 {
    DENSITY * 4.0 / 3.0 * PI * radius.powi(3)
}

fn wall_force(simulation: &Simulation) -> f64 {
    let contacts = simulation.snapshot().contacts;
    let walls = contacts.iter().filter(|contact| matches!(contact.second, Partner::Wall(_)));
    walls.map(|contact| -contact.normal[2] * contact.normal_force - contact.tangential_force[2]).sum()
}

#[test]
fn a_ball_on_an_incline_slides_or_rolls() {
    for (degrees, friction) in [(20.0_f64, 0.05), (20.0, 0.5), (40.0, 0.2), (40.0, 0.3)] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        for law in [CONVERGED_RIGID, CONVERGED_HERTZ] {
            let mut simulation = Setup {
                gravity: [GRAVITY * sine, 0.0, -GRAVITY * cosine],
                wall_friction: friction,
                solver: law.into(),
                body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS], [0.0; 3])),
                ..Setup::default()
            }
            .start();
            run_until(&mut simulation, 0.5);
            let ball = simulation.snapshot().particles[0];
            let slips = sine / cosine > 3.5 * friction;
            let (acceleration, spin) = if slips {
                (GRAVITY * (sine - friction * cosine), 2.5 * friction * GRAVITY * cosine / RADIUS)
            } else {
                (5.0 / 7.0 * GRAVITY * sine, 5.0 / 7.0 * GRAVITY * sine / RADIUS)
            };
            // The Hertzian ball settles by a few micrometres first, and its friction waits for that.
            let tolerance = if law == CONVERGED_RIGID { 1e-6 } else { 1e-3 };
            assert_relative_eq!(ball.velocity[0], acceleration * 0.5, max_relative = tolerance);
            assert_relative_eq!(ball.spin[1], spin * 0.5, max_relative = tolerance);
        }
    }
}

#[test]
fn a_grain_that_hovers_is_stopped_at_touch_where_it_is_stiff() {
    const STEP: f64 = 1e-3;
    let fall = 0.5 * GRAVITY * STEP * STEP;
    let after_a_step = |youngs_modulus: f64, gap: f64| {
        let setup = Setup {
            youngs_modulus,
            solver: format!("step = {STEP}\nover_relaxation = 1.0\nstop = {{ kind = 'sweeps', sweeps = 50 }}"),
            body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS + gap], [0.01, 0.0, 0.0])),
            ..Setup::default()
        };
        let mut simulation = setup.start();
        simulation.step();
        simulation.snapshot().particles[0]
    };
    // A stiff one touches the ground at the end of the step, as far as its compliance lets it, and rubs already.
    let stiff = after_a_step(1e12, 0.5 * fall);
    assert_relative_eq!(stiff.position[2], RADIUS, epsilon = 1e-2 * fall);
    let impulse = GRAVITY * STEP - 0.5 * fall / STEP;
    assert_relative_eq!(stiff.velocity[0], 0.01 - 0.5 * impulse.min(0.01 * 2.0 / 3.5), max_relative = 1e-2);
    // Out of reach, or soft enough for the step to follow its impact, it falls.
    for (youngs_modulus, gap) in [(1e12, 7.0 * fall), (1e5, 0.5 * fall)] {
        let falling = after_a_step(youngs_modulus, gap);
        assert_relative_eq!(falling.velocity[2], -GRAVITY * STEP, max_relative = 1e-12);
        assert_relative_eq!(falling.velocity[0], 0.01, max_relative = 1e-12);
    }
}

#[test]
fn a_hertzian_grain_rests_at_its_static_overlap() {
    let setup = Setup {
        solver: CONVERGED_HERTZ.into(),
        restitution: 0.3,
        body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS], [0.0; 3])),
        ..Setup::default()
    };
    let mut simulation = setup.start();
    run_until(&mut simulation, 1.0);
    let effective_modulus = setup.youngs_modulus / (2.0 * (1.0 - 0.3 * 0.3));
    let stiffness = 4.0 / 3.0 * effective_modulus * RADIUS.sqrt();
    let expected = (mass(RADIUS) * GRAVITY / stiffness).powf(2.0 / 3.0);
    let overlap = RADIUS - simulation.snapshot().particles[0].position[2];
    assert_relative_eq!(overlap, expected, max_relative = 1e-6);
    assert_relative_eq!(wall_force(&simulation), mass(RADIUS) * GRAVITY, max_relative = 1e-6);
    // The integral of a force that goes with the overlap to the power 3/2.
    assert_relative_eq!(simulation.energy().elastic, 0.4 * mass(RADIUS) * GRAVITY * overlap, max_relative = 1e-5);
}

#[test]
fn a_linear_grain_rests_at_its_static_overlap() {
    let mut simulation = Setup {
        solver: CONVERGED_HERTZ.replace("{ kind = 'hertz' }", "{ kind = 'linear', stiffness = 1e4 }"),
        body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS], [0.0; 3])),
        ..Setup::default()
    }
    .start();
    run_until(&mut simulation, 1.0);
    let overlap = RADIUS - simulation.snapshot().particles[0].position[2];
    assert_relative_eq!(overlap, mass(RADIUS) * GRAVITY / 1e4, max_relative = 1e-6);
    assert_relative_eq!(simulation.energy().elastic, 0.5 * mass(RADIUS) * GRAVITY * overlap, max_relative = 1e-5);
}

#[test]
fn a_stack_of_ten_bears_its_weight() {
    for law in [CONVERGED_RIGID, CONVERGED_HERTZ] {
        let grains: String =
            (0..10).map(|i| grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 + 2.0 * f64::from(i))], [0.0; 3])).collect();
        let mut simulation = Setup { solver: law.into(), body: format!("{FLOOR}{grains}"), ..Setup::default() }.start();
        run_until(&mut simulation, 2.0);
        let weight = 10.0 * mass(RADIUS) * GRAVITY;
        assert_relative_eq!(wall_force(&simulation), weight, max_relative = 1e-6);
        for contact in simulation.snapshot().contacts {
            // Each contact bears the grains above it; a pair names the lower grain first.
            let above = if matches!(contact.second, Partner::Wall(_)) { 10 } else { 9 - contact.first };
            assert_relative_eq!(contact.normal_force, weight * f64::from(above) / 10.0, max_relative = 1e-5);
        }
    }
}

/// Returns the depth by which the top sphere sinks within 0.4 s, over the radius, on `base` touching spheres (two in a plane, or three).
fn pyramid_sinks(base: u32, grain_friction: f64, ground_friction: f64) -> f64 {
    let side = 2.0 * RADIUS;
    // Distance of the lower spheres from the axis: half a side, or the circumradius of the triangle.
    let from_axis = if base == 2 { 0.5 * side } else { side / 3.0_f64.sqrt() };
    let mut body = String::from(FLOOR);
    for corner in 0..base {
        let angle = 2.0 * PI * f64::from(corner) / f64::from(base);
        let (x, y) = if base == 2 { (1.0 - 2.0 * f64::from(corner), 0.0) } else { (angle.cos(), angle.sin()) };
        body += &grain(RADIUS, [from_axis * x, from_axis * y, RADIUS], [0.0; 3]);
    }
    let top = RADIUS + (side * side - from_axis * from_axis).sqrt();
    body += &grain(RADIUS, [0.0, 0.0, top], [0.0; 3]);
    let mut simulation = Setup {
        friction: grain_friction,
        wall_friction: ground_friction,
        restitution: 0.0,
        body,
        solver: CONVERGED_RIGID.replace("1e-4", "5e-4").replace("1e-13", "1e-9"),
        ..Setup::default()
    }
    .start();
    run_until(&mut simulation, 0.4);
    (top - simulation.snapshot().particles[base as usize].position[2]) / RADIUS
}

/// The force on a lower sphere from above must point at its ground contact, so it leans by half the angle between the
/// contact's normal and the vertical: 30 degrees on two spheres, asin(1/sqrt 3) on three.
#[test]
fn pyramids_stand_above_both_friction_thresholds() {
    let on_two = (2.0 - 3.0_f64.sqrt(), (2.0 - 3.0_f64.sqrt()) / 3.0);
    let on_three = (3.0_f64.sqrt() - 2.0_f64.sqrt(), (3.0_f64.sqrt() - 2.0_f64.sqrt()) / 4.0);
    for (base, (between_grains, on_ground)) in [(2, on_two), (3, on_three)] {
        assert!(pyramid_sinks(base, 1.05 * between_grains, 1.0) < 0.01, "{base}: grain friction is enough");
        assert!(pyramid_sinks(base, 0.95 * between_grains, 1.0) > 0.1, "{base}: grain friction is not enough");
        assert!(pyramid_sinks(base, 1.0, 1.05 * on_ground) < 0.01, "{base}: ground friction is enough");
        assert!(pyramid_sinks(base, 1.0, 0.95 * on_ground) > 0.1, "{base}: ground friction is not enough");
    }
}

#[test]
fn a_belt_carries_a_grain_up_to_its_speed() {
    let belt = FLOOR.trim_end().to_string() + "\nmotion = { kind = 'translating', velocity = [0.3, 0, 0] }\n";
    let mut simulation =
        Setup { body: format!("{belt}{}", grain(RADIUS, [0.0, 0.0, RADIUS], [0.0; 3])), ..Setup::default() }.start();
    run_until(&mut simulation, 0.3);
    let ball = simulation.snapshot().particles[0];
    // Friction acts until the contact point moves with the belt: v = 2/7 of its speed, spin -5/7 of it over R.
    assert_relative_eq!(ball.velocity[0], 2.0 / 7.0 * 0.3, max_relative = 1e-6);
    assert_relative_eq!(ball.spin[1], -5.0 / 7.0 * 0.3 / RADIUS, max_relative = 1e-6);
}
