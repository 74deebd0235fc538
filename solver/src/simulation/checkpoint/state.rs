//! Content of a checkpoint.

use super::{MARK, MARK_OF_ALTERED, open, seal_value};
use crate::Simulation;
use crate::detect::{AngularImpulse, Candidates, Impulse, Memory, PairCandidate, WallCandidate};
use crate::groups::ImpactMemory;
use crate::partition::{Layout, Plan, PlannedTask};
use crate::scene::{GrainEntry, Scene, sphere_volume};
use crate::schedule::Team;
use crate::simulation::Request;
use crate::simulation::flow::{Counts, Flow};
use crate::simulation::gauge::{Gauges, Passages};
use crate::simulation::intervention::Booked;
use crate::simulation::ledger::Ledger;
use crate::simulation::stages::{StageState, Stages};
use crate::simulation::wall_record::WallRecord;
use crate::wall::Steered;
use crate::world::{Body, Roll, Sphere, World};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Upper bound of the step counters: above this value, time as a product of steps is no longer exact.
const LARGEST_COUNT: u64 = 1 << 53;

/// Upper bound of positions, speeds, sizes and impulses in SI units; the square of the bound is finite.
const LARGEST: f64 = 1e30;

/// Complete state on which later steps depend.
#[derive(Serialize, Deserialize)]
pub(in crate::simulation) struct State {
    /// Time step, s.
    step: f64,
    steps: u64,
    contact_sweeps: u64,
    /// Grains in memory order.
    grains: Vec<GrainState>,
    /// Absent before the first step.
    list: Option<ListState>,
    pairs: Vec<KeptContact>,
    walls: Vec<KeptContact>,
    /// Angular impulses of these pairs, N m s, if contacts transmit torques; otherwise empty.
    pair_torques: Vec<[f64; 3]>,
    wall_torques: Vec<[f64; 3]>,
    /// States of the dynamic walls in scene order.
    driven_walls: Vec<DriveState>,
    /// Position of a stored ledger in the checkpoint.
    ledger: Option<Ledger>,
    /// Optional state, written only if not empty.
    #[serde(skip)]
    altered: Altered,
}

/// Optional state that few simulations have: effects of the caller on later steps, extra candidates, and the energy of tangential
/// springs.
#[derive(Clone, Default, PartialEq, Serialize, Deserialize)]
struct Altered {
    /// Kinematic walls by their numbers in the scene.
    moved_walls: Vec<(u32, Steered)>,
    /// Ledger entries of external actions.
    booked: Booked,
    /// True if the caller caused the new contacts of the next candidate list and a ledger is open.
    disturbed: bool,
    /// Net energy stored by tangential springs since the ledger was opened, J.
    springs: f64,
    /// Permanent numbers of the grains, if the grains differ from those of the scene.
    roll: Roll,
    /// Counts of the sources and sinks, and the number of grains that the boxes were chosen for.
    flow: Option<(Counts, u64)>,
    /// Position in the stages of the scene.
    stages: Option<StageState>,
    /// Ids and surfaces of extra candidates, which were not near each other when the list was built.
    beyond: Vec<(u32, u32)>,
    /// Sums of the loads and the wear of walls.
    wall_record: Option<WallRecord>,
    /// Passages of the gauges.
    gauges: Vec<[Passages; 2]>,
}

/// State of a dynamic wall.
#[derive(Serialize, Deserialize)]
struct DriveState {
    /// m or rad
    displacement: f64,
    /// m/s or rad/s
    rate: f64,
    /// Displacement when the candidate list was built, m or rad.
    displacement_in_list: f64,
}

#[derive(Serialize, Deserialize)]
struct GrainState {
    id: u32,
    position: [f64; 3],
    velocity: [f64; 3],
    scaled_spin: [f64; 3],
    radius: f64,
    inverse_mass: f64,
    material: u8,
}

