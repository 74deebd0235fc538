//! Impacts: one decision per impact, at first contact, valid until separation.
//!
//! An impact begins in the step in which two approaching bodies overlap for the first time. The approach speed v0 of
//! this step determines the method of computation and the restitution e:
//!
//! - **resolved** by the step, if a contact of this stiffness lasts for enough steps ([`NormalContact::constraint`]): compliance and
//!   damping give the rebound;
//! - **unresolved** otherwise: Newton's law sets the separation speed `e v0` within the step, with the stiffness of a rigid contact.
//!   Approaches below the restitution threshold are then contacts at rest, not impacts.
//!
//! In steps that are long compared with the contact time, the bodies separate at most at `w = e v0`, whatever the phase of the step at
//! first contact. Without a limit, such a step adds energy, by an overlap without elastic work or by a force that ends late, and the
//! separation speed could reach the approach speed. In all later steps, the bias is therefore at most that of a separation at w,
//!
//! ```text
//! q <- min(q, w + Sigma'/S (w - u))         u = u_n0 + (u_n0 - u_n0' - S lambda')
//! ```
//!
//! where u is the velocity of the two bodies without the contact, if all other forces act as in the last step, with the velocity
//! `u_n0'` and the impulse `lambda'` of that step. A contact under load remains compliant, since the load reduces u; an unloaded
//! contact separates at w. The rule leaves the compliance unchanged and never increases the impulse. It therefore creates no
//! energy, and the contact problem of a step retains its form for every solution method.
//!
//! An impact ends at separation, or when the contact comes to rest: on a renewed approach without separation, which
//! requires a third body; for a resolved impact, once the stored energy is twice the impact energy, which requires a
//! load; otherwise as soon as compliance acts. From then on, the contact is treated as a contact at rest.
//!
//! [`NormalContact::constraint`]: super::compliance::NormalContact::constraint

use crate::lanes::Number;
use crate::laws::compliance::{NormalConstraint, NormalLaw, NormalScheme};

/// Smallest recovery speed of the residual overlap, over the impact speed: the restitution at the largest damping.
const LEAST_RECOVERY: f64 = 0.0025;

/// Stored energy, over the impact energy, from which on a contact carries a load. The ratio exceeds one, because a
/// finite step overestimates the depth.
const LOADED: f64 = 2.0;

/// Stored speed of a contact without an impact in progress.
pub const AT_REST: f64 = -1.0;

/// Bias of an inactive contact, m/s: no contact separates at such a speed.
const OUT_OF_TOUCH: f64 = -1e30;

/// Impact of one contact, or of eight contacts, at the start of a step.
#[derive(Clone, Copy)]
pub struct Impact<N: Number> {
    /// Approach speed at first contact, m/s; 0 without an impact.
    pub speed: N,
    /// True at the first contact of two approaching bodies.
    pub begins: N::Mask,
    /// True if the two bodies overlap.
    pub touches: N::Mask,
    /// Velocity due to all other impulses of the last step, m/s.
    pub external: N,
}

/// Constraint of a contact in a step, and the stored state of its impact.
#[derive(Clone, Copy)]
pub struct Decision<N: Number> {
    /// Constraint of the contact.
    pub constraint: NormalConstraint<N>,
    /// Speed to be stored, m/s: that of the first contact, [`AT_REST`], or 0 for separated bodies.
    pub speed: N,
}

impl<N: Number> Impact<N> {
    /// Creates the impact of a contact. Input: overlap (m), normal velocity at the start of the step (m/s), stored
    /// speed and velocity (m/s), and the velocity due to the impulse of the contact in the last step (m/s).
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

    /// Returns the speed (m/s) for the speed-dependent restitution from the normal velocity at the start of the step (m/s).
    #[inline(always)]
    pub fn speed_of_restitution(&self, velocity: N) -> N {
        N::select(N::zero().below(self.speed), self.speed, -velocity)
    }

    /// Applies the decision to the contact's constraint. `overlap` in m; `velocity`, at the start of the step, in m/s; `inverse_mass`
    /// in 1/kg.
    ///
    /// A rigid contact stores no elastic energy in an overlap, so stabilisation must not push: a separating contact is
    /// inactive, and a resting one recovers its overlap at most at the threshold speed. Across a gap, only a slow
    /// approach is stopped, at first contact; a fast approach becomes an impact once the two bodies overlap. A
    /// compliant contact with a resolved impact is inactive across a gap.
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
        // An unresolved impact. A contact at rest with a bias above its rebound speed is under load or deep: the
        // impulse must continue to follow from its compliance, or the overlap would become speed.
        let rebound = -restitution * velocity;
        let strikes =
            if is_rigid { approaches } else { approaches & !resolved & !(!self.begins & !bias.below(rebound)) };
        let loaded = resolved & (N::splat(LOADED) * self.speed * self.speed).below(constraint.stored * inverse_mass);
        let lasts = zero.below(self.speed) & !(self.begins & !resolved) & !loaded;
        let speed = N::select(strikes, -velocity, N::select(lasts, self.speed, zero));
        // Bias of a separation at the rebound speed, if all other forces act as in the last step.
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
        // Speed to be stored.
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

/// Returns true if a contact may be active in this step.
#[inline(always)]
pub fn bears<N: Number>(constraint: &NormalConstraint<N>) -> N::Mask {
    N::splat(OUT_OF_TOUCH).below(constraint.bias)
}
