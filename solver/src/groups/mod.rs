//! Lane groups: eight contacts that share no body.

mod compiled;

pub use compiled::PairGroups;
pub(crate) use compiled::{
    ContactLayout, Effects, Frictional, Frictionless, Rolling, RollingTwisting, Sprung, SprungTorques, Twisting,
    with_effects, with_first, with_pairs, with_tangential,
};

use crate::effects::friction::FrictionLanes;
use crate::effects::resistance::TorqueLanes;
use crate::effects::spring::SpringLanes;
use crate::effects::term::Tangential;
use crate::lanes::{Eight, LANES, Lanes, Slots};
use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// Marks an empty lane.
const NO_SOURCE: u32 = u32::MAX;

/// Constraint data and impulses of eight contacts, or of sixteen in single precision; `T` holds the friction data, `()`
/// for smooth grains.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct ContactLanes<Several = Eight, T = FrictionLanes<Several>> {
    /// Unit normals from the first body to the second, or to the wall.
    pub normal: [Several; 3],
    /// Biases q, m/s.
    pub bias: Several,
    /// Regularisations Sigma', 1/kg.
    pub regularisation: Several,
    /// Normal impulses, N s.
    pub impulse_normal: Several,
    /// Friction coefficients and tangential impulses, if any.
    pub tangential: T,
}

/// Eight contacts with walls.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct WallTorqueLanes {
    /// Angular velocities of the walls, rad/s.
    pub wall_spin: [Eight; 3],
    /// Levers and angular impulses.
    pub torques: TorqueLanes,
}

/// Eight contacts of pairs of grains that share no body.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct PairGroup<T = FrictionLanes> {
    /// Slots of the first bodies.
    pub first: [u32; LANES],
    /// Slots of the second bodies.
    pub second: [u32; LANES],
    /// Contacts of the pairs.
    pub contacts: ContactLanes<Eight, T>,
}

/// Eight contacts of different grains with walls. The groups are few, and always have memory for friction and springs.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct WallGroup {
    /// Slots of the grains.
    pub body: [u32; LANES],
    /// Velocities of the wall at the contacts, m/s.
    pub wall_velocity: [Eight; 3],
    /// Contacts with the walls.
    pub contacts: ContactLanes<Eight, SpringLanes>,
}

/// Impact state of a candidate, stored until separation: see `effects/impact.rs`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct ImpactMemory {
    /// Approach speed at first contact, m/s, positive; -1 for a contact at rest, 0 for separated bodies.
    pub speed: f32,
    /// Normal velocity at the start of the last step, m/s; positive in separation; undefined if the speed is 0.
    pub velocity: f32,
}

impl ImpactMemory {
    /// Returns true if the two bodies are in contact.
    pub(crate) fn touches(&self) -> bool {
        self.speed != 0.0
    }
}

/// Impact states of eight contacts for their candidates, stored separately from the group because sweeps do not need them.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct ImpactLanes {
    /// Speeds: see [`ImpactMemory`].
    pub speed: [f32; LANES],
    /// Normal velocities at the start of the step, m/s.
    pub velocity: [f32; LANES],
}

/// Candidates of the contacts of a lane group, stored separately from the group because sweeps do not need them.
#[derive(Clone, Copy, Debug)]
pub struct Sources([u32; LANES]);

impl<T: Tangential> ContactLanes<Eight, T> {
    /// Returns the normal impulse of the contact in a lane, N s.
    pub fn normal_impulse(&self, lane: usize) -> f64 {
        self.impulse_normal.0[lane]
    }

    /// Returns the tangential impulse of the contact in a lane, N s.
    pub fn tangential_impulse(&self, lane: usize) -> [f64; 3] {
        let impulse = |lanes: &FrictionLanes| std::array::from_fn(|axis| lanes.impulse[axis].0[lane]);
        self.tangential.lanes().map_or([0.0; 3], impulse)
    }

    /// Returns the friction coefficient of the contact in a lane.
    pub fn friction(&self, lane: usize) -> f64 {
        self.tangential.lanes().map_or(0.0, |lanes| lanes.coefficient.0[lane])
    }

    /// Returns the normal of the contact in a lane.
    pub fn normal(&self, lane: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.normal[axis].0[lane])
    }
}

