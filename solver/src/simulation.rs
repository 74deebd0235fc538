//! The time step, and a simulation as a caller sees it.

use crate::checkpoint::checksum;
use crate::constrain::Constrainer;
use crate::detect::Candidates;
use crate::effects::EffectSet;
use crate::interrupt::Interrupt;
use crate::lanes::{Available, InstructionSet, PREFETCH, Quad};
use crate::ledger::Ledger;
use crate::methods::Solver;
use crate::partition::{BoxGrid, Layout, Portion};
use crate::scene::{Precision, Scene, SceneError, SolverMethod, SolverSettings, Stop, populate};
use crate::schedule::{Phase, Scheduler, StepTrace, Team};
use crate::setting_error::{Obstacle, SettingError, method_goes_with, precision_goes_with};
use crate::solve::{SolveReport, StopReason, solve};
use crate::sweep::{Relaxation, start_driven};
use crate::swept::Swept;
use crate::world::{Body, Sphere, World, by_chunk, chunk, chunks};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// A scene in motion.
#[derive(Clone, Debug)]
pub struct Simulation {
    pub(crate) world: World,
    pub(crate) settings: SolverSettings,
    pub(crate) candidates: Candidates,
    pub(crate) relaxation: Relaxation,
    /// Lane groups ahead of a sweep to fetch, where that was said; elsewhere it goes by the size of the step.
    prefetch: Option<usize>,
    pub(crate) constrainer: Constrainer,
    pub(crate) layout: Layout,
    pub(crate) solver: Solver,
    pub(crate) team: Team,
    pub(crate) steps: u64,
    pub(crate) contact_sweeps: u64,
    pub(crate) ledger: Option<Ledger>,
    pub(crate) swept: Swept,
    pub(crate) interrupt: Interrupt,
    /// Work that walls did on grains in the last step besides what the solve tells, J.
    pub(crate) work_outside_of_the_solve: f64,
    phases: PhaseSeconds,
}

/// Wall time spent in each phase of the steps so far, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseSeconds {
    /// Candidate list.
    pub detect: f64,
    /// Gaps, normals, constraint data, lane groups, warm start.
    pub constrain: f64,
    /// Sweeps.
    pub sweep: f64,
    /// Forces, motion, remembering impulses.
    pub integrate: f64,
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// The solve.
    pub solve: SolveReport,
    /// Number of contacts.
    pub contacts: usize,
}

impl Simulation {
    /// Places the scene's grains and makes ready for the first step.
    ///
    /// # Errors
    /// [`SceneError`] if the scene breaks a rule that scenes from files have to keep ([`Scene::check`]), or if its grains do not fit their
    /// container or overlap.
    pub fn new(scene: &Scene, seed: u64) -> Result<Simulation, SceneError> {
        scene.check()?;
        let grains = populate(scene, seed)?;
        Ok(Simulation::of_world(scene, World::new(scene, &grains)))
    }

    pub(crate) fn of_world(scene: &Scene, mut world: World) -> Simulation {
        let (largest, mean) = world.largest_and_mean_radius();
        let wanted = scene.solver.reach(mean, world.field.largest());
        let skin = wanted.min(world.longest_reach()).max(scene.solver.skin * mean);
        let reach = skin + world.range_of_cohesion();
        let boxes = BoxGrid::new(&world.domain, &world.period, world.grains(), largest, reach);
        world.add_dummies(boxes.boxes());
        let effects = world.table.effects();
        Simulation {
            relaxation: Relaxation { instruction_set: Available::detect(), scalar: false, effects, prefetch: PREFETCH },
            prefetch: None,
            candidates: Candidates::new(&boxes, &world, skin, scene.solver.step, effects.torques()),
            constrainer: Constrainer::new(&world, &scene.solver),
            world,
            settings: scene.solver.clone(),
            layout: Layout::new(boxes.tasks()),
            solver: Solver::new(scene.solver.method),
            team: Team::default(),
            steps: 0,
            contact_sweeps: 0,
            ledger: None,
            swept: Swept::default(),
            interrupt: Interrupt::new(),
            work_outside_of_the_solve: 0.0,
            phases: PhaseSeconds::default(),
        }
    }

    /// Advances by one time step, unless it is [interrupted](crate::interrupt): then all is as before it, and the report says so.
    pub fn step(&mut self) -> StepReport {
        let team = self.team.clone();
        team.enter(|| self.step_of(&team))
    }

    /// Advances by one time step and tells how long each task took.
    pub fn trace_step(&mut self) -> (StepReport, StepTrace) {
        let team = self.team.traced();
        let report = team.enter(|| self.step_of(&team));
        (report, team.take_trace())
    }

