//! Relaxation of a task's lane groups, in the same arithmetic on every instruction set.

mod driven;
pub(crate) mod kernel;
mod pairs;
mod residual;
mod single;
mod torques;

use crate::detect::{AngularImpulse, Impulse, MemoryOfTask};
use crate::effects::EffectSet;
use crate::effects::resistance::TorqueLanes;
use crate::effects::spring::SpringLanes;
use crate::effects::term::{Tangential, TermState};
use crate::groups::{
    ContactLanes, ContactLayout, Effects, Frictionless, ImpactLanes, ImpactMemory, PairGroup, Sources, WallGroup,
    WallTorqueLanes, with_effects, with_pairs,
};
use crate::lanes::{Available, Eight, Kernel, LANES, Lanes, PREFETCH, TaskSlots, cross, prefetch_places, times};
use crate::partition::{ByBodies, ByNumber, ByPlace, Plan, Ranks, SingleCopy, TaskGroups, overlapped};
use crate::schedule::{Phase, Team};
use crate::world::Body;
use bytemuck::Pod;
pub(crate) use driven::{start_driven, tell_driven};
use kernel::{Bodies, Contact, Pair, push_each};
pub(crate) use residual::{Directions, LaneResidual, Off, ResidualLevel, TaskResidual};
use residual::{MeasuredLevel, with_level};
pub use residual::{Residual, Residuals};
use std::marker::PhantomData;

pub(crate) use torques::Turning;

/// Relaxation kernel for the effects of a scene and the selected instruction set.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation {
    /// Instruction set of the kernel.
    pub instruction_set: Available,
    /// Effects compiled into the kernels; without friction, sweeps do not carry spins.
    pub effects: EffectSet,
    /// Prefetch distance of bodies in lane groups; 0 for none.
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

/// Applies the starting impulses of a task's contacts to the bodies.
struct Start<'a, E: Effects> {
    bodies: TaskSlots<'a, Body>,
    groups: &'a TaskGroups,
    effects: PhantomData<E>,
}

/// Applies the cohesive impulses of a task's contacts to the bodies.
struct Pull<'a> {
    bodies: TaskSlots<'a, Body>,
    groups: &'a TaskGroups,
}

/// Stores a task's impulses and impacts with the candidates of its contacts.
struct Remember<'a> {
    groups: &'a TaskGroups,
    memory: [MemoryOfTask<'a>; 2],
    /// True if there are tangential springs.
    springs: bool,
}

impl Relaxation {
    /// Relaxes every group of a task once, pairs first; adds the residuals of the level to `residual`.
    pub(crate) fn sweep(
        &self,
        bodies: TaskSlots<'_, Body>,
        groups: &mut TaskGroups,
        factor: f64,
        level: ResidualLevel,
        residual: &mut TaskResidual,
    ) {
        let prefetch = self.prefetch;
        with_effects!(self.effects, E => with_level!(level, G => {
            self.instruction_set.run(Sweep::<E, G> { bodies, groups, factor, prefetch, residual, compiled: PhantomData });
        }))
    }

    /// Applies the starting impulses and the cohesive impulses of a task's contacts to the bodies.
    pub(crate) fn start(&self, bodies: TaskSlots<'_, Body>, groups: &TaskGroups) {
        with_effects!(self.effects, E => {
            self.instruction_set.run(Start::<E> { bodies, groups, effects: PhantomData });
        });
        if self.effects.cohesion() {
            self.instruction_set.run(Pull { bodies, groups });
        }
    }

