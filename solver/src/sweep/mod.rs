//! One relaxation of a task's lane groups, in the same arithmetic on every instruction set.

mod bytes;
mod driven;
pub(crate) mod kernel;
mod pairs;
mod residual;
mod scalar;
mod single;
mod stages;
mod torques;

pub use bytes::SweepBytes;
pub(crate) use driven::{start_driven, tell_driven};
pub(crate) use residual::{Directions, LaneResidual, Off, ResidualLevel, TaskResidual};
use residual::{MeasuredLevel, with_level};
pub use residual::{Residual, Residuals};
pub(crate) use stages::{SweepOperands, SweepPass};

use crate::detect::{AngularImpulse, Impulse, ImpulsesOfTask};
use crate::effects::{EffectSet, Effects, Frictionless, with_effects};
use crate::groups::{
    ContactLanes, ContactLayout, ImpactLanes, ImpactMemory, Sources, Tangential, WallTorqueLanes, with_pairs,
};
use crate::lanes::{Available, Eight, Kernel, Lanes, Number, PREFETCH, TaskSlots, cross, prefetch_places, times};
use crate::partition::{TaskGroups, overlapped};
use crate::world::Body;
pub(crate) use kernel::INVERSE_INERTIA;
use kernel::{Bodies, Contact, Pair, push_each};
use std::marker::PhantomData;
pub(crate) use torques::Torque;

/// The relaxation that a scene calls for, on the instruction set that was chosen.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation {
    /// Instruction set of the kernel.
    pub instruction_set: Available,
    /// One contact at a time instead of eight: what lanes are measured against. In double precision only.
    pub scalar: bool,
    /// Effects that the kernels are compiled with; without friction bodies carry no spin through the sweep.
    pub effects: EffectSet,
    /// How many lane groups ahead bodies are fetched into the cache; 0 for not at all.
    pub prefetch: usize,
}

/// One sweep over a task.
struct Sweep<'a, E: Effects, G: MeasuredLevel> {
    bodies: TaskSlots<'a, Body>,
    groups: &'a mut TaskGroups,
    factor: f64,
    prefetch: usize,
    residual: &'a mut TaskResidual,
    compiled: PhantomData<(E, G)>,
}

/// Gives bodies the impulses that a task's contacts start from.
struct Start<'a, E: Effects> {
    bodies: TaskSlots<'a, Body>,
    groups: &'a TaskGroups,
    effects: PhantomData<E>,
}

/// Gives bodies the impulses with which cohesion pulls at a task's contacts.
struct Pull<'a> {
    bodies: TaskSlots<'a, Body>,
    groups: &'a TaskGroups,
}

/// Keeps a task's impulses and impacts with the candidates that its contacts came from.
struct Remember<'a> {
    groups: &'a TaskGroups,
    impulses: ImpulsesOfTask<'a>,
    /// Whether there are tangential springs.
    springs: bool,
}

impl Relaxation {
    /// Relaxes every group of a task once, pairs first; adds to `residual` what the level says.
    pub(crate) fn sweep(
        &self,
        bodies: TaskSlots<'_, Body>,
        groups: &mut TaskGroups,
        factor: f64,
        level: ResidualLevel,
        residual: &mut TaskResidual,
    ) {
        with_effects!(self.effects, E => {
            with_level!(level, G => self.dispatch::<E, G>(bodies, groups, factor, residual))
        })
    }

    fn dispatch<E: Effects, G: MeasuredLevel>(
        &self,
        bodies: TaskSlots<'_, Body>,
        groups: &mut TaskGroups,
        factor: f64,
        residual: &mut TaskResidual,
    ) {
        if self.scalar {
            scalar::sweep::<E, G>(bodies, groups, factor, residual);
        } else {
            let prefetch = self.prefetch;
            let compiled = PhantomData;
            self.instruction_set.run(Sweep::<E, G> { bodies, groups, factor, prefetch, residual, compiled });
        }
    }

    /// Gives bodies the impulses that a task's contacts start from, and those with which cohesion pulls at them.
    pub(crate) fn start(&self, bodies: TaskSlots<'_, Body>, groups: &TaskGroups) {
        with_effects!(self.effects, E => {
            self.instruction_set.run(Start::<E> { bodies, groups, effects: PhantomData });
        });
        if self.effects.cohesion() {
            self.instruction_set.run(Pull { bodies, groups });
        }
    }

