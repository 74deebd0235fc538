//! Contact terms: impulses of effects in addition to the normal impulse.
//!
//! A term has an impulse P, tangential or angular, with a bound given by the normal impulse. With the residual r of
//! sticking, the operator S and the relaxation factor w, its update is
//!
//! ```text
//! P' = project(P - r w / S)
//! ```
//!
//! and `S (P' - P)` is its part of the residual of a sweep. Sweeps, set-up and memory access terms only through the traits of this module.

use super::friction::FrictionLanes;
use super::resistance::TorqueLanes;
use super::spring::SpringTerms;
use crate::lanes::{Eight, Number, minus, times};
use crate::laws::compliance::NormalConstraint;

/// Normal and normal impulse (N s) of one contact or of eight contacts.
pub type NormalLoad<N> = ([N; 3], N);

/// Term of one contact, or of eight contacts, in a kernel.
pub trait ContactTerm<N: Number>: Copy {
    /// False for a term without effect: no code is compiled for the term.
    const ACTS: bool;

    /// Projects an impulse onto the admissible set.
    fn project(&self, impulse: [N; 3], load: NormalLoad<N>) -> [N; 3];

    /// Returns the operator from that of a rigid contact.
    #[inline(always)]
    fn operator(&self, rigid: N) -> N {
        rigid
    }

    /// Returns the residual of sticking from the impulse and the velocity that is zero in sticking.
    #[inline(always)]
    fn residual(&self, velocity: [N; 3], _impulse: [N; 3]) -> [N; 3] {
        velocity
    }
}

/// Tangential term.
pub trait TangentialTerm<N: Number>: ContactTerm<N> {
    /// Reads the term, one number at a time, from lanes that may contain more numbers.
    fn read<S>(lanes: &impl Tangential<S>, number: impl Fn(&S) -> N) -> Self;

    /// Friction coefficient.
    fn coefficient(&self) -> N;
}

/// Torque term.
pub trait TorqueTerm<N: Number>: ContactTerm<N> {
    /// Reads the term, one number at a time.
    fn read(lanes: &TorqueLanes, number: impl Fn(&Eight) -> N) -> Self;
}

/// Term and its impulse on the second side, N s or N m s.
#[derive(Clone, Copy)]
pub struct TermState<N, T> {
    pub(crate) impulse: [N; 3],
    pub(crate) term: T,
}

impl<N: Number, T: ContactTerm<N>> TermState<N, T> {
    /// Solves the one-contact problem: updates the impulse and returns the change.
    #[inline(always)]
    pub(crate) fn relax(&mut self, load: NormalLoad<N>, velocity: [N; 3], operator: N, relaxation: N) -> [N; 3] {
        // Unconstrained update, then projection.
        let before = self.impulse;
        let residual = self.term.residual(velocity, before);
        let target = minus(before, times(residual, relaxation / operator));
        self.impulse = self.term.project(target, load);
        minus(self.impulse, before)
    }

    /// Projects the impulse of the last step for the warm start. The result is zero for zero normal impulse: in a contact that has just closed.
    #[inline(always)]
    pub(crate) fn start(&mut self, load: NormalLoad<N>) {
        let bears = N::zero().below(load.1);
        let borne = self.term.project(self.impulse, load);
        self.impulse = borne.map(|component| N::select(bears, component, N::zero()));
    }
}

impl<N: Number, T: TangentialTerm<N>> TermState<N, T> {
    /// Reads a tangential term, one number at a time.
    #[inline(always)]
    pub(crate) fn across<S>(lanes: &impl Tangential<S>, number: impl Fn(&S) -> N) -> Self {
        let impulse = lanes.lanes().map_or([N::zero(); 3], |lanes| lanes.impulse.each_ref().map(&number));
        TermState { impulse, term: T::read(lanes, number) }
    }
}

impl<N: Number, T: TorqueTerm<N>> TermState<N, T> {
    /// Reads a torque term, one number at a time.
    #[inline(always)]
    pub(crate) fn angular(lanes: &TorqueLanes, number: impl Fn(&Eight) -> N) -> Self {
        TermState { impulse: lanes.impulse.each_ref().map(&number), term: T::read(lanes, number) }
    }
}

impl<N: Copy, T> TermState<N, T> {
    /// Writes the impulse back.
    #[inline(always)]
    pub(crate) fn write<S>(&self, lanes: &mut [S; 3], number: impl Fn(N, &mut S)) {
        self.impulse.into_iter().zip(lanes).for_each(|(component, to)| number(component, to));
    }
}

/// Input of the set-up of a tangential term in a step.
pub struct TermStart<'a, N: Number> {
    /// Normal constraint.
    pub constraint: &'a NormalConstraint<N>,
    /// True if the contact may be active.
    pub active: N::Mask,
    /// Impulse of the last step in the new tangent plane, N s.
    pub last_impulse: [N; 3],
    /// Fraction of `last_impulse` for the warm start.
    pub share: N,
    /// Friction coefficient.
    pub friction: N,
    /// Ratio of tangential to normal stiffness, if contacts have a tangential spring.
    pub stiffness_ratio: Option<N>,
    /// Time step, s.
    pub step: f64,
}

/// Tangential part of the contacts of a lane group: [`FrictionLanes`], [`SpringLanes`](super::spring::SpringLanes), or
/// `()` for smooth grains.
pub trait Tangential<S = Eight>: Copy + Default {
    /// Returns coefficients and impulses, if present.
    #[inline(always)]
    fn lanes(&self) -> Option<&FrictionLanes<S>> {
        None
    }

    /// Returns mutable coefficients and impulses, if present.
    #[inline(always)]
    fn lanes_mut(&mut self) -> Option<&mut FrictionLanes<S>> {
        None
    }

    /// Returns the springs, if present.
    #[inline(always)]
    fn spring(&self) -> Option<&SpringTerms<S>> {
        None
    }

    /// Sets up the tangential part for a step.
    #[inline(always)]
    fn fill<N: Number>(&mut self, _start: &TermStart<'_, N>, _number: impl Fn(N, &mut S)) {}

    /// Returns the impulses (N s) for the warm start of the next step.
    #[inline(always)]
    fn remembered<N: Number>(&self, number: impl Fn(&S) -> N) -> [N; 3] {
        self.lanes().map_or([N::zero(); 3], |lanes| lanes.impulse.each_ref().map(number))
    }
}

impl<S> Tangential<S> for () {}
