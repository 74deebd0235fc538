//! The same relaxation one contact at a time: the baseline of the benches, and a witness for the lanes.

use super::kernel::{Bodies, Contact, Pair};
use super::residual::{LaneResidual, MeasuredLevel, TaskResidual};
use super::torques::Torque;
use crate::effects::Effects;
use crate::groups::{ContactLayout, WallTorqueLanes};
use crate::lanes::{Eight, LANES, TaskSlots};
use crate::partition::TaskGroups;
use crate::world::Body;

/// Relaxes a task's contacts once, lane after lane.
pub(super) fn sweep<E: Effects, G: MeasuredLevel>(
    bodies: TaskSlots<'_, Body>,
    groups: &mut TaskGroups,
    relaxation: f64,
    residual: &mut TaskResidual,
) {
    let load = |place: u32| Bodies::load_one(bodies, place);
    for (number, group) in E::Tangential::of_mut(&mut groups.pairs).iter_mut().enumerate() {
        for lane in 0..LANES {
            let (a, b) = (group.first[lane], group.second[lane]);
            let (mut first, mut second) = (load(a), load(b));
            let mut contact = Contact::read(&group.contacts, |eight| eight.0[lane]);
            let mut own = LaneResidual::zero();
            let pair = Pair::of(&first, &second);
            let [impulse, lever] = contact.relax_pair::<E, G>(&pair, relaxation, &mut own);
            first.push::<E>(-1.0, impulse, lever);
            second.push::<E>(1.0, impulse, lever);
            if E::TORQUES {
                let torques = &mut groups.pair_torques[number];
                let mut torque = Torque::read(torques, |eight| eight.0[lane]);
                let bearing = (contact.normal, contact.impulse_normal);
                torque.relax_pair::<E, G>(bearing, &mut first, &mut second, relaxation, &mut own);
                torque.write(torques, |value, eight: &mut Eight| eight.0[lane] = value);
            }
            first.store_one::<E>(bodies, a);
            second.store_one::<E>(bodies, b);
            contact.write::<E, _, _>(&mut group.contacts, |value, eight: &mut Eight| eight.0[lane] = value);
            if G::ANY {
                residual.add_lane(lane, own);
            }
        }
    }
    let prescribed = groups.prescribed_walls();
    for (number, group) in groups.walls[..prescribed].iter_mut().enumerate() {
        for lane in 0..LANES {
            let place = group.body[lane];
            let mut grain = load(place);
            let mut contact = Contact::read(&group.contacts, |eight| eight.0[lane]);
            let wall_velocity = group.wall_velocity.each_ref().map(|eight| eight.0[lane]);
            let mut own = LaneResidual::zero();
            let [impulse, lever] = contact.relax_wall::<E, G>(&grain, wall_velocity, relaxation, &mut own);
            grain.push::<E>(-1.0, impulse, lever);
            if E::TORQUES {
                let WallTorqueLanes { wall_spin, torques } = &mut groups.wall_torques[number];
                let mut torque = Torque::read(torques, |eight| eight.0[lane]);
                let bearing = (contact.normal, contact.impulse_normal);
                let wall_spin = wall_spin.each_ref().map(|eight| eight.0[lane]);
                torque.relax_wall::<E, G>(bearing, &mut grain, wall_spin, relaxation, &mut own);
                torque.write(torques, |value, eight: &mut Eight| eight.0[lane] = value);
            }
            grain.store_one::<E>(bodies, place);
            contact.write::<E, _, _>(&mut group.contacts, |value, eight: &mut Eight| eight.0[lane] = value);
            if G::ANY {
                residual.add_lane(lane, own);
            }
        }
    }
}
