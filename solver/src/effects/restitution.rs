//! Coefficients of restitution: the ratio of separation speed to impact speed.
//!
//! The rule for a separation at `e` times the impact speed: [`impact`](super::impact).
//!
//! The restitution of plastically deformed grains decreases with the impact speed: `e ~ v^(-1/4)` (Johnson, Contact Mechanics, 1985, 11.4,
//! for spheres with predominantly plastic deformation). With a speed `v_y` up to which restitution is that of the material,
//!
//! ```text
//! e(v) = e                        v <= v_y
//! e(v) = e (v_y / v)^(1/4)        v >  v_y
//! ```
//!
//! with v the normal speed of the impact. This law applies to impacts that end within a step. If the step resolves a
//! compliant impact, its damping gives the restitution, the same at any speed. Scenes with both are rejected.

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

/// Restitution that decreases with the impact speed.
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

/// Returns the bias (m/s) of the impact of a grain on a wall that the grain would pass within the step. The grain separates at `-e u_n0`
/// or, if that is below the threshold, reaches the wall at the end of the step. `gap` in m, `velocity` in m/s, negative in approach.
pub fn impact_on_the_way(scheme: &NormalScheme, gap: f64, velocity: f64, restitution: f64) -> f64 {
    let rebound = -restitution * velocity;
    if rebound > scheme.restitution_threshold { rebound } else { -gap / scheme.step }
}

/// Returns the restitution of an impact at a speed (m/s): constant up to the `limit`, above it decreasing as the fourth
/// root. The two square roots are correctly rounded on every platform.
#[inline(always)]
pub fn at_speed<N: Number>(restitution: N, limit: N, speed: N) -> N {
    N::select(limit.below(speed), restitution * (limit / speed).sqrt().sqrt(), restitution)
}
