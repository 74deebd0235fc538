//! Relaxation of the pairs of a task, group after group.

use super::Sweep;
use super::kernel::{Bodies, Contact, Pair};
use super::residual::{LaneResidual, MeasuredLevel};
use super::torques::Turning;
use crate::effects::resistance::TorqueLanes;
use crate::effects::term::TermState;
use crate::groups::{ContactLayout, Effects, PairGroup};
use crate::lanes::{Lanes, Slots, TaskSlots, prefetch_lines, prefetch_places};
use crate::partition::{PREVIOUS, SECOND_PREVIOUS, TaskGroups};
use crate::world::Body;

impl<E: Effects, G: MeasuredLevel> Sweep<'_, E, G> {
    /// Relaxes the pairs, one group after another.
    #[inline(always)]
    pub(super) fn relax_in_turn<L: Lanes>(&mut self, factor: L, residual: &mut LaneResidual<L>) {
        let TaskGroups { pairs, pair_torques, .. } = &mut *self.groups;
        let pairs = E::Tangential::of_mut(pairs);
        for number in 0..pairs.len() {
            fetch(self.bodies.as_ptr(), (pairs, pair_torques), number, self.prefetch);
            let group = &mut pairs[number];
            let mut contact = Contact::<L, E>::read(&group.contacts, L::load);
            // Without spin, the registers suffice to hold the bodies until they are written.
            if !E::FRICTION {
                let (pair, kept) = Pair::<L>::load_keeping(self.bodies.to_read(), group);
                let [impulse, _] = contact.relax_with_lever::<G>(&pair, factor, residual);
                Pair::push_kept(self.bodies, group, kept, impulse);
                contact.write(&mut group.contacts, L::store);
                continue;
            }
            // Torques need both bodies' spins; otherwise the relative motion suffices, and bodies stay in memory.
            if !E::TORQUES {
                let pair = Pair::<L>::load::<E>(self.bodies.to_read(), group);
                let push = contact.relax_with_lever::<G>(&pair, factor, residual);
                Pair::push::<E>(self.bodies, group, push);
                contact.write(&mut group.contacts, L::store);
                continue;
            }
            let mut bodies = both::<L, E>(self.bodies.to_read(), group);
            push_both::<L, E, G>(&mut bodies, &mut contact, factor, residual);
            turn_both::<L, E, G>(&mut bodies, &contact, &mut pair_torques[number], factor, residual);
            store_both::<L, E>(self.bodies, group, bodies);
            contact.write(&mut group.contacts, L::store);
        }
    }

    /// Relaxes the pairs as a pipeline of three groups, to the same bits; for contacts without torques.
    ///
    /// A group is one long dependency chain: its bodies, a division, a root, another division, its bodies again. Waiting
    /// instructions fill the processor's queues and hide the next group. The pipeline fills this gap: after each relaxed group,
    /// it writes the impulses of the previous group and loads the bodies of the next group, which do not wait.
    ///
    /// ```text
    /// relax 4 · push 3 · read 5 · relax 5 · push 4 · read 6 ...
    /// ```
    ///
    /// A group that shares a body with the previous group is loaded only after that group's impulses are written.
    #[inline(always)]
    pub(super) fn relax_overlapped<L: Lanes>(&mut self, factor: L, residual: &mut LaneResidual<L>) {
        let TaskGroups { pairs, pair_waits, pair_torques, .. } = &mut *self.groups;
        let pairs = E::Tangential::of_mut(pairs);
        let mut next = 0;
        let mut read: Option<(usize, Pair<L>)> = None;
        let mut relaxed: Option<(usize, [[L; 3]; 2])> = None;
        while next < pairs.len() || read.is_some() || relaxed.is_some() {
            let before = relaxed;
            relaxed = None;
            if let Some((number, pair)) = read {
                let contacts = &mut pairs[number].contacts;
                let mut contact = Contact::<L, E>::read(contacts, L::load);
                relaxed = Some((number, contact.relax_with_lever::<G>(&pair, factor, residual)));
                contact.write(contacts, L::store);
            }
            if let Some((number, push)) = before {
                Pair::push::<E>(self.bodies, &pairs[number], push);
            }
            read = None;
            if next < pairs.len() && (relaxed.is_none() || pair_waits.get(next) == Some(&0)) {
                fetch(self.bodies.as_ptr(), (pairs, pair_torques), next, self.prefetch);
                read = Some((next, Pair::load::<E>(self.bodies.to_read(), &pairs[next])));
                next += 1;
            }
        }
    }

    /// Relaxes pairs with torques as a pipeline of four groups, to the same bits.
    ///
    /// The torque of a contact waits for the contact's impulse, in a chain twice as long as that of friction alone. The torques
    /// of one group and the impulses of the next group are independent, and the processor computes them together.
    ///
    /// ```text
    /// turn 3 · push 4 · write 2 · read 5 · turn 4 · push 5 · write 3 · read 6 ...
    /// ```
    ///
    /// A group that shares a body with one of the two previous groups is read only after that group is written.
    #[inline(always)]
    pub(super) fn relax_torques_overlapped<L: Lanes>(&mut self, factor: L, residual: &mut LaneResidual<L>) {
        let TaskGroups { pairs, pair_waits, pair_torques, .. } = &mut *self.groups;
        let pairs = E::Tangential::of_mut(pairs);
        // Bodies of the groups in flight, by the number of the group.
        let mut flight = [[Bodies::<L>::zero(); 2]; FLIGHT];
        let [mut read, mut pushed, mut turned] = [None; 3];
        let mut next = 0;
        while next < pairs.len() || read.is_some() || pushed.is_some() || turned.is_some() {
            let done: Option<usize> = turned;
            (turned, pushed) = (pushed, read);
            if let Some(number) = turned {
                let contact = Contact::<L, E>::read(&pairs[number].contacts, L::load);
                let torques = &mut pair_torques[number];
                turn_both::<L, E, G>(&mut flight[number % FLIGHT], &contact, torques, factor, residual);
            }
            if let Some(number) = pushed {
                let contacts = &mut pairs[number].contacts;
                let mut contact = Contact::<L, E>::read(contacts, L::load);
                push_both::<L, E, G>(&mut flight[number % FLIGHT], &mut contact, factor, residual);
                contact.write(contacts, L::store);
            }
            if let Some(number) = done {
                store_both::<L, E>(self.bodies, &pairs[number], flight[number % FLIGHT]);
            }
            read = None;
            let is_free = |before: usize, shared: u8| {
                let other = next.checked_sub(before);
                let waits = pair_waits.get(next).is_none_or(|marks| marks & shared != 0);
                other.is_none() || (pushed != other && turned != other) || !waits
            };
            if next < pairs.len() && is_free(1, PREVIOUS) && is_free(2, SECOND_PREVIOUS) {
                fetch(self.bodies.as_ptr(), (pairs, pair_torques), next, self.prefetch);
                flight[next % FLIGHT] = both::<L, E>(self.bodies.to_read(), &pairs[next]);
                read = Some(next);
                next += 1;
            }
        }
    }
}

