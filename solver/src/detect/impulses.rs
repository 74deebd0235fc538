//! Memory of candidates from step to step: impulses, from which the next step starts, and impacts in progress.

use crate::groups::ImpactMemory;
use crate::lanes::TaskSlots;
use crate::partition::{ByBlocks, ByCandidates};
use bytemuck::{Pod, Zeroable};

/// Impulse that a candidate bore in the last step, N s; the tangential part is a world vector. One quad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Impulse {
    /// Normal impulse.
    pub normal: f64,
    /// Tangential impulse on the second body or on the wall.
    pub tangential: [f64; 3],
}

impl Impulse {
    /// Whether it is zero to the last bit: a negative zero is none.
    pub(crate) fn is_blank(&self) -> bool {
        let [x, y, z] = self.tangential;
        [self.normal, x, y, z].iter().all(|component| component.to_bits() == 0)
    }
}

/// Angular impulse that a candidate bore in the last step, on its second side, N m s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct AngularImpulse(pub [f64; 3]);

/// What each candidate bore in the last step.
#[derive(Clone, Debug)]
pub struct ContactImpulses {
    /// Impulse of each pair that bore any, and one of zero behind them all. Those of other pairs mean nothing.
    pub pairs: Vec<Impulse>,
    /// Which pairs bore an impulse, or may have: those that were contacts in the last step, and since the list was built those that
    /// were given one. Bits, a byte for each block of a task's pairs.
    pub(crate) borne: Vec<u8>,
    /// Impulse of each grain and surface, and one of zero behind them.
    pub walls: Vec<Impulse>,
    /// Impacts of the same pairs, and an empty one behind them.
    pub pair_impacts: Vec<ImpactMemory>,
    /// Impacts of each grain and surface, and an empty one behind them.
    pub wall_impacts: Vec<ImpactMemory>,
    /// Angular impulses of the same, where contacts bear torques; empty elsewhere. They mean nothing where the normal impulse
    /// is zero.
    pub pair_torques: Vec<AngularImpulse>,
    /// As `pair_torques`.
    pub wall_torques: Vec<AngularImpulse>,
}

impl Default for ContactImpulses {
    fn default() -> ContactImpulses {
        let (pairs, walls) = (vec![Impulse::default()], vec![Impulse::default()]);
        let [pair_impacts, wall_impacts] = [0, 1].map(|_| vec![ImpactMemory::default()]);
        let (borne, pair_torques, wall_torques) = (Vec::new(), Vec::new(), Vec::new());
        ContactImpulses { pairs, borne, walls, pair_impacts, wall_impacts, pair_torques, wall_torques }
    }
}

/// What the candidates of one task bore.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImpulsesOfTask<'a> {
    pub pairs: TaskSlots<'a, Impulse>,
    pub walls: TaskSlots<'a, Impulse>,
    pub pair_impacts: TaskSlots<'a, ImpactMemory>,
    pub wall_impacts: TaskSlots<'a, ImpactMemory>,
    pub pair_torques: TaskSlots<'a, AngularImpulse>,
    pub wall_torques: TaskSlots<'a, AngularImpulse>,
}

/// How tasks that run at the same time share them out: each candidate belongs to one task.
type ImpulseShares<'a> =
    ([ByCandidates<'a, Impulse>; 2], [ByCandidates<'a, ImpactMemory>; 2], [ByCandidates<'a, AngularImpulse>; 2]);

/// Shares of one task.
type OwnImpulses<'a> =
    ([TaskSlots<'a, Impulse>; 2], [TaskSlots<'a, ImpactMemory>; 2], [TaskSlots<'a, AngularImpulse>; 2]);

impl ContactImpulses {
    /// What the candidates of each task bore, and for each block of its pairs which of them did.
    pub(crate) fn shares(&mut self) -> (ImpulseShares<'_>, ByBlocks<'_, u8>) {
        let ContactImpulses { pairs, borne, walls, pair_impacts, wall_impacts, pair_torques, wall_torques } = self;
        let impulses = [pairs, walls].map(|impulses| ByCandidates::of(impulses));
        let impacts = [pair_impacts, wall_impacts].map(|impacts| ByCandidates::of(impacts));
        let torques = [pair_torques, wall_torques].map(|torques| ByCandidates::of(torques));
        ((impulses, impacts, torques), ByBlocks::of(borne))
    }
}

impl<'a> From<OwnImpulses<'a>> for ImpulsesOfTask<'a> {
    fn from((impulses, impacts, torques): OwnImpulses<'a>) -> ImpulsesOfTask<'a> {
        let ([pairs, walls], [pair_impacts, wall_impacts], [pair_torques, wall_torques]) = (impulses, impacts, torques);
        ImpulsesOfTask { pairs, walls, pair_impacts, wall_impacts, pair_torques, wall_torques }
    }
}