    /// Stores a task's impulses, and its angular impulses if any, with the candidates of its contacts.
    pub(crate) fn remember(&self, groups: &TaskGroups, memory: [MemoryOfTask<'_>; 2]) {
        let springs = self.effects.spring();
        self.instruction_set.run(Remember { groups, memory, springs });
        if self.effects.torques() {
            remember_torques(groups, memory);
        }
    }
}

impl<E: Effects, G: MeasuredLevel> Kernel for Sweep<'_, E, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let factor = L::splat(self.factor);
        let mut residual = LaneResidual::<L>::read(self.residual);
        // Pairs of grains.
        match (const { overlapped::<L>(E::FRICTION) }, E::TORQUES) {
            (true, false) => self.relax_overlapped::<L>(factor, &mut residual),
            (true, true) => self.relax_torques_overlapped::<L>(factor, &mut residual),
            (false, _) => self.relax_in_turn::<L>(factor, &mut residual),
        }
        // Contacts with kinematic and fixed walls; contacts with dynamic walls follow once for all tasks.
        let prescribed = self.groups.prescribed_walls();
        for (number, group) in self.groups.walls[..prescribed].iter_mut().enumerate() {
            let mut grain = Bodies::<L>::load::<E>(self.bodies.to_read(), &group.body);
            let mut contact = Contact::<L, E>::read(&group.contacts, L::load);
            let wall_velocity = group.wall_velocity.each_ref().map(L::load);
            let push = contact.relax_with_lever::<G>(&Pair::with_wall(&grain, wall_velocity), factor, &mut residual);
            contact.write(&mut group.contacts, L::store);
            if !E::TORQUES {
                push_each::<L, E>(self.bodies, &group.body, -1.0, push);
                continue;
            }
            // Torque of the contact, at the spin after the impulse.
            grain.push::<E>(-1.0, push[0], push[1]);
            let WallTorqueLanes { wall_spin, torques } = &mut self.groups.wall_torques[number];
            let mut torque = TermState::<L, E::Torque<L>>::angular(torques, L::load);
            let bearing = (contact.normal, contact.impulse_normal);
            let wall_spin = wall_spin.each_ref().map(L::load);
            let turning = Turning::with_wall(&grain, wall_spin);
            grain.turn(-1.0, turning.relax::<G>(&mut torque, bearing, factor, &mut residual));
            torque.write(&mut torques.impulse, L::store);
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
            // Impulses of the last step, with their lever arms.
            let contact = Contact::<L, E>::read(&group.contacts, L::load);
            let impulse = contact.impulse();
            let lever = cross(contact.normal, impulse);
            Pair::push::<E>(self.bodies, group, [impulse, lever]);
            if E::TORQUES {
                let angular = TermState::<L, E::Torque<L>>::angular(&self.groups.pair_torques[number], L::load).impulse;
                turn_each::<L, E>(self.bodies, &group.first, -1.0, angular);
                turn_each::<L, E>(self.bodies, &group.second, 1.0, angular);
            }
        }
        for (number, group) in self.groups.walls.iter().enumerate() {
            let contact = Contact::<L, E>::read(&group.contacts, L::load);
            let impulse = contact.impulse();
            let lever = cross(contact.normal, impulse);
            push_each::<L, E>(self.bodies, &group.body, -1.0, [impulse, lever]);
            if E::TORQUES {
                let torques = &self.groups.wall_torques[number].torques;
                let angular = TermState::<L, E::Torque<L>>::angular(torques, L::load).impulse;
                turn_each::<L, E>(self.bodies, &group.body, -1.0, angular);
            }
        }
    }
}

/// Adds `sign` times an angular impulse to eight bodies in memory.
#[inline(always)]
fn turn_each<L: Lanes, E: Effects>(bodies: TaskSlots<'_, Body>, places: &[u32; LANES], sign: f64, impulse: [L; 3]) {
    let mut turned = Bodies::<L>::load::<E>(bodies.to_read(), places);
    turned.turn(sign, impulse);
    turned.store::<E>(bodies, places);
}

impl Kernel for Pull<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, pair_pulls, walls, wall_pulls, .. } = self.groups;
        with_pairs!(pairs, pairs => for (group, pulls) in pairs.iter().zip(pair_pulls) {
            let pull = times(group.contacts.normal.each_ref().map(L::load), L::load(pulls));
            push_each::<L, Frictionless>(self.bodies, &group.first, 1.0, [pull, pull]);
            push_each::<L, Frictionless>(self.bodies, &group.second, -1.0, [pull, pull]);
        });
        for (group, pulls) in walls.iter().zip(wall_pulls) {
            let pull = times(group.contacts.normal.each_ref().map(L::load), L::load(pulls));
            push_each::<L, Frictionless>(self.bodies, &group.body, 1.0, [pull, pull]);
        }
    }
}