    /// Keeps a task's impulses, angular ones too where there are any, with the candidates that its contacts came from.
    pub(crate) fn remember(&self, groups: &TaskGroups, impulses: ImpulsesOfTask<'_>) {
        let springs = self.effects.spring();
        self.instruction_set.run(Remember { groups, impulses, springs });
        if self.effects.torques() {
            remember_torques(groups, impulses);
        }
    }
}

impl<E: Effects, G: MeasuredLevel> Kernel for Sweep<'_, E, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let factor = L::splat(self.factor);
        let mut residual = LaneResidual::<L>::read(self.residual);
        if const { overlapped::<L>(E::FRICTION, E::TORQUES) } {
            self.relax_overlapped::<L>(factor, &mut residual);
        } else {
            self.relax_in_turn::<L>(factor, &mut residual);
        }
        let prescribed = self.groups.prescribed_walls();
        for (number, group) in self.groups.walls[..prescribed].iter_mut().enumerate() {
            let mut grain = Bodies::<L>::load::<E>(self.bodies.to_read(), &group.body);
            let mut contact = Contact::read(&group.contacts, L::load);
            let wall_velocity = group.wall_velocity.each_ref().map(L::load);
            let push = contact.relax_wall::<E, G>(&grain, wall_velocity, factor, &mut residual);
            contact.write::<E, _, _>(&mut group.contacts, L::store);
            if !E::TORQUES {
                push_each::<L, E>(self.bodies, &group.body, -1.0, push);
                continue;
            }
            grain.push::<E>(-1.0, push[0], push[1]);
            if E::TORQUES {
                let WallTorqueLanes { wall_spin, torques } = &mut self.groups.wall_torques[number];
                let mut torque = Torque::read(torques, L::load);
                let bearing = (contact.normal, contact.impulse_normal);
                let wall_spin = wall_spin.each_ref().map(L::load);
                torque.relax_wall::<E, G>(bearing, &mut grain, wall_spin, factor, &mut residual);
                torque.write(torques, L::store);
            }
            grain.store::<E>(self.bodies, &group.body);
        }
        if G::ANY {
            residual.write(self.residual);
        }
    }
}

impl<E: Effects> Kernel for Start<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let pairs = E::Tangential::of(&self.groups.pairs);
        for (number, group) in pairs.iter().enumerate() {
            if let Some(ahead) = pairs.get(number + PREFETCH) {
                prefetch_places(self.bodies.as_ptr(), &ahead.first);
                prefetch_places(self.bodies.as_ptr(), &ahead.second);
            }
            let contact = Contact::read(&group.contacts, L::load);
            let impulse = contact.impulse();
            let lever = cross(contact.normal, impulse);
            if !E::TORQUES {
                Pair::push::<E>(self.bodies, group, [impulse, lever]);
                continue;
            }
            let mut first = Bodies::<L>::load::<E>(self.bodies.to_read(), &group.first);
            let mut second = Bodies::<L>::load::<E>(self.bodies.to_read(), &group.second);
            first.push::<E>(-1.0, impulse, lever);
            second.push::<E>(1.0, impulse, lever);
            if E::TORQUES {
                let impulse = Torque::read(&self.groups.pair_torques[number], L::load).impulse;
                first.turn(-1.0, impulse);
                second.turn(1.0, impulse);
            }
            first.store::<E>(self.bodies, &group.first);
            second.store::<E>(self.bodies, &group.second);
        }
        for (number, group) in self.groups.walls.iter().enumerate() {
            let contact = Contact::read(&group.contacts, L::load);
            let impulse = contact.impulse();
            let lever = cross(contact.normal, impulse);
            if !E::TORQUES {
                push_each::<L, E>(self.bodies, &group.body, -1.0, [impulse, lever]);
                continue;
            }
            let mut grain = Bodies::<L>::load::<E>(self.bodies.to_read(), &group.body);
            grain.push::<E>(-1.0, impulse, lever);
            if E::TORQUES {
                grain.turn(-1.0, Torque::read(&self.groups.wall_torques[number].torques, L::load).impulse);
            }
            grain.store::<E>(self.bodies, &group.body);
        }
    }
}

