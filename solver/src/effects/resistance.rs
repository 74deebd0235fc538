//! Resistance to rolling and twisting: torques that oppose the relative rotation of two grains.
//!
//! A contact exerts an angular impulse `T` (N m s) on its second side and `-T` on its first. With the relative angular
//! velocity `w = omega_b - omega_a` and the rotational operator `S_r = 1/I_a + 1/I_b`, the impulse is, as for friction,
//! the projection of the impulse that would stop the rotation,
//!
//! ```text
//! T*     = T - w / S_r
//! T_roll = T* in the tangent plane, in a disc of radius mu_r R* lambda_n
//! T_spin = T* along the normal, between -mu_t R* lambda_n and mu_t R* lambda_n
//! ```
//!
//! with the effective radius `R* = r_a r_b / (r_a + r_b)`, the grain's radius at a wall. The rolling torque of at most
//! `mu_r R* F_n` is that of models B and C of Ai, Chen, Rotter & Ooi, Powder Technology 206 (2011). A smaller torque,
//! without a spring and its parameters, holds a grain at rest. Rolling and twisting are decoupled: the inertia of a
//! sphere is the same about every axis, so neither changes the other, nor the normal velocity at the contact.

use super::catalogue::{Change, Effect, change_coefficients};
use super::friction::disc_shrinkage;
use super::term::{ContactTerm, NormalLoad, TorqueTerm};
use crate::lanes::{Eight, Number, dot, minus, plus, times};
use crate::scene::{ContactCoefficients, coefficients};

/// Descriptor of a rolling or twisting resistance with the coefficient of a key.
macro_rules! resistance {
    ($name:literal, $entry:ident, $coefficient:ident, $member:ident, $without:literal) => {
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
            ..Effect::of_contacts($name, coefficients::$entry, |contact| contact.$coefficient > 0.0, $without)
        }
    };
}

/// Resistance to rolling.
pub static ROLLING: Effect =
    resistance!("rolling resistance", ROLLING, rolling_friction, rolling, "grains roll without a torque");
/// Resistance to twisting.
pub static TWISTING: Effect =
    resistance!("twisting resistance", TWISTING, twisting_friction, twisting, "grains twist without a torque");

/// Levers and angular impulses of eight contacts.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct TorqueLanes {
    /// Largest rolling torque over the normal force, m.
    pub rolling_lever: Eight,
    /// Largest twisting torque over the normal force, m.
    pub twisting_lever: Eight,
    /// Angular impulses on the second body, or on the wall, N m s.
    pub impulse: [Eight; 3],
}

impl TorqueLanes {
    /// Sets up a lane for a step: coefficients of the contact, effective radius (m), angular impulse of the warm start (N m s).
    pub(crate) fn fill(&mut self, lane: usize, contact: &ContactCoefficients, effective_radius: f64, start: [f64; 3]) {
        self.rolling_lever.0[lane] = contact.rolling_friction * effective_radius;
        self.twisting_lever.0[lane] = contact.twisting_friction * effective_radius;
        self.impulse.iter_mut().zip(start).for_each(|(own, component)| own.0[lane] = component);
    }

    /// Returns the angular impulse of the contact in a lane, N m s.
    pub fn angular_impulse(&self, lane: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.impulse[axis].0[lane])
    }
}

/// Resistances of a compiled kernel with their levers (m); each is optional.
#[derive(Clone, Copy)]
pub struct Resistance<N, const ROLLING: bool, const TWISTING: bool>(N, N);

impl<N: Number, const ROLLING: bool, const TWISTING: bool> ContactTerm<N> for Resistance<N, ROLLING, TWISTING> {
    const ACTS: bool = ROLLING || TWISTING;

    #[inline(always)]
    fn project(&self, impulse: [N; 3], (normal, normal_impulse): NormalLoad<N>) -> [N; 3] {
        let (rolling_cap, twisting_cap) = (self.0 * normal_impulse, self.1 * normal_impulse);
        // Normal and tangential parts, projected separately.
        let along = dot(normal, impulse);
        let across = minus(impulse, times(normal, along));
        let mut borne = [N::zero(); 3];
        if ROLLING {
            borne = times(across, disc_shrinkage(across, rolling_cap));
        }
        if TWISTING {
            borne = plus(borne, times(normal, along.larger(-twisting_cap).smaller(twisting_cap)));
        }
        borne
    }
}

impl<N: Number, const ROLLING: bool, const TWISTING: bool> TorqueTerm<N> for Resistance<N, ROLLING, TWISTING> {
    #[inline(always)]
    fn read(lanes: &TorqueLanes, number: impl Fn(&Eight) -> N) -> Self {
        Resistance(number(&lanes.rolling_lever), number(&lanes.twisting_lever))
    }
}
