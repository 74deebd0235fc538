//! Combinations of effects that kernels are compiled for, and lane groups of pairs with the memory of each combination.

use super::PairGroup;
use crate::effects::friction::{Coulomb, FrictionLanes};
use crate::effects::resistance::Resistance;
use crate::effects::spring::{self, SpringLanes};
use crate::effects::term::{ContactTerm, Tangential, TangentialTerm, TorqueTerm};
use crate::lanes::Number;
use std::marker::PhantomData;

/// Effects of a compiled kernel. Disabled effects add no instructions.
pub(crate) trait Effects {
    /// Tangential part of lane groups.
    type Tangential: ContactLayout;
    /// Torques of contacts.
    type Torque<N: Number>: TorqueTerm<N>;
    /// True with Coulomb friction; without friction, grains do not spin.
    const FRICTION: bool = <<Self::Tangential as ContactLayout>::Term<f64> as ContactTerm<f64>>::ACTS;
    /// True if contacts transmit torques.
    const TORQUES: bool = <Self::Torque<f64> as ContactTerm<f64>>::ACTS;
}

/// Combination of effects: a tangential part, and the resistances.
pub(crate) struct Compiled<T, const ROLLING: bool, const TWISTING: bool>(PhantomData<T>);

impl<T: ContactLayout, const ROLLING: bool, const TWISTING: bool> Effects for Compiled<T, ROLLING, TWISTING> {
    type Tangential = T;
    type Torque<N: Number> = Resistance<N, ROLLING, TWISTING>;
}

pub(crate) type Frictionless = Compiled<(), false, false>;
pub(crate) type Frictional = Compiled<FrictionLanes, false, false>;
pub(crate) type Rolling = Compiled<FrictionLanes, true, false>;
pub(crate) type Twisting = Compiled<FrictionLanes, false, true>;
pub(crate) type RollingTwisting = Compiled<FrictionLanes, true, true>;
pub(crate) type Sprung = Compiled<SpringLanes, false, false>;
/// With a spring, both resistances are compiled together, and either may be zero: few scenes have them, and every kernel adds compile time.
pub(crate) type SprungTorques = Compiled<SpringLanes, true, true>;

/// Evaluates an expression with `$effects` as the type that is compiled for the combination.
macro_rules! with_effects {
    ($set:expr, $effects:ident => $body:expr) => {{
        let set = $set;
        $crate::groups::with_first!($effects => $body;
            set.spring() && set.torques() => SprungTorques, set.rolling() && set.twisting() => RollingTwisting,
            set.rolling() => Rolling, set.twisting() => Twisting,
            set.spring() => Sprung, set.tangential() => Frictional, true => Frictionless)
    }};
}

/// Evaluates an expression for computations without torques: contacts have a tangential part or none.
macro_rules! with_tangential {
    ($set:expr, $effects:ident => $body:expr) => {{
        let set = $set;
        $crate::groups::with_first!($effects => $body;
            set.spring() => Sprung, set.tangential() => Frictional, true => Frictionless)
    }};
}

/// Evaluates an expression for the first combination with a true condition.
macro_rules! with_first {
    ($effects:ident => $body:expr; $($condition:expr => $choice:ident),*) => {
        match () {
            $(() if $condition => { type $effects = $crate::groups::$choice; $body })*
            () => unreachable!("the last condition holds"),
        }
    };
}

pub(crate) use with_effects;
pub(crate) use with_first;
pub(crate) use with_tangential;

/// Lane groups of contacts between two grains, with the memory that the effects need.
#[derive(Clone, Debug)]
pub enum PairGroups {
    /// Without friction.
    Smooth(Vec<PairGroup<()>>),
    /// With friction.
    Frictional(Vec<PairGroup>),
    /// With friction and tangential springs.
    Sprung(Vec<PairGroup<SpringLanes>>),
}

/// Layout of the lane groups in [`PairGroups`].
pub(crate) trait ContactLayout: Tangential + Send + Sync {
    /// Tangential term of the contacts in a kernel.
    type Term<N: Number>: TangentialTerm<N>;

    /// Returns the groups, which have this layout.
    fn of(groups: &PairGroups) -> &[PairGroup<Self>];

    /// Returns the groups for mutable access.
    fn of_mut(groups: &mut PairGroups) -> &mut [PairGroup<Self>];
}

/// Evaluates an expression with `$pairs` as the groups in their actual layout.
macro_rules! with_pairs {
    ($groups:expr, $pairs:ident => $body:expr) => {
        match $groups {
            $crate::groups::PairGroups::Smooth($pairs) => $body,
            $crate::groups::PairGroups::Frictional($pairs) => $body,
            $crate::groups::PairGroups::Sprung($pairs) => $body,
        }
    };
}

pub(crate) use with_pairs;

/// Reason why no other layout can occur: set-up and sweeps use the same effects.
const LAID_OUT: &str = "lane groups were laid out for the effects of the sweep";

/// Implements a layout for one variant of [`PairGroups`].
macro_rules! laid_out_as {
    ($kind:ty, $variant:ident, $number:ident => $term:ty) => {
        impl ContactLayout for $kind {
            type Term<$number: Number> = $term;

            #[inline(always)]
            fn of(groups: &PairGroups) -> &[PairGroup<Self>] {
                let PairGroups::$variant(groups) = groups else { unreachable!("{LAID_OUT}") };
                groups
            }

            #[inline(always)]
            fn of_mut(groups: &mut PairGroups) -> &mut [PairGroup<Self>] {
                let PairGroups::$variant(groups) = groups else { unreachable!("{LAID_OUT}") };
                groups
            }
        }
    };
}

laid_out_as!((), Smooth, N => Coulomb<N, false>);
laid_out_as!(FrictionLanes, Frictional, N => Coulomb<N, true>);
laid_out_as!(SpringLanes, Sprung, N => spring::Sprung<N>);

impl Default for PairGroups {
    fn default() -> PairGroups {
        PairGroups::Frictional(Vec::new())
    }
}

impl PairGroups {
    /// Returns the number of groups.
    pub fn len(&self) -> usize {
        with_pairs!(self, groups => groups.len())
    }

    /// Returns true if there are no groups.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns copies of the groups with memory for friction and springs in every layout, for occasional reading.
    pub fn iter(&self) -> impl Iterator<Item = PairGroup<SpringLanes>> + '_ {
        (0..self.len()).map(|number| with_pairs!(self, groups => groups[number].with_all()))
    }

    /// Returns the size of a group, bytes.
    pub fn bytes_of_group(&self) -> usize {
        fn bytes<T>(_: &[PairGroup<T>]) -> usize {
            size_of::<PairGroup<T>>()
        }
        with_pairs!(self, groups => bytes(groups))
    }

    /// Returns the number of groups in the allocated memory.
    pub(crate) fn capacity(&self) -> usize {
        with_pairs!(self, groups => groups.capacity())
    }

    /// Removes the groups from this index on; memory remains allocated.
    pub(crate) fn truncate(&mut self, count: usize) {
        with_pairs!(self, groups => groups.truncate(count));
    }

    /// Changes the layout to groups with or without a tangential part, and with or without springs; removes groups of
    /// another layout.
    pub(crate) fn suit(&mut self, tangential: bool, springs: bool) {
        let suited = match (tangential, springs) {
            (false, _) => PairGroups::Smooth(Vec::new()),
            (true, false) => PairGroups::Frictional(Vec::new()),
            (true, true) => PairGroups::Sprung(Vec::new()),
        };
        if std::mem::discriminant(self) != std::mem::discriminant(&suited) {
            *self = suited;
        }
    }
}
