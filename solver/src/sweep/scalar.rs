//! The same relaxation one contact at a time: the baseline of the benches, and a witness for the lanes.

use super::kernel::{Bodies, Contact};
use super::residual::{LaneResidual, TaskResidual};
use crate::lanes::{Eight, LANES};
use crate::partition::TaskGroups;
use crate::world::Body;

/// Relaxes a task's contacts once, lane after lane.
///
/// # Safety
/// The groups name bodies behind `bodies`, and no other task uses these.
pub(super) unsafe fn sweep<const FRICTION: bool, const MEASURE: bool>(
    bodies: *mut Body,
    groups: &mut TaskGroups,
    relaxation: f64,
    residual: &mut TaskResidual,
) {
    // SAFETY: the caller's promise; the two bodies of a contact are different ones.
    let at = |place: u32| unsafe { &mut *bodies.add(place as usize) };
    for group in &mut groups.pairs {
        for lane in 0..LANES {
            let (a, b) = (group.first[lane], group.second[lane]);
            let (mut first, mut second) = (Bodies::of(at(a)), Bodies::of(at(b)));
            let mut contact = Contact::read(&group.contacts, |eight| eight.0[lane]);
            let mut own = LaneResidual::zero();
            contact.relax_pair::<FRICTION, MEASURE>(&mut first, &mut second, relaxation, &mut own);
            put::<FRICTION>(at(a), &first);
            put::<FRICTION>(at(b), &second);
            contact.write::<FRICTION, _>(&mut group.contacts, |value, eight: &mut Eight| eight.0[lane] = value);
            if MEASURE {
                residual.add_lane(lane, own);
            }
        }
    }
    for group in &mut groups.walls {
        for lane in 0..LANES {
            let place = group.body[lane];
            let mut grain = Bodies::of(at(place));
            let mut contact = Contact::read(&group.contacts, |eight| eight.0[lane]);
            let wall_velocity = group.wall_velocity.each_ref().map(|eight| eight.0[lane]);
            let mut own = LaneResidual::zero();
            contact.relax_wall::<FRICTION, MEASURE>(&mut grain, wall_velocity, relaxation, &mut own);
            put::<FRICTION>(at(place), &grain);
            contact.write::<FRICTION, _>(&mut group.contacts, |value, eight: &mut Eight| eight.0[lane] = value);
            if MEASURE {
                residual.add_lane(lane, own);
            }
        }
    }
}

#[inline(always)]
fn put<const FRICTION: bool>(body: &mut Body, new: &Bodies<f64>) {
    body.velocity = new.velocity;
    if FRICTION {
        body.surface_speed = new.surface_speed;
    }
}