/// State from which the candidate list was built, and the list at that time.
#[derive(Serialize, Deserialize)]
struct ListState {
    /// Simulated time, s.
    built_at: f64,
    rebuilds: u64,
    /// Centres in memory order, m.
    reference: Vec<[f64; 3]>,
    pairs: u32,
    walls: u32,
}

/// Memory of an active candidate from one step to the next.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct KeptContact {
    /// Index in the list.
    candidate: u32,
    /// Id of the first grain.
    pub first: u32,
    /// Id of the second grain, or number of the face of a wall.
    pub second: u32,
    /// Normal and tangential impulse, N s.
    pub impulse: [f64; 4],
    /// Current impact.
    pub impact: ImpactMemory,
}

impl KeptContact {
    fn scaled(&self, [normal, tangential]: [f64; 2]) -> Impulse {
        let [along, x, y, z] = self.impulse;
        Impulse { normal: along * normal, tangential: [x, y, z].map(|component| component * tangential) }
    }
}

/// Sets the impulse of a candidate, times a factor, and its angular impulse in a scene with torques.
fn give(memory: &mut Memory, candidate: usize, (known, torque): (&KeptContact, Option<&[f64; 3]>), scales: [f64; 2]) {
    let torque = torque.map_or([0.0; 3], |torque| torque.map(|component| component * scales[0]));
    memory.set(candidate, known.scaled(scales), known.impact, torque);
}

/// Contacts of a task, of pairs of grains and of walls.
#[derive(Default, Serialize, Deserialize)]
struct OfTask {
    /// Numbers of candidates.
    candidates: [u32; 2],
    /// Memories of the active ones, with their indices among the candidates of the task.
    kept: [Vec<KeptContact>; 2],
    /// Their angular impulses, N m s; empty if contacts transmit no torques.
    torques: [Vec<[f64; 3]>; 2],
}

impl OfTask {
    fn of(simulation: &Simulation, task: &PlannedTask) -> OfTask {
        let Candidates { pairs, walls, impulses, .. } = &simulation.candidates;
        let id = |place: u32| simulation.world.ids[place as usize];
        let pair = |c: usize| (id(pairs[c].first), id(pairs[c].second));
        let wall = |c: usize| (id(walls[c].body), walls[c].surface);
        let all_walls = task.walls.start as usize..task.walls.end as usize;
        let mut kept: [Vec<_>; 2] = [
            remembered(task.named(&impulses.borne), &impulses.pairs, pair).collect(),
            remembered(all_walls, &impulses.walls, wall).collect(),
        ];
        let torques = [torques_of(&kept[0], &impulses.pairs.torques), torques_of(&kept[1], &impulses.walls.torques)];
        for (kept, range) in kept.iter_mut().zip([&task.pairs, &task.walls]) {
            kept.iter_mut().for_each(|one| one.candidate -= range.start);
        }
        OfTask { candidates: [task.pairs.len() as u32, task.walls.len() as u32], kept, torques }
    }

    /// Appends the contacts of the next task.
    fn append(&mut self, next: OfTask) {
        for kind in 0..2 {
            let start = self.candidates[kind];
            let moved = |one: &KeptContact| KeptContact { candidate: start + one.candidate, ..*one };
            self.kept[kind].extend(next.kept[kind].iter().map(moved));
            self.torques[kind].extend(&next.torques[kind]);
            self.candidates[kind] += next.candidates[kind];
        }
    }

    /// Returns the contacts of all tasks of all ranks.
    fn all(simulation: &Simulation) -> OfTask {
        let own = simulation.layout.plan.tasks().iter().map(|task| OfTask::of(simulation, task));
        let mut all = OfTask::default();
        match simulation.together(Request::Checkpoint) {
            None => own.for_each(|next| all.append(next)),
            Some(ranks) => {
                let own = own.map(|one| vec![one]).collect();
                ranks.merge(own).into_iter().flatten().for_each(|next| all.append(next));
            }
        }
        all
    }
}

