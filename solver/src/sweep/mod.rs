//! One relaxation of a task's lane groups, in the same arithmetic on every instruction set.

mod count;
pub(crate) mod kernel;
mod residual;
mod scalar;
mod single;

pub use count::Operations;
pub(crate) use residual::{LaneResidual, TaskResidual};
pub use residual::{Residual, Residuals};

use crate::detect::Impulse;
use crate::lanes::{InstructionSet, Kernel, Lanes, PREFETCH, Quad, prefetch_lines, prefetch_places};
use crate::partition::TaskGroups;
use crate::schedule::Disjoint;
use crate::world::Body;
use kernel::{Bodies, Contact};

/// The relaxation that a scene calls for, on the instruction set that was chosen.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation {
    /// Instruction set of the kernel.
    pub instruction_set: InstructionSet,
    /// One contact at a time instead of eight: what lanes are measured against. In double precision only.
    pub scalar: bool,
    /// Whether contacts have friction; without it bodies carry no spin through the sweep.
    pub friction: bool,
    /// How many lane groups ahead bodies are fetched into the cache; 0 for not at all.
    pub prefetch: usize,
}

/// One sweep over a task.
struct Sweep<'a, const FRICTION: bool, const MEASURE: bool> {
    bodies: *mut Body,
    groups: &'a mut TaskGroups,
    factor: f64,
    prefetch: usize,
    residual: &'a mut TaskResidual,
}

/// Gives bodies the impulses that a task's contacts start from.
struct Start<'a, const FRICTION: bool> {
    bodies: *mut Body,
    groups: &'a TaskGroups,
}

/// Keeps a task's impulses with the candidates that its contacts came from.
struct Remember<'a> {
    groups: &'a TaskGroups,
    pairs: &'a Disjoint<'a, Impulse>,
    walls: &'a Disjoint<'a, Impulse>,
}

impl Relaxation {
    /// Relaxes every group of a task once, pairs first; adds to `residual` only if `measure`.
    ///
    /// # Safety
    /// The groups name bodies behind `bodies`, and no other task uses these meanwhile.
    pub(crate) unsafe fn sweep(
        &self,
        bodies: *mut Body,
        groups: &mut TaskGroups,
        factor: f64,
        measure: bool,
        residual: &mut TaskResidual,
    ) {
        // SAFETY: the caller's promise.
        unsafe {
            match (self.friction, measure) {
                (true, true) => self.dispatch::<true, true>(bodies, groups, factor, residual),
                (true, false) => self.dispatch::<true, false>(bodies, groups, factor, residual),
                (false, true) => self.dispatch::<false, true>(bodies, groups, factor, residual),
                (false, false) => self.dispatch::<false, false>(bodies, groups, factor, residual),
            }
        }
    }

    unsafe fn dispatch<const FRICTION: bool, const MEASURE: bool>(
        &self,
        bodies: *mut Body,
        groups: &mut TaskGroups,
        factor: f64,
        residual: &mut TaskResidual,
    ) {
        if self.scalar {
            // SAFETY: the promise of `sweep`.
            unsafe { scalar::sweep::<FRICTION, MEASURE>(bodies, groups, factor, residual) };
        } else {
            let prefetch = self.prefetch;
            self.instruction_set.run(Sweep::<FRICTION, MEASURE> { bodies, groups, factor, prefetch, residual });
        }
    }

    /// Gives bodies the impulses that a task's contacts start from.
    ///
    /// # Safety
    /// As for `sweep`.
    pub(crate) unsafe fn start(&self, bodies: *mut Body, groups: &TaskGroups) {
        match self.friction {
            true => self.instruction_set.run(Start::<true> { bodies, groups }),
            false => self.instruction_set.run(Start::<false> { bodies, groups }),
        }
    }

    /// Keeps a task's impulses with the candidates that its contacts came from.
    ///
    /// # Safety
    /// No other task uses these candidates meanwhile.
    pub(crate) unsafe fn remember(
        &self,
        groups: &TaskGroups,
        pairs: &Disjoint<'_, Impulse>,
        walls: &Disjoint<'_, Impulse>,
    ) {
        self.instruction_set.run(Remember { groups, pairs, walls });
    }
}

