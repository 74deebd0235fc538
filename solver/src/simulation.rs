//! The time step, and a simulation as a caller sees it.

use crate::checkpoint::checksum;
use crate::constrain::Constrainer;
use crate::detect::Candidates;
use crate::partition::{BoxGrid, Layout};
use crate::scene::{Scene, SceneError, SolverSettings, populate};
use crate::solve::{SolveReport, solve};
use crate::sweep::{InstructionSet, Relaxation};
use crate::world::World;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;

/// A scene in motion.
#[derive(Clone, Debug)]
pub struct Simulation {
    pub(crate) world: World,
    pub(crate) settings: SolverSettings,
    pub(crate) candidates: Candidates,
    boxes: BoxGrid,
    skin: f64,
    relaxation: Relaxation,
    constrainer: Constrainer,
    pub(crate) layout: Layout,
    pub(crate) steps: u64,
    contact_sweeps: u64,
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
    /// [`SceneError`] if the grains do not fit their container or overlap.
    pub fn new(scene: &Scene, seed: u64, file: &Path) -> Result<Simulation, SceneError> {
        let grains = populate(scene, seed, file)?;
        Ok(Simulation::of_world(scene, World::new(scene, &grains)))
    }

    pub(crate) fn of_world(scene: &Scene, world: World) -> Simulation {
        let (largest, mean) = world.largest_and_mean_radius();
        let skin = scene.solver.skin * mean;
        Simulation {
            boxes: BoxGrid::new(&world.domain, world.grains(), largest, skin),
            skin,
            relaxation: Relaxation { instruction_set: InstructionSet::detect(), friction: world.table.any_friction() },
            world,
            settings: scene.solver.clone(),
            candidates: Candidates::default(),
            constrainer: Constrainer::default(),
            layout: Layout::default(),
            steps: 0,
            contact_sweeps: 0,
            phases: PhaseSeconds::default(),
        }
    }

    /// Advances by one time step.
    pub fn step(&mut self) -> StepReport {
        let clock = Clock::start();
        // Which grains and walls may touch.
        if self.candidates.are_stale(&self.world, self.skin) {
            self.candidates.rebuild(&self.world, &self.boxes, self.skin);
        }
        let clock = clock.lap(&mut self.phases.detect);
        // Which do, as constraints laid out in boxes, stages and lane groups.
        self.constrainer.constrain(&self.world, &mut self.candidates, &self.settings, &mut self.layout);
        let clock = clock.lap(&mut self.phases.constrain);
        // Forces, then the impulses of the last step, then sweeps until the settings say stop.
        self.apply_gravity();
        let clock = clock.lap(&mut self.phases.integrate);
        self.relaxation.warm_start(&mut self.world.bodies, &self.layout.pairs, &self.layout.walls);
        let clock = clock.lap(&mut self.phases.constrain);
        let solve = solve(&mut self.world, &mut self.layout, &self.relaxation, &self.settings);
        let clock = clock.lap(&mut self.phases.sweep);
        // Motion with the new velocities.
        self.remember_impulses();
        self.move_bodies();
        clock.lap(&mut self.phases.integrate);
        self.contact_sweeps += u64::from(solve.sweeps) * self.layout.contacts as u64;
        StepReport { solve, contacts: self.layout.contacts }
    }

    fn apply_gravity(&mut self) {
        let change = self.world.gravity * self.settings.step;
        let grains = self.world.grains();
        for body in &mut self.world.bodies[..grains] {
            for axis in 0..3 {
                body.velocity[axis] += change[axis];
            }
        }
    }

    fn move_bodies(&mut self) {
        let h = self.settings.step;
        for (position, body) in self.world.positions.iter_mut().zip(&self.world.bodies) {
            *position += Vector3::from(body.velocity) * h;
        }
        self.steps += 1;
        self.world.time = self.world_time_after(self.steps);
    }

    /// Time after a number of steps: a product, so that it gathers no rounding error.
    fn world_time_after(&self, steps: u64) -> f64 {
        steps as f64 * self.settings.step
    }

    fn remember_impulses(&mut self) {
        for group in &self.layout.pairs {
            for (lane, source) in group.contacts.occupied() {
                self.candidates.pair_impulses[source] = group.contacts.impulse(lane);
            }
        }
        for group in &self.layout.walls {
            for (lane, source) in group.contacts.occupied() {
                self.candidates.wall_impulses[source] = group.contacts.impulse(lane);
            }
        }
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

    /// Instruction set of the sweep kernel.
    pub fn instruction_set(&self) -> InstructionSet {
        self.relaxation.instruction_set
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

    /// Hash of the state (time, positions, velocities, spins): FNV-1a, 64 bits, over their bits.
    pub fn state_hash(&self) -> u64 {
        let mut bytes = self.world.time.to_bits().to_le_bytes().to_vec();
        for (position, body) in self.world.positions.iter().zip(&self.world.bodies) {
            let values = position.iter().chain(&body.velocity).chain(&body.surface_speed);
            bytes.extend(values.flat_map(|value| value.to_bits().to_le_bytes()));
        }
        checksum(&bytes)
    }

    /// Bytes that the simulation holds for its bodies, candidates and contacts.
    pub fn memory_bytes(&self) -> usize {
        self.world.memory_bytes() + self.candidates.memory_bytes() + self.layout.memory_bytes()
    }

    /// Sweeps on another instruction set than the one found at start; all give the same bits.
    ///
    /// Ignored where the processor lacks it.
    pub fn use_instruction_set(&mut self, instruction_set: InstructionSet) {
        if instruction_set.is_available() {
            self.relaxation.instruction_set = instruction_set;
        }
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