/// Impulses and impacts of the active candidates, each with its index in the list. An impulse is active if any of its bits is
/// set.
fn remembered<'a>(
    candidates: impl Iterator<Item = usize> + 'a,
    memory: &'a Memory,
    name: impl Fn(usize) -> (u32, u32) + 'a,
) -> impl Iterator<Item = KeptContact> + 'a {
    candidates.filter(|&candidate| memory.is_known(candidate)).map(move |candidate| {
        let Impulse { normal, tangential: [x, y, z] } = memory.impulses[candidate];
        let (impact, (first, second)) = (memory.impacts[candidate], name(candidate));
        let (candidate, impulse) = (candidate as u32, [normal, x, y, z]);
        KeptContact { candidate, first, second, impulse, impact }
    })
}

/// Returns the angular impulses of these candidates; empty if contacts transmit no torques.
fn torques_of(borne: &[KeptContact], torques: &[AngularImpulse]) -> Vec<[f64; 3]> {
    let known = |one: &KeptContact| torques.get(one.candidate as usize).map(|torque| torque.0);
    borne.iter().filter_map(known).collect()
}

impl Simulation {
    /// Returns the contact memories of the last step, for the next step: of pairs of grains, and with walls.
    #[doc(hidden)]
    pub fn kept_contacts(&self) -> [Vec<KeptContact>; 2] {
        let State { pairs, walls, .. } = State::of(self);
        [pairs, walls]
    }
}

impl State {
    /// Captures the state of a simulation.
    pub fn of(simulation: &Simulation) -> State {
        let Simulation { world, candidates, .. } = simulation;
        let grains = world.ids.iter().enumerate().map(|(place, &id)| GrainState {
            id,
            position: world.spheres[place].centre.into(),
            velocity: world.bodies[place].velocity,
            scaled_spin: world.bodies[place].scaled_spin,
            radius: world.spheres[place].radius,
            inverse_mass: world.bodies[place].inverse_mass,
            material: world.materials[place],
        });
        let OfTask { candidates: [pairs, walls], kept, torques } = OfTask::all(simulation);
        let [pairs_kept, walls_kept] = kept;
        let [pair_torques, wall_torques] = torques;
        let mut beyond = candidates.beyond().to_vec();
        if let Some(ranks) = simulation.layout.ranks.as_ref().filter(|ranks| ranks.is_divided()) {
            beyond = ranks.everyone(&beyond).concat();
            beyond.sort_unstable();
            beyond.dedup();
        }
        State {
            pair_torques,
            wall_torques,
            step: simulation.settings.step,
            steps: simulation.steps,
            contact_sweeps: simulation.contact_sweeps,
            grains: grains.collect(),
            list: candidates.built_from().map(|(reference, built_at)| ListState {
                built_at,
                rebuilds: candidates.rebuilds,
                reference: reference.iter().map(|centre| (*centre).into()).collect(),
                pairs,
                walls,
            }),
            pairs: pairs_kept,
            walls: walls_kept,
            driven_walls: (world.drives.iter())
                .map(|drive| DriveState {
                    displacement: drive.displacement,
                    rate: drive.rate,
                    displacement_in_list: match candidates.built_from() {
                        Some(_) => world.walls.displacement_in_list(drive.wall),
                        None => 0.0,
                    },
                })
                .collect(),
            ledger: simulation.ledger.clone(),
            altered: Altered {
                moved_walls: world.walls.steered().map(|(wall, steered)| (wall, *steered)).collect(),
                booked: simulation.interventions.booked,
                disturbed: simulation.interventions.disturbed,
                beyond,
                springs: simulation.ledger.as_ref().map_or(0.0, |ledger| ledger.entries.springs),
                roll: world.roll.clone(),
                stages: simulation.stages.as_ref().map(|stages| stages.state.clone()),
                wall_record: simulation.wall_record.clone(),
                gauges: simulation.gauges.passed.clone(),
                flow: simulation.flow.as_ref().map(|flow| (flow.counts.clone(), candidates.boxes_for() as u64)),
            },
        }
    }

