//! Restitution of impacts: Newton's law, in the same solve as everything else.
//!
//! A contact that approaches faster than a threshold must leave at `e` times its approach speed: its bias becomes
//! `q = max(q, -e u_n0)` (Lacoursière 2007, 10.31, without a separate impact stage). Below the threshold a contact is
//! a resting one. A compliant contact whose impact the step resolves needs none of this: its damping gives the
//! restitution. Where the step does not resolve it, the impact is over within the step, so it is as stiff as a rigid one.

use super::compliance::NormalConstraint;
use crate::scene::NormalLaw;

/// Applies restitution to a contact's constraint; `None` where the contact needs no constraint in this step.
///
/// `overlap` in m, `velocity` and `threshold` in m/s, `h` in s. A rigid contact has no elastic energy that an overlap could
/// give back, so there stabilisation must not push: an impact leaves at `-e u_n0` exactly, a contact that already
/// separates is left alone, and a resting one recovers its overlap no faster than the threshold. Across a gap only a
/// slow approach is stopped, at touch; a fast one becomes an impact once the two overlap.
#[inline]
pub fn with_restitution(
    constraint: NormalConstraint,
    law: NormalLaw,
    overlap: f64,
    velocity: f64,
    restitution: f64,
    threshold: f64,
    h: f64,
) -> Option<NormalConstraint> {
    let impact = velocity < -threshold;
    match law {
        NormalLaw::Rigid if overlap < 0.0 => {
            let resting = !impact && velocity <= threshold;
            resting.then_some(NormalConstraint { bias: overlap / h, ..constraint })
        }
        NormalLaw::Rigid if impact => Some(NormalConstraint { bias: -restitution * velocity, ..constraint }),
        NormalLaw::Rigid if velocity > threshold => None,
        NormalLaw::Rigid => Some(NormalConstraint { bias: constraint.bias.min(threshold), ..constraint }),
        _ if impact && !constraint.resolves_impact => {
            let bias = constraint.bias.max(-restitution * velocity);
            Some(NormalConstraint { bias, regularisation: 0.0, ..constraint })
        }
        _ => Some(constraint),
    }
}
