//! How far the torques of contacts are from the solution: the same measure as for their impulses, by one more pass.

use super::group::Group;
use super::problem::Tally;
use crate::effects::Effects;
use crate::groups::{ContactLayout, WallTorqueLanes};
use crate::lanes::{Kernel, Lanes, Slots};
use crate::partition::TaskGroups;
use crate::sweep::kernel::{Bodies, Contact};
use crate::sweep::{Directions, LaneResidual, Off, Torque};
use crate::world::Body;
use std::marker::PhantomData;

/// Adds what one unrelaxed update of each contact's torque by itself would change, as a surface velocity, m/s. A torque is bounded by
/// the normal impulse that the contact would have then, as friction is.
pub(super) struct MeasureTorques<'a, E: Effects> {
    pub groups: &'a TaskGroups,
    pub bodies: Slots<'a, Body>,
    pub tally: &'a mut Tally,
    pub effects: PhantomData<E>,
}

impl<E: Effects> Kernel for MeasureTorques<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, pair_torques, walls, wall_torques, .. } = self.groups;
        let mut residual = LaneResidual::<L>::read(&self.tally.residual);
        for (group, torques) in E::Tangential::of(pairs).iter().zip(pair_torques) {
            let bearing = bearing::<L, _, E>(group, self.bodies);
            // Copies are turned, not the bodies.
            let [mut first, mut second] =
                [&group.first, &group.second].map(|places| Bodies::<L>::load::<E>(self.bodies, places));
            let mut torque = Torque::read(torques, L::load);
            torque.relax_pair::<E, Directions>(bearing, &mut first, &mut second, L::splat(1.0), &mut residual);
        }
        for (group, WallTorqueLanes { wall_spin, torques }) in walls.iter().zip(wall_torques) {
            let bearing = bearing::<L, _, E>(group, self.bodies);
            let mut grain = Bodies::<L>::load::<E>(self.bodies, &group.body);
            let wall_spin = wall_spin.each_ref().map(L::load);
            let mut torque = Torque::read(torques, L::load);
            torque.relax_wall::<E, Directions>(bearing, &mut grain, wall_spin, L::splat(1.0), &mut residual);
        }
        residual.write(&mut self.tally.residual);
    }
}

/// Normals and normal impulses of a group's contacts, each relaxed by itself.
#[inline(always)]
fn bearing<L: Lanes, G: Group<E>, E: Effects>(group: &G, bodies: Slots<'_, Body>) -> ([L; 3], L) {
    let mut contact: Contact<L> = group.read();
    let (velocity, inverse_mass) = group.velocity(bodies, &contact, 1.0);
    contact.relax::<E, Off>(velocity, inverse_mass, L::splat(1.0), &mut LaneResidual::zero());
    (contact.normal, contact.impulse_normal)
}