    /// Serializes the state as a checkpoint.
    pub fn write(&self) -> Vec<u8> {
        match self.altered == Altered::default() {
            true => seal_value(MARK, self),
            false => seal_value(MARK_OF_ALTERED, &(self, &self.altered)),
        }
    }

    /// Reads a checkpoint.
    pub fn read(bytes: &[u8]) -> Result<State, String> {
        let altered = bytes.get(..8) == Some(&MARK_OF_ALTERED[..]);
        let body = open(if altered { MARK_OF_ALTERED } else { MARK }, bytes)?;
        let other = |error: postcard::Error| format!("does not hold what a checkpoint holds ({error})");
        let (mut state, mut rest) = postcard::take_from_bytes::<State>(body).map_err(other)?;
        if altered {
            (state.altered, rest) = postcard::take_from_bytes(rest).map_err(other)?;
        }
        let impulses = state.pairs.iter().chain(&state.walls).flat_map(|known| &known.impulse);
        let drives =
            state.driven_walls.iter().flat_map(|wall| [wall.displacement, wall.rate, wall.displacement_in_list]);
        let impacts =
            state.pairs.iter().chain(&state.walls).flat_map(|known| [known.impact.speed, known.impact.velocity]);
        let torques = state.pair_torques.iter().chain(&state.wall_torques).flatten();
        let sound = rest.is_empty()
            && state.step.is_finite()
            && state.step > 0.0
            && state.steps.max(state.contact_sweeps) < LARGEST_COUNT
            && state.list.as_ref().is_none_or(|list| list.built_at.is_finite() && list.rebuilds < LARGEST_COUNT)
            && { impulses }.all(|component| component.abs() < LARGEST)
            && { impacts }.all(|number| number.abs() < LARGEST as f32)
            && { torques }.all(|component| component.abs() < LARGEST)
            && drives.into_iter().all(|number| number.abs() < LARGEST)
            && state.altered.springs.abs() < LARGEST
            && state.altered.roll.is_sound(state.grains.len())
            && state.altered.flow.as_ref().is_none_or(|(counts, boxes_for)| {
                // New boxes are chosen when the number of grains has doubled or halved.
                let grains = state.grains.len() as u64;
                counts.are_sound() && grains <= boxes_for.saturating_mul(2) && *boxes_for <= 2 * grains
            })
            && state.altered.moved_walls.iter().all(|(_, steered)| steered.is_sound())
            && [(&state.pairs, &state.pair_torques), (&state.walls, &state.wall_torques)]
                .iter()
                .all(|(borne, torques)| torques.is_empty() || torques.len() == borne.len())
            && state.pairs.iter().all(|pair| pair.first != pair.second);
        if sound { Ok(state) } else { Err("holds numbers that no run can have".into()) }
    }

