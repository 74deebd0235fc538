//! Relaxation of the pairs of a task, group after group.

use super::Sweep;
use super::kernel::{Bodies, Contact, Pair};
use super::residual::{LaneResidual, MeasuredLevel};
use super::torques::Turning;
use crate::effects::term::TermState;
use crate::groups::{ContactLayout, Effects, PairGroup};
use crate::lanes::{Lanes, prefetch_lines, prefetch_places};
use crate::partition::TaskGroups;

impl<E: Effects, G: MeasuredLevel> Sweep<'_, E, G> {
    /// Relaxes the pairs, one group after another.
    #[inline(always)]
    pub(super) fn relax_in_turn<L: Lanes>(&mut self, factor: L, residual: &mut LaneResidual<L>) {
        let TaskGroups { pairs, pair_torques, .. } = &mut *self.groups;
        let pairs = E::Tangential::of_mut(pairs);
        for number in 0..pairs.len() {
            fetch(self.bodies.as_ptr(), pairs, number, self.prefetch);
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
            let mut first = Bodies::<L>::load::<E>(self.bodies.to_read(), &group.first);
            let mut second = Bodies::<L>::load::<E>(self.bodies.to_read(), &group.second);
            let pair = Pair::of(&first, &second);
            let [impulse, lever] = contact.relax_with_lever::<G>(&pair, factor, residual);
            first.push::<E>(-1.0, impulse, lever);
            second.push::<E>(1.0, impulse, lever);
            let torques = &mut pair_torques[number];
            let mut torque = TermState::<L, E::Torque<L>>::angular(torques, L::load);
            let bearing = (contact.normal, contact.impulse_normal);
            let change = Turning::of(&first, &second).relax::<G>(&mut torque, bearing, factor, residual);
            first.turn(-1.0, change);
            second.turn(1.0, change);
            torque.write(&mut torques.impulse, L::store);
            first.store::<E>(self.bodies, &group.first);
            second.store::<E>(self.bodies, &group.second);
            contact.write(&mut group.contacts, L::store);
        }
    }

    /// Relaxes the pairs as a pipeline of three groups, to the same bits; not for contacts that transmit torques.
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
        let TaskGroups { pairs, pair_waits, .. } = &mut *self.groups;
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
            if next < pairs.len() && (relaxed.is_none() || pair_waits.get(next) == Some(&false)) {
                fetch(self.bodies.as_ptr(), pairs, next, self.prefetch);
                read = Some((next, Pair::load::<E>(self.bodies.to_read(), &pairs[next])));
                next += 1;
            }
        }
    }
}

/// Prefetches the bodies of the group at the given distance, and the group at twice the distance; nothing for distance 0.
#[inline(always)]
fn fetch<B, T>(bodies: *const B, pairs: &[PairGroup<T>], number: usize, distance: usize) {
    if distance > 0 {
        // The group is prefetched before its bodies.
        prefetch_lines(pairs.as_ptr().wrapping_add(number + 2 * distance), size_of::<PairGroup<T>>());
        if let Some(ahead) = pairs.get(number + distance) {
            prefetch_places(bodies, &ahead.first);
            prefetch_places(bodies, &ahead.second);
        }
    }
}
