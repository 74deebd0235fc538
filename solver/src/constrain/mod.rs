//! Conversion of active candidates to constraint data: gap and normal, bias, regularisation, starting impulse.
//!
//! A task processes its candidates eight at a time and packs the active ones into lane groups, by body index only. Then the task
//! fills the groups, eight contacts at a time, from the bodies and from the impulses of the last step.

mod coefficients;
mod fill;
mod touch;

use crate::contact::ContactGeometry;
use crate::detect::{CandidateList, Candidates, MemoryOfTask, WallCandidate};
use crate::effects::EffectSet;
use crate::effects::friction::slip_speed;
use crate::effects::impact::{Decision, Impact, bears};
use crate::effects::term::{Tangential, TermStart};
use crate::groups::{ContactLanes, ImpactLanes, WallGroup, with_effects, with_pairs};
use crate::lanes::{Available, Eight, Lanes, Number, Quad, Slots, TaskSlots, dot, minus, times};
use crate::laws::compliance::{NormalContact, NormalScheme};
use crate::partition::{
    Between, ByBodies, ByCandidates, ByNumber, DRIVEN_STAGE, DrivenContact, FindWaits, LaneAssigner, Layout,
    PlannedTask, Taken, TakenGroups, TaskGroups,
};
use crate::scene::SolverSettings;
use crate::schedule::{Phase, Team};
use crate::surface::NearPart;
use crate::sweep::Relaxation;
use crate::wall::{Pose, WallsAt};
use crate::world::{Body, ContactMaterial, Sphere, World, WorldBesideBodies};
use coefficients::LaneMaterial;
use fill::{FillPairs, FillTorques, FillWalls};
use nalgebra::Vector3;
use std::marker::PhantomData;
use std::sync::atomic::{AtomicU32, Ordering};
use touch::AssignPairs;

/// Converts candidates to lane groups; buffers are reused over the steps.
#[derive(Clone, Debug)]
pub struct Constrainer {
    constants: StepConstants,
    /// Stiffest possible contact of the scene.
    stiffest: NormalContact<f64>,
    /// Largest range of cohesion, m.
    range_of_cohesion: f64,
    effects: EffectSet,
    /// True if the data of a step exceed the cache and are prefetched; set by the caller before each step.
    pub(crate) fetches: bool,
    taken: TakenGroups,
    poses: Vec<Pose>,
}

/// Constants of all contacts.
#[derive(Clone, Copy, Debug)]
struct StepConstants {
    scheme: NormalScheme,
    warm_start: f64,
    /// Gap up to which a contact may still matter in a step, m.
    contact_margin: f64,
    /// Sliding speed at the start of a step above which a contact has kinetic friction, m/s.
    slip_speed: f64,
}

/// Input data of the tasks of a step.
struct StepContext<'a> {
    world: WorldBesideBodies<'a>,
    spheres: Slots<'a, Sphere>,
    /// Velocities and inverse masses at the start of the step.
    before: Slots<'a, Quad>,
    /// Surface speeds at the start of the step, if stored.
    spins_before: Slots<'a, Quad>,
    candidates: CandidateList<'a>,
    walls: WallsAt<'a>,
    constants: StepConstants,
    effects: EffectSet,
    /// True if the data of a step exceed the cache and are prefetched.
    fetches: bool,
    /// True if some wall turns, so that its contacts drift.
    drifts: bool,
    /// Contact material of all pairs of grains, if all share one.
    material: Option<&'a ContactMaterial>,
}

/// Task with its wall candidates, the impulses of its pairs and wall contacts, and the mask of active pairs for each block.
struct Own<'a> {
    task: &'a PlannedTask,
    listed: Listed<'a>,
    memory: [MemoryOfTask<'a>; 2],
    borne: &'a mut [u8],
}

/// Wall candidates of a task, and the faces near its grains at meshes.
#[derive(Clone, Copy)]
struct Listed<'a> {
    walls: TaskSlots<'a, WallCandidate>,
    near: TaskSlots<'a, NearPart>,
}

impl Constrainer {
    /// Creates a constrainer for the possible contacts of a world.
    pub(crate) fn new(world: &World, settings: &SolverSettings) -> Constrainer {
        let scheme = NormalScheme {
            law: settings.normal_law,
            step: settings.step,
            damping_steps: settings.damping_steps,
            restitution_threshold: settings.slowest_impact(world.largest_and_mean_radius().1, world.field.largest()),
            gravity: world.gravity.norm(),
        };
        let (stiffest, range_of_cohesion) = (world.stiffest_contact(), world.range_of_cohesion());
        let slip_speed = slip_speed(world.field.largest(), settings.step);
        let constants = StepConstants { scheme, warm_start: settings.warm_start, contact_margin: 0.0, slip_speed };
        let effects = world.table.effects();
        let (taken, poses) = (TakenGroups::default(), Vec::new());
        Constrainer { constants, stiffest, range_of_cohesion, effects, fetches: false, taken, poses }
    }