    /// Builds a simulation that continues from this state.
    pub fn resume(&self, scene: &Scene) -> Result<Simulation, String> {
        let stages = self.stages(scene)?;
        let present = stages.as_ref().map(Stages::present);
        let scene = self.check(scene, present.as_ref())?;
        if self.step.to_bits() != scene.solver.step.to_bits() {
            return Err(format!("has a time step of {:e} s where the scene has {:e} s", self.step, scene.solver.step));
        }
        let mut simulation = self.start_in(scene, stages)?;
        let drives = simulation.world.drives.len();
        if self.driven_walls.len() != drives {
            return Err(format!("has {} driven walls where the scene has {drives}", self.driven_walls.len()));
        }
        if let Some(list) = &self.list {
            self.put_driven_walls(&mut simulation.world, |wall| wall.displacement_in_list);
            self.put_moved_walls(&mut simulation.world, Steered::in_list)?;
            self.rebuild(&mut simulation, list)?;
        }
        self.put_driven_walls(&mut simulation.world, |wall| wall.displacement);
        self.put_moved_walls(&mut simulation.world, |steered| *steered)?;
        if let Some((flow, (counts, _))) = simulation.flow.as_mut().zip(self.altered.flow.as_ref()) {
            flow.continue_from(counts)?;
        }
        simulation.gauges.continue_from(&self.altered.gauges)?;
        if self.altered.wall_record.as_ref().is_some_and(|record| !record.fits(&simulation.world)) {
            return Err("has loads of other walls than those of the scene".into());
        }
        simulation.wall_record = self.altered.wall_record.clone();
        simulation.interventions.booked = self.altered.booked;
        simulation.interventions.disturbed = self.altered.disturbed;
        simulation.steps = self.steps;
        simulation.contact_sweeps = self.contact_sweeps;
        simulation.ledger = self.ledger.clone();
        simulation.ledger.iter_mut().for_each(|ledger| ledger.entries.springs = self.altered.springs);
        simulation.world.set_time(simulation.world_time_after(self.steps));
        Ok(simulation)
    }

    /// Builds a simulation of the scene at time zero with these grains, in id order, and the impulses of their contacts.
    pub fn start(&self, scene: &Scene) -> Result<Simulation, String> {
        let stages = Stages::of(scene);
        let present = stages.as_ref().map(Stages::present);
        self.start_in(self.check(scene, present.as_ref())?, stages)
    }

    /// Returns the stages of a scene at this state.
    fn stages(&self, scene: &Scene) -> Result<Option<Stages>, String> {
        match (Stages::of(scene), self.altered.stages.clone()) {
            (None, None) => Ok(None),
            (Some(Stages { scene, .. }), Some(state)) if state.is_sound(&scene, self.steps) => {
                Ok(Some(Stages { scene, state }))
            }
            _ => Err("has other stages than the scene".into()),
        }
    }

    /// Checks a scene and returns the scene of its present stage, if it has one.
    fn check<'s>(&self, scene: &'s Scene, present: Option<&'s Scene>) -> Result<&'s Scene, String> {
        let expected = scene.grain_count();
        if self.grains.len() != expected && !self.altered.roll.changed {
            return Err(format!("holds {} grains where the scene has {expected}", self.grains.len()));
        }
        scene.check().map_err(|error| format!("cannot go on with the scene: {error}"))?;
        Ok(present.unwrap_or(scene))
    }

    /// Builds a simulation of a checked scene, or of the scene of a stage, at time zero.
    fn start_in(&self, scene: &Scene, stages: Option<Stages>) -> Result<Simulation, String> {
        let seed = self.altered.flow.as_ref().map_or(scene.seed, |(counts, _)| counts.seed);
        let boxes_for = self.altered.flow.as_ref().map_or(self.grains.len(), |(_, grains)| *grains as usize);
        let mut world = World::new(scene, &[]);
        for (&wall, beginning) in stages.iter().flat_map(|stages| &stages.state.beginnings) {
            world.begin_motion(wall, &scene.course(wall as usize), beginning);
        }
        let mut simulation = Simulation::of_world(&scene.solver, self.populate(world)?, boxes_for);
        (simulation.flow, simulation.stages) = (Flow::of(scene, seed, &simulation.world), stages);
        simulation.gauges = Gauges::of(scene);
        // If the scene has other dynamic walls than the source of the grains, its walls start at their initial positions.
        if self.driven_walls.len() == simulation.world.drives.len() {
            self.put_driven_walls(&mut simulation.world, |wall| wall.displacement);
        }
        self.give_impulses(&mut simulation, scene.solver.step / self.step)?;
        simulation.world.roll = self.altered.roll.clone();
        Ok(simulation)
    }

