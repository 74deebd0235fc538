//! The tangential spring against closed forms, against Hertz's and Mindlin's equations of one impact, and beside the other effects.

use crate::common::bits::{reference_scene, same_bits_everywhere};
use crate::common::{DENSITY, FLOOR, Setup, grain, parse, run_until};
use approx::assert_relative_eq;
use makadam::Simulation;
use makadam::scene::{Material, Scene, TangentialLaw};
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
/// Effective modulus of two materials of 10 MPa and Poisson's ratio 0.3, Pa.
const MODULUS: f64 = 1e7 / (2.0 * (1.0 - 0.09));
/// Mindlin's ratio at 0.3.
const RATIO: f64 = 2.0 * 0.7 / 1.7;

/// Settings with springs. At short steps Sigma_t lambda_t and b are far larger than their difference, which is rounded.
fn springy(step: f64, ratio: &str) -> String {
    format!(
        "step = {step:e}\nnormal_law = {{ kind = 'hertz' }}\nover_relaxation = 1.0\n\
         tangential_law = {{ kind = 'spring'{ratio} }}\nstop = {{ kind = 'residual', tolerance = 1e-10, max_sweeps = 50 }}"
    )
}

/// Overlap at which the floor bears the ball's weight by Hertz's law, m; the effective modulus is in Pa.
fn static_overlap(modulus: f64) -> f64 {
    (MASS * 9.81 / (4.0 / 3.0 * modulus * RADIUS.sqrt())).powf(2.0 / 3.0)
}

/// A ball that rests on the floor, at the overlap that bears its weight, and has just been given a speed.
fn pushed(step: f64, ratio: &str, speed: f64) -> Scene {
    let overlap = static_overlap(MODULUS);
    let ball = grain(RADIUS, [0.0, 0.0, RADIUS - overlap], [speed, 0.0, 0.0]);
    let body = format!("{FLOOR}{ball}");
    Setup {
        friction: 10.0,
        wall_friction: 10.0,
        restitution: 1.0,
        solver: springy(step, ratio),
        body,
        ..Setup::default()
    }
    .scene()
}

/// Velocity of the ball's surface at the floor, m/s.
fn slip(simulation: &Simulation) -> f64 {
    let ball = simulation.snapshot().particles[0];
    ball.velocity[0] - RADIUS * ball.spin[1]
}

#[test]
fn a_ball_on_a_floor_swings_with_the_period_of_its_spring() {
    let overlap = static_overlap(MODULUS);
    for (ratio, text) in [(RATIO, String::new()), (0.3, ", stiffness_ratio = 0.3".into())] {
        // The surface has the mass 2/7 m at its contact.
        let stiffness = ratio * 2.0 * MODULUS * (RADIUS * overlap).sqrt();
        let period = 2.0 * PI / (3.5 * stiffness / MASS).sqrt();
        let step = period / 2000.0;
        let speed = 1e-4;
        let scene = pushed(step, &text, speed);
        let mut ball = Simulation::new(&scene, 1).unwrap();
        ball.open_ledger();
        let (mut before, mut crossings) = (slip(&ball), Vec::new());
        while crossings.len() < 9 {
            ball.step();
            let now = slip(&ball);
            if (now < 0.0) != (before < 0.0) {
                crossings.push(ball.time() - step * now / (now - before));
                // Where the surface turns round for the first time, the spring holds what implicit Euler has left of its energy.
                if crossings.len() == 1 {
                    let balance = ball.balance().unwrap();
                    let energy = 0.5 * 2.0 / 7.0 * MASS * speed * speed;
                    let left = energy * (-step * (2.0 * PI / period).powi(2) * ball.time()).exp();
                    assert_relative_eq!(balance.springs, left, max_relative = 3e-3);
                    assert_relative_eq!(balance.springs + balance.friction, energy, max_relative = 2e-5);
                    let resumed = Simulation::resume(&scene, &ball.checkpoint()).unwrap();
                    assert_eq!(resumed.balance().unwrap().springs, balance.springs);
                }
            }
            before = now;
        }
        let found = (crossings[8] - crossings[0]) / 4.0;
        assert_relative_eq!(found, period, max_relative = 2e-4);
        // Meanwhile it moves on at the speed at which it would roll.
        assert_relative_eq!(
            ball.snapshot().particles[0].velocity[0] - slip(&ball) * 2.0 / 7.0,
            5e-4 / 7.0,
            max_relative = 1e-9
        );
    }
}

