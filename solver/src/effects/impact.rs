//! Impacts: one decision each, at first touch, kept until the two separate.
//!
//! An impact begins in the step in which two that approach overlap for the first time. The speed v0 at which they do decides how it is
//! computed and what restitution e it has:
//!
//! - **resolved** by the step, if a contact of its stiffness takes enough steps for it ([`NormalContact::constraint`]): compliance and
//!   damping give the rebound;
//! - **unresolved** elsewhere: Newton's law makes it leave at `e v0` within the step, as stiff as a rigid one. Slower approaches than
//!   the restitution threshold are no impacts then, but contacts at rest.
//!
//! In steps that are long against the contact, the two leave at `w = e v0` and no faster, at whatever phase of the step they met. What
//! such a step adds, by an overlap that nothing has worked for, or by a force that ends late, would push them apart at up to the
//! speed of the approach. So in the steps after the first the bias is at most that with which the contact leaves at w,
//!
//! ```text
//! q <- min(q, w + Sigma'/S (w - u))         u = u_n0 + (u_n0 - u_n0' - S lambda')
//! ```
//!
//! where u is the velocity that the two would have without the contact if all else acted on them as in the last step, in which they
//! had the velocity `u_n0'` and the impulse `lambda'`. A contact that bears a load keeps its compliance, since the load makes u smaller;
//! one that nothing holds leaves at w. The contact stays as compliant as it is and pushes no harder than without the rule, so that it
//! creates no energy, and the contact problem of a step keeps its form for every method that solves it.
//!
//! An impact ends when the two separate, or when they rest on each other: where they approach again without having been apart, which
//! two that nothing else touches never do; where the step resolved it, once they store twice the energy that the impact brought, which
//! only a load can give them; elsewhere as soon as compliance has taken over. What then happens to the contact happens to a contact at
//! rest.
//!
//! [`NormalContact::constraint`]: super::compliance::NormalContact::constraint

use crate::lanes::Number;
use crate::laws::compliance::{NormalConstraint, NormalLaw, NormalScheme};

/// Least share of its speed at which an impact recovers the overlap that it has left: the restitution of the largest damping.
const LEAST_RECOVERY: f64 = 0.0025;

/// Energy that a contact stores, over that of its impact, from which on it bears a load. More than one, because a step takes the two
/// deeper than they would go.
const LOADED: f64 = 2.0;

/// Speed to be remembered of a contact without an impact in progress.
pub const AT_REST: f64 = -1.0;

/// Bias of a contact that must bear nothing, m/s: no contact separates as fast as that.
const OUT_OF_TOUCH: f64 = -1e30;

/// Impact of a contact, or of eight, at the start of a step.
#[derive(Clone, Copy)]
pub struct Impact<N: Number> {
    /// Speed of first touch, m/s; 0 without an impact.
    pub speed: N,
    /// True where the two touch for the first time, and approach.
    pub begins: N::Mask,
    /// True where the two overlap.
    pub touches: N::Mask,
    /// Velocity that all else gave the two in the last step, m/s.
    pub external: N,
}

/// Constraint of a contact in a step, and the memory of its impact.
#[derive(Clone, Copy)]
pub struct Decision<N: Number> {
    /// The contact's constraint.
    pub constraint: NormalConstraint<N>,
    /// Speed to be remembered, m/s: that of the first touch, [`AT_REST`], or 0 where the two are apart.
    pub speed: N,
}

impl<N: Number> Impact<N> {
    /// Of a contact with this overlap (m) and normal velocity at the start of the step (m/s), given the speed and the velocity that
    /// are remembered of it (m/s), and the velocity that its impulse gave the two in the last step (m/s).
    #[inline(always)]
    pub fn of([overlap, velocity]: [N; 2], [speed, velocity_before]: [N; 2], given: N) -> Self {
        let zero = N::zero();
        let touches = !overlap.below(zero);
        let begins = touches & speed.abs().at_most(zero) & velocity.below(zero);
        let turned = !zero.below(velocity) & !velocity_before.below(zero);
        let lasts = touches & zero.below(speed) & !turned;
        Impact {
            speed: N::select(begins, -velocity, N::select(lasts, speed, zero)),
            begins,
            touches,
            external: N::select(lasts, velocity - velocity_before - given, zero),
        }
    }

