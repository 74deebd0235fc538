//! Kernels over the contacts of a task, generic over pairs and walls.

use super::problem::Tally;
use crate::effects::term::{TangentialTerm, TermState};
use crate::groups::{ContactLanes, ContactLayout, Effects, PairGroup, WallGroup, WallTorqueLanes};
use crate::lanes::{Eight, Kernel, Lanes, PREFETCH, Slots, TaskSlots, cross, dot, minus, prefetch_places, times};
use crate::partition::TaskGroups;
use crate::sweep::kernel::{Bodies, Contact, Pair};
use crate::sweep::{Directions, LaneResidual, Off, Turning};
use crate::world::Body;
use std::marker::PhantomData;

/// Vectors of eight contacts, three components each, in the world frame.
pub(crate) type Block = [Eight; 3];

/// Reads eight vectors.
#[inline(always)]
pub(crate) fn load<L: Lanes>(block: &Block) -> [L; 3] {
    [L::load(&block[0]), L::load(&block[1]), L::load(&block[2])]
}

/// Writes eight vectors.
#[inline(always)]
pub(crate) fn store<L: Lanes>(vector: [L; 3], block: &mut Block) {
    for axis in 0..3 {
        vector[axis].store(&mut block[axis]);
    }
}

/// Adds to a sum in memory.
#[inline(always)]
pub(crate) fn add<L: Lanes>(sum: &mut Eight, value: L) {
    (L::load(sum) + value).store(sum);
}

/// Access of a kernel to a lane group of contacts with grains or with walls.
pub(crate) trait Group<E: Effects> {
    /// Reads the contacts.
    fn read<L: Lanes>(&self) -> Contact<L, E>;

    /// Writes the impulses back.
    fn write<L: Lanes>(&mut self, contact: &Contact<L, E>);

    /// Prefetches the cache lines of its bodies.
    fn fetch(&self, bodies: Slots<'_, Body>);

    /// Relative velocities at the contacts and inverse masses S_n. `wall_share` scales the velocity of walls: 1 for velocities, 0
    /// for changes of velocities.
    fn velocity<L: Lanes>(&self, bodies: Slots<'_, Body>, contact: &Contact<L, E>, wall_share: f64) -> ([L; 3], L);

    /// Applies an impulse to the bodies.
    fn push<L: Lanes>(&self, bodies: TaskSlots<'_, Body>, normal: [L; 3], impulse: [L; 3]);
}

impl<E: Effects> Group<E> for PairGroup<E::Tangential> {
    #[inline(always)]
    fn read<L: Lanes>(&self) -> Contact<L, E> {
        Contact::<L, E>::read(&self.contacts, L::load)
    }

    #[inline(always)]
    fn write<L: Lanes>(&mut self, contact: &Contact<L, E>) {
        contact.write(&mut self.contacts, L::store);
    }

    #[inline(always)]
    fn fetch(&self, bodies: Slots<'_, Body>) {
        prefetch_places(bodies.as_ptr(), &self.first);
        prefetch_places(bodies.as_ptr(), &self.second);
    }

    #[inline(always)]
    fn velocity<L: Lanes>(&self, bodies: Slots<'_, Body>, contact: &Contact<L, E>, _: f64) -> ([L; 3], L) {
        let pair = Pair::load::<E>(bodies, self);
        (contact.velocity(&pair), pair.inverse_mass)
    }

    #[inline(always)]
    fn push<L: Lanes>(&self, bodies: TaskSlots<'_, Body>, normal: [L; 3], impulse: [L; 3]) {
        Pair::push::<E>(bodies, self, [impulse, cross(normal, impulse)]);
    }
}

impl<E: Effects> Group<E> for WallGroup {
    #[inline(always)]
    fn read<L: Lanes>(&self) -> Contact<L, E> {
        Contact::<L, E>::read(&self.contacts, L::load)
    }

    #[inline(always)]
    fn write<L: Lanes>(&mut self, contact: &Contact<L, E>) {
        contact.write(&mut self.contacts, L::store);
    }

    #[inline(always)]
    fn fetch(&self, bodies: Slots<'_, Body>) {
        prefetch_places(bodies.as_ptr(), &self.body);
    }

    #[inline(always)]
    fn velocity<L: Lanes>(&self, bodies: Slots<'_, Body>, contact: &Contact<L, E>, wall_share: f64) -> ([L; 3], L) {
        let grain = Bodies::<L>::load::<E>(bodies, &self.body);
        let wall_velocity = times(load(&self.wall_velocity), L::splat(wall_share));
        (contact.velocity(&Pair::with_wall(&grain, wall_velocity)), grain.inverse_mass)
    }

    #[inline(always)]
    fn push<L: Lanes>(&self, bodies: TaskSlots<'_, Body>, normal: [L; 3], impulse: [L; 3]) {
        let mut grain = Bodies::<L>::load::<E>(bodies.to_read(), &self.body);
        grain.push::<E>(-1.0, impulse, cross(normal, impulse));
        grain.store::<E>(bodies, &self.body);
    }
}

/// Operation on one lane group after another.
pub(crate) trait ContactPass {
    /// Bodies to prefetch, if any.
    #[inline(always)]
    fn bodies(&self) -> Option<Slots<'_, Body>> {
        None
    }

    /// Applies the operation to the group with this number in its task, pairs first.
    fn apply<L: Lanes, G: Group<E>, E: Effects>(&mut self, number: usize, group: &mut G);
}

/// Pass over every group of a task.
pub(crate) struct PassOverTask<'a, V, E: Effects> {
    pub groups: &'a mut TaskGroups,
    pub pass: V,
    pub effects: PhantomData<E>,
}

impl<V: ContactPass, E: Effects> Kernel for PassOverTask<'_, V, E> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let (pairs, walls) = (E::Tangential::of_mut(&mut self.groups.pairs), &mut self.groups.walls);
        for number in 0..pairs.len() {
            if let Some(bodies) = self.pass.bodies()
                && let Some(ahead) = pairs.get(number + PREFETCH)
            {
                Group::<E>::fetch(ahead, bodies);
            }
            self.pass.apply::<L, _, E>(number, &mut pairs[number]);
        }
        for (number, group) in walls.iter_mut().enumerate() {
            self.pass.apply::<L, _, E>(pairs.len() + number, group);
        }
    }
}

