//! Coulomb friction: the tangential impulse stays in a disc of radius `mu lambda_n`.
//!
//! For two spheres the tangential operator is isotropic and does not couple with the normal, so the projection of the
//! unconstrained impulse onto the disc is the exact solution of the one-contact problem: no box, no cone of facets.
//!
//! A contact that slides may have a smaller coefficient than one that sticks: Coulomb's `mu_k <= mu_s`. Which of the two it has is
//! decided when it is set up, once a step, from the impulses of the last step and the velocity that this has left:
//!
//! ```text
//! mu = mu_k    if |u_t| > g h    and    |lambda_t| = mu_k lambda_n    or    |lambda_t| = mu_s lambda_n
//! mu = mu_s    otherwise
//! ```
//!
//! so that sweeps know one coefficient and a contact takes no more memory. By Coulomb's law friction is at its limit where a contact slides.
//! A contact whose friction was below its limit has stuck, whatever speed the solve left it; this holds under any load, without gravity too.
//! A contact at its limit sticks on as long as it is slower than g h (g is the largest of the run). Of a contact that has borne nothing yet,
//! as in an impact, only the speed is known, and it decides. A contact that begins to slide keeps mu_s until its speed is above g h: at an
//! acceleration a that takes g/a steps. One that slides sticks again once friction has slowed it below g h. Both shrink with h, and the law
//! becomes that of two coefficients.

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

/// Friction that is less while a contact slides.
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

/// Spin of grains: it goes with friction, since nothing else turns a grain.
pub static SPIN: Effect = Effect::of_scene("spin", |scene| match FRICTION.called_by(scene) {
    Ok(call) => Ok(Call { why: "friction turns grains".into(), ..call }),
    Err(_) => Err("without friction nothing turns a grain"),
});

/// Speed (m/s) that rounding may leave to a contact that sticks, where there is no gravity to compare with.
const ROUNDING: f64 = 1e-9;

/// Speed above which a contact slides, m/s, for a gravity (m/s2) and a step (s).
pub fn slip_speed(gravity: f64, step: f64) -> f64 {
    (gravity * step).max(ROUNDING)
}

/// Share of a limit of friction by which an impulse at the limit may differ from it: rounding, in single precision too.
const AT_THE_LIMIT: f64 = 1e-5;

/// Coefficient of a contact that slides with the tangential velocity `sliding` (m/s), or sticks: if that is no more than `slip`, or if the
/// friction that it bore in the last step was not at a limit. `borne` is its normal and tangential impulse then, N s.
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
    // One that bears no friction is below the kinetic limit as well, but nothing is known of it.
    let below =
        N::select(none.below(friction), N::select(friction.below(limit(kinetic, -1.0)), sticking, kinetic), kinetic);
    let between = N::select(friction.below(limit(sticking, -1.0)), sticking, kinetic);
    let borne = N::select(limit(kinetic, 1.0).below(friction), between, below);
    N::select(slow, sticking, borne)
}

/// Factor by which the impulse (x, y, z) must shrink to lie in a disc of the given radius.
#[inline(always)]
pub fn disc_shrinkage<N: Number>(impulse: [N; 3], radius: N) -> N {
    let square = impulse[0] * impulse[0] + impulse[1] * impulse[1] + impulse[2] * impulse[2];
    let inside = square.at_most(radius * radius);
    // Where it lies inside, the quotient may be 0/0; the selection leaves it out.
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

/// Friction in a kernel, by its coefficient, or none.
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
