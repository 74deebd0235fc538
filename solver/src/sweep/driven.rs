//! Relaxation of contacts with dynamic walls, one after another: see [`drive`](crate::effects::drive).

use super::Relaxation;
use super::kernel::{Bodies, Contact, Pair};
use super::residual::{LaneResidual, MeasuredLevel, ResidualLevel, TaskResidual, with_level};
use super::torques::Turning;
use crate::effects::drive::Drive;
use crate::effects::term::TermState;
use crate::groups::{Effects, WallGroup, with_effects};
use crate::lanes::{Eight, TaskSlots, cross, dot, minus, plus, times};
use crate::partition::{DRIVEN_STAGE, DrivenContact, Layout, Ranks, TaskGroups};
use crate::world::Body;

impl Relaxation {
    /// Relaxes every contact with a dynamic wall once, and adds its residuals of the level.
    pub(crate) fn sweep_driven(
        &self,
        bodies: &mut [Body],
        layout: &mut Layout,
        drives: &mut [Drive],
        factor: f64,
        level: ResidualLevel,
    ) -> TaskResidual {
        with_effects!(self.effects, E => with_level!(level, G => sweep::<E, G>(bodies, layout, drives, factor)))
    }
}

fn sweep<E: Effects, G: MeasuredLevel>(
    bodies: &mut [Body],
    layout: &mut Layout,
    drives: &mut [Drive],
    factor: f64,
) -> TaskResidual {
    let Layout { groups, driven, ranks, .. } = layout;
    if let Some(ranks) = ranks {
        ranks.pass_on(DRIVEN_STAGE, TaskSlots::of(bodies));
    }
    let mut residual = TaskResidual::default();
    in_turn(ranks.as_ref(), driven, drives, &mut residual, |one, drive, residual| {
        let own = relax::<E, G>(one, &mut groups[one.task as usize], bodies, drive, factor);
        if G::ANY {
            residual.add_lane(one.lane as usize, own);
        }
    });
    residual
}

/// Calls a function for each contact with a dynamic wall, on all ranks in the order of their tasks.
fn in_turn(
    ranks: Option<&Ranks>,
    driven: &[DrivenContact],
    drives: &mut [Drive],
    residual: &mut TaskResidual,
    mut act: impl FnMut(&DrivenContact, &mut Drive, &mut TaskResidual),
) {
    let mut act_on = |contacts: &[DrivenContact], drives: &mut [Drive], residual: &mut TaskResidual| {
        contacts.iter().for_each(|one| act(one, &mut drives[one.drive as usize], residual));
    };
    let Some(ranks) = ranks else { return act_on(driven, drives, residual) };
    let mut state = (drives.iter().map(Drive::speeds).collect::<Vec<_>>(), bytemuck::bytes_of(residual).to_vec());
    ranks.in_turn(&mut state, |contacts, (speeds, sums)| {
        drives.iter_mut().zip(&*speeds).for_each(|(drive, &speeds)| drive.set_speeds(speeds));
        *residual = bytemuck::pod_read_unaligned(sums);
        act_on(&driven[contacts], drives, residual);
        (*speeds, *sums) = (drives.iter().map(Drive::speeds).collect(), bytemuck::bytes_of(residual).to_vec());
    });
    drives.iter_mut().zip(state.0).for_each(|(drive, speeds)| drive.set_speeds(speeds));
    *residual = bytemuck::pod_read_unaligned(&state.1);
}

