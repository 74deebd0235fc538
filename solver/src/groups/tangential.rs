//! Tangential part of lane groups; without it they are shorter by that.

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

/// Tangential part of contacts with a spring.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct SpringLanes<Several = Eight> {
    /// Friction coefficients and tangential impulses.
    pub friction: FrictionLanes<Several>,
    /// The springs.
    pub spring: SpringTerms<Several>,
}

/// Tangential springs of eight contacts.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct SpringTerms<Several = Eight> {
    /// Compliances Sigma_t, 1/kg.
    pub compliance: Several,
    /// Biases b across the normals, m/s.
    pub bias: [Several; 3],
}

/// Tangential part of the contacts of a lane group: [`FrictionLanes`], [`SpringLanes`], or `()` where grains are smooth.
pub trait Tangential<Several = Eight>: Copy + Default {
    /// Coefficients and impulses, if there are any.
    fn lanes(&self) -> Option<&FrictionLanes<Several>>;

    /// Coefficients and impulses, mutable.
    fn lanes_mut(&mut self) -> Option<&mut FrictionLanes<Several>>;

    /// The springs, if there are any.
    #[inline(always)]
    fn spring(&self) -> Option<&SpringTerms<Several>> {
        None
    }

    /// The springs, mutable.
    #[inline(always)]
    fn spring_mut(&mut self) -> Option<&mut SpringTerms<Several>> {
        None
    }
}

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

impl<Several: Copy + Default> Tangential<Several> for SpringLanes<Several> {
    #[inline(always)]
    fn lanes(&self) -> Option<&FrictionLanes<Several>> {
        Some(&self.friction)
    }

    #[inline(always)]
    fn lanes_mut(&mut self) -> Option<&mut FrictionLanes<Several>> {
        Some(&mut self.friction)
    }

    #[inline(always)]
    fn spring(&self) -> Option<&SpringTerms<Several>> {
        Some(&self.spring)
    }

    #[inline(always)]
    fn spring_mut(&mut self) -> Option<&mut SpringTerms<Several>> {
        Some(&mut self.spring)
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

/// Makes a kind of lane groups that of one variant of [`PairGroups`].
macro_rules! laid_out_as {
    ($kind:ty, $variant:ident) => {
        impl ContactLayout for $kind {
            #[inline(always)]
            fn of(groups: &PairGroups) -> &[PairGroup<Self>] {
                match groups {
                    PairGroups::$variant(groups) => groups,
                    _ => unreachable!("{LAID_OUT}"),
                }
            }

            #[inline(always)]
            fn of_mut(groups: &mut PairGroups) -> &mut [PairGroup<Self>] {
                match groups {
                    PairGroups::$variant(groups) => groups,
                    _ => unreachable!("{LAID_OUT}"),
                }
            }
        }
    };
}

laid_out_as!((), Smooth);
laid_out_as!(FrictionLanes, Frictional);
laid_out_as!(SpringLanes, Sprung);

impl SpringTerms {
    /// Takes the spring of the contact in a lane away for a step.
    pub(crate) fn make_rigid(&mut self, lane: usize) {
        self.compliance.0[lane] = 0.0;
        self.bias.iter_mut().for_each(|component| component.0[lane] = 0.0);
    }

    /// Energy (J) that the spring of the contact in a lane held when the step began.
    pub(crate) fn held(&self, lane: usize) -> f64 {
        let compliance = self.compliance.0[lane];
        let square: f64 = self.bias.iter().map(|component| component.0[lane] * component.0[lane]).sum();
        if compliance > 0.0 { 0.5 * square / compliance } else { 0.0 }
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

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The groups with room for friction and springs, whether they have any or not: for who reads them once in a while.
    pub fn iter(&self) -> impl Iterator<Item = PairGroup<SpringLanes>> + '_ {
        (0..self.len()).map(|number| with_pairs!(self, groups => groups[number].with_all()))
    }

    /// Bytes of a group.
    pub fn bytes_of_group(&self) -> usize {
        match self {
            PairGroups::Smooth(_) => size_of::<PairGroup<()>>(),
            PairGroups::Frictional(_) => size_of::<PairGroup>(),
            PairGroups::Sprung(_) => size_of::<PairGroup<SpringLanes>>(),
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

    /// Becomes groups with a tangential part, or without, and with springs in it, or without; what there was is dropped if it was of
    /// another kind.
    pub(crate) fn suit(&mut self, tangential: bool, springs: bool) {
        match (tangential, springs, &self) {
            (false, _, PairGroups::Smooth(_))
            | (true, false, PairGroups::Frictional(_))
            | (true, true, PairGroups::Sprung(_)) => {}
            (false, ..) => *self = PairGroups::Smooth(Vec::new()),
            (true, false, _) => *self = PairGroups::Frictional(Vec::new()),
            (true, true, _) => *self = PairGroups::Sprung(Vec::new()),
        }
    }
}