    fn step_of(&mut self, team: &Team) -> StepReport {
        self.work_outside_of_the_solve = 0.0;
        // The contact problem of the step.
        self.pose_problem(team);
        let clock = Clock::start();
        // Iterations until the settings say stop.
        let Simulation { world, settings, layout, relaxation, solver, interrupt, .. } = self;
        let solve = solve(world, layout, relaxation, settings, team, solver, interrupt);
        let clock = clock.lap(&mut self.phases.sweep);
        if solve.reason == StopReason::Interrupted {
            self.abandon_step();
            return StepReport { solve, contacts: 0 };
        }
        if let Some(mut ledger) = self.ledger.take() {
            ledger.note(self, self.constrainer.scheme());
            self.ledger = Some(ledger);
        }
        // Walls that grains would pass within the step.
        let stopped = self.stop_ahead(team);
        // Motion with the new velocities.
        self.remember_impulses(team);
        self.move_bodies(stopped, team);
        clock.lap(&mut self.phases.integrate);
        let sweeps = u64::from(solve.sweeps) * u64::from(self.settings.sweeps_per_iteration());
        self.contact_sweeps += sweeps * self.layout.contacts as u64;
        StepReport { solve, contacts: self.layout.contacts }
    }

    /// Poses the next step's contact problem: contacts laid out with the impulses that they start from, and bodies with the
    /// velocities that go with these.
    pub(crate) fn pose_problem(&mut self, team: &Team) {
        let set = self.relaxation.instruction_set;
        let clock = Clock::start();
        // Which grains and walls may touch.
        let unknown = self.may_be_swift() && self.candidates.miss_a_wall(&self.world, team);
        if unknown || self.candidates.are_stale(&self.world, team) {
            self.candidates.rebuild(&mut self.world, &mut self.layout.plan, set, team);
        }
        let clock = clock.lap(&mut self.phases.detect);
        if let Some(ledger) = &mut self.ledger {
            ledger.begin(&self.world, &self.candidates, self.constrainer.scheme());
        }
        // Forces.
        self.apply_gravity(self.settings.step, team);
        let clock = clock.lap(&mut self.phases.integrate);
        // Which do, as constraints laid out in boxes, stages and lane groups; they start from their last impulses.
        self.constrain(team);
        start_driven(&self.layout, &mut self.world.drives);
        clock.lap(&mut self.phases.constrain);
    }

    /// Keeps the velocities, and spins where they are asked for, at the start of a step of length `h` (s), then lets gravity
    /// act on the grains, and on driven walls what drives them.
    pub(crate) fn apply_gravity(&mut self, h: f64, team: &Team) {
        let change = self.world.gravity * h;
        let (time, gravity) = (self.world.time, self.world.gravity);
        self.world.drives.iter_mut().for_each(|drive| drive.begin(time, h, &gravity));
        let spins = self.keeps_spins();
        let (grains, count) = (self.world.grains(), self.world.bodies.len());
        let World { bodies, before, spins_before, .. } = &mut self.world;
        before.resize(count, Quad::default());
        spins_before.resize(if spins { count } else { 0 }, Quad::default());
        let shares = (by_chunk(bodies), [by_chunk(before), by_chunk(spins_before)]);
        team.each_with(Phase::Integrate, chunks(count), shares, |number, (bodies, [before, spins_before])| {
            let places = chunk(number, count);
            let falling = places.start..places.end.min(grains).max(places.start);
            for (body, spin) in bodies.iter().zip(spins_before) {
                let [x, y, z] = body.surface_speed;
                *spin = Quad([x, y, z, 0.0]);
            }
            for (body, before) in bodies.iter().zip(before) {
                let [x, y, z] = body.velocity;
                *before = Quad([x, y, z, body.inverse_mass]);
            }
            for body in &mut bodies[..falling.len()] {
                for axis in 0..3 {
                    body.velocity[axis] += change[axis];
                }
            }
        });
    }

    pub(crate) fn constrain(&mut self, team: &Team) {
        self.layout.fit(self.candidates.tasks());
        // Bodies, and contacts about as many as in the last step.
        self.constrainer.fetches = self.layout.prefetch(self.world.bodies.len()) > 0;
        let Simulation { world, candidates, relaxation, constrainer, layout, .. } = self;
        constrainer.constrain(world, candidates, relaxation, team, layout);
        self.choose_prefetch();
    }

    /// Fetches as far ahead as was said, or as pays for what is laid out.
    fn choose_prefetch(&mut self) {
        let pays = self.layout.prefetch(self.world.bodies.len());
        self.relaxation.prefetch = self.prefetch.unwrap_or(pays);
    }