/// Rebound of a ball without spin from a wall by Hertz's and Mindlin's equations: surface speed after over that before, where friction
/// caps the spring. Integrated by a method of its own (semi-implicit, steps of a twenty-thousandth of the impact).
fn rebound(speed: f64, angle: f64, friction: f64) -> f64 {
    let hertz = 4.0 / 3.0 * MODULUS * RADIUS.sqrt();
    let lasts = 2.94 * (15.0 * MASS / (16.0 * MODULUS * RADIUS.sqrt() * speed.sqrt())).powf(0.4);
    let h = lasts / 20_000.0;
    let (mut depth, mut into, mut across, mut force) = (0.0_f64, speed, speed * angle.tan(), 0.0_f64);
    let start = across;
    loop {
        depth += h * into;
        if depth <= 0.0 {
            return across / start;
        }
        let normal = hertz * depth * depth.sqrt();
        into -= h * normal / MASS;
        let stiffness = RATIO * 1.5 * hertz * depth.sqrt();
        force = (force - h * stiffness * across).clamp(-friction * normal, friction * normal);
        across += h * 3.5 * force / MASS;
    }
}

#[test]
fn oblique_impacts_rebound_by_hertz_and_mindlin() {
    let (speed, friction) = (0.5, 0.3);
    let mut reversed = 0;
    for degrees in [1.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0] {
        let angle = f64::to_radians(degrees);
        let velocity = [speed * angle.tan(), 0.0, -speed];
        let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 + 1e-6)], velocity));
        let setup = Setup {
            gravity: [0.0; 3],
            friction,
            wall_friction: friction,
            restitution: 1.0,
            // Implicit Euler takes h w^2 T / 2 of the spring's swing in an impact of the length T: 0.4% here.
            solver: springy(4e-7, ""),
            body,
            ..Setup::default()
        };
        let mut ball = setup.start();
        run_until(&mut ball, 3e-3);
        assert_relative_eq!(ball.snapshot().particles[0].velocity[2], speed, max_relative = 5e-3);
        let (found, expected) = (slip(&ball) / (speed * angle.tan()), rebound(speed, angle, friction));
        assert!((found - expected).abs() < 0.006, "{degrees} degrees: {found} {expected}");
        reversed += usize::from(found < 0.0);
        // Beyond the angle at which it slides all the way through, Coulomb's law alone decides.
        let slides = 1.0 - 7.0 * friction / angle.tan();
        if degrees > 70.0 {
            assert!((found - slides).abs() < 0.006, "{degrees} degrees: {found} {slides}");
        }
    }
    assert!(reversed >= 3, "the surface springs back where the impact is steep: {reversed}");
}

#[test]
fn a_stiff_spring_is_no_spring() {
    let rigid = springy(5e-4, "").replace("tangential_law = { kind = 'spring' }\n", "");
    let pile = |solver: String| {
        let corners = "min = [-0.02, -0.02, 0.0], max = [0.02, 0.02, 0.2]";
        let body = format!(
            "[[wall]]\nname = 'box'\nmaterial = 'wall'\nshape = {{ kind = 'box', {corners}, open = ['+z'] }}\n\
             [[population]]\ncount = 30\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0.2 }}\n\
             region = {{ kind = 'box', {corners} }}\nagitation = 0.3\n"
        );
        let mut pile = Setup { solver, body, ..Setup::default() }.start();
        for _ in 0..40 {
            pile.step();
        }
        pile.snapshot().particles
    };
    let mut scene_apart = 0.0_f64;
    for (one, other) in pile(rigid).iter().zip(&pile(springy(5e-4, ", stiffness_ratio = 1000.0"))) {
        for axis in 0..3 {
            scene_apart = scene_apart.max((one.velocity[axis] - other.velocity[axis]).abs());
        }
    }
    assert!(scene_apart > 0.0 && scene_apart < 1e-3, "{scene_apart} m/s");
}

