//! What friction adds to lane groups; without it they are shorter by that.

use super::PairGroup;
use crate::lanes::Eight;

/// Friction coefficients and tangential impulses of eight contacts, or of sixteen in single precision.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct FrictionLanes<Several = Eight> {
    /// Friction coefficients.
    pub coefficient: Several,
    /// Tangential impulses on the second body, or on the wall, N s.
    pub impulse: [Several; 3],
}

/// What friction adds to the contacts of a lane group: [`FrictionLanes`], or `()` where grains are smooth.
pub trait Tangential<Several = Eight>: Copy + Default {
    /// Coefficients and impulses, if there are any.
    fn lanes(&self) -> Option<&FrictionLanes<Several>>;

    /// The same, to be written.
    fn lanes_mut(&mut self) -> Option<&mut FrictionLanes<Several>>;
}

/// Lane groups of contacts of two grains, as long as the effects need.
#[derive(Clone, Debug)]
pub enum PairGroups {
    /// Without friction.
    Smooth(Vec<PairGroup<()>>),
    /// With it.
    Frictional(Vec<PairGroup>),
}

/// A kind of lane groups that [`PairGroups`] can hold.
pub(crate) trait ContactLayout: Tangential + Send + Sync {
    /// The groups, which are of this kind.
    fn of(groups: &PairGroups) -> &[PairGroup<Self>];

    /// The same, to be written.
    fn of_mut(groups: &mut PairGroups) -> &mut [PairGroup<Self>];
}

/// Evaluates an expression with `$pairs` as the groups of the kind that there is.
macro_rules! with_pairs {
    ($groups:expr, $pairs:ident => $body:expr) => {
        match $groups {
            $crate::groups::PairGroups::Smooth($pairs) => $body,
            $crate::groups::PairGroups::Frictional($pairs) => $body,
        }
    };
}

pub(crate) use with_pairs;

impl<Several: Copy + Default> Tangential<Several> for FrictionLanes<Several> {
    #[inline(always)]
    fn lanes(&self) -> Option<&FrictionLanes<Several>> {
        Some(self)
    }

    #[inline(always)]
    fn lanes_mut(&mut self) -> Option<&mut FrictionLanes<Several>> {
        Some(self)
    }
}

impl<Several> Tangential<Several> for () {
    #[inline(always)]
    fn lanes(&self) -> Option<&FrictionLanes<Several>> {
        None
    }

    #[inline(always)]
    fn lanes_mut(&mut self) -> Option<&mut FrictionLanes<Several>> {
        None
    }
}

/// Whoever lays groups out and whoever sweeps them go by the same effects.
const LAID_OUT: &str = "lane groups were laid out for the effects of the sweep";

impl ContactLayout for FrictionLanes {
    #[inline(always)]
    fn of(groups: &PairGroups) -> &[PairGroup] {
        match groups {
            PairGroups::Frictional(groups) => groups,
            PairGroups::Smooth(_) => unreachable!("{LAID_OUT}"),
        }
    }

    #[inline(always)]
    fn of_mut(groups: &mut PairGroups) -> &mut [PairGroup] {
        match groups {
            PairGroups::Frictional(groups) => groups,
            PairGroups::Smooth(_) => unreachable!("{LAID_OUT}"),
        }
    }
}

impl ContactLayout for () {
    #[inline(always)]
    fn of(groups: &PairGroups) -> &[PairGroup<()>] {
        match groups {
            PairGroups::Smooth(groups) => groups,
            PairGroups::Frictional(_) => unreachable!("{LAID_OUT}"),
        }
    }

    #[inline(always)]
    fn of_mut(groups: &mut PairGroups) -> &mut [PairGroup<()>] {
        match groups {
            PairGroups::Smooth(groups) => groups,
            PairGroups::Frictional(_) => unreachable!("{LAID_OUT}"),
        }
    }
}

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

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The groups with room for friction, whether they have any or not: for who reads them once in a while.
    pub fn iter(&self) -> impl Iterator<Item = PairGroup> + '_ {
        (0..self.len()).map(|number| with_pairs!(self, groups => groups[number].with_friction()))
    }

    /// Bytes of a group.
    pub fn bytes_of_group(&self) -> usize {
        match self {
            PairGroups::Smooth(_) => size_of::<PairGroup<()>>(),
            PairGroups::Frictional(_) => size_of::<PairGroup>(),
        }
    }

    /// Number of groups that there is room for.
    pub(crate) fn capacity(&self) -> usize {
        with_pairs!(self, groups => groups.capacity())
    }

    /// Drops the groups from this number on; memory stays.
    pub(crate) fn truncate(&mut self, count: usize) {
        with_pairs!(self, groups => groups.truncate(count));
    }

    /// Becomes groups with a tangential part, or without; what there was is dropped if it was of the other kind.
    pub(crate) fn suit(&mut self, tangential: bool) {
        match (tangential, &self) {
            (true, PairGroups::Smooth(_)) => *self = PairGroups::Frictional(Vec::new()),
            (false, PairGroups::Frictional(_)) => *self = PairGroups::Smooth(Vec::new()),
            _ => {}
        }
    }
}