impl Kernel for Remember<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, pair_sources, pair_impacts, walls, wall_sources, wall_impacts, .. } = self.groups;
        let [of_pairs, of_walls] = self.memory;
        with_pairs!(pairs, pairs => for (group, sources) in pairs.iter().zip(pair_sources) {
            remember::<L, _>(&group.contacts, &group.contacts.tangential, sources, of_pairs.impulses);
        });
        for (group, sources) in walls.iter().zip(wall_sources) {
            let SpringLanes { friction, .. } = &group.contacts.tangential;
            match self.springs {
                true => remember::<L, _>(&group.contacts, &group.contacts.tangential, sources, of_walls.impulses),
                false => remember::<L, _>(&group.contacts, friction, sources, of_walls.impulses),
            }
        }
        remember_impacts(pair_impacts, pair_sources, of_pairs.impacts);
        remember_impacts(wall_impacts, wall_sources, of_walls.impacts);
    }
}

/// Stores the impulses of a lane group with its candidates; the tangential term provides the tangential ones.
#[inline(always)]
fn remember<L: Lanes, T: Tangential>(
    contacts: &ContactLanes<Eight, impl Tangential>,
    term: &T,
    sources: &Sources,
    impulses: TaskSlots<'_, Impulse>,
) {
    if sources.is_full() {
        // All lanes at once.
        let [x, y, z] = term.remembered(L::load);
        impulses.store_quads(&sources.or(u32::MAX), [L::load(&contacts.impulse_normal), x, y, z]);
    } else {
        // Padding lanes have no candidate.
        for (lane, candidate) in sources.occupied() {
            let tangential = term.remembered(|eight| eight.0[lane]);
            impulses.set(candidate as u32, Impulse { normal: contacts.normal_impulse(lane), tangential });
        }
    }
}

/// Stores the impacts of a task's contacts.
#[inline(always)]
fn remember_impacts(groups: &[ImpactLanes], sources: &[Sources], impacts: TaskSlots<'_, ImpactMemory>) {
    for (group, sources) in groups.iter().zip(sources) {
        for (lane, candidate) in sources.occupied() {
            impacts.with_trusted(candidate as u32, |one| *one = group.memory(lane));
        }
    }
}