/// Number of groups in flight.
const FLIGHT: usize = 4;

/// Reads the bodies of a group.
#[inline(always)]
fn both<L: Lanes, E: Effects>(bodies: Slots<'_, Body>, group: &PairGroup<E::Tangential>) -> [Bodies<L>; 2] {
    [Bodies::load::<E>(bodies, &group.first), Bodies::load::<E>(bodies, &group.second)]
}

/// Relaxes the impulses of a group, and applies them to its bodies.
#[inline(always)]
fn push_both<L: Lanes, E: Effects, G: MeasuredLevel>(
    [first, second]: &mut [Bodies<L>; 2],
    contact: &mut Contact<L, E>,
    factor: L,
    residual: &mut LaneResidual<L>,
) {
    let [impulse, lever] = contact.relax_with_lever::<G>(&Pair::of(first, second), factor, residual);
    first.push::<E>(-1.0, impulse, lever);
    second.push::<E>(1.0, impulse, lever);
}

/// Relaxes the torques of a group at the spins after its impulses, and applies them to its bodies.
#[inline(always)]
fn turn_both<L: Lanes, E: Effects, G: MeasuredLevel>(
    [first, second]: &mut [Bodies<L>; 2],
    contact: &Contact<L, E>,
    torques: &mut TorqueLanes,
    factor: L,
    residual: &mut LaneResidual<L>,
) {
    let mut torque = TermState::<L, E::Torque<L>>::angular(torques, L::load);
    let bearing = (contact.normal, contact.impulse_normal);
    let change = Turning::of(first, second).relax::<G>(&mut torque, bearing, factor, residual);
    first.turn(-1.0, change);
    second.turn(1.0, change);
    torque.write(&mut torques.impulse, L::store);
}

/// Writes the bodies of a group, unchanged in memory since they were read.
#[inline(always)]
fn store_both<L: Lanes, E: Effects>(
    slots: TaskSlots<'_, Body>,
    group: &PairGroup<E::Tangential>,
    [first, second]: [Bodies<L>; 2],
) {
    first.store::<E>(slots, &group.first);
    second.store::<E>(slots, &group.second);
}

/// Prefetches the bodies of the group at the given distance, and the group at twice the distance; nothing for distance 0.
#[inline(always)]
fn fetch<B, T>(bodies: *const B, (pairs, torques): (&[PairGroup<T>], &[TorqueLanes]), number: usize, distance: usize) {
    if distance > 0 {
        // The group is prefetched before its bodies.
        let ahead = number + 2 * distance;
        prefetch_lines(pairs.as_ptr().wrapping_add(ahead), size_of::<PairGroup<T>>());
        if !torques.is_empty() {
            prefetch_lines(torques.as_ptr().wrapping_add(ahead), size_of::<TorqueLanes>());
        }
        if let Some(ahead) = pairs.get(number + distance) {
            prefetch_places(bodies, &ahead.first);
            prefetch_places(bodies, &ahead.second);
        }
    }
}
