//! Effects of a scene, one small file each: equations, their source, contact terms, descriptor.
//!
//! Contact laws are only in this module and in [`laws`](crate::laws). `constrain` evaluates them once per contact and
//! step, and the sweep kernel is compiled for the [terms](term) of the scene. [`CATALOGUE`] lists the descriptors.

mod belt;
pub mod catalogue;
pub mod cohesion;
pub mod compliance;
pub mod drive;
pub mod flow;
pub mod friction;
pub mod gravity;
pub mod impact;
pub mod period;
pub mod resistance;
pub mod restitution;
pub mod size_spread;
pub mod spring;
pub mod term;
pub mod vibration;

use crate::scene::ContactCoefficients;
pub use belt::SURFACE_VELOCITY;
pub use catalogue::Effect;
pub use cohesion::COHESION;
pub use compliance::{COMPLIANCE, VISCOSITY};
pub use drive::DRIVEN_WALLS;
pub use flow::{INFLOW, OUTFLOW};
pub use friction::{FRICTION, KINETIC_FRICTION, SPIN};
pub use gravity::{CHANGING_GRAVITY, GRAVITY};
pub use period::PERIODIC_AXES;
pub use resistance::{ROLLING, TWISTING};
pub use restitution::{FALLING_RESTITUTION, RESTITUTION};
pub use size_spread::SIZE_SPREAD;
pub use spring::TANGENTIAL_SPRING;
pub use vibration::WALL_MOTION;

/// All effects, in their order within a step. A coefficient follows those that bound it.
pub static CATALOGUE: [&Effect; 20] = [
    &GRAVITY,
    &CHANGING_GRAVITY,
    &WALL_MOTION,
    &SURFACE_VELOCITY,
    &DRIVEN_WALLS,
    &INFLOW,
    &OUTFLOW,
    &SIZE_SPREAD,
    &PERIODIC_AXES,
    &COMPLIANCE,
    &VISCOSITY,
    &RESTITUTION,
    &FALLING_RESTITUTION,
    &FRICTION,
    &KINETIC_FRICTION,
    &TANGENTIAL_SPRING,
    &SPIN,
    &COHESION,
    &ROLLING,
    &TWISTING,
];

/// Declares [`EffectSet`] with its members.
macro_rules! members {
    ($($(#[$about:meta])* $member:ident;)*) => {
        /// Contact effects that a scene enables, for the selection of kernels, memory layout or passes.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct EffectSet { $($member: bool),* }

        impl EffectSet {
            const NONE: EffectSet = EffectSet { $($member: false),* };

            $($(#[$about])* #[inline(always)] pub fn $member(&self) -> bool { self.$member })*
        }
    };
}

members! {
    /// At least one contact can have friction.
    friction;
    /// At least one contact can resist rolling.
    rolling;
    /// At least one contact can resist twisting.
    twisting;
    /// At least one contact has cohesion. Sweeps do not depend on this effect.
    cohesion;
    /// At least one contact has a restitution that decreases with the impact speed. Sweeps do not depend on this effect.
    falling_restitution;
    /// At least one contact has less friction in sliding. Sweeps do not depend on this effect.
    kinetic_friction;
    /// Sticking contacts have a tangential spring.
    spring;
}

impl EffectSet {
    /// All combinations that a kernel is compiled for.
    pub const COMPILED: [EffectSet; 7] = [
        EffectSet::NONE,
        EffectSet { friction: true, ..EffectSet::NONE },
        EffectSet { friction: true, rolling: true, ..EffectSet::NONE },
        EffectSet { friction: true, twisting: true, ..EffectSet::NONE },
        EffectSet { friction: true, rolling: true, twisting: true, ..EffectSet::NONE },
        EffectSet { friction: true, spring: true, ..EffectSet::NONE },
        EffectSet { friction: true, rolling: true, twisting: true, spring: true, ..EffectSet::NONE },
    ];

    /// Returns the union of the effects of these contacts.
    pub fn of<'a>(contacts: impl Iterator<Item = &'a ContactCoefficients>) -> EffectSet {
        let mut set = EffectSet::NONE;
        for contact in contacts {
            for effect in CATALOGUE {
                if let (Some(member), catalogue::Trigger::Contacts { acts, .. }) = (effect.member, &effect.trigger) {
                    *member(&mut set) |= acts(contact);
                }
            }
        }
        set
    }

    /// Adds a tangential spring if the scene has one; without friction, the spring carries no force.
    pub(crate) fn with_spring(self, spring: bool) -> EffectSet {
        EffectSet { spring: spring && self.friction, ..self }
    }

    /// Returns membership of an effect; `None` for one without a member.
    pub fn has(mut self, effect: &Effect) -> Option<bool> {
        effect.member.map(|member| *member(&mut self))
    }

    /// Returns true if contacts transmit torques.
    #[inline(always)]
    pub fn torques(&self) -> bool {
        self.rolling() || self.twisting()
    }

    /// Returns true if contacts have a tangential part: with friction, and with resistance to rolling or twisting,
    /// because such grains have spin. The layout of contacts and all passes over contacts use this criterion alone.
    #[inline(always)]
    pub fn tangential(&self) -> bool {
        self.friction() || self.torques()
    }

    /// Returns the set of effects of the compiled kernel for this set.
    pub fn compiled(&self) -> EffectSet {
        let (friction, spring) = (self.tangential(), self.spring());
        // With a spring, both resistances are compiled together.
        let both = spring && self.torques();
        let (rolling, twisting) = (self.rolling() || both, self.twisting() || both);
        EffectSet { friction, rolling, twisting, spring, ..EffectSet::NONE }
    }

    /// Returns the names of the effects as text.
    pub fn name(&self) -> &'static str {
        match (self.tangential(), self.rolling(), self.twisting()) {
            _ if self.spring() && self.torques() => "friction with a spring, rolling and twisting resistance",
            _ if self.spring() => "friction with a spring",
            (_, true, true) => "friction, rolling and twisting resistance",
            (_, true, false) => "friction and rolling resistance",
            (_, false, true) => "friction and twisting resistance",
            (true, ..) => "friction",
            (false, ..) => "frictionless",
        }
    }
}