/// One-contact solution, including the wall's inertia.
#[inline(always)]
fn relax<E: Effects, G: MeasuredLevel>(
    one: &DrivenContact,
    task: &mut TaskGroups,
    bodies: &mut [Body],
    drive: &mut Drive,
    factor: f64,
) -> LaneResidual<f64> {
    let (number, lane) = (one.group as usize, one.lane as usize);
    let group = &mut task.walls[number];
    let body = &mut bodies[group.body[lane] as usize];
    let (mut grain, mut residual) = (Bodies::of(body), LaneResidual::zero());
    let mut contact = Contact::<f64, E>::read(&group.contacts, |eight| eight.0[lane]);
    let along = dot(contact.normal, one.jacobian);
    // Normal impulse, projected onto repulsion.
    let velocity = contact.velocity(&Pair::with_wall(&grain, one.velocity(drive.rate)));
    let operator = grain.inverse_mass + drive.inverse_inertia * along * along + contact.regularisation;
    let violation = contact.bias - dot(contact.normal, velocity) - contact.regularisation * contact.impulse_normal;
    let updated = (contact.impulse_normal + factor * violation / operator).max(0.0);
    let change = updated - contact.impulse_normal;
    contact.impulse_normal = updated;
    grain.push::<E>(-1.0, times(contact.normal, change), [0.0; 3]);
    drive.push(along * change);
    if G::ANY {
        residual.add_normal::<G>(change * operator);
    }
    if E::FRICTION {
        // Tangential impulse, at the velocity after the normal impulse.
        let velocity = contact.velocity(&Pair::with_wall(&grain, one.velocity(drive.rate)));
        let tangential = minus(velocity, times(contact.normal, dot(contact.normal, velocity)));
        let across = (dot(one.jacobian, one.jacobian) - along * along).max(0.0);
        let operator = contact.tangential_operator(grain.inverse_mass) + drive.inverse_inertia * across;
        let change = contact.tangential.relax((contact.normal, updated), tangential, operator, factor);
        grain.push::<E>(-1.0, change, cross(contact.normal, change));
        drive.push(dot(one.jacobian, change));
        if G::ANY {
            residual.add_tangential::<G>(contact.normal, times(change, operator));
        }
    }
    if E::TORQUES {
        let axis: [f64; 3] = drive.turning().into();
        let lanes = &mut task.wall_torques[number].torques;
        let mut torque = TermState::<f64, E::Torque<f64>>::angular(lanes, |eight| eight.0[lane]);
        let mut turning = Turning::with_wall(&grain, times(axis, drive.rate));
        turning.operator += drive.inverse_inertia * dot(axis, axis);
        let change = turning.relax::<G>(&mut torque, (contact.normal, updated), factor, &mut residual);
        grain.turn(-1.0, change);
        drive.push(dot(axis, change));
        torque.write(&mut lanes.impulse, |value, eight: &mut Eight| eight.0[lane] = value);
    }
    grain.put::<E>(body);
    contact.write(&mut group.contacts, |value, eight: &mut Eight| eight.0[lane] = value);
    residual
}

impl DrivenContact {
    /// Velocity of the wall at the contact, m/s, for a rate of the drive, m/s or rad/s.
    #[inline(always)]
    pub(crate) fn velocity(&self, rate: f64) -> [f64; 3] {
        plus(times(self.jacobian, rate), self.drift)
    }
}

/// Applies the starting impulses of their contacts to dynamic walls.
pub(crate) fn start_driven(layout: &Layout, drives: &mut [Drive]) {
    let Layout { groups, driven, ranks, .. } = layout;
    in_turn(ranks.as_ref(), driven, drives, &mut TaskResidual::default(), |one, drive, _| {
        let task = &groups[one.task as usize];
        let (number, lane) = (one.group as usize, one.lane as usize);
        let WallGroup { contacts, .. } = &task.walls[number];
        let pull = task.wall_pulls.get(number).map_or(0.0, |pulls| pulls.0[lane]);
        let along = times(contacts.normal(lane), contacts.normal_impulse(lane) - pull);
        drive.push(dot(one.jacobian, plus(along, contacts.tangential_impulse(lane))));
        if let Some(lanes) = task.wall_torques.get(number) {
            drive.push(dot(drive.turning().into(), lanes.torques.angular_impulse(lane)));
        }
    });
}

/// Copies the present rates of dynamic walls to their contacts.
pub(crate) fn tell_driven(layout: &mut Layout, drives: &[Drive]) {
    let Layout { groups, driven, .. } = layout;
    for one in &*driven {
        let (task, drive) = (&mut groups[one.task as usize], &drives[one.drive as usize]);
        let (number, lane) = (one.group as usize, one.lane as usize);
        let (velocity, spin) = (one.velocity(drive.rate), drive.turning() * drive.rate);
        for axis in 0..3 {
            task.walls[number].wall_velocity[axis].0[lane] = velocity[axis];
            if let Some(lanes) = task.wall_torques.get_mut(number) {
                lanes.wall_spin[axis].0[lane] = spin[axis];
            }
        }
    }
}
