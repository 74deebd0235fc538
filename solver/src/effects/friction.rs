//! Coulomb friction: the tangential impulse stays in a disc of radius `mu lambda_n`.
//!
//! For two spheres the tangential operator is isotropic and does not couple with the normal, so the projection of the
//! unconstrained impulse onto the disc is the exact solution of the one-contact problem: no box, no cone of facets.

use crate::lanes::Number;

/// Factor by which the impulse (x, y, z) must shrink to lie in a disc of the given radius.
#[inline(always)]
pub fn disc_shrinkage<N: Number>(impulse: [N; 3], radius: N) -> N {
    let square = impulse[0] * impulse[0] + impulse[1] * impulse[1] + impulse[2] * impulse[2];
    let inside = square.at_most(radius * radius);
    // Where it lies inside, the quotient may be 0/0; the selection leaves it out.
    N::select(inside, N::splat(1.0), radius / square.sqrt())
}
