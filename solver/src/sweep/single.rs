//! Sweep in single precision: the same relaxation, sixteen contacts at a time.

use super::Relaxation;
use super::kernel::{Bodies, Contact, Pair};
use super::residual::{LaneResidual, MeasuredLevel, ResidualLevel, TaskResidual, with_level};
use crate::groups::{Effects, Frictional, Frictionless};
use crate::lanes::{Kernel, Lanes, Number, SingleLanes, TaskSlots, prefetch_lines, prefetch_places};
use crate::partition::{SingleBody, SingleGroups, SinglePairGroup};
use std::marker::PhantomData;

/// One sweep over a task.
pub(super) struct SingleSweep<'a, E: Effects, G: MeasuredLevel> {
    bodies: TaskSlots<'a, SingleBody>,
    groups: &'a mut SingleGroups,
    factor: f64,
    prefetch: usize,
    residual: &'a mut TaskResidual,
    compiled: PhantomData<(E, G)>,
}

impl Relaxation {
    /// Same as [`Relaxation::sweep`], in single precision; always in lanes.
    pub(crate) fn sweep_single(
        &self,
        bodies: TaskSlots<'_, SingleBody>,
        groups: &mut SingleGroups,
        factor: f64,
        level: ResidualLevel,
        residual: &mut TaskResidual,
    ) {
        // Scenes with torques or springs do not allow single precision.
        with_level!(level, G => match self.effects.tangential() {
            true => self.run_single::<Frictional, G>(bodies, groups, factor, residual),
            false => self.run_single::<Frictionless, G>(bodies, groups, factor, residual),
        });
    }

    fn run_single<E: Effects, G: MeasuredLevel>(
        &self,
        bodies: TaskSlots<'_, SingleBody>,
        groups: &mut SingleGroups,
        factor: f64,
        residual: &mut TaskResidual,
    ) {
        let prefetch = self.prefetch.div_ceil(2);
        let compiled = PhantomData;
        self.instruction_set.run(SingleSweep::<E, G> { bodies, groups, factor, prefetch, residual, compiled });
    }
}

impl<E: Effects, G: MeasuredLevel> Kernel for SingleSweep<'_, E, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let factor = <L::Single as Number>::splat(self.factor);
        let mut residual = LaneResidual::<L::Single>::zero();
        let pairs = &mut self.groups.pairs;
        for number in 0..pairs.len() {
            if self.prefetch > 0 {
                // The group is prefetched before its bodies.
                prefetch_lines(pairs.as_ptr().wrapping_add(number + 2 * self.prefetch), SinglePairGroup::used::<E>());
                if let Some(ahead) = pairs.get(number + self.prefetch) {
                    prefetch_places(self.bodies.as_ptr(), &ahead.first);
                    prefetch_places(self.bodies.as_ptr(), &ahead.second);
                }
            }
            let group = &mut pairs[number];
            let mut first = Bodies::<L::Single>::load_single(self.bodies.to_read(), &group.first);
            let mut second = Bodies::<L::Single>::load_single(self.bodies.to_read(), &group.second);
            let mut contact = Contact::<L::Single, E>::read(&group.contacts, L::Single::load);
            let pair = Pair::of(&first, &second);
            let [impulse, lever] = contact.relax_with_lever::<G>(&pair, factor, &mut residual);
            first.push::<E>(-1.0, impulse, lever);
            second.push::<E>(1.0, impulse, lever);
            first.store_single(self.bodies, &group.first);
            second.store_single(self.bodies, &group.second);
            contact.write(&mut group.contacts, L::Single::store);
        }
        for group in &mut self.groups.walls {
            let mut grain = Bodies::<L::Single>::load_single(self.bodies.to_read(), &group.body);
            let mut contact = Contact::<L::Single, E>::read(&group.contacts, L::Single::load);
            let wall_velocity = group.wall_velocity.each_ref().map(L::Single::load);
            let pair = Pair::with_wall(&grain, wall_velocity);
            let [impulse, lever] = contact.relax_with_lever::<G>(&pair, factor, &mut residual);
            grain.push::<E>(-1.0, impulse, lever);
            grain.store_single(self.bodies, &group.body);
            contact.write(&mut group.contacts, L::Single::store);
        }
        if G::ANY {
            residual.add_to(self.residual);
        }
    }
}