/// Stores the angular impulses of a task's contacts.
fn remember_torques(groups: &TaskGroups, [of_pairs, of_walls]: [MemoryOfTask<'_>; 2]) {
    let TaskGroups { pair_torques, pair_sources, wall_torques, wall_sources, .. } = groups;
    let pairs = pair_torques.iter().zip(pair_sources).map(|both| (both, of_pairs.torques));
    let walls = wall_torques.iter().map(|group| &group.torques).zip(wall_sources);
    for ((torques, sources), impulses) in pairs.chain(walls.map(|both| (both, of_walls.torques))) {
        for (lane, candidate) in sources.occupied() {
            impulses.set(candidate as u32, AngularImpulse(torques.angular_impulse(lane)));
        }
    }
}

/// Bodies and groups of sweeps, in one of the precisions.
pub(crate) enum SweepOperands<'a> {
    Double { bodies: &'a mut [Body], groups: &'a mut [TaskGroups] },
    Single(&'a mut SingleCopy),
}

/// Relaxation of tasks: number of repetitions, and residual level of the last one.
pub(crate) struct SweepPass<F> {
    /// Relaxation factor.
    pub factor: f64,
    /// Number of relaxations of each task.
    pub inner: u32,
    /// Returns true to skip the remaining repetitions; polled if there are several.
    pub stops: F,
    /// Residual level of the last repetition.
    pub level: ResidualLevel,
}

impl Relaxation {
    /// Relaxes every task, stage after stage; returns the summed residuals of the last repetition, with `residuals` as buffer.
    pub(crate) fn sweep_all(
        &self,
        (plan, ranks): (&Plan, Option<&Ranks>),
        operands: SweepOperands<'_>,
        pass: &SweepPass<impl Fn() -> bool + Sync>,
        residuals: &mut Vec<TaskResidual>,
        team: &Team,
    ) -> TaskResidual {
        let factor = pass.factor;
        match operands {
            SweepOperands::Double { bodies, groups } => {
                let shares = (ByBodies::of(bodies), ByNumber::of(groups));
                pass.run((plan, ranks), shares, residuals, team, |(bodies, groups), level, residual| {
                    self.sweep(*bodies, groups, factor, level, residual);
                })
            }
            SweepOperands::Single(copy) => {
                let shares = (ByBodies::of(&mut copy.bodies), ByNumber::of(&mut copy.groups));
                pass.run((plan, ranks), shares, residuals, team, |(bodies, groups), level, residual| {
                    self.sweep_single(*bodies, groups, factor, level, residual);
                })
            }
        }
    }
}

impl<F: Fn() -> bool + Sync> SweepPass<F> {
    fn run<T: Pod + Send, G: Send>(
        &self,
        (plan, ranks): (&Plan, Option<&Ranks>),
        shares: (ByBodies<'_, T>, ByNumber<'_, G>),
        residuals: &mut Vec<TaskResidual>,
        team: &Team,
        sweep: impl Fn(&mut (TaskSlots<'_, T>, &mut G), ResidualLevel, &mut TaskResidual) + Sync,
    ) -> TaskResidual {
        let measured = self.level != ResidualLevel::Off;
        residuals.clear();
        residuals.resize(if measured { plan.tasks().len() } else { 0 }, TaskResidual::default());
        let shares = (shares, measured.then(|| ByPlace::of(residuals)));
        plan.run_stages(
            team,
            Phase::Sweep,
            |stage, ((bodies, _), _), between| {
                ranks.into_iter().for_each(|ranks| ranks.pass_on(stage, bodies.all(between)));
            },
            shares,
            |_, _, (mut own, mut residual)| {
                let mut unused = TaskResidual::default();
                for time in 1..=self.inner {
                    if self.inner > 1 && (self.stops)() {
                        break;
                    }
                    match &mut residual {
                        Some(residual) if time == self.inner => sweep(&mut own, self.level, residual),
                        _ => sweep(&mut own, ResidualLevel::Off, &mut unused),
                    }
                }
            },
        );
        // Summed in task order, on any number of threads and ranks.
        if let Some(ranks) = ranks.filter(|_| measured) {
            *residuals = ranks.in_order(residuals);
        }
        let mut total = TaskResidual::default();
        residuals.iter().for_each(|own| total.merge(own));
        total
    }
}

/// Size of the impulse arrays written by a sweep: one along the normal, and three components of each other kind.
const NORMAL: usize = size_of::<Eight>();
/// See [`NORMAL`].
const VECTOR: usize = 3 * size_of::<Eight>();

/// Memory traffic of a sweep, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SweepBytes {
    /// Bytes accessed at least once, each counted once: lane groups and a cache line per grain.
    pub touched: usize,
    /// Traffic without reuse between sweeps: lane groups are read and their impulses written, and each grain is read and written
    /// once, since a box's grains stay in the innermost cache while its contacts are relaxed. Padding lanes are included.
    pub moved: usize,
}

impl EffectSet {
    /// Returns the bytes of a contact of two grains in its lane groups.
    pub fn bytes_of_contact(&self) -> usize {
        self.bytes_of_pairs() / LANES
    }

    /// Returns the bytes of the lane groups of eight contacts of two grains.
    pub(crate) fn bytes_of_pairs(&self) -> usize {
        let torques = if self.torques() { size_of::<TorqueLanes>() } else { 0 };
        with_effects!(*self, E => size_of::<PairGroup<<E as Effects>::Tangential>>()) + torques
    }

    /// Returns the bytes of the lane groups of eight contacts with walls, which always include friction.
    pub(crate) fn bytes_of_walls(&self) -> usize {
        size_of::<WallGroup>() + if self.torques() { size_of::<WallTorqueLanes>() } else { 0 }
    }

    /// Returns the bytes of the impulses of eight contacts, which a sweep writes.
    pub(crate) fn bytes_written(&self) -> usize {
        NORMAL + usize::from(self.tangential()) * VECTOR + usize::from(self.torques()) * VECTOR
    }
}