    /// Updates the settings for the present gravity.
    fn follow(&mut self, gravity: f64) {
        let StepConstants { scheme, contact_margin, .. } = &mut self.constants;
        scheme.gravity = gravity;
        *contact_margin = scheme.contact_margin(&self.stiffest).max(self.range_of_cohesion);
    }

    /// Lays out the contacts of a step from the state at its start, and applies the starting impulses to the bodies. Each task
    /// applies its impulses once its groups are complete and still in the cache.
    pub(crate) fn constrain(
        &mut self,
        world: &mut World,
        candidates: &mut Candidates,
        relaxation: &Relaxation,
        team: &Team,
        layout: &mut Layout,
    ) {
        self.poses.clear();
        self.poses.extend(world.walls.poses_over(world.time, self.constants.scheme.step));
        self.follow(world.gravity.norm());
        self.taken.start(world.grains());
        let (candidates, (listed, near), impulses) = candidates.split();
        {
            let (bodies, world) = world.split();
            let context = StepContext {
                world,
                spheres: Slots::of(world.spheres),
                before: Slots::of(world.before),
                spins_before: Slots::of(world.spins_before),
                candidates,
                walls: world.walls.placed(&self.poses),
                constants: self.constants,
                effects: self.effects,
                fetches: self.fetches,
                drifts: self.poses.iter().any(Pose::drifts),
                material: world.table.of_all_grains(),
            };
            let (taken, first, next) = self.taken.stage();
            let Layout { plan, groups, ranks, .. } = layout;
            let of_candidates = (ByCandidates::of(listed), ByCandidates::of(near), impulses.shares());
            let shares = ((ByBodies::of(&mut *bodies), taken), ByNumber::of(groups), of_candidates);
            let set = relaxation.instruction_set;
            // First group number of the stage, and the end so far.
            let (base, end) = (AtomicU32::new(first), AtomicU32::new(first));
            let begin = |stage, ((bodies, _), ..): &((ByBodies<'_, Body>, _), _, _), between: &Between| {
                base.store(end.load(Ordering::Relaxed), Ordering::Relaxed);
                ranks.iter().for_each(|ranks| ranks.pass_on(stage, bodies.all(between)));
            };
            plan.run_stages(team, Phase::Constrain, begin, shares, |_, task, share| {
                let ((bodies, taken), groups, (listed, near, (impulses, borne))) = share;
                let own = Own {
                    task,
                    listed: Listed { walls: listed, near },
                    memory: impulses.map(MemoryOfTask::from),
                    borne,
                };
                let first = (base.load(Ordering::Relaxed), taken);
                end.fetch_max(context.lay_out(own, first, groups, set), Ordering::Relaxed);
                relaxation.start(bodies, groups);
            });
            *next = end.into_inner();
            ranks.iter().for_each(|ranks| ranks.pass_on(DRIVEN_STAGE, TaskSlots::of(bodies)));
        }
        if !world.drives.is_empty() {
            team.alone(Phase::Constrain, || self.list_driven(world, listed, layout));
        }
        let own = layout.plan.tasks().iter().map(|task| layout.groups[task.number as usize].contacts()).sum();
        layout.contacts = layout.ranks.as_ref().map_or(own, |ranks| ranks.sum(own));
    }

    /// Lists the contacts with dynamic walls, ordered by task, and the turns of the ranks.
    fn list_driven(&self, world: &World, walls: &[WallCandidate], layout: &mut Layout) {
        layout.driven.clear();
        for task in layout.plan.tasks() {
            let groups = &layout.groups[task.number as usize];
            for group in groups.prescribed_walls()..groups.walls.len() {
                for (lane, candidate) in groups.wall_sources[group].occupied() {
                    let surface = walls[candidate].surface;
                    let Some(drive) = world.drive_of(surface) else { continue };
                    let WallGroup { body, contacts, .. } = &groups.walls[group];
                    let (sphere, [u, v, w, _]) =
                        (&world.spheres[body[lane] as usize], world.before[body[lane] as usize].0);
                    let (placed, step) = (world.walls.placed(&self.poses), self.constants.scheme.step);
                    let state = [&sphere.centre, &Vector3::new(u, v, w)];
                    let (distance, .., [_, _, drift]) =
                        placed.contact(surface, state, sphere.radius, step, &Vector3::zeros());
                    let point = sphere.centre + Vector3::from(contacts.normal(lane)) * distance;
                    layout.driven.push(DrivenContact {
                        task: task.number,
                        group: group as u32,
                        lane: lane as u32,
                        drive: drive as u32,
                        jacobian: world.drives[drive].jacobian(&point).into(),
                        drift: drift.into(),
                    });
                }
            }
        }
        if let Some(ranks) = &mut layout.ranks {
            let of_tasks = layout.driven.chunk_by(|one, next| one.task == next.task);
            ranks.take_turns(of_tasks.map(|task| (task[0].task, task.len())).collect());
        }
    }

    /// Lays out contacts with other effects than those of the world's materials.
    pub(crate) fn compile_effects(&mut self, effects: EffectSet) {
        self.effects = effects;
    }

    /// Returns the discretisation of contacts.
    pub(crate) fn scheme(&self) -> &NormalScheme {
        &self.constants.scheme
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.taken.memory_bytes() + self.poses.capacity() * size_of::<Pose>()
    }
}

impl StepContext<'_> {
    /// Lays out one task, with groups numbered from `base` on; returns the next free group number.
    fn lay_out(
        &self,
        own: Own<'_>,
        (base, taken): (u32, TaskSlots<'_, Taken>),
        groups: &mut TaskGroups,
        set: Available,
    ) -> u32 {
        let Own { task, listed, memory: [of_pairs, of_walls], borne } = own;
        let dummies = self.world.dummies_of(task.home as usize);
        let (assigner, periodic) = (LaneAssigner::new(taken, base, task.pairs.len()), self.world.period.any());
        let (impulses, known) = (of_pairs.impulses, of_pairs.impacts);
        let mut next = if periodic {
            set.run(AssignPairs::<true> { context: self, task, dummies, assigner, groups, impulses, known, borne })
        } else {
            set.run(AssignPairs::<false> { context: self, task, dummies, assigner, groups, impulses, known, borne })
        };
        groups.restart_walls(dummies);
        next = self.assign_walls((task, listed), false, LaneAssigner::new(taken, next, 0), groups, &of_walls);
        if !self.world.drives.is_empty() {
            let prescribed = groups.wall_groups();
            next = self.assign_walls((task, listed), true, LaneAssigner::new(taken, next, 0), groups, &of_walls);
            groups.driven_walls = groups.wall_groups() - prescribed;
        }
        groups.finish(self.effects, self.drifts);
        set.run(FindWaits { groups, effects: self.effects, grains: self.world.grains() as u32 });
        let (impulses, known_impacts) = (impulses.to_read(), known.to_read());
        let (context, sources, impacts) = (self, &*groups.pair_sources, &mut *groups.pair_impacts);
        with_pairs!(&mut groups.pairs, pairs => match periodic {
            true => set.run(FillPairs::<true, _> { context, task, pairs, sources, impacts, impulses, known_impacts }),
            false => set.run(FillPairs::<false, _> { context, task, pairs, sources, impacts, impulses, known_impacts }),
        });
        let (impulses, known_impacts) = (of_walls.impulses.to_read(), of_walls.impacts.to_read());
        let candidates = listed.walls.to_read();
        set.run(FillWalls { context, groups, candidates, impulses, known_impacts });
        if self.effects.cohesion() {
            self.fill_pulls(groups, candidates);
        }
        if self.effects.torques() {
            let (pairs, walls) = (of_pairs.torques.to_read(), of_walls.torques.to_read());
            with_effects!(self.effects, E => {
                let effects = PhantomData::<E>;
                set.run(FillTorques { context: self, groups, candidates, pairs, walls, effects })
            });
        }
        next
    }
}

/// Writes constraint data and starting impulses of eight contacts, and the memory of their impacts. Arguments include the
/// velocities along the normals (m/s) and the sums of the inverse masses (1/kg).
///
/// The stored tangential impulse is projected onto the new tangent plane.
#[inline(always)]
fn write_contacts<L: Lanes, T: Tangential>(
    contacts: &mut ContactLanes<Eight, T>,
    geometry: &ContactGeometry<L>,
    [velocity, inverse_mass]: [L; 2],
    material: &LaneMaterial<L>,
    (remembered, impact): ([L; 4], &Impact<L>),
    constants: &StepConstants,
) -> ImpactLanes {
    let ContactGeometry { normal, overlap, .. } = *geometry;
    let scheme = &constants.scheme;
    let LaneMaterial { effective_modulus, damping_ratio, restitution, friction, stiffness_ratio } = *material;
    let contact = geometry.normal_contact(velocity, inverse_mass, effective_modulus, damping_ratio);
    let constraint = contact.constraint(scheme, impact.speed);
    let Decision { constraint, speed } =
        impact.decide(constraint, scheme, [overlap, velocity], inverse_mass, restitution);
    let active = bears(&constraint);
    let share = L::select(active, L::splat(constants.warm_start), <L as Number>::zero());
    let [impulse, x, y, z] = remembered;
    let along = dot(normal, [x, y, z]);
    let last_impulse = minus([x, y, z], times(normal, along));
    let (constraint, step) = (&constraint, scheme.step);
    let start = TermStart { constraint, active, last_impulse, share, friction, stiffness_ratio, step };
    contacts.tangential.fill(&start, L::store);
    normal.into_iter().zip(&mut contacts.normal).for_each(|(component, lanes)| component.store(lanes));
    (impulse * share).store(&mut contacts.impulse_normal);
    constraint.bias.store(&mut contacts.bias);
    constraint.regularisation.store(&mut contacts.regularisation);
    ImpactLanes::of(speed, velocity)
}
