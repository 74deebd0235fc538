//! Sources of the energy of a step.
//!
//! A step takes velocities from v to `v_f = v + h g`, then by impulses to v', and moves grains by h v'. With
//! `v' = v_f + M^-1 G' lambda` the kinetic and potential energy E changes by exactly
//!
//! ```text
//! E' - E = sum lambda . u'  -  |v' - v|_M^2 / 2                u' = relative velocity at a contact after the step
//! ```
//!
//! as `E' - E = <v' - v, v' + v>_M / 2 - <h g, v'>_M` and `v' - v - h g = M^-1 G' lambda`. Without contacts a step of free fall loses
//! `m h^2 g^2 / 2`.
//!
//! In the sum, `lambda_n u_n'` is `lambda_n asked` by the normal law, where `asked` is the velocity at which the law lets the
//! contact open; Coulomb's law makes the rest `-mu lambda_n |u_t'|`. Where a solve misses the laws, the change is off by no more
//! than the slacks of its contacts, which are residuals times impulses (`Touch::normal_slack`, `friction_slack`). So
//!
//! - a step in which no bearing contact asks for a separation gains nothing, whatever the friction and however many contacts
//!   press at once: rigid contacts that do not rebound only take energy;
//! - Newton's restitution asks for `-e u_n`, stabilisation for a part of the overlap, and a compliant contact gives back what it
//!   stored: these are the sources of energy. Each alone gives no more than it took; together they may. With e = 1, let A hit
//!   B at 1 m/s while B and C, in touch, part at 0.04 m/s, slower than an impact: the resting contact of B and C bears while it
//!   opens, does work, and energy grows. The law of impacts says so (as does Kane's paradox with friction), not the solve;
//! - without friction, and taken half a step earlier (at `x - h v / 2`, so that free fall keeps it), energy changes by
//!   `sum lambda_n (u_n + u_n') / 2` with u before gravity: it grows in no step whose bearing contacts all approach at least as
//!   fast as they are asked to part.

use super::contacts::{INERTIA, Laws, ROUNDING, Stepped, Touch, step};
use super::scene::{Drawn, Solves};
use makadam::snapshot::Snapshot;
use nalgebra::Vector3;
use proptest::prelude::*;

type Vector = Vector3<f64>;

/// Steps of a run.
const STEPS: usize = 200;

/// Kinetic energy of velocities and spins, or of their differences from those of `then`, J.
fn kinetic(laws: &Laws, now: &Snapshot, then: Option<&Snapshot>) -> f64 {
    let energy = |grain: usize| {
        let particle = &now.particles[grain];
        let (mut velocity, mut spin) = (Vector::from(particle.velocity), Vector::from(particle.spin));
        if let Some(then) = then {
            velocity -= Vector::from(then.particles[grain].velocity);
            spin -= Vector::from(then.particles[grain].spin);
        }
        0.5 * laws.mass(grain) * (velocity.norm_squared() + INERTIA * (spin * particle.radius).norm_squared())
    };
    (0..now.particles.len()).map(energy).sum()
}

/// Potential energy, and the sum of its terms' magnitudes, J.
fn potential(laws: &Laws, drawn: &Drawn, snapshot: &Snapshot) -> (f64, f64) {
    let terms = snapshot.particles.iter().enumerate().map(|(grain, particle)| {
        let place = Vector::from(particle.position);
        (-laws.mass(grain) * drawn.gravity.dot(&place), laws.mass(grain) * drawn.gravity.norm() * place.norm())
    });
    terms.fold((0.0, 0.0), |(sum, size), (term, magnitude)| (sum + term, size + magnitude))
}

/// Counts the steps, those without a contact that asks for a separation, and those without friction whose contacts all take.
pub fn check(drawn: &Drawn, solves: Solves) -> Result<[u64; 3], TestCaseError> {
    assert!(!drawn.container.moves(), "walls at rest do no work");
    let laws = Laws::new(drawn, &drawn.scene(solves));
    let mut simulation = drawn.start(solves);
    let (h, g) = (drawn.step, drawn.gravity);
    let mut counts = [0; 3];
    for number in 0..STEPS {
        let Stepped { before, after, touches, inexact, struck, .. } = step(&mut simulation, &laws);
        let bearing: Vec<&Touch> = touches.iter().filter(|touch| touch.along > 0.0).collect();
        // The place and the normal at which a fast grain meets a wall on its way are not those of the snapshot.
        if bearing.is_empty() || struck > 0 || bearing.iter().any(|touch| touch.law.is_none()) {
            continue;
        }
        let (early, late) = (potential(&laws, drawn, &before), potential(&laws, drawn, &after));
        let speeds = [kinetic(&laws, &before, None), kinetic(&laws, &after, None)];
        let gain = speeds[1] - speeds[0] + late.0 - early.0;
        // What the laws say.
        let taken = kinetic(&laws, &after, Some(&before));
        // A grain that meets a wall on its way gives what it gives: its law is that of `impact.rs`.
        let given = |touch: &&Touch| touch.along * touch.asked().unwrap_or_else(|| touch.opening());
        let rubbed = |touch: &&Touch| drawn.friction * touch.along * touch.sliding().norm();
        let law = bearing.iter().map(given).sum::<f64>() - bearing.iter().map(rubbed).sum::<f64>() - taken;
        // How far the solve may be off, either way: impulses beyond the gap velocity they should end at, and the slacks.
        let slack = |touch: &&Touch| touch.normal_slack(inexact) + touch.friction_slack(drawn.friction, inexact);
        let (above, below) = (
            bearing.iter().map(slack).sum::<f64>(),
            bearing.iter().map(|touch| touch.along * inexact.normal).sum::<f64>(),
        );
        let work = |touch: &&Touch| {
            let size = touch.along + touch.tangential.norm();
            size * (touch.before.norm() + touch.after.norm() + g.norm() * h)
        };
        let size = speeds[0] + speeds[1] + early.1 + late.1 + taken + bearing.iter().map(work).sum::<f64>();
        let rounding = ROUNDING * size;
        prop_assert!(
            gain <= law + above + rounding && gain >= law - below - rounding,
            "step {number}: {gain:e} J gained, {law:e} by the laws, {above:e} more or {below:e} less by the solve, \
             {rounding:e} by rounding"
        );
        counts[0] += 1;
        // Nothing asks for a separation: nothing is gained.
        if bearing.iter().all(|touch| touch.asked().is_some_and(|asked| asked <= 0.0)) {
            prop_assert!(
                gain <= above + rounding,
                "step {number}: {gain:e} J gained, {above:e} J by the solve at most"
            );
            counts[1] += 1;
        }
        // Smooth contacts that all come at least as fast as they may go: nothing is gained.
        let takes = |touch: &&Touch| touch.asked().is_some_and(|asked| touch.normal.dot(&touch.before) + asked <= 0.0);
        if drawn.friction == 0.0 && bearing.iter().all(takes) {
            let momentum = |snapshot: &Snapshot| {
                let own = snapshot.particles.iter().enumerate();
                own.map(|(grain, particle)| Vector::from(particle.velocity) * laws.mass(grain)).sum::<Vector>()
            };
            let half = gain + 0.5 * h * g.dot(&(momentum(&after) - momentum(&before)));
            prop_assert!(
                half <= above + rounding,
                "step {number}: {half:e} J gained, {above:e} J by the solve at most"
            );
            counts[2] += 1;
        }
    }
    Ok(counts)
}