impl<const FRICTION: bool, const MEASURE: bool> Kernel for Sweep<'_, FRICTION, MEASURE> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let factor = L::splat(self.factor);
        let mut residual = LaneResidual::<L>::read(self.residual);
        let pairs = &mut self.groups.pairs;
        for number in 0..pairs.len() {
            if self.prefetch > 0 {
                // The group itself is fetched before the bodies that it names.
                prefetch_lines(pairs.as_ptr().wrapping_add(number + 2 * self.prefetch));
                if let Some(ahead) = pairs.get(number + self.prefetch) {
                    prefetch_places(self.bodies, &ahead.first);
                    prefetch_places(self.bodies, &ahead.second);
                }
            }
            let group = &mut pairs[number];
            // SAFETY: the promise of `Relaxation::sweep`; the sixteen bodies of a group are different ones.
            unsafe {
                let mut first = Bodies::<L>::load::<FRICTION>(self.bodies, &group.first);
                let mut second = Bodies::<L>::load::<FRICTION>(self.bodies, &group.second);
                let mut contact = Contact::read(&group.contacts, L::load);
                contact.relax_pair::<FRICTION, MEASURE>(&mut first, &mut second, factor, &mut residual);
                first.store::<FRICTION>(self.bodies, &group.first);
                second.store::<FRICTION>(self.bodies, &group.second);
                contact.write::<FRICTION, _>(&mut group.contacts, L::store);
            }
        }
        for group in &mut self.groups.walls {
            // SAFETY: as above.
            unsafe {
                let mut grain = Bodies::<L>::load::<FRICTION>(self.bodies, &group.body);
                let mut contact = Contact::read(&group.contacts, L::load);
                let wall_velocity = group.wall_velocity.each_ref().map(L::load);
                contact.relax_wall::<FRICTION, MEASURE>(&mut grain, wall_velocity, factor, &mut residual);
                grain.store::<FRICTION>(self.bodies, &group.body);
                contact.write::<FRICTION, _>(&mut group.contacts, L::store);
            }
        }
        if MEASURE {
            residual.write(self.residual);
        }
    }
}

impl<const FRICTION: bool> Kernel for Start<'_, FRICTION> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (number, group) in self.groups.pairs.iter().enumerate() {
            if let Some(ahead) = self.groups.pairs.get(number + PREFETCH) {
                prefetch_places(self.bodies, &ahead.first);
                prefetch_places(self.bodies, &ahead.second);
            }
            // SAFETY: the promise of `Relaxation::start`; the sixteen bodies of a group are different ones.
            unsafe {
                let mut first = Bodies::<L>::load::<FRICTION>(self.bodies, &group.first);
                let mut second = Bodies::<L>::load::<FRICTION>(self.bodies, &group.second);
                let contact = Contact::read(&group.contacts, L::load);
                let impulse = contact.impulse();
                let lever = crate::lanes::cross(contact.normal, impulse);
                first.push::<FRICTION>(-1.0, impulse, lever);
                second.push::<FRICTION>(1.0, impulse, lever);
                first.store::<FRICTION>(self.bodies, &group.first);
                second.store::<FRICTION>(self.bodies, &group.second);
            }
        }
        for group in &self.groups.walls {
            // SAFETY: as above.
            unsafe {
                let mut grain = Bodies::<L>::load::<FRICTION>(self.bodies, &group.body);
                let contact = Contact::read(&group.contacts, L::load);
                let impulse = contact.impulse();
                grain.push::<FRICTION>(-1.0, impulse, crate::lanes::cross(contact.normal, impulse));
                grain.store::<FRICTION>(self.bodies, &group.body);
            }
        }
    }
}

impl Kernel for Remember<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, pair_sources, walls, wall_sources, .. } = self.groups;
        let contacts = pairs.iter().map(|group| &group.contacts).zip(pair_sources);
        let all = contacts.map(|both| (both, self.pairs));
        let contacts = walls.iter().map(|group| &group.contacts).zip(wall_sources);
        for ((contacts, sources), impulses) in all.chain(contacts.map(|both| (both, self.walls))) {
            if sources.is_full() {
                let [x, y, z] = contacts.impulse_tangential.each_ref().map(L::load);
                let quads = [L::load(&contacts.impulse_normal), x, y, z];
                let base: *mut Quad = impulses.as_ptr().cast();
                // SAFETY: the promise of `Relaxation::remember`; an impulse is a quad.
                unsafe { L::store_quads::<1>(base, &sources.or(u32::MAX), quads) };
            } else {
                for (lane, candidate) in sources.occupied() {
                    let impulse = Impulse {
                        normal: contacts.normal_impulse(lane),
                        tangential: contacts.tangential_impulse(lane),
                    };
                    // SAFETY: the promise of `Relaxation::remember`.
                    *unsafe { impulses.at(candidate) } = impulse;
                }
            }
        }
    }
}

#[cfg(all(test, target_os = "linux", target_arch = "x86_64", not(target_feature = "avx512vl")))]
mod tests;
