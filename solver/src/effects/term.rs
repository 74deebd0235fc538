//! Terms of contacts: the impulses that effects add to the one along the normal.
//!
//! A term bears an impulse P, across the normal or an angular one, which the normal impulse bounds. With the residual r of sticking, the
//! operator S and the relaxation factor w it is relaxed as
//!
//! ```text
//! P' = bearable(P - r w / S)
//! ```
//!
//! and counts with `S (P' - P)` among the residuals of a sweep. Sweeps, set-up and memory call terms by the traits here alone.

use super::compliance::NormalConstraint;
use super::friction::FrictionLanes;
use super::resistance::TorqueLanes;
use super::spring::SpringTerms;
use crate::lanes::{Eight, Number, minus, times};

/// Normal and normal impulse (N s) of a contact, or of eight.
pub type Bearing<N> = ([N; 3], N);

/// A term of one contact, or of eight, in a kernel.
pub trait ContactTerm<N: Number>: Copy {
    /// True if it bears anything; else nothing is compiled for it.
    const ACTS: bool;

    /// Impulse on the second side, N s or N m s.
    fn impulse(&self) -> [N; 3];

    /// Replaces the impulse.
    fn set_impulse(&mut self, impulse: [N; 3]);

    /// The part of an impulse that the contact can bear.
    fn bearable(&self, impulse: [N; 3], bearing: Bearing<N>) -> [N; 3];

    /// Operator, given that of a rigid contact.
    #[inline(always)]
    fn operator(&self, rigid: N) -> N {
        rigid
    }

    /// Residual of sticking, given the velocity that sticking brings to zero.
    #[inline(always)]
    fn residual(&self, velocity: [N; 3]) -> [N; 3] {
        velocity
    }

    /// The one-contact solution: updates the impulse and returns the change.
    #[inline(always)]
    fn relax(&mut self, bearing: Bearing<N>, velocity: [N; 3], operator: N, relaxation: N) -> [N; 3] {
        let before = self.impulse();
        let target = minus(before, times(self.residual(velocity), relaxation / operator));
        let borne = self.bearable(target, bearing);
        self.set_impulse(borne);
        minus(borne, before)
    }

    /// Starts from the impulse of the last step, as far as the contact can bear it now. A contact that has just closed starts from none,
    /// whatever it bore when it opened.
    #[inline(always)]
    fn start(&mut self, bearing: Bearing<N>) {
        let bears = N::zero().below(bearing.1);
        let borne = self.bearable(self.impulse(), bearing);
        self.set_impulse(borne.map(|component| N::select(bears, component, N::zero())));
    }
}

/// A term across the normal, in a kernel.
pub trait TangentialTerm<N: Number>: ContactTerm<N> {
    /// Reads it, number by number, from lanes that may hold more.
    fn read<S, T: Tangential<S>>(lanes: &T, number: impl Fn(&S) -> N) -> Self;

    /// Friction coefficient.
    fn coefficient(&self) -> N;

    /// Writes its impulse back.
    #[inline(always)]
    fn write<S, T: Tangential<S>>(&self, lanes: &mut T, number: impl Fn(N, &mut S)) {
        if Self::ACTS
            && let Some(lanes) = lanes.lanes_mut()
        {
            self.impulse().into_iter().zip(&mut lanes.impulse).for_each(|(component, to)| number(component, to));
        }
    }
}

/// A term of torques, in a kernel.
pub trait TorqueTerm<N: Number>: ContactTerm<N> {
    /// Reads it, number by number.
    fn read(lanes: &TorqueLanes, number: impl Fn(&Eight) -> N) -> Self;

    /// Writes its impulse back.
    #[inline(always)]
    fn write(&self, lanes: &mut TorqueLanes, number: impl Fn(N, &mut Eight)) {
        self.impulse().into_iter().zip(&mut lanes.impulse).for_each(|(component, to)| number(component, to));
    }
}

/// What a term across the normal is set up from, in each step.
pub struct TermStart<'a, N: Number> {
    /// Constraint along the normal.
    pub constraint: &'a NormalConstraint<N>,
    /// True where the contact may bear something.
    pub bears: N::Mask,
    /// Impulse of the last step in the new tangent plane, N s.
    pub borne: [N; 3],
    /// Share of it that the solve starts from.
    pub share: N,
    /// Friction coefficient.
    pub friction: N,
    /// Stiffness across the normal over that along it, where contacts have a tangential spring.
    pub stiffness_ratio: Option<N>,
    /// Time step, s.
    pub step: f64,
}

/// Tangential part of the contacts of a lane group: [`FrictionLanes`], [`SpringLanes`](super::spring::SpringLanes), or `()` where grains
/// are smooth.
pub trait Tangential<S = Eight>: Copy + Default {
    /// Coefficients and impulses, if there are any.
    fn lanes(&self) -> Option<&FrictionLanes<S>>;

    /// Coefficients and impulses, mutable.
    fn lanes_mut(&mut self) -> Option<&mut FrictionLanes<S>>;

    /// The springs, if there are any.
    #[inline(always)]
    fn spring(&self) -> Option<&SpringTerms<S>> {
        None
    }

    /// Sets it up for a step.
    fn fill<N: Number>(&mut self, start: &TermStart<'_, N>, number: impl Fn(N, &mut S));

    /// Impulses that the next step goes on from, N s.
    #[inline(always)]
    fn remembered<N: Number>(&self, number: impl Fn(&S) -> N) -> [N; 3] {
        self.lanes().map_or([N::zero(); 3], |lanes| lanes.impulse.each_ref().map(number))
    }
}