#[test]
fn what_an_impact_bore_within_one_step_is_no_load_of_the_spring() {
    // An inelastic ball, a hundred times as stiff as the others, hits the floor aslant where the floor bears its weight. The impact is over
    // within the step, and the ball rolls on. Were its spring loaded with what the impact bore, its surface would slip by 9 mm/s in the next step.
    let overlap = static_overlap(100.0 * MODULUS);
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS - overlap], [1.0, 0.0, -1.0]));
    let setup = Setup { restitution: 0.0, youngs_modulus: 1e9, solver: springy(1e-3, ""), body, ..Setup::default() };
    let mut ball = setup.start();
    for _ in 0..20 {
        ball.step();
        assert!(slip(&ball).abs() < 1e-6, "{} m/s after {} s", slip(&ball), ball.time());
    }
    assert_relative_eq!(ball.snapshot().particles[0].velocity[0], 5.0 / 7.0, max_relative = 1e-6);
}

#[test]
fn springs_have_the_same_bits_on_any_threads_and_instruction_sets() {
    for resistance in [0.0, 0.05] {
        let mut scene = reference_scene("packing");
        scene.solver.tangential_law = TangentialLaw::Spring { stiffness_ratio: None };
        scene.material.values_mut().for_each(|material| material.rolling_friction = resistance);
        same_bits_everywhere(&scene, 240);
    }
}

#[test]
fn what_a_spring_does_not_go_with_is_refused_in_words() {
    let text = |solver: &str| {
        format!(
            "name = 'a'\nduration = 1.0\ngravity = [0, 0, -9.81]\ndomain = {{ min = [-1, -1, -1], max = [1, 1, 1] }}\n\
             [material.grain]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
             {FLOOR}[[grain]]\nmaterial = 'grain'\nradius = 0.005\nposition = [0, 0, 0.005]\n[solver]\n\
             tangential_law = {{ kind = 'spring' }}\n{solver}\n"
        )
        .replace("material = 'wall'", "material = 'grain'")
    };
    assert!(parse(&text("")).is_ok_and(|scene| scene.solver.tangential_law != TangentialLaw::Rigid));
    for (solver, words) in [
        ("normal_law = { kind = 'rigid' }", "give normal_law a stiffness"),
        ("method = { kind = 'jacobi' }", "tangential springs go with gauss-seidel"),
        ("precision = 'single'", "tangential springs go with gauss-seidel"),
    ] {
        let error = parse(&text(solver)).unwrap_err();
        assert!(error.contains(words) && error.contains("test.toml"), "{error}");
    }
    let error = parse(&text("").replace("'spring' }", "'spring', stiffness_ratio = -1.0 }")).unwrap_err();
    assert!(error.contains("stiffness_ratio"), "{error}");
    // Written scenes say nothing of a law that is the default, and keep their hashes.
    let scene: Scene = parse(&text("").replace("tangential_law = { kind = 'spring' }\n", "")).unwrap();
    assert!(!toml::to_string(&scene).unwrap().contains("tangential_law"));
}

#[test]
fn the_ratio_is_mindlins() {
    for poisson_ratio in [0.0, 0.25, 0.3, 0.5] {
        let one = Material { poisson_ratio, ..Material::default() };
        let ratio = TangentialLaw::default().stiffness_ratio([&one, &one]);
        let expected = 2.0 * (1.0 - poisson_ratio) / (2.0 - poisson_ratio);
        assert!((ratio - expected).abs() < 1e-15, "{ratio} {expected}");
    }
    // A stiff partner gives nothing: the soft one's own ratio, whatever the other's.
    let soft = Material { youngs_modulus: 1e5, ..Material::default() };
    let stiff = Material { youngs_modulus: 1e15, poisson_ratio: 0.1, ..Material::default() };
    let ratio = TangentialLaw::default().stiffness_ratio([&soft, &stiff]);
    assert!((ratio - 2.0 * 0.7 / 1.7).abs() < 1e-9);
    assert_eq!(TangentialLaw::Spring { stiffness_ratio: Some(0.5) }.stiffness_ratio([&soft, &stiff]), 0.5);
}