impl<L: Lanes, T: TangentialTerm<L>> ContactLanes<L, TermState<L, T>> {
    /// Splits an impulse into its normal and tangential parts.
    #[inline(always)]
    pub(crate) fn set_impulse(&mut self, impulse: [L; 3]) {
        self.impulse_normal = dot(self.normal, impulse);
        self.tangential.impulse = minus(impulse, times(self.normal, self.impulse_normal));
    }

    /// Projects the impulse: the normal part onto repulsion, then the tangential part onto the limit of the contact.
    #[inline(always)]
    pub(crate) fn project(&mut self) {
        self.impulse_normal = self.impulse_normal.larger(L::zero());
        if T::ACTS {
            let TermState { impulse, term } = self.tangential;
            self.tangential.impulse = term.project(impulse, (self.normal, self.impulse_normal));
        }
    }
}

/// Adds the change by one unrelaxed update of each contact's torque by itself, as a surface velocity, m/s. A torque is bounded by
/// the normal impulse after such an update, like friction.
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
        let (one, mut residual) = (L::splat(1.0), LaneResidual::<L>::read(&self.tally.residual));
        for (group, torques) in E::Tangential::of(pairs).iter().zip(pair_torques) {
            let [first, second] =
                [&group.first, &group.second].map(|places| Bodies::<L>::load::<E>(self.bodies, places));
            let mut torque = TermState::<L, E::Torque<L>>::angular(torques, L::load);
            let bearing = bearing::<L, _, E>(group, self.bodies);
            Turning::of(&first, &second).relax::<Directions>(&mut torque, bearing, one, &mut residual);
        }
        for (group, WallTorqueLanes { wall_spin, torques }) in walls.iter().zip(wall_torques) {
            let turning = Turning::with_wall(&Bodies::<L>::load::<E>(self.bodies, &group.body), load(wall_spin));
            let mut torque = TermState::<L, E::Torque<L>>::angular(torques, L::load);
            let bearing = bearing::<L, _, E>(group, self.bodies);
            turning.relax::<Directions>(&mut torque, bearing, one, &mut residual);
        }
        residual.write(&mut self.tally.residual);
    }
}

/// Normals and normal impulses of a group's contacts, each relaxed by itself.
#[inline(always)]
fn bearing<L: Lanes, G: Group<E>, E: Effects>(group: &G, bodies: Slots<'_, Body>) -> ([L; 3], L) {
    let mut contact: Contact<L, E> = group.read();
    let (velocity, inverse_mass) = group.velocity(bodies, &contact, 1.0);
    contact.relax::<Off>(velocity, inverse_mass, L::splat(1.0), &mut LaneResidual::zero());
    (contact.normal, contact.impulse_normal)
}
