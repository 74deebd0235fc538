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
