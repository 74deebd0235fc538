//! Closed containers drawn at random keep their grains: no centre ever crosses a wall, however fast grains and walls are for the step.
//!
//! `MAKADAM_CONTAINERS=10000 cargo test --release -p makadam containment` tries as many.

pub mod container;
pub mod draw;

use draw::Drawn;
use makadam::Simulation;
use makadam::schedule::Scheduler;
use std::path::Path;

/// Containers of a usual run.
const FEW: u64 = 200;

/// Steps of each.
const STEPS: usize = 40;

/// Rigid contacts, solved to rounding.
const CONVERGED: &str = "normal_law = { kind = 'rigid' }\nover_relaxation = 1.0\n\
                         stop = { kind = 'residual', tolerance = 1e-13, max_sweeps = 1000 }";

/// Record of how a container kept its grains.
#[derive(Debug, PartialEq)]
enum Outcome {
    Kept,
    /// The run says that a grain crossed.
    Told,
    /// Step and grain.
    Lost(usize, u32),
}

/// Runs a container on so many threads; how it kept its grains, and the bits of the end.
fn run(drawn: &Drawn, threads: usize) -> (Outcome, u64) {
    let mut simulation = Simulation::new(&drawn.scene(), 1).unwrap_or_else(|error| panic!("{error}\n{}", drawn.text()));
    simulation.use_team(Scheduler::WorkStealing, threads).unwrap();
    for step in 1..=STEPS {
        simulation.step();
        if simulation.crossing().is_some() {
            return (Outcome::Told, simulation.state_hash());
        }
        let frame = simulation.snapshot();
        let displacement = frame.driven_walls.first().map_or(0.0, |wall| wall.displacement);
        let lost = frame
            .particles
            .iter()
            .find(|grain| !drawn.container.holds(grain.position.into(), simulation.time(), displacement));
        if let Some(grain) = lost {
            return (Outcome::Lost(step, grain.id), simulation.state_hash());
        }
    }
    (Outcome::Kept, simulation.state_hash())
}

#[test]
fn no_centre_crosses_the_walls_of_a_closed_container() {
    let asked = std::env::var("MAKADAM_CONTAINERS").ok().map(|count| count.parse().expect("a whole number"));
    let first = std::env::var("MAKADAM_FIRST_CONTAINER").ok().map_or(0, |first| first.parse().expect("a whole number"));
    let (mut told, mut lost) = (0, Vec::new());
    let count = asked.unwrap_or(FEW);
    for number in first..first + count {
        let drawn = Drawn::number(number);
        match run(&drawn, 1).0 {
            Outcome::Kept => {}
            Outcome::Told => {
                told += 1;
                eprintln!("container {number} ({}): the run tells of a crossing", drawn.summary());
            }
            Outcome::Lost(step, grain) => {
                eprintln!("container {number} ({}): grain {grain} is out after step {step}", drawn.summary());
                lost.push(number);
            }
        }
    }
    assert!(
        lost.is_empty(),
        "{} of {count} containers lost grains: {lost:?}; the first: {}",
        lost.len(),
        Drawn::number(lost[0]).text()
    );
    // Nothing but walls that close on each other leaves a grain no place.
    assert!(told * 1000 <= count, "{told} of {count} containers told of crossings");
}

#[test]
fn no_centre_crosses_the_walls_of_a_closed_funnel() {
    for number in 0..100 {
        let drawn = Drawn::funnel(number);
        let outcome = run(&drawn, 1);
        assert_eq!(outcome.0, Outcome::Kept, "funnel {number} ({}): {}", drawn.summary(), drawn.text());
        if number % 10 == 0 {
            assert_eq!(run(&drawn, 3), outcome, "funnel {number} on three threads");
        }
    }
}

#[test]
fn fast_grains_in_containers_have_the_same_bits_on_any_number_of_threads() {
    for number in 0..30 {
        let drawn = Drawn::number(number);
        let alone = run(&drawn, 1);
        for threads in [2, 3, 8] {
            assert_eq!(run(&drawn, threads), alone, "container {number} on {threads} threads");
        }
    }
}

