//! Restitution of impacts: Newton's law, in the same solve as everything else.
//!
//! A contact that approaches faster than a threshold must leave at `e` times its approach speed: its bias becomes
//! `q = max(q, -e u_n0)` (Lacoursière 2007, 10.31, without a separate impact stage). Below the threshold a contact is
//! a resting one. A compliant contact whose impact the step resolves needs none of this: its damping gives the
//! restitution. Where the step does not resolve it, the impact is over within the step, so it is as stiff as a rigid one.

use super::compliance::NormalConstraint;
use crate::lanes::Number;
use crate::scene::NormalLaw;

/// Bias of a contact that must bear nothing, m/s: no contact separates as fast as that.
const OUT_OF_TOUCH: f64 = -1e30;

/// Applies restitution to a contact's constraint.
///
/// `overlap` in m, `velocity` and `threshold` in m/s, `h` in s. A rigid contact has no elastic energy that an overlap could
/// give back, so there stabilisation must not push: an impact leaves at `-e u_n0` exactly, a contact that already
/// separates bears nothing, and a resting one recovers its overlap no faster than the threshold. Across a gap only a
/// slow approach is stopped, at touch; a fast one becomes an impact once the two overlap.
#[inline(always)]
pub fn with_restitution<N: Number>(
    constraint: NormalConstraint<N>,
    law: NormalLaw,
    overlap: N,
    velocity: N,
    restitution: N,
    threshold: f64,
    h: f64,
) -> NormalConstraint<N> {
    let threshold = N::splat(threshold);
    let impact = velocity.below(-threshold);
    let rebound = -restitution * velocity;
    match law {
        NormalLaw::Rigid => {
            let (never, separates) = (N::splat(OUT_OF_TOUCH), threshold.below(velocity));
            let resting = N::select(separates, never, constraint.bias.smaller(threshold));
            let touching = N::select(impact, rebound, resting);
            let across = N::select(!impact & !separates, overlap / N::splat(h), never);
            NormalConstraint { bias: N::select(overlap.below(N::zero()), across, touching), ..constraint }
        }
        _ => {
            let unresolved = impact & !constraint.resolves_impact;
            NormalConstraint {
                bias: N::select(unresolved, constraint.bias.larger(rebound), constraint.bias),
                regularisation: N::select(unresolved, N::zero(), constraint.regularisation),
                ..constraint
            }
        }
    }
}

/// Whether a contact may bear something in this step.
#[inline(always)]
pub fn bears<N: Number>(constraint: &NormalConstraint<N>) -> N::Mask {
    N::splat(OUT_OF_TOUCH).below(constraint.bias)
}
