//! Coulomb friction: the tangential impulse is limited to a disc of radius `mu lambda_n`.
//!
//! For two spheres, the tangential operator is isotropic and decoupled from the normal. The projection of the unconstrained
//! impulse onto the disc is therefore the exact solution of the one-contact problem, without a box or a faceted cone.
//!
//! The coefficient of a sliding contact may be smaller than that of a sticking one: Coulomb's `mu_k <= mu_s`. The
//! choice is made at set-up, once per step, from the impulses of the last step and the resulting velocity:
//!
//! ```text
//! mu = mu_k    if |u_t| > g h    and    |lambda_t| = mu_k lambda_n    or    |lambda_t| = mu_s lambda_n
//! mu = mu_s    otherwise
//! ```
//!
//! so that sweeps use one coefficient and a contact needs no more memory. By Coulomb's law, friction is at its limit if a contact
//! slides. A contact with friction below its limit has stuck, whatever its speed after the solve; this holds under any load, also
//! without gravity. A contact at its limit continues to stick while its speed is below g h (g is the largest of the run). For a
//! contact without an earlier impulse, as in an impact, the speed alone decides. A contact at the onset of sliding retains mu_s
//! until its speed exceeds g h: at an acceleration a, after g/a steps. A sliding contact sticks again once friction has reduced
//! its speed below g h. Both effects shrink with h, and the law converges to that of two coefficients.

use super::catalogue::{Call, Change, Effect, change_coefficients};
use super::term::{ContactTerm, NormalLoad, Tangential, TangentialTerm, TermStart};
use crate::lanes::{Eight, Number, dot, times};
use crate::scene::coefficients;

/// Coulomb friction.
pub static FRICTION: Effect = Effect {
    off: Change::off(|scene| {
        change_coefficients(
            scene,
            |one| (one.friction, one.kinetic_friction) = (0.0, None),
            |rule| (rule.friction, rule.kinetic_friction) = (None, None),
        );
    }),
    member: Some(|set| &mut set.friction),
    ..Effect::of_contacts(
        "Coulomb friction",
        coefficients::FRICTION,
        |contact| contact.friction > 0.0,
        "grains are smooth",
    )
};

/// Friction that is smaller for a sliding contact.
pub static KINETIC_FRICTION: Effect = Effect {
    off: Change::off(|scene| {
        change_coefficients(scene, |one| one.kinetic_friction = None, |rule| rule.kinetic_friction = None)
    }),
    member: Some(|set| &mut set.kinetic_friction),
    ..Effect::of_contacts(
        "kinetic friction",
        coefficients::KINETIC_FRICTION,
        |contact| contact.kinetic_friction < contact.friction,
        "friction is the same for what sticks and what slides",
    )
};

/// Spin of grains, present with friction: grains have no other torque.
pub static SPIN: Effect = Effect::of_scene("spin", |scene| match FRICTION.called_by(scene) {
    Ok(call) => Ok(Call { why: "friction turns grains".into(), ..call }),
    Err(_) => Err("without friction nothing turns a grain"),
});

/// Speed (m/s) of a sticking contact due to rounding, for runs without gravity as a reference.
const ROUNDING: f64 = 1e-9;

/// Returns the speed (m/s) above which a contact slides, for a gravity (m/s2) and a step (s).
pub fn slip_speed(gravity: f64, step: f64) -> f64 {
    (gravity * step).max(ROUNDING)
}

/// Relative tolerance of the test for an impulse at the friction limit: rounding, in single precision too.
const AT_THE_LIMIT: f64 = 1e-5;

/// Returns the coefficient of a contact with the tangential velocity `sliding` (m/s). The contact sticks if the velocity is at most `slip`,
/// or if the friction of the last step was not at a limit. `borne` is the normal and tangential impulse of that step, N s.
#[inline(always)]
pub fn while_sliding<N: Number>(sticking: N, kinetic: N, sliding: [N; 3], slip: N, borne: [N; 4]) -> N {
    let [normal, x, y, z] = borne;
    let friction = dot([x, y, z], [x, y, z]);
    let limit = |coefficient: N, side: f64| {
        let limit = coefficient * normal * N::splat(1.0 + side * AT_THE_LIMIT);
        limit * limit
    };
    let none = N::zero();
    let slow = dot(sliding, sliding).at_most(slip * slip);
    // A contact without friction is below the kinetic limit as well, but its state is unknown.
    let below =
        N::select(none.below(friction), N::select(friction.below(limit(kinetic, -1.0)), sticking, kinetic), kinetic);
    let between = N::select(friction.below(limit(sticking, -1.0)), sticking, kinetic);
    let borne = N::select(limit(kinetic, 1.0).below(friction), between, below);
    N::select(slow, sticking, borne)
}

/// Returns the factor that scales the impulse (x, y, z) into a disc of the given radius.
#[inline(always)]
pub fn disc_shrinkage<N: Number>(impulse: [N; 3], radius: N) -> N {
    let square = impulse[0] * impulse[0] + impulse[1] * impulse[1] + impulse[2] * impulse[2];
    let inside = square.at_most(radius * radius);
    // Inside the disc, the quotient may be 0/0; the selection discards the quotient.
    N::select(inside, N::splat(1.0), radius / square.sqrt())
}

/// Friction coefficients and tangential impulses: of eight contacts in memory, of sixteen in single precision, or in a kernel.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct FrictionLanes<S = Eight> {
    /// Friction coefficients.
    pub coefficient: S,
    /// Tangential impulses on the second body, or on the wall, N s.
    pub impulse: [S; 3],
}

impl<S: Copy + Default> Tangential<S> for FrictionLanes<S> {
    #[inline(always)]
    fn lanes(&self) -> Option<&FrictionLanes<S>> {
        Some(self)
    }

    #[inline(always)]
    fn lanes_mut(&mut self) -> Option<&mut FrictionLanes<S>> {
        Some(self)
    }

    #[inline(always)]
    fn fill<N: Number>(&mut self, start: &TermStart<'_, N>, number: impl Fn(N, &mut S)) {
        for (component, lanes) in start.last_impulse.into_iter().zip(&mut self.impulse) {
            number(component * start.share, lanes);
        }
        number(start.friction, &mut self.coefficient);
    }
}

/// Friction in a kernel: its coefficient, or no friction.
#[derive(Clone, Copy)]
pub struct Coulomb<N, const ACTS: bool>(N);

impl<N: Number, const ACTS: bool> ContactTerm<N> for Coulomb<N, ACTS> {
    const ACTS: bool = ACTS;

    #[inline(always)]
    fn project(&self, impulse: [N; 3], (_, normal_impulse): NormalLoad<N>) -> [N; 3] {
        times(impulse, disc_shrinkage(impulse, self.0 * normal_impulse))
    }
}

impl<N: Number, const ACTS: bool> TangentialTerm<N> for Coulomb<N, ACTS> {
    #[inline(always)]
    fn read<S>(lanes: &impl Tangential<S>, number: impl Fn(&S) -> N) -> Self {
        Coulomb(lanes.lanes().map_or(N::zero(), |lanes| number(&lanes.coefficient)))
    }

    #[inline(always)]
    fn coefficient(&self) -> N {
        self.0
    }
}