    /// Sets the contact impulses of a simulation that has these grains, in id order, and no candidate list.
    pub fn give_impulses(&self, simulation: &mut Simulation, scale: f64) -> Result<(), String> {
        let (grains, surfaces) = (self.grains.len() as u32, simulation.world.walls.faces() as u32);
        let candidates = &mut simulation.candidates;
        // Start and source may differ in whether contacts transmit torques, or friction.
        let effects = simulation.relaxation.effects;
        let (torques, scales) = (effects.torques(), [scale, if effects.friction() { scale } else { 0.0 }]);
        let of_pairs = (&self.pairs, &self.pair_torques, &mut candidates.impulses.pairs, grains);
        let of_walls = (&self.walls, &self.wall_torques, &mut candidates.impulses.walls, surfaces);
        for (borne, angular, memory, partners) in [of_pairs, of_walls] {
            memory.resize(borne.len(), torques);
            for (number, known) in borne.iter().enumerate() {
                if known.first >= grains || known.second >= partners {
                    return Err("names a grain or a wall that is not there".into());
                }
                give(memory, number, (known, angular.get(number)), scales);
            }
        }
        let pair = |known: &KeptContact| PairCandidate { first: known.first, second: known.second };
        let wall = |known: &KeptContact| WallCandidate { body: known.first, surface: known.second };
        candidates.pairs.extend(self.pairs.iter().map(pair));
        candidates.walls.extend(self.walls.iter().map(wall));
        simulation.layout.replan(1, |plan| *plan = Plan::single(self.pairs.len() as u32, self.walls.len() as u32));
        simulation.candidates.find_borne(&simulation.layout.plan);
        Ok(())
    }

    /// Fills a world without grains with these grains, in id order.
    pub fn populate(&self, mut world: World) -> Result<World, String> {
        let mut by_id: Vec<&GrainState> = self.grains.iter().collect();
        by_id.sort_by_key(|grain| grain.id);
        for (id, grain) in by_id.into_iter().enumerate() {
            let GrainState { position, velocity, scaled_spin, radius, inverse_mass, .. } = grain;
            let numbers = position.iter().chain(velocity).chain(scaled_spin);
            let sound = [radius, inverse_mass].into_iter().all(|&value| value > 1.0 / LARGEST && value < LARGEST);
            if !sound || !numbers.into_iter().all(|value| value.abs() < LARGEST) {
                return Err(format!("gives grain {id} no finite state"));
            }
            if grain.id as usize != id {
                return Err(format!("has no grain {id}"));
            }
            if usize::from(grain.material) >= world.table.materials() {
                return Err("names a material that is not there".into());
            }
            world.ids.push(id as u32);
            world.spheres.push(Sphere { centre: Vector3::from(*position), radius: *radius });
            world.materials.push(grain.material);
            world.bodies.push(Body {
                velocity: *velocity,
                inverse_mass: *inverse_mass,
                scaled_spin: *scaled_spin,
                inverse_radius: 1.0 / radius,
            });
        }
        Ok(world)
    }

    /// Adds a grain with its material number and density (kg/m3).
    pub fn add(&mut self, id: u32, entry: &GrainEntry, material: u8, density: f64) {
        let radius = entry.radius;
        self.grains.push(GrainState {
            id,
            position: entry.position,
            velocity: entry.velocity,
            scaled_spin: entry.spin.map(|component| component * radius),
            radius,
            inverse_mass: 1.0 / (density * sphere_volume(radius)),
            material,
        });
    }

    /// Renumbers grains, given the new id of each old id; grains without a new id and their contacts are removed.
    pub fn renumber(&mut self, new_ids: &[Option<u32>]) {
        let new_id = |id: u32| new_ids.get(id as usize).copied().flatten();
        self.grains.retain_mut(|grain| new_id(grain.id).map(|id| grain.id = id).is_some());
        for (borne, torques, two) in
            [(&mut self.pairs, &mut self.pair_torques, true), (&mut self.walls, &mut self.wall_torques, false)]
        {
            let both = |known: &KeptContact| {
                let second = if two { new_id(known.second) } else { Some(known.second) };
                Some((new_id(known.first)?, second?))
            };
            let mut stays = borne.iter().map(|known| both(known).is_some());
            torques.retain(|_| stays.next().unwrap_or(false));
            borne.retain_mut(|known| both(known).map(|ids| (known.first, known.second) = ids).is_some());
        }
    }

