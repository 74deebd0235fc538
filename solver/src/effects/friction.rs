//! Coulomb friction: the tangential impulse stays in a disc of radius `mu lambda_n`.
//!
//! For two spheres the tangential operator is isotropic and does not couple with the normal, so the projection of the
//! unconstrained impulse onto the disc is the exact solution of the one-contact problem: no box, no cone of facets.
//!
//! A contact that slides may have a smaller coefficient than one that sticks: Coulomb's `mu_k <= mu_s`. Which of the two it has is
//! decided when it is set up, once a step,
//!
//! ```text
//! mu = mu_k    if |u_t| > g h    with u_t at the start of the step
//! mu = mu_s    otherwise
//! ```
//!
//! so that sweeps know one coefficient and a contact takes no more memory. A contact that stuck in the last step has no speed but
//! what the solve left open, which is measured in g h (g is the largest of the run). So a contact that slides sticks again
//! once friction has slowed it below g h, and one that begins to slide keeps mu_s until its speed is above g h: at an
//! acceleration a that takes g/a steps. Both shrink with h, and the law becomes that of two coefficients. A solve that
//! leaves more than g h open takes sticking contacts for sliding ones.

use crate::lanes::{Number, dot};

/// Speed (m/s) that rounding may leave to a contact that sticks, where there is no gravity to compare with.
const ROUNDING: f64 = 1e-9;

/// Speed above which a contact slides, m/s, for a gravity (m/s2) and a step (s).
pub fn slip_speed(gravity: f64, step: f64) -> f64 {
    (gravity * step).max(ROUNDING)
}

/// Coefficient of a contact that slides with the tangential velocity `sliding` (m/s), or sticks if that is no more than `slip`.
#[inline(always)]
pub fn while_sliding<N: Number>(sticking: N, kinetic: N, sliding: [N; 3], slip: N) -> N {
    N::select((slip * slip).below(dot(sliding, sliding)), kinetic, sticking)
}

/// Factor by which the impulse (x, y, z) must shrink to lie in a disc of the given radius.
#[inline(always)]
pub fn disc_shrinkage<N: Number>(impulse: [N; 3], radius: N) -> N {
    let square = impulse[0] * impulse[0] + impulse[1] * impulse[1] + impulse[2] * impulse[2];
    let inside = square.at_most(radius * radius);
    // Where it lies inside, the quotient may be 0/0; the selection leaves it out.
    N::select(inside, N::splat(1.0), radius / square.sqrt())
}
