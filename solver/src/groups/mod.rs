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

/// Marks a lane that holds no contact.
const NO_SOURCE: u32 = u32::MAX;

/// Constraint data and impulses of eight contacts, or of sixteen in single precision; `T` is what friction adds, `()` where grains
/// are smooth.
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
    /// Friction coefficients and tangential impulses, if there is friction.
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
    /// Places of the first bodies.
    pub first: [u32; LANES],
    /// Places of the second bodies.
    pub second: [u32; LANES],
    /// Their contacts.
    pub contacts: ContactLanes<Eight, T>,
}

/// Eight contacts of different grains with walls. They are few, and have room for friction and springs whether there are any or not.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct WallGroup {
    /// Places of the grains.
    pub body: [u32; LANES],
    /// Velocities of the wall at the contacts, m/s.
    pub wall_velocity: [Eight; 3],
    /// Their contacts.
    pub contacts: ContactLanes<Eight, SpringLanes>,
}

/// Impact that a candidate is in, kept until its two sides separate: see `effects/impact.rs`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ImpactMemory {
    /// Speed of first touch, m/s, positive; -1 where the two rest on each other, 0 where they are apart.
    pub speed: f32,
    /// Normal velocity at the start of the last step, m/s; positive where the two separate; without meaning where the speed is 0.
    pub velocity: f32,
}

impl ImpactMemory {
    /// Returns true if the two touch.
    pub(crate) fn touches(&self) -> bool {
        self.speed != 0.0
    }
}

/// Impacts of eight contacts, as their candidates are to remember them. Kept beside the group, because sweeps need none of it.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct ImpactLanes {
    /// Speeds: see [`ImpactMemory`].
    pub speed: [f32; LANES],
    /// Normal velocities at the start of the step, m/s.
    pub velocity: [f32; LANES],
}

/// Candidates that the contacts of a lane group came from. Kept beside the group, because sweeps need none of it.
#[derive(Clone, Copy, Debug)]
pub struct Sources([u32; LANES]);

impl<T: Tangential> ContactLanes<Eight, T> {
    /// Normal impulse of the contact in a lane, N s.
    pub fn normal_impulse(&self, lane: usize) -> f64 {
        self.impulse_normal.0[lane]
    }

    /// Tangential impulse of the contact in a lane, N s.
    pub fn tangential_impulse(&self, lane: usize) -> [f64; 3] {
        let impulse = |lanes: &FrictionLanes| std::array::from_fn(|axis| lanes.impulse[axis].0[lane]);
        self.tangential.lanes().map_or([0.0; 3], impulse)
    }

    /// Friction coefficient of the contact in a lane.
    pub fn friction(&self, lane: usize) -> f64 {
        self.tangential.lanes().map_or(0.0, |lanes| lanes.coefficient.0[lane])
    }

    /// Normal of the contact in a lane.
    pub fn normal(&self, lane: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.normal[axis].0[lane])
    }
}

impl ImpactLanes {
    /// Reads what the candidates of eight contacts remember: speeds, and velocities at the start of the last step.
    #[inline(always)]
    pub(crate) fn load<L: Lanes>(impacts: Slots<'_, ImpactMemory>, candidates: &[u32; LANES]) -> [L; 2] {
        let known = candidates.map(|candidate| impacts.get_trusted(candidate));
        [known.map(|one| f64::from(one.speed)), known.map(|one| f64::from(one.velocity))]
            .map(|eight| L::load(&Eight(eight)))
    }

    /// Memories of eight contacts. A speed is rounded downwards, so that no impact leaves faster for it; one that has been
    /// rounded stays.
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

    /// Memory of the contact in a lane.
    #[inline(always)]
    pub(crate) fn memory(&self, lane: usize) -> ImpactMemory {
        ImpactMemory { speed: self.speed[lane], velocity: self.velocity[lane] }
    }
}

impl<T: Tangential> PairGroup<T> {
    /// A group of padding lanes, which point at a box's dummies, the first of them at `dummies`.
    pub(crate) fn padding(dummies: u32) -> Self {
        let [first, second] = padding_places(dummies);
        PairGroup { first, second, contacts: ContactLanes::default() }
    }

    /// Converts to a layout with room for friction and springs.
    pub(crate) fn with_all(&self) -> PairGroup<SpringLanes> {
        let PairGroup { first, second, contacts } = *self;
        let ContactLanes { normal, bias, regularisation, impulse_normal, tangential } = contacts;
        let friction = tangential.lanes().copied().unwrap_or_default();
        let tangential = SpringLanes { friction, spring: tangential.spring().copied().unwrap_or_default() };
        let contacts = ContactLanes { normal, bias, regularisation, impulse_normal, tangential };
        PairGroup { first, second, contacts }
    }

    /// Empties all lanes; the constraint data stay, to be overwritten.
    pub(crate) fn clear(&mut self, dummies: u32) {
        [self.first, self.second] = padding_places(dummies);
    }
}

/// Indices of the padding lanes of pairs: at a box's dummies, the first of them at `dummies`.
pub(crate) fn padding_places(dummies: u32) -> [[u32; LANES]; 2] {
    [0, LANES as u32].map(|side| std::array::from_fn(|lane| dummies + side + lane as u32))
}

impl WallGroup {
    /// As [`PairGroup::padding`].
    pub(crate) fn padding(dummies: u32) -> WallGroup {
        let body = std::array::from_fn(|lane| dummies + lane as u32);
        WallGroup { body, wall_velocity: Default::default(), contacts: ContactLanes::default() }
    }

    /// As [`PairGroup::clear`].
    pub(crate) fn clear(&mut self, dummies: u32) {
        self.body = std::array::from_fn(|lane| dummies + lane as u32);
    }
}

impl Sources {
    /// No lane holds a contact.
    pub(crate) const NONE: Sources = Sources([NO_SOURCE; LANES]);

    pub(crate) fn set(&mut self, lane: usize, candidate: u32) {
        self.0[lane] = candidate;
    }

    /// Lanes that hold a contact, with the candidates that these came from.
    pub fn occupied(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let occupied = |&(_, &source): &(usize, &u32)| source != NO_SOURCE;
        self.0.iter().enumerate().filter(occupied).map(|(lane, &source)| (lane, source as usize))
    }

    /// Returns true if each lane holds a contact. Lanes are filled in their order.
    pub fn is_full(&self) -> bool {
        self.0[LANES - 1] != NO_SOURCE
    }

    /// The candidates, `nothing` in the place of those that are not there.
    #[inline(always)]
    pub(crate) fn or(&self, nothing: u32) -> [u32; LANES] {
        self.0.map(|source| source.min(nothing))
    }
}