impl Kernel for Pull<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, pair_pulls, walls, wall_pulls, .. } = self.groups;
        with_pairs!(pairs, pairs => for (group, pulls) in pairs.iter().zip(pair_pulls) {
            let mut first = Bodies::<L>::load::<Frictionless>(self.bodies.to_read(), &group.first);
            let mut second = Bodies::<L>::load::<Frictionless>(self.bodies.to_read(), &group.second);
            let pull = times(group.contacts.normal.each_ref().map(L::load), L::load(pulls));
            first.push::<Frictionless>(1.0, pull, pull);
            second.push::<Frictionless>(-1.0, pull, pull);
            first.store::<Frictionless>(self.bodies, &group.first);
            second.store::<Frictionless>(self.bodies, &group.second);
        });
        for (group, pulls) in walls.iter().zip(wall_pulls) {
            let mut grain = Bodies::<L>::load::<Frictionless>(self.bodies.to_read(), &group.body);
            let pull = times(group.contacts.normal.each_ref().map(L::load), L::load(pulls));
            grain.push::<Frictionless>(1.0, pull, pull);
            grain.store::<Frictionless>(self.bodies, &group.body);
        }
    }
}

impl Kernel for Remember<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, pair_sources, pair_impacts, walls, wall_sources, wall_impacts, .. } = self.groups;
        with_pairs!(pairs, pairs => for (group, sources) in pairs.iter().zip(pair_sources) {
            remember::<L, _>(&group.contacts, sources, self.impulses.pairs, self.springs);
        });
        for (group, sources) in walls.iter().zip(wall_sources) {
            remember::<L, _>(&group.contacts, sources, self.impulses.walls, self.springs);
        }
        remember_impacts(pair_impacts, pair_sources, self.impulses.pair_impacts);
        remember_impacts(wall_impacts, wall_sources, self.impulses.wall_impacts);
    }
}

/// Keeps the impulses of a lane group; see [`Relaxation::remember`]. What an impact bore that was over within the step is no load of a
/// spring.
#[inline(always)]
fn remember<L: Lanes, T: Tangential>(
    contacts: &ContactLanes<Eight, T>,
    sources: &Sources,
    impulses: TaskSlots<'_, Impulse>,
    springs: bool,
) {
    let spring = if springs { contacts.tangential.spring() } else { None };
    if sources.is_full() {
        let contact = Contact::read(contacts, L::load);
        let mut tangential = contact.impulse_tangential;
        if let Some(spring) = spring {
            let springy = <L as Number>::zero().below(L::load(&spring.compliance));
            tangential = tangential.map(|component| L::select(springy, component, <L as Number>::zero()));
        }
        let [x, y, z] = tangential;
        impulses.store_quads(&sources.or(u32::MAX), [contact.impulse_normal, x, y, z]);
    } else {
        for (lane, candidate) in sources.occupied() {
            let springy = spring.is_none_or(|spring| spring.compliance.0[lane] > 0.0);
            let tangential = if springy { contacts.tangential_impulse(lane) } else { [0.0; 3] };
            impulses.set(candidate as u32, Impulse { normal: contacts.normal_impulse(lane), tangential });
        }
    }
}

/// Keeps the impacts of a task's contacts.
#[inline(always)]
fn remember_impacts(groups: &[ImpactLanes], sources: &[Sources], impacts: TaskSlots<'_, ImpactMemory>) {
    for (group, sources) in groups.iter().zip(sources) {
        for (lane, candidate) in sources.occupied() {
            impacts.with_trusted(candidate as u32, |one| *one = group.memory(lane));
        }
    }
}

/// Keeps the angular impulses of a task's contacts.
fn remember_torques(groups: &TaskGroups, impulses: ImpulsesOfTask<'_>) {
    let TaskGroups { pair_torques, pair_sources, wall_torques, wall_sources, .. } = groups;
    let pairs = pair_torques.iter().zip(pair_sources).map(|both| (both, impulses.pair_torques));
    let walls = wall_torques.iter().map(|group| &group.torques).zip(wall_sources);
    for ((torques, sources), impulses) in pairs.chain(walls.map(|both| (both, impulses.wall_torques))) {
        for (lane, candidate) in sources.occupied() {
            impulses.set(candidate as u32, AngularImpulse(torques.angular_impulse(lane)));
        }
    }
}
