//! The same relaxation one contact at a time: the baseline of the benches, and a witness for the lanes.

use super::kernel::{Bodies, Contact, Pair};
use super::residual::{Gauged, LaneResidual, TaskResidual};
use super::torques::Torque;
use crate::effects::Effects;
use crate::groups::{Kind, WallTorqueLanes};
use crate::lanes::{Eight, LANES};
use crate::partition::TaskGroups;
use crate::world::Body;

/// Relaxes a task's contacts once, lane after lane.
///
/// # Safety
/// The groups name bodies behind `bodies`, and no other task uses these.
pub(super) unsafe fn sweep<E: Effects, G: Gauged>(
    bodies: *mut Body,
    groups: &mut TaskGroups,
    relaxation: f64,
    residual: &mut TaskResidual,
) {
    // SAFETY: the caller's promise; the two bodies of a contact are different ones.
    let at = |place: u32| unsafe { &mut *bodies.add(place as usize) };
    for (number, group) in E::Tangential::of_mut(&mut groups.pairs).iter_mut().enumerate() {
        for lane in 0..LANES {
            let (a, b) = (group.first[lane], group.second[lane]);
            let (mut first, mut second) = (Bodies::of(at(a)), Bodies::of(at(b)));
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
            put::<E>(at(a), &first);
            put::<E>(at(b), &second);
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
            let mut grain = Bodies::of(at(place));
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
            put::<E>(at(place), &grain);
            contact.write::<E, _, _>(&mut group.contacts, |value, eight: &mut Eight| eight.0[lane] = value);
            if G::ANY {
                residual.add_lane(lane, own);
            }
        }
    }
}

#[inline(always)]
pub(super) fn put<E: Effects>(body: &mut Body, new: &Bodies<f64>) {
    body.velocity = new.velocity;
    if E::FRICTION {
        body.surface_speed = new.surface_speed;
    }
}
