//! Coefficients of restitution: the share of its speed that an impact gives back.
//!
//! The rule by which a contact leaves at `e` times the speed of its impact: [`impact`](super::impact).
//!
//! Grains that yield give back less the faster they meet: `e ~ v^(-1/4)` (Johnson, Contact Mechanics, 1985, 11.4, for spheres that
//! are plastic in the main). With a speed `v_y` up to which restitution is the material's,
//!
//! ```text
//! e(v) = e                        v <= v_y
//! e(v) = e (v_y / v)^(1/4)        v >  v_y
//! ```
//!
//! with v the speed of the impact along the normal. This goes with impacts that are over within a step. Where the step resolves a
//! compliant impact, its damping gives the restitution, the same at any speed. Scenes that ask for both are refused.

use super::catalogue::{Change, Effect, change_coefficients};
use crate::lanes::Number;
use crate::laws::compliance::NormalScheme;
use crate::scene::coefficients;

/// Restitution.
pub static RESTITUTION: Effect = Effect {
    off: Change::off(|scene| change_coefficients(scene, |one| one.restitution = 0.0, |rule| rule.restitution = None)),
    ..Effect::of_contacts(
        "restitution",
        coefficients::RESTITUTION,
        |contact| contact.restitution > 0.0,
        "impacts are inelastic",
    )
};

/// Restitution that falls with the speed of impact.
pub static FALLING_RESTITUTION: Effect = Effect {
    off: Change::off(|scene| {
        change_coefficients(scene, |one| one.restitution_speed = None, |rule| rule.restitution_speed = None)
    }),
    member: Some(|set| &mut set.falling_restitution),
    ..Effect::of_contacts(
        "falling restitution",
        coefficients::FALLING_RESTITUTION,
        |contact| contact.restitution_speed.is_finite(),
        "restitution is the same at any speed",
    )
};

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