/// A closed drum with one grain that flies from near the middle into a direction, so many diameters a step.
fn lone(direction: [f64; 3], diameters: f64, solver: &str) -> String {
    let (radius, step) = (0.004, 5e-4);
    let velocity = direction.map(|component| component * diameters * 2.0 * radius / step);
    format!(
        "name = 'drum'\ndescription = 'one grain'\nduration = 0.1\ngravity = [0.0, 0.0, 0.0]\n\
         domain = {{ min = [-0.2, -0.2, -0.2], max = [0.2, 0.2, 0.2] }}\n\
         [material.stone]\ndensity = 2500.0\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.3\nrestitution = 0.9\n\
         [solver]\nstep = {step:?}\n{solver}\n\
         [[wall]]\nname = 'shell'\nmaterial = 'stone'\n\
         shape = {{ kind = 'cylinder', base = [0.0, -0.03, 0.0], axis = [0.0, 1.0, 0.0], radius = 0.1, length = 0.06 }}\n\
         [[wall]]\nname = 'left'\nmaterial = 'stone'\n\
         shape = {{ kind = 'disc', centre = [0.0, -0.03, 0.0], normal = [0.0, 1.0, 0.0], radius = 0.1 }}\n\
         [[wall]]\nname = 'right'\nmaterial = 'stone'\n\
         shape = {{ kind = 'disc', centre = [0.0, 0.03, 0.0], normal = [0.0, -1.0, 0.0], radius = 0.1 }}\n\
         [[grain]]\nmaterial = 'stone'\nradius = {radius:?}\nposition = [0.0, 0.0, 0.006]\nvelocity = {velocity:?}\n"
    )
}

#[test]
fn a_lone_grain_stays_in_a_closed_drum_in_every_direction() {
    for diameters in [0.5, 1.0, 1.25, 3.0, 10.0, 50.0] {
        for number in 0..60 {
            // Directions that lie evenly on the sphere.
            let (height, angle) = (1.0 - (2.0 * f64::from(number) + 1.0) / 60.0, 2.399963 * f64::from(number));
            let across = (1.0 - height * height).sqrt();
            let direction = [across * angle.cos(), height, across * angle.sin()];
            let text = lone(direction, diameters, "");
            let scene = makadam::scene::Scene::parse(&text).unwrap();
            let mut simulation = Simulation::new(&scene, 1).unwrap();
            let energy = simulation.energy().kinetic;
            for step in 0..100 {
                simulation.step();
                let [x, y, z] = simulation.snapshot().particles[0].position;
                assert!(
                    x.hypot(z) <= 0.1 && y.abs() <= 0.03 && simulation.crossing().is_none(),
                    "{diameters} diameters a step along {direction:?}: ({x}, {y}, {z}) after step {step}"
                );
            }
            assert!(simulation.energy().kinetic <= energy * (1.0 + 1e-9), "impacts take energy");
        }
    }
}

#[test]
fn grains_bounce_off_a_shell_as_newton_says_however_old_the_candidate_list_is() {
    // Smooth and elastic: a grain keeps its speed whatever it hits.
    for number in 0..40 {
        let angle = std::f64::consts::TAU * f64::from(number) / 40.0;
        let text = lone([angle.cos(), 0.0, angle.sin()], 1.0, CONVERGED)
            .replace("friction = 0.3", "friction = 0.0")
            .replace("restitution = 0.9", "restitution = 1.0");
        let scene = makadam::scene::Scene::parse(&text).unwrap();
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        let energy = simulation.energy().kinetic;
        for _ in 0..100 {
            simulation.step();
        }
        let [x, _, z] = simulation.snapshot().particles[0].position;
        assert!(x.hypot(z) <= 0.1 && (simulation.energy().kinetic / energy - 1.0).abs() < 1e-9, "direction {number}");
    }
}

#[test]
fn the_drum_keeps_its_grains_at_fifty_diameters_a_step() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/drum/scene.toml");
    for diameters in [1.0, 10.0, 50.0] {
        let mut scene = makadam::scene::Scene::load(&file).unwrap();
        scene.population[0].agitation = diameters * 0.01 / scene.solver.step;
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        for step in 0..60 {
            simulation.step();
            assert!(simulation.crossing().is_none());
            let frame = simulation.snapshot();
            let outside = frame.particles.iter().find(|grain| {
                let [x, y, z] = grain.position;
                x.hypot(z) > 0.1 || y.abs() > 0.06
            });
            assert_eq!(outside, None, "{diameters} diameters a step, after step {step}");
        }
    }
}

#[test]
fn the_ledger_closes_over_impacts_that_no_solve_knew_of() {
    for number in 0..60 {
        let drawn = Drawn::number(number);
        let mut simulation = Simulation::new(&drawn.scene(), 1).unwrap();
        simulation.open_ledger();
        for _ in 0..STEPS {
            simulation.step();
        }
        let balance = simulation.balance().unwrap();
        // Velocities of single precision are not the sums of their impulses to more than that.
        let rounding = if drawn.is_single() { 1e-3 } else { 1e-6 };
        assert!(
            balance.closure.abs() <= rounding * balance.exchanged(),
            "container {number} ({}): {:e} J of {:e} J are left open",
            drawn.summary(),
            balance.closure,
            balance.exchanged()
        );
        let alone = run(&drawn, 1);
        if alone.0 == Outcome::Kept {
            assert_eq!(simulation.state_hash(), alone.1, "container {number}: a ledger changes no bit");
        }
    }
}
