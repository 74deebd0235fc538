//! The choices of effects that kernels are compiled for, and lane groups of pairs as long as each needs.

use super::PairGroup;
use crate::effects::friction::{Coulomb, FrictionLanes};
use crate::effects::resistance::Resistance;
use crate::effects::spring::{self, SpringLanes};
use crate::effects::term::{ContactTerm, Tangential, TangentialTerm, TorqueTerm};
use crate::lanes::Number;
use std::marker::PhantomData;

/// Effects that a kernel is compiled with. An effect that is off leaves no instruction in it.
pub(crate) trait Effects {
    /// Tangential part of lane groups.
    type Tangential: ContactLayout;
    /// Torques of contacts.
    type Torque<N: Number>: TorqueTerm<N>;
    /// True with Coulomb friction; without it grains do not spin.
    const FRICTION: bool = <<Self::Tangential as ContactLayout>::Term<f64> as ContactTerm<f64>>::ACTS;
    /// True if contacts bear torques.
    const TORQUES: bool = <Self::Torque<f64> as ContactTerm<f64>>::ACTS;
}

/// One choice of effects: a tangential part, and the resistances.
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
/// With a spring both resistances go together, of which one may be zero: few scenes have them, and each kernel takes time to compile.
pub(crate) type SprungTorques = Compiled<SpringLanes, true, true>;

/// Evaluates an expression with `$effects` as the type that is compiled for the choice.
macro_rules! with_effects {
    ($set:expr, $effects:ident => $body:expr) => {{
        let set = $set;
        $crate::groups::with_first!($effects => $body;
            set.spring() && set.torques() => SprungTorques, set.rolling() && set.twisting() => RollingTwisting,
            set.rolling() => Rolling, set.twisting() => Twisting,
            set.spring() => Sprung, set.tangential() => Frictional, true => Frictionless)
    }};
}

/// Evaluates an expression for work on forces alone, which knows nothing of torques: contacts have a tangential part or have none.
macro_rules! with_tangential {
    ($set:expr, $effects:ident => $body:expr) => {{
        let set = $set;
        $crate::groups::with_first!($effects => $body;
            set.spring() => Sprung, set.tangential() => Frictional, true => Frictionless)
    }};
}

/// Evaluates an expression for the first choice whose condition holds.
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

/// Lane groups of contacts of two grains, as long as the effects need.
#[derive(Clone, Debug)]
pub enum PairGroups {
    /// Without friction.
    Smooth(Vec<PairGroup<()>>),
    /// With it.
    Frictional(Vec<PairGroup>),
    /// With tangential springs besides.
    Sprung(Vec<PairGroup<SpringLanes>>),
}

/// A kind of lane groups that [`PairGroups`] can hold.
pub(crate) trait ContactLayout: Tangential + Send + Sync {
    /// Tangential term of its contacts in a kernel.
    type Term<N: Number>: TangentialTerm<N>;

    /// The groups, which are of this kind.
    fn of(groups: &PairGroups) -> &[PairGroup<Self>];

    /// Mutable access.
    fn of_mut(groups: &mut PairGroups) -> &mut [PairGroup<Self>];
}

/// Evaluates an expression with `$pairs` as the groups of the kind that there is.
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

/// Reason for which no other layout can occur: set-up and sweeps use the same effects.
const LAID_OUT: &str = "lane groups were laid out for the effects of the sweep";

/// Makes a kind of lane groups that of one variant of [`PairGroups`].
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
    /// Number of groups.
    pub fn len(&self) -> usize {
        with_pairs!(self, groups => groups.len())
    }

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Copies of the groups with room for friction and springs, whether they have any or not, for occasional reading.
    pub fn iter(&self) -> impl Iterator<Item = PairGroup<SpringLanes>> + '_ {
        (0..self.len()).map(|number| with_pairs!(self, groups => groups[number].with_all()))
    }

    /// Bytes of a group.
    pub fn bytes_of_group(&self) -> usize {
        fn bytes<T>(_: &[PairGroup<T>]) -> usize {
            size_of::<PairGroup<T>>()
        }
        with_pairs!(self, groups => bytes(groups))
    }

    /// Number of groups that there is room for.
    pub(crate) fn capacity(&self) -> usize {
        with_pairs!(self, groups => groups.capacity())
    }

    /// Drops the groups from this number on; memory stays.
    pub(crate) fn truncate(&mut self, count: usize) {
        with_pairs!(self, groups => groups.truncate(count));
    }

    /// Becomes groups with a tangential part, or without, and with springs in it, or without; what there was is dropped if it was of
    /// another kind.
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
