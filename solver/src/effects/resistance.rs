//! Resistance to rolling and to twisting: torques that keep two grains from turning against each other.
//!
//! A contact bears an angular impulse `T` (N m s) on its second side and `-T` on its first. With the relative angular velocity
//! `w = omega_b - omega_a` and the rotational operator `S_r = 1/I_a + 1/I_b` it is, as for friction, the projection of the impulse
//! that would stop the turning,
//!
//! ```text
//! T*     = T - w / S_r
//! T_roll = T* in the tangent plane, in a disc of radius mu_r R* lambda_n
//! T_spin = T* along the normal, between -mu_t R* lambda_n and mu_t R* lambda_n
//! ```
//!
//! with the effective radius `R* = r_a r_b / (r_a + r_b)`, that of the grain at a wall. The torque at most `mu_r R* F_n` against
//! rolling is that of the models B and C of Ai, Chen, Rotter & Ooi, Powder Technology 206 (2011); a grain at rest is held by
//! the smaller torque that it takes, without a spring that would have to be tuned. Rolling and twisting are apart: the inertia
//! of a sphere is the same about every axis, so neither changes the other, nor the velocity at the contact along the normal.

use super::Effects;
use super::catalogue::{Absent, Change, Coefficient, Effect, change_coefficients};
use super::friction::disc_shrinkage;
use crate::lanes::{Number, dot, minus, plus, times};

/// Descriptor of a resistance to turning by the coefficient of a key.
macro_rules! resistance {
    ($name:literal, $coefficient:ident, $member:ident, $without:literal) => {
        Effect {
            off: Change::off(|scene| {
                change_coefficients(scene, |one| one.$coefficient = 0.0, |rule| rule.$coefficient = None)
            }),
            tried: Some(Change {
                words: "on: 0.1",
                apply: |scene| {
                    change_coefficients(scene, |one| one.$coefficient = 0.1, |rule| rule.$coefficient = None)
                },
            }),
            member: Some(|set| &mut set.$member),
            ..Effect::of_contacts(
                $name,
                &[Coefficient {
                    absent: Absent::Value(0.0),
                    off: Some(0.0),
                    ..Coefficient::new(
                        stringify!($coefficient),
                        "(no unit)",
                        [0.0, 1e9],
                        |one| Some(one.$coefficient),
                        |rule| rule.$coefficient,
                    )
                }],
                |pair, contact| contact.$coefficient = pair.value(|rule| rule.$coefficient, |one| one.$coefficient),
                |contact| contact.$coefficient > 0.0,
                $without,
            )
        }
    };
}

/// Resistance to rolling.
pub static ROLLING: Effect =
    resistance!("rolling resistance", rolling_friction, rolling, "grains roll without a torque");
/// Resistance to twisting.
pub static TWISTING: Effect =
    resistance!("twisting resistance", twisting_friction, twisting, "grains twist without a torque");

/// Projects an angular impulse onto what a contact can bear; `rolling_cap` and `twisting_cap` in N m s.
#[inline(always)]
pub(crate) fn bearable<E: Effects, N: Number>(
    impulse: [N; 3],
    normal: [N; 3],
    rolling_cap: N,
    twisting_cap: N,
) -> [N; 3] {
    let along = dot(normal, impulse);
    let across = minus(impulse, times(normal, along));
    let mut borne = [N::zero(); 3];
    if E::ROLLING {
        borne = times(across, disc_shrinkage(across, rolling_cap));
    }
    if E::TWISTING {
        borne = plus(borne, times(normal, along.larger(-twisting_cap).smaller(twisting_cap)));
    }
    borne
}