impl ImpactLanes {
    /// Reads the impact states of the candidates of eight contacts: speeds, and velocities at the start of the last step.
    #[inline(always)]
    pub(crate) fn load<L: Lanes>(impacts: Slots<'_, ImpactMemory>, candidates: &[u32; LANES]) -> [L; 2] {
        let known = candidates.map(|candidate| impacts.get_trusted(candidate));
        [known.map(|one| f64::from(one.speed)), known.map(|one| f64::from(one.velocity))]
            .map(|eight| L::load(&Eight(eight)))
    }

    /// Creates the impact states of eight contacts. Speeds are rounded down, so that rounding never increases a
    /// rebound; rounded speeds do not change again.
    #[inline(always)]
    pub(crate) fn of<L: Lanes>(speed: L, velocity: L) -> ImpactLanes {
        let downwards = |number: f64| {
            let nearest = number as f32;
            if f64::from(nearest) > number { nearest.next_down() } else { nearest }
        };
        let [mut speeds, mut velocities] = [Eight::default(); 2];
        speed.store(&mut speeds);
        velocity.store(&mut velocities);
        ImpactLanes { speed: speeds.0.map(downwards), velocity: velocities.0.map(|number| number as f32) }
    }

    /// Returns the impact state of the contact in a lane.
    #[inline(always)]
    pub(crate) fn memory(&self, lane: usize) -> ImpactMemory {
        ImpactMemory { speed: self.speed[lane], velocity: self.velocity[lane] }
    }
}

impl<T: Tangential> PairGroup<T> {
    /// Creates a group of padding lanes, which refer to the padding bodies of a box from `dummies` on.
    pub(crate) fn padding(dummies: u32) -> Self {
        let [first, second] = padding_places(dummies);
        PairGroup { first, second, contacts: ContactLanes::default() }
    }

    /// Converts to a layout with memory for friction and springs.
    pub(crate) fn with_all(&self) -> PairGroup<SpringLanes> {
        let PairGroup { first, second, contacts } = *self;
        let ContactLanes { normal, bias, regularisation, impulse_normal, tangential } = contacts;
        let friction = tangential.lanes().copied().unwrap_or_default();
        let tangential = SpringLanes { friction, spring: tangential.spring().copied().unwrap_or_default() };
        let contacts = ContactLanes { normal, bias, regularisation, impulse_normal, tangential };
        PairGroup { first, second, contacts }
    }

    /// Empties all lanes; the constraint data remain until they are overwritten.
    pub(crate) fn clear(&mut self, dummies: u32) {
        [self.first, self.second] = padding_places(dummies);
    }
}

/// Returns the slots of the padding lanes of pairs: padding bodies of a box from `dummies` on.
pub(crate) fn padding_places(dummies: u32) -> [[u32; LANES]; 2] {
    [0, LANES as u32].map(|side| std::array::from_fn(|lane| dummies + side + lane as u32))
}

impl WallGroup {
    /// Creates a group of padding lanes, as [`PairGroup::padding`] does.
    pub(crate) fn padding(dummies: u32) -> WallGroup {
        let body = std::array::from_fn(|lane| dummies + lane as u32);
        WallGroup { body, wall_velocity: Default::default(), contacts: ContactLanes::default() }
    }

    /// Empties all lanes, as [`PairGroup::clear`] does.
    pub(crate) fn clear(&mut self, dummies: u32) {
        self.body = std::array::from_fn(|lane| dummies + lane as u32);
    }
}

impl Sources {
    /// Sources of an empty group.
    pub(crate) const NONE: Sources = Sources([NO_SOURCE; LANES]);

    pub(crate) fn set(&mut self, lane: usize, candidate: u32) {
        self.0[lane] = candidate;
    }

    /// Returns the occupied lanes with the candidates of their contacts.
    pub fn occupied(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let occupied = |&(_, &source): &(usize, &u32)| source != NO_SOURCE;
        self.0.iter().enumerate().filter(occupied).map(|(lane, &source)| (lane, source as usize))
    }

    /// Returns true if all lanes are occupied. Lanes are filled in their order.
    pub fn is_full(&self) -> bool {
        self.0[LANES - 1] != NO_SOURCE
    }

    /// Returns the candidates, with `nothing` for empty lanes.
    #[inline(always)]
    pub(crate) fn or(&self, nothing: u32) -> [u32; LANES] {
        self.0.map(|source| source.min(nothing))
    }
}
