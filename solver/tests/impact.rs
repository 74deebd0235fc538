//! Impacts against their closed forms (rigid sphere; see Chung & Ooi, Granular Matter 13, 2011, tests 3 and 4).

mod common;
use approx::assert_relative_eq;
use common::{FLOOR, Setup, grain, run_until};

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
        solver: common::CONVERGED_RIGID.replace("1e-4", "1e-5"),
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
        solver: common::CONVERGED_HERTZ.replace("1e-4", &format!("{step:e}")),
        body: format!("{FLOOR}{}", grain(0.005, [0.0, 0.0, 0.005 + gap], [0.0, 0.0, -speed])),
        ..Setup::default()
    }
    .start();
    run_until(&mut simulation, gap / speed + 0.02);
    simulation.snapshot().particles[0].velocity[2] / speed
}

#[test]
fn hertzian_impacts_have_the_restitution_where_the_step_resolves_them() {
    for asked in [0.05, 0.1, 0.3, 0.6, 0.9] {
        for speed in [0.1, 0.5] {
            let restitution = hertzian_restitution(asked, speed, 1e-4, 2e-6);
            assert!((restitution - asked).abs() < 3e-3, "asked {asked} at {speed} m/s: {restitution}");
        }
    }
}

#[test]
fn linear_impacts_have_the_restitution_where_the_step_resolves_them() {
    for asked in [0.1, 0.5, 0.9] {
        let mut simulation = Setup {
            gravity: [0.0; 3],
            restitution: asked,
            solver: common::CONVERGED_HERTZ
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
