//! What holds in every scene, in small ones drawn at random. `MAKADAM_RANDOM_SCENES` sets their number for each property.

#[path = "random/scene.rs"]
mod scene;

use makadam::Simulation;
use makadam::snapshot::{Partner, Snapshot};
use nalgebra::Vector3;
use proptest::prelude::*;
use scene::{Container, Drawn, Solves, scenes};

type Vector = Vector3<f64>;

/// Steps of a run.
const STEPS: usize = 200;

/// Steps over which two runs are compared, before differences in rounding have grown.
const COMPARED_STEPS: usize = 20;

/// Excess over the Coulomb cone that rounding makes, over the cone.
const CONE_ROUNDING: f64 = 1e-12;

/// Difference of two runs that only rounding and the end of converged solves part, over the largest speed.
const SAME_RUN: f64 = 1e-6;

fn cases(usual: u32) -> ProptestConfig {
    let asked = std::env::var("MAKADAM_RANDOM_SCENES").ok().and_then(|number| number.parse().ok());
    ProptestConfig {
        failure_persistence: None,
        max_shrink_iters: 2000,
        ..ProptestConfig::with_cases(asked.unwrap_or(usual))
    }
}

/// Sum of kinetic and potential energy, J.
fn energy(simulation: &Simulation) -> f64 {
    let energy = simulation.energy();
    energy.kinetic + energy.potential
}

/// Work of the container on the grains in the step that led from `before` to `after`, J: impulse times the wall's velocity.
fn work_of_walls(drawn: &Drawn, before: &Snapshot, after: &Snapshot) -> f64 {
    let Container::Cylinder { radius, rate } = drawn.container else { return 0.0 };
    let walls = after.contacts.iter().filter(|contact| matches!(contact.second, Partner::Wall(_)));
    let power = walls.map(|contact| {
        let centre = Vector::from(before.particles[contact.first as usize].position);
        let outwards = Vector::new(centre.x, centre.y, 0.0).try_normalize(0.0).unwrap_or_default();
        let velocity = Vector::z().cross(&outwards) * (rate * radius);
        -Vector::from(contact.tangential_force).dot(&velocity)
    });
    power.sum::<f64>() * drawn.step
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
#[test]
#[ignore]
fn explore() {
    use proptest::strategy::ValueTree;
    let n: usize = std::env::var("N").unwrap().parse().unwrap();
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for _ in 0..n {
        let drawn = scenes(30).new_tree(&mut runner).unwrap().current();
        for solves in [Solves::Usual, Solves::Converged] {
            let mut simulation = drawn.start(solves);
            let start = energy(&simulation);
            let scale = simulation.energy().kinetic;
            let mut work = 0.0;
            let mut worst = 0.0_f64;
            let mut contacts = 0;
            let mut cone = 0.0_f64;
            let mut worst_step = 0;
            let mut before = simulation.snapshot();
            let mut highk = 0.0_f64;
            for s in 0..STEPS {
                contacts += simulation.step().contacts;
                let after = simulation.snapshot();
                assert!(all_finite(&after), "{}", drawn.text(solves));
                cone = cone.max(cone_excess(&drawn, &after));
                work += work_of_walls(&drawn, &before, &after);
                let gain = energy(&simulation) - start - work;
                highk = highk.max(simulation.energy().kinetic).max(scale);
                if gain / highk > worst {
                    worst = gain / highk;
                    worst_step = s;
                }
                before = after;
            }
            let kind = match drawn.container {
                Container::None => 0,
                Container::Box { .. } => 1,
                Container::Plane { .. } => 2,
                Container::Cylinder { rate, .. } if rate == 0.0 => 3,
                _ => 4,
            };
            println!(
                "{solves:?} {kind} n={} g={} E={:?} mu={:.2} e={:.2} h={:.1e} contacts={contacts} cone={cone:.1e} gain={worst:.3e} at {worst_step} K0={scale:.2e} Kmax={highk:.2e}",
                drawn.grains.len(),
                (drawn.gravity.norm() > 0.0) as u8,
                drawn.youngs_modulus.map(|e| e.log10()),
                drawn.friction,
                drawn.restitution,
                drawn.step
            );
        }
    }
}

/// What one run of a scene must keep.
fn check_run(drawn: &Drawn) -> Result<(), TestCaseError> {
    let mut simulation = drawn.start(Solves::Usual);
    let (start, mut before) = (energy(&simulation), simulation.snapshot());
    let (mut work, mut fastest) = (0.0, 0.0_f64);
    for step in 0..STEPS {
        simulation.step();
        let after = simulation.snapshot();
        prop_assert!(all_finite(&after), "step {step}: a number is none");
        let excess = cone_excess(drawn, &after);
        prop_assert!(excess <= CONE_ROUNDING * drawn.friction.max(1.0), "step {step}: {excess:e} beyond the cone");
        work += work_of_walls(drawn, &before, &after);
        fastest = fastest.max(simulation.energy().kinetic);
        let gain = energy(&simulation) - start - work;
        prop_assert!(gain <= most_gain(drawn, fastest), "step {step}: {gain:e} J gained, with {fastest:e} J at most");
        before = after;
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

/// Largest differences between two runs of which `image` maps the places and velocities, and `order` the grains, of the first to
/// those of the second: in distance moved at the largest speed, and in that speed.
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

/// A scene with fewer grains, without the slide of one run from the other that a spin of rigid piles has.
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
    fn runs_stay_finite_in_the_cone_and_gain_no_energy(drawn in scenes(30)) {
        check_run(&drawn)?;
    }

    #[test]
    fn grains_among_themselves_keep_their_momentum(drawn in scenes(30)) {
        check_momentum(&drawn)?;
    }

    #[test]
    fn the_order_of_grains_does_not_matter(drawn in scenes(12)) {
        check_order(&drawn)?;
    }

    #[test]
    fn a_mirror_image_runs_as_its_original(drawn in scenes(12)) {
        check_mirror(&drawn)?;
    }

    #[test]
    fn a_turned_scene_runs_as_its_original(drawn in scenes(12)) {
        check_turn(&drawn)?;
    }
}

/// Energy that a run may gain, J.
fn most_gain(_drawn: &Drawn, fastest: f64) -> f64 {
    1e-9 * fastest
}

#[test]
#[ignore]
fn explore_differences() {
    use proptest::strategy::ValueTree;
    let n: usize = std::env::var("N").unwrap().parse().unwrap();
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for _ in 0..n {
        let drawn = scenes(12).new_tree(&mut runner).unwrap().current();
        let last = drawn.grains.len() - 1;
        let mut reversed = drawn.clone();
        reversed.grains.reverse();
        let order = difference((&drawn, &reversed), |g| last - g, |v| v);
        let polar = |v: Vector| Vector::new(-v.x, v.y, v.z);
        let mirror = difference((&drawn, &drawn.mapped(polar, |v: Vector| Vector::new(v.x, -v.y, -v.z))), |g| g, polar);
        let turn = |v: Vector| Vector::new(-v.y, v.x, v.z);
        let turned = difference((&drawn, &drawn.mapped(turn, turn)), |g| g, turn);
        println!(
            "n={} E={:?} mu={:.2} e={:.2} h={:.1e} order={order:.1e} mirror={mirror:.1e} turn={turned:.1e} {:?}",
            drawn.grains.len(),
            drawn.youngs_modulus.map(|e| e.log10()),
            drawn.friction,
            drawn.restitution,
            drawn.step,
            drawn.container
        );
    }
}
