//! What candidates bore in the last step, from which the next one starts.

use crate::schedule::Disjoint;

/// Impulse that a candidate bore in the last step, N s; the tangential part is a world vector. One quad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
    /// Angular impulses of the same, where contacts bear torques; empty elsewhere. They mean nothing where the normal impulse
    /// is zero.
    pub pair_torques: Vec<AngularImpulse>,
    /// As `pair_torques`.
    pub wall_torques: Vec<AngularImpulse>,
}

impl Default for ContactImpulses {
    fn default() -> ContactImpulses {
        let (pairs, walls) = (vec![Impulse::default()], vec![Impulse::default()]);
        ContactImpulses { pairs, borne: Vec::new(), walls, pair_torques: Vec::new(), wall_torques: Vec::new() }
    }
}

/// The same for tasks that run at the same time. Each candidate belongs to one task, so that they are written without a lock.
pub(crate) struct ImpulsesOfTasks<'a> {
    pub pairs: Disjoint<'a, Impulse>,
    /// Which pairs bore any, as bits: a byte a block.
    pub borne: Disjoint<'a, u8>,
    pub walls: Disjoint<'a, Impulse>,
    pub pair_torques: Disjoint<'a, AngularImpulse>,
    pub wall_torques: Disjoint<'a, AngularImpulse>,
}

impl ContactImpulses {
    pub(crate) fn of_tasks(&mut self) -> ImpulsesOfTasks<'_> {
        ImpulsesOfTasks {
            pairs: Disjoint::new(&mut self.pairs),
            borne: Disjoint::new(&mut self.borne),
            walls: Disjoint::new(&mut self.walls),
            pair_torques: Disjoint::new(&mut self.pair_torques),
            wall_torques: Disjoint::new(&mut self.wall_torques),
        }
    }
}