    fn move_bodies(&mut self, stopped: bool, team: &Team) {
        let h = self.settings.step;
        self.move_grains(stopped, team);
        self.world.drives.iter_mut().for_each(|drive| drive.advance(h));
        self.world.place_driven_walls();
        self.steps += 1;
        let (time, gravity) = (self.world_time_after(self.steps), self.world.gravity);
        self.world.set_time(time);
        if let Some(ledger) = &mut self.ledger {
            ledger.settle(&self.world, &self.candidates, self.constrainer.scheme());
            ledger.change_gravity(&self.world, gravity, h);
        }
    }

    /// Time after a number of steps: a product, so that it gathers no rounding error.
    pub(crate) fn world_time_after(&self, steps: u64) -> f64 {
        steps as f64 * self.settings.step
    }

    fn remember_impulses(&mut self, team: &Team) {
        let (relaxation, layout) = (&self.relaxation, &self.layout);
        let (impulses, _) = self.candidates.impulses.shares();
        layout.plan.run_all(team, Phase::Integrate, impulses, |_, task, impulses| {
            relaxation.remember(&layout.groups[task.number as usize], impulses.into());
        });
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.world.time
    }

    /// Steps taken.
    pub fn steps_taken(&self) -> u64 {
        self.steps
    }

    /// Time step, s.
    pub fn time_step(&self) -> f64 {
        self.settings.step
    }

    /// The effects that the scene calls for, as far as the sweep kernel has to know them.
    pub fn effects(&self) -> EffectSet {
        self.relaxation.effects
    }

    /// Instruction set of the sweep kernel.
    pub fn instruction_set(&self) -> InstructionSet {
        self.relaxation.instruction_set.name()
    }

    /// Contacts times sweeps, summed over the steps taken.
    pub fn contact_sweeps(&self) -> u64 {
        self.contact_sweeps
    }

    /// Wall time of the phases, summed over the steps taken.
    pub fn phase_seconds(&self) -> PhaseSeconds {
        self.phases
    }

    /// The contacts of the last step as they were laid out.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Number of times that the candidate list was built.
    pub fn rebuilds(&self) -> u64 {
        self.candidates.rebuilds
    }

    /// Hash of the state (time, positions, velocities, spins, grain by grain, then driven walls): FNV-1a, 64 bits, over their bits.
    pub fn state_hash(&self) -> u64 {
        let mut bytes = self.world.time.to_bits().to_le_bytes().to_vec();
        for place in self.places_by_id() {
            let (sphere, body) = (&self.world.spheres[place as usize], &self.world.bodies[place as usize]);
            let values = sphere.centre.iter().chain(&body.velocity).chain(&body.surface_speed);
            bytes.extend(values.flat_map(|value| value.to_bits().to_le_bytes()));
        }
        let driven = self.world.drives.iter().flat_map(|drive| [drive.displacement, drive.rate]);
        bytes.extend(driven.flat_map(|value| value.to_bits().to_le_bytes()));
        checksum(&bytes)
    }

    /// Place of each grain, by id.
    pub(crate) fn places_by_id(&self) -> Vec<u32> {
        let mut places = vec![0; self.world.grains()];
        for (place, &id) in self.world.ids.iter().enumerate() {
            places[id as usize] = place as u32;
        }
        places
    }

    /// Id of the first grain whose state is not finite.
    pub fn not_finite(&self) -> Option<u32> {
        self.first_grain(|sphere, body| {
            let values = sphere.centre.iter().chain(&body.velocity).chain(&body.surface_speed);
            values.fold(0.0, |sum, value| sum + 0.0 * value) != 0.0
        })
    }

    /// Smallest id of the grains of which something holds.
    pub(crate) fn first_grain(&self, holds: impl Fn(&Sphere, &Body) -> bool) -> Option<u32> {
        let World { spheres, bodies, ids, .. } = &self.world;
        let grains = spheres.iter().zip(bodies).zip(ids);
        grains.filter(|((sphere, body), _)| holds(sphere, body)).map(|(_, &id)| id).min()
    }

    /// Bytes that the simulation holds for its bodies, candidates and contacts.
    pub fn memory_bytes(&self) -> usize {
        self.world.memory_bytes()
            + self.candidates.memory_bytes()
            + self.layout.memory_bytes()
            + self.constrainer.memory_bytes()
            + self.solver.memory_bytes()
    }

