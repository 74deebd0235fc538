//! Invariants of small scenes drawn at random. `MAKADAM_RANDOM_SCENES` sets their number for each property.

mod conservation;
mod contacts;
mod energy;
mod images;
mod scene;
mod uniqueness;

use self::conservation::Seen;
use self::contacts::{Laws, Stepped, step};
use self::images::Image;
use self::scene::{Container, Drawn, Solves, scenes};
use makadam::snapshot::Snapshot;
use nalgebra::Vector3;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use std::cell::Cell;

type Vector = Vector3<f64>;

/// Steps of a run.
const STEPS: usize = 200;

/// Excess over the Coulomb cone that rounding makes, over the cone.
const CONE_ROUNDING: f64 = 1e-12;

/// Scenes of a property where nothing else is asked for.
const USUAL: u32 = 48;

/// Checks scenes drawn from a fixed seed; a check returns how often it could say what. Returns the sums.
fn check<S: std::fmt::Debug, const KINDS: usize>(
    scenes: impl Strategy<Value = S>,
    check: impl Fn(&S) -> Result<[u64; KINDS], TestCaseError>,
) -> [u64; KINDS] {
    let asked = std::env::var("MAKADAM_RANDOM_SCENES").ok().and_then(|number| number.parse().ok());
    let config = ProptestConfig {
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        max_shrink_iters: 2000,
        ..ProptestConfig::with_cases(asked.unwrap_or(USUAL))
    };
    let sums = Cell::new([0; KINDS]);
    let outcome = TestRunner::new(config).run(&scenes, |drawn| {
        let own = check(&drawn)?;
        let before = sums.get();
        sums.set(std::array::from_fn(|kind| before[kind] + own[kind]));
        Ok(())
    });
    if let Err(error) = outcome {
        panic!("{error}");
    }
    sums.get()
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
fn check_run(drawn: &Drawn) -> Result<[u64; 1], TestCaseError> {
    let mut simulation = drawn.start(Solves::Usual);
    for step in 0..STEPS {
        simulation.step();
        let after = simulation.snapshot();
        prop_assert!(all_finite(&after), "step {step}: a number is none");
        let excess = cone_excess(drawn, &after);
        prop_assert!(excess <= CONE_ROUNDING * drawn.friction.max(1.0), "step {step}: {excess:e} beyond the cone");
    }
    Ok([STEPS as u64])
}

fn check_momentum(drawn: &Drawn) -> Result<[u64; 1], TestCaseError> {
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
    Ok([STEPS as u64])
}

/// Snapshots before and after each step obey the laws of contact as far as the solver says that it solved them: gap velocity and
/// impulse are complementary, friction opposes sliding with all that it has.
fn check_laws(drawn: &Drawn, solves: Solves, steps: usize) -> Result<[u64; 1], TestCaseError> {
    let laws = Laws::new(drawn, &drawn.scene(solves));
    let mut simulation = drawn.start(solves);
    let mut bearing = 0;
    for number in 0..steps {
        let Stepped { touches, inexact, struck, .. } = step(&mut simulation, &laws);
        if struck > 0 {
            continue;
        }
        for touch in &touches {
            let along = touch.along;
            bearing += u64::from(along > 0.0);
            prop_assert!(along >= 0.0, "step {number}: {touch:?} attracts");
            // Of a grain that meets a wall on its way `impact.rs` knows the law, and where on a turning wall that is.
            let (Some(law), Some(asked)) = (touch.law, touch.asked()) else { continue };
            let (gap, push) = (touch.opening() - asked, along * (touch.inverse_mass + law.regularisation));
            let off = gap.min(push).abs();
            prop_assert!(
                off <= inexact.normal,
                "step {number}: {off:e} m/s off the normal law, {inexact:?}: {touch:?}"
            );
            let (sliding, friction) = (touch.sliding(), drawn.friction);
            let off = touch.tangential.dot(&sliding) + friction * along * sliding.norm();
            let bound = touch.friction_slack(friction, inexact);
            prop_assert!(off <= bound, "step {number}: {off:e} J off Coulomb's law, {bound:e} at most: {touch:?}");
        }
    }
    Ok([bearing])
}

#[test]
fn runs_stay_finite_and_in_the_cone() {
    check(scenes(30), check_run);
}

#[test]
fn grains_among_themselves_keep_their_momentum() {
    check(scenes(30), check_momentum);
}

#[test]
fn ledgers_close_with_all_effects() {
    let counts = check(conservation::with_effects(20), conservation::check_ledger);
    println!("{counts:?} steps, with contacts");
    assert!(counts[1] > 1000, "{counts:?}");
}

#[test]
fn moving_frames_change_nothing() {
    let boosted = (conservation::with_effects(12), conservation::boosts());
    let counts = check(boosted, |(scene, boost)| conservation::check_seen(scene, Seen::Moving(*boost)));
    println!("{counts:?} steps with contacts, with solves to the end");
    assert!(counts[1] > 100, "{counts:?}");
}

#[test]
fn mirrors_change_nothing_with_all_effects() {
    let counts = check(conservation::with_effects(12), |scene| conservation::check_seen(scene, Seen::Mirrored));
    println!("{counts:?} steps with contacts, with solves to the end");
    assert!(counts[1] > 100, "{counts:?}");
}

#[test]
fn contacts_obey_their_laws_as_far_as_solves_go() {
    let [bearing] = check(scenes(30), |drawn| check_laws(drawn, Solves::Usual, STEPS));
    println!("{bearing} bearing contacts");
    assert!(bearing > 1000);
}

#[test]
fn contacts_obey_their_laws_to_rounding_where_solves_converge() {
    let [bearing] = check(scenes(12), |drawn| check_laws(drawn, Solves::Converged, STEPS));
    println!("{bearing} bearing contacts");
    assert!(bearing > 1000);
}

#[test]
fn rigid_grains_between_walls_at_rest_gain_energy_from_rebounds_alone() {
    let counts = check(scenes(30), |drawn| {
        energy::check(
            &Drawn { youngs_modulus: None, container: drawn.container.at_rest(), ..drawn.clone() },
            Solves::Usual,
        )
    });
    println!("steps, without a contact that asks to part, of smooth impacts: {counts:?}");
    assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
}

#[test]
fn rigid_grains_gain_energy_from_rebounds_alone_to_rounding_where_solves_converge() {
    let counts = check(scenes(12), |drawn| {
        energy::check(
            &Drawn { youngs_modulus: None, container: drawn.container.at_rest(), ..drawn.clone() },
            Solves::Converged,
        )
    });
    println!("steps, without a contact that asks to part, of smooth impacts: {counts:?}");
    assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
}

#[test]
fn compliant_grains_between_walls_at_rest_gain_the_energy_that_contacts_give_back() {
    let with_modulus = (scenes(30), 6.0..11.0_f64).prop_map(|(drawn, exponent)| Drawn {
        youngs_modulus: Some(10.0_f64.powf(exponent)),
        container: drawn.container.at_rest(),
        ..drawn
    });
    let counts = check(with_modulus, |drawn| energy::check(drawn, Solves::Usual));
    println!("steps, without a contact that asks to part, of smooth impacts: {counts:?}");
    assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
}

fn check_image(image: &Image) {
    let counts = check(scenes(12), |drawn| images::check(drawn, image));
    println!(
        "{}: {counts:?} steps with contacts, with velocities that are unique, known to 1e-5 of the fastest",
        image.name
    );
    assert!(counts[1] > 100 && counts[2] > 10, "{counts:?}");
}

#[test]
fn the_order_of_grains_does_not_matter() {
    check_image(&Image::REVERSED);
}

#[test]
fn a_mirror_image_moves_as_its_original() {
    check_image(&Image::MIRRORED);
}

#[test]
fn a_turned_scene_moves_as_its_original() {
    check_image(&Image::TURNED);
}
