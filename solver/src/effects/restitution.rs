//! Restitution of impacts: Newton's law, in the same solve as everything else.
//!
//! A contact that approaches faster than a threshold must leave at `e` times its approach speed: its bias becomes
//! `q = max(q, -e u_n0)` (Lacoursière 2007, 10.31, without a separate impact stage); where the first is larger, the contact
//! keeps its compliance. Below the threshold a contact is a resting one. A compliant contact whose impact the step resolves
//! needs none of this: its damping gives the restitution. Where the step does not resolve it, the impact is over within the
//! step, so it is as stiff as a rigid one.
//!
//! Grains that yield give back less the faster they meet: `e ~ v^(-1/4)` (Johnson, Contact Mechanics, 1985, 11.4, for spheres that
//! are plastic in the main). With a speed `v_y` up to which restitution is the material's,
//!
//! ```text
//! e(v) = e                        v <= v_y
//! e(v) = e (v_y / v)^(1/4)        v >  v_y
//! ```
//!
//! with v the speed of approach along the normal at the start of the step. This goes with impacts that are over within a step.
//! Where the step resolves a compliant impact, its damping gives the restitution, the same at any speed: the speed with which
//! an impact began is not known any more in its later steps. Scenes that ask for both are refused.

use super::catalogue::{Absent, Change, Coefficient, Combination, Effect, SMALLER, Trigger, change_coefficients};
use super::compliance::{NormalConstraint, NormalLaw, NormalScheme};
use crate::lanes::Number;
use crate::scene::Material;

/// Restitution.
pub static RESTITUTION: Effect = Effect {
    name: "restitution",
    coefficients: &[Coefficient {
        key: "restitution",
        unit: "(no unit)",
        range: [0.0, 1.0],
        ceiling: None,
        absent: Absent::Refused,
        off: Some(0.0),
        of_material: |one| Some(one.restitution),
        of_rule: |rule| rule.restitution,
    }],
    combination: Some(Combination {
        words: SMALLER,
        combine: |pair, contact| contact.restitution = pair.value(|rule| rule.restitution, |one| one.restitution),
    }),
    trigger: Trigger::Contacts { acts: |contact| contact.restitution > 0.0, without: "impacts are inelastic" },
    off: Some(Change {
        words: "off",
        apply: |scene| change_coefficients(scene, |one| one.restitution = 0.0, |rule| rule.restitution = None),
    }),
    tried: None,
    member: None,
};

/// Restitution that falls with the speed of impact.
pub static FALLING_RESTITUTION: Effect = Effect {
    name: "falling restitution",
    coefficients: &[Coefficient {
        key: "restitution_speed",
        unit: "m/s",
        range: [1e-6, 1e6],
        ceiling: None,
        absent: Absent::Off,
        off: None,
        of_material: |one| one.restitution_speed,
        of_rule: |rule| rule.restitution_speed,
    }],
    combination: Some(Combination {
        words: SMALLER,
        combine: |pair, contact| {
            let of_material = |one: &Material| one.restitution_speed.unwrap_or(f64::INFINITY);
            contact.restitution_speed = pair.value(|rule| rule.restitution_speed, of_material);
        },
    }),
    trigger: Trigger::Contacts {
        acts: |contact| contact.restitution_speed.is_finite(),
        without: "restitution is the same at any speed",
    },
    off: Some(Change {
        words: "off",
        apply: |scene| {
            change_coefficients(scene, |one| one.restitution_speed = None, |rule| rule.restitution_speed = None);
        },
    }),
    tried: None,
    member: Some(|set| &mut set.falling_restitution),
};

/// Bias of a contact that must bear nothing, m/s: no contact separates as fast as that.
const OUT_OF_TOUCH: f64 = -1e30;

/// Applies restitution to a contact's constraint.
///
/// `overlap` in m, `velocity` in m/s. A rigid contact has no elastic energy that an overlap could give back, so there
/// stabilisation must not push: an impact leaves at `-e u_n0` exactly, a contact that already separates bears nothing, and a
/// resting one recovers its overlap no faster than the threshold. Across a gap only a slow approach is stopped, at touch; a
/// fast one becomes an impact once the two overlap. A compliant contact whose impact the step resolves bears nothing across a
/// gap.
#[inline(always)]
pub fn with_restitution<N: Number>(
    constraint: NormalConstraint<N>,
    scheme: &NormalScheme,
    overlap: N,
    velocity: N,
    restitution: N,
) -> NormalConstraint<N> {
    let threshold = N::splat(scheme.restitution_threshold);
    let (never, separates) = (N::splat(OUT_OF_TOUCH), threshold.below(velocity));
    let impact = velocity.below(-threshold);
    let rebound = -restitution * velocity;
    // A contact that is pushed apart faster than it would rebound bears a load, or is deep: its compliance must go on telling how
    // much, or the overlap would become speed.
    let unresolved = impact & !constraint.resolves_impact & constraint.bias.below(rebound);
    let (touching, regularisation) = match scheme.law {
        NormalLaw::Rigid => {
            let resting = N::select(separates, never, constraint.bias.smaller(threshold));
            (N::select(impact, rebound, resting), constraint.regularisation)
        }
        _ => (
            N::select(unresolved, rebound, constraint.bias),
            N::select(unresolved, N::zero(), constraint.regularisation),
        ),
    };
    let stopped = !impact & !separates & !constraint.resolves_impact;
    let across = N::select(stopped, overlap / N::splat(scheme.step), never);
    NormalConstraint { bias: N::select(overlap.below(N::zero()), across, touching), regularisation, ..constraint }
}

/// Bias of the impact of a grain on a wall that it would pass within the step, m/s: it leaves at `-e u_n0`, or, if that is
/// slower than the threshold, it reaches the wall at the end of the step. `gap` in m, `velocity` in m/s, negative in approach.
pub fn impact_on_the_way(scheme: &NormalScheme, gap: f64, velocity: f64, restitution: f64) -> f64 {
    let rebound = -restitution * velocity;
    if rebound > scheme.restitution_threshold { rebound } else { -gap / scheme.step }
}

/// Restitution of an impact at a speed (m/s): the material's up to the `limit`, beyond it falling as the fourth root. Two square
/// roots, which are rounded alike everywhere.
#[inline(always)]
pub fn at_speed<N: Number>(restitution: N, limit: N, speed: N) -> N {
    N::select(limit.below(speed), restitution * (limit / speed).sqrt().sqrt(), restitution)
}

/// Whether a contact may bear something in this step.
#[inline(always)]
pub fn bears<N: Number>(constraint: &NormalConstraint<N>) -> N::Mask {
    N::splat(OUT_OF_TOUCH).below(constraint.bias)
}