    /// Speed (m/s) by which a restitution that falls with it goes, given the normal velocity at the start of the step (m/s).
    #[inline(always)]
    pub fn speed_of_restitution(&self, velocity: N) -> N {
        N::select(N::zero().below(self.speed), self.speed, -velocity)
    }

    /// Applies the decision to the contact's constraint. `overlap` in m; `velocity`, at the start of the step, in m/s; `inverse_mass`
    /// in 1/kg.
    ///
    /// A rigid contact has no elastic energy that an overlap could give back, so there stabilisation must not push: a contact that
    /// already separates bears nothing, and a resting one recovers its overlap no faster than the threshold. Across a gap only a slow
    /// approach is stopped, at touch; a fast one becomes an impact once the two overlap. A compliant contact whose impact the step
    /// resolves bears nothing across a gap.
    #[inline(always)]
    pub fn decide(
        &self,
        constraint: NormalConstraint<N>,
        scheme: &NormalScheme,
        [overlap, velocity]: [N; 2],
        inverse_mass: N,
        restitution: N,
    ) -> Decision<N> {
        let (zero, never) = (N::zero(), N::splat(OUT_OF_TOUCH));
        let threshold = N::splat(scheme.restitution_threshold);
        let (separates, approaches) = (threshold.below(velocity), velocity.below(-threshold));
        let NormalConstraint { regularisation, bias, resolves_impact: resolved, .. } = constraint;
        let is_rigid = scheme.law == NormalLaw::Rigid;
        // An unresolved impact. A contact at rest that is pushed apart faster than it would rebound bears a load, or is deep: its
        // compliance must go on telling how much, or the overlap would become speed.
        let rebound = -restitution * velocity;
        let strikes =
            if is_rigid { approaches } else { approaches & !resolved & !(!self.begins & !bias.below(rebound)) };
        let loaded = resolved & (N::splat(LOADED) * self.speed * self.speed).below(constraint.stored * inverse_mass);
        let lasts = zero.below(self.speed) & !(self.begins & !resolved) & !loaded;
        let speed = N::select(strikes, -velocity, N::select(lasts, self.speed, zero));
        // The bias with which the contact, if all else acts as in the last step, leaves at the speed of the rebound.
        let least = (N::splat(LEAST_RECOVERY) * speed).larger(N::splat(scheme.gravity * scheme.step));
        let fastest = (restitution * speed).larger(least);
        let fastest = if is_rigid { fastest.smaller(threshold) } else { fastest };
        let free = velocity + self.external;
        let highest = fastest + regularisation / inverse_mass * (fastest - free);
        let limited = lasts & !strikes & constraint.is_coarse & highest.below(bias);
        let acts = !(!strikes & !limited);
        let compliant = if is_rigid { bias.smaller(threshold) } else { bias };
        let touching = N::select(strikes, rebound, N::select(limited, highest, compliant));
        let touching = if is_rigid { N::select(separates, never, touching) } else { touching };
        let stopped = !approaches & !separates & !resolved;
        let across = N::select(stopped, overlap / N::splat(scheme.step), never);
        // What is remembered.
        let goes_on = zero.below(speed) & !(!acts & !resolved);
        let kept = N::select(goes_on, speed, N::splat(AT_REST));
        Decision {
            constraint: NormalConstraint {
                bias: N::select(self.touches, touching, across),
                regularisation: N::select(strikes, zero, regularisation),
                stiffness: N::select(strikes, N::splat(f64::INFINITY), constraint.stiffness),
                ..constraint
            },
            speed: N::select(self.touches, kept, zero),
        }
    }
}

/// Returns true where a contact may bear something in this step.
#[inline(always)]
pub fn bears<N: Number>(constraint: &NormalConstraint<N>) -> N::Mask {
    N::splat(OUT_OF_TOUCH).below(constraint.bias)
}