    /// Sets the kinematic walls to their poses at the given time.
    fn put_moved_walls(&self, world: &mut World, then: impl Fn(&Steered) -> Steered) -> Result<(), String> {
        for (wall, steered) in &self.altered.moved_walls {
            if *wall as usize >= world.walls.count() {
                return Err(format!("moves wall {wall}, which is not there"));
            }
            world.walls.restore(*wall, then(steered));
        }
        Ok(())
    }

    /// Sets the dynamic walls to the given displacements.
    fn put_driven_walls(&self, world: &mut World, displacement: impl Fn(&DriveState) -> f64) {
        for (drive, state) in world.drives.iter_mut().zip(&self.driven_walls) {
            (drive.displacement, drive.rate) = (displacement(state), state.rate);
        }
        world.place_driven_walls();
    }

    /// Rebuilds the candidate list at the state of its last build, and restores the impulses of its candidates.
    fn rebuild(&self, simulation: &mut Simulation, list: &ListState) -> Result<(), String> {
        const OTHER: &str = "belongs to another scene or version: its contacts do not come out the same";
        let Simulation { world, candidates, layout, relaxation, team, .. } = simulation;
        let team: &Team = team;
        if list.reference.len() != self.grains.len() || !list.reference.iter().flatten().all(|x| x.abs() < LARGEST) {
            return Err(OTHER.into());
        }
        // Grains lie in id order: set the positions of the last build first, then the present positions.
        let places: Vec<u32> = self.grains.iter().map(|grain| grain.id).collect();
        world.reorder(&places, team);
        for (sphere, centre) in world.spheres.iter_mut().zip(&list.reference) {
            sphere.centre = Vector3::from(*centre);
        }
        world.time = list.built_at;
        // Remove the candidates by id that the start has inserted.
        (candidates.pairs, candidates.walls) = (Vec::new(), Vec::new());
        candidates.impulses.pairs = Memory::default();
        *layout = Layout::new(0);
        let set = relaxation.instruction_set;
        candidates.restore(world, layout, set, team, &self.altered.beyond).ok_or(OTHER)?;
        candidates.rebuilds = list.rebuilds;
        let same = (candidates.pairs.len() as u32, candidates.walls.len() as u32) == (list.pairs, list.walls);
        if !same || world.ids != places {
            return Err(OTHER.into());
        }
        for (sphere, grain) in world.spheres.iter_mut().zip(&self.grains) {
            sphere.centre = Vector3::from(grain.position);
        }
        let id = |place: u32| world.ids[place as usize];
        for (number, known) in self.pairs.iter().enumerate() {
            let pair = candidates.pairs.get(known.candidate as usize).ok_or(OTHER)?;
            if (id(pair.first), id(pair.second)) != (known.first, known.second) {
                return Err(OTHER.into());
            }
            let borne = (known, self.pair_torques.get(number));
            give(&mut candidates.impulses.pairs, known.candidate as usize, borne, [1.0; 2]);
        }
        candidates.find_borne(&layout.plan);
        for (number, known) in self.walls.iter().enumerate() {
            let wall = candidates.walls.get_mut(known.candidate as usize).ok_or(OTHER)?;
            let faces = world.walls.faces() as u32;
            let listed = |face: u32| (face < faces).then(|| world.walls.listed(face));
            if id(wall.body) != known.first || listed(known.second) != Some(wall.surface) {
                return Err(OTHER.into());
            }
            wall.surface = known.second;
            let borne = (known, self.wall_torques.get(number));
            give(&mut candidates.impulses.walls, known.candidate as usize, borne, [1.0; 2]);
        }
        Ok(())
    }
}