    /// Works on another instruction set than the one found at start; all give the same bits.
    ///
    /// # Errors
    /// [`SettingError::NoInstructionSet`] where the processor lacks it.
    pub fn use_instruction_set(&mut self, instruction_set: InstructionSet) -> Result<(), SettingError> {
        self.relaxation.instruction_set = instruction_set.on_this_processor().ok_or_else(|| {
            let available = InstructionSet::ALL.into_iter().filter(|set| set.is_available());
            SettingError::NoInstructionSet { wanted: instruction_set, available: available.collect() }
        })?;
        Ok(())
    }

    /// Sweeps one contact at a time instead of eight, with the same bits: the baseline that lanes are measured against.
    pub fn use_scalar_sweeps(&mut self, scalar: bool) {
        self.relaxation.scalar = scalar;
    }

    /// What goes with Gauss-Seidel in double precision alone, if the scene has it.
    fn obstacle(&self) -> Option<Obstacle> {
        Obstacle::of_scene(self.relaxation.effects.torques(), !self.world.drives.is_empty())
    }

    /// Sweeps in another precision from the next step on; this changes the result.
    ///
    /// # Errors
    /// [`SettingError::SinglePrecision`] where contacts bear torques, walls are driven or the method is another than Gauss-Seidel:
    /// these go with double precision alone.
    pub fn use_precision(&mut self, precision: Precision) -> Result<(), SettingError> {
        precision_goes_with(precision, self.settings.method, || self.obstacle())?;
        self.settings.precision = precision;
        Ok(())
    }

    /// Fetches bodies into the cache so many lane groups before a sweep needs them; 0 leaves it to the processor. Absent, as many
    /// as pay: none where a step fits into the cache.
    pub fn use_prefetch(&mut self, groups: Option<usize>) {
        self.prefetch = groups;
        self.choose_prefetch();
    }

    /// Gives threads tasks in other portions, with the same bits.
    pub fn use_portion(&mut self, portion: Portion) {
        self.layout.plan.set_portion(portion);
    }

    /// Solves the steps to come with another method.
    ///
    /// # Errors
    /// [`SettingError::Method`] where contacts bear torques, walls are driven or sweeps are in single precision: these go with
    /// Gauss-Seidel alone.
    pub fn use_method(&mut self, method: SolverMethod) -> Result<(), SettingError> {
        self.goes_with(method)?;
        self.settings.method = method;
        self.solver = Solver::new(method);
        Ok(())
    }

    /// Whether a method can solve the steps to come.
    ///
    /// # Errors
    /// As for [`use_method`](Simulation::use_method).
    pub fn goes_with(&self, method: SolverMethod) -> Result<(), SettingError> {
        method_goes_with(method, self.settings.precision, || self.obstacle())
    }

    /// Stops the solves to come by another rule.
    pub fn use_stop(&mut self, stop: Stop) {
        self.settings.stop = stop;
    }

    /// Steps on so many threads that share tasks in this way; any choice gives the same bits.
    ///
    /// # Errors
    /// [`SettingError::NoThreads`] where the system gives no more threads.
    pub fn use_team(&mut self, scheduler: Scheduler, threads: usize) -> Result<(), SettingError> {
        let refused =
            |error: rayon::ThreadPoolBuildError| SettingError::NoThreads { threads, reason: error.to_string() };
        self.team = Team::new(scheduler, threads).map_err(refused)?;
        Ok(())
    }

    /// Threads and the way in which they share tasks.
    pub fn team(&self) -> &Team {
        &self.team
    }
}

/// Laps of wall time.
struct Clock(Instant);

impl Clock {
    fn start() -> Clock {
        Clock(Instant::now())
    }

    fn lap(self, sum: &mut f64) -> Clock {
        let now = Instant::now();
        *sum += (now - self.0).as_secs_f64();
        Clock(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_up_fetches_ahead_what_is_too_large_for_the_cache() {
        let fetches = |count: usize| {
            let text = format!(
                "name = 'cloud'\ndescription = ''\nduration = 1\ngravity = [0, 0, 0]\n\
                 domain = {{ min = [0, 0, 0], max = [1, 1, 1] }}\n\
                 [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nrestitution = 0.5\nfriction = 0\n\
                 [[population]]\ncount = {count}\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.005, spread = 0 }}\n\
                 region = {{ kind = 'box', min = [0, 0, 0], max = [1, 1, 1] }}\n"
            );
            let mut simulation = Simulation::new(&Scene::parse(&text).unwrap(), 1).unwrap();
            assert_eq!(simulation.step().contacts, 0, "bodies alone count");
            simulation.constrainer.fetches
        };
        assert!(!fetches(1_000), "64 KB of bodies");
        assert!(fetches(20_000), "1.3 MB of bodies");
    }
}
