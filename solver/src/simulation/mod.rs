//! Simulation: public interface and internals.
//!
//! ```text
//! step.rs         the time step: detect, constrain, solve, move
//! swept/          contacts of grains that would cross a wall or another grain within a step
//! intervention/   actions of the caller between steps: forces, written states, inserted and removed grains, kinematic walls
//! flow.rs         grains that come and go by the scene
//! stages.rs       stages of a process
//! gauge.rs        grains that pass surfaces in space
//! settings.rs     threads, instruction set, precision, method, stop; interrupts
//! energy.rs       mechanical energy of a state
//! ledger/         sources and sinks of energy and momentum
//! wall_record.rs  loads and wear of walls
//! checkpoint/     stored states, to resume from
//! ranks.rs        runs on several ranks
//! ```

pub mod checkpoint;
pub(crate) mod energy;
pub(crate) mod flow;
pub(crate) mod gauge;
pub(crate) mod intervention;
pub(crate) mod ledger;
pub(crate) mod ranks;
mod settings;
pub(crate) mod stages;
mod step;
pub(crate) mod swept;
pub(crate) mod wall_record;

use crate::constrain::Constrainer;
use crate::detect::Candidates;
use crate::effects::EffectSet;
use crate::interrupt::Interrupt;
use crate::lanes::{Available, InstructionSet, PREFETCH};
use crate::methods::Solver;
use crate::partition::{BoxGrid, Layout, Ranks};
use crate::scene::{Scene, SceneError, SolverSettings, populate};
use crate::schedule::Team;
use crate::solve::SolveReport;
use crate::sweep::Relaxation;
use crate::world::{Body, Sphere, World};
use checkpoint::checksum;
use flow::Flow;
use gauge::Gauges;
use intervention::Interventions;
use ledger::Ledger;
use serde::{Deserialize, Serialize};
use stages::Stages;
use swept::Swept;
use wall_record::WallRecord;

/// Scene in motion.
#[derive(Clone, Debug)]
pub struct Simulation {
    pub(crate) world: World,
    pub(crate) settings: SolverSettings,
    pub(crate) candidates: Candidates,
    pub(crate) relaxation: Relaxation,
    /// Prefetch distance of sweeps in lane groups, if set; the default depends on the size of the step.
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
    pub(crate) interventions: Interventions,
    pub(crate) flow: Option<Flow>,
    pub(crate) stages: Option<Stages>,
    pub(crate) gauges: Gauges,
    pub(crate) wall_record: Option<WallRecord>,
    /// Work of walls on grains in the last step that the solve does not report, J.
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
    /// Forces, motion, storage of impulses.
    pub integrate: f64,
}

/// Report of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Report of the solve.
    pub solve: SolveReport,
    /// Number of contacts.
    pub contacts: usize,
}

/// Call that the leading rank asks the others to make with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Request {
    /// End of the run.
    End,
    /// Division of a simulation.
    Divide,
    Step,
    PairContacts,
    WallContacts,
    Energy,
    Checkpoint,
}

impl Request {
    /// All requests.
    pub const ALL: [Request; 7] = [
        Request::End,
        Request::Divide,
        Request::Step,
        Request::PairContacts,
        Request::WallContacts,
        Request::Energy,
        Request::Checkpoint,
    ];
}

impl Simulation {
    /// Inserts the scene's grains and prepares the first step.
    ///
    /// # Errors
    /// [`SceneError`] if the scene breaks a rule for scenes from files ([`Scene::check`]), or if its grains do not fit into their
    /// container or overlap.
    pub fn new(scene: &Scene, seed: u64) -> Result<Simulation, SceneError> {
        scene.check()?;
        let grains = populate(scene, seed)?;
        let stages = Stages::of(scene);
        let first = stages.as_ref().map(Stages::present);
        let scene = first.as_ref().unwrap_or(scene);
        let mut simulation = Simulation::of_world(&scene.solver, World::new(scene, &grains), grains.len());
        (simulation.flow, simulation.stages) = (Flow::of(scene, seed, &simulation.world), stages);
        simulation.gauges = Gauges::of(scene);
        Ok(simulation)
    }

    /// Prepares the first step of a world, with boxes for the given number of grains.
    pub(crate) fn of_world(settings: &SolverSettings, mut world: World, boxes_for: usize) -> Simulation {
        let (largest, mean) = world.largest_and_mean_radius();
        let wanted = settings.reach(mean, world.field.largest());
        let skin = wanted.min(world.longest_reach()).max(settings.skin * mean);
        let reach = skin + world.range_of_cohesion();
        let boxes = BoxGrid::new(&world.domain, &world.period, boxes_for, largest, reach);
        world.add_dummies(boxes.boxes());
        let effects = world.table.effects();
        Simulation {
            relaxation: Relaxation { instruction_set: Available::detect(), effects, prefetch: PREFETCH },
            prefetch: None,
            candidates: Candidates::new(&boxes, &world, boxes_for, skin, settings.step, effects.torques()),
            constrainer: Constrainer::new(&world, settings),
            swept: Swept::new(&world),
            world,
            settings: settings.clone(),
            layout: Layout::new(boxes.tasks()),
            solver: Solver::new(settings.method),
            team: Team::default(),
            steps: 0,
            contact_sweeps: 0,
            ledger: None,
            interrupt: Interrupt::new(),
            interventions: Interventions::default(),
            flow: None,
            stages: None,
            gauges: Gauges::default(),
            wall_record: None,
            work_outside_of_the_solve: 0.0,
            phases: PhaseSeconds::default(),
        }
    }

    /// Continues with the grains and contacts of another simulation of the same scene.
    fn go_on_as(&mut self, other: &Simulation) {
        self.relaxation.instruction_set = other.relaxation.instruction_set;
        self.use_prefetch(other.prefetch);
        self.layout.plan.set_portion(other.layout.plan.portion());
        self.layout.ranks = other.layout.ranks.as_ref().map(Ranks::anew);
        self.team = other.team.clone();
        (self.steps, self.contact_sweeps) = (other.steps, other.contact_sweeps);
        self.ledger = other.ledger.clone();
        (self.flow, self.stages) = (other.flow.clone(), other.stages.clone());
        (self.gauges, self.wall_record) = (other.gauges.clone(), other.wall_record.clone());
        (self.swept.crossing, self.swept.passage) = (other.swept.crossing, other.swept.passage);
        self.interrupt = other.interrupt.clone();
        self.phases = other.phases;
    }

    crate::getters! {
        /// Simulated time, s.
        pub time: f64 = |simulation| simulation.world.time;
        /// Steps taken.
        pub steps_taken: u64 = |simulation| simulation.steps;
        /// Time step, s.
        pub time_step: f64 = |simulation| simulation.settings.step;
        /// Returns the active effects of the scene that concern the sweep kernel.
        pub effects: EffectSet = |simulation| simulation.relaxation.effects;
        /// Instruction set of the sweep kernel.
        pub instruction_set: InstructionSet = |simulation| simulation.relaxation.instruction_set.name();
        /// Returns the number of contacts times sweeps, summed over the steps taken.
        pub contact_sweeps: u64 = |simulation| simulation.contact_sweeps;
        /// Wall time of the phases, summed over the steps taken.
        pub phase_seconds: PhaseSeconds = |simulation| simulation.phases;
        /// Returns the layout of the contacts of the last step.
        pub layout: &Layout = |simulation| &simulation.layout;
        /// Number of times that the candidate list was built.
        pub rebuilds: u64 = |simulation| simulation.candidates.rebuilds;
        /// Threads and their scheduler.
        pub team: &Team = |simulation| &simulation.team;
    }

    /// Hash of the state (time, positions, velocities and spins per grain, then dynamic walls): FNV-1a, 64 bits, over their bits.
    pub fn state_hash(&self) -> u64 {
        let mut bytes = self.world.time.to_bits().to_le_bytes().to_vec();
        for place in self.places_by_id() {
            let (sphere, body) = (&self.world.spheres[place as usize], &self.world.bodies[place as usize]);
            let values = sphere.centre.iter().chain(&body.velocity).chain(&body.scaled_spin);
            bytes.extend(values.flat_map(|value| value.to_bits().to_le_bytes()));
        }
        let driven = self.world.drives.iter().flat_map(|drive| [drive.displacement, drive.rate]);
        bytes.extend(driven.flat_map(|value| value.to_bits().to_le_bytes()));
        checksum(&bytes)
    }

    /// Body index of each grain, by id.
    pub(crate) fn places_by_id(&self) -> Vec<u32> {
        let mut places = vec![0; self.world.grains()];
        for (place, &id) in self.world.ids.iter().enumerate() {
            places[id as usize] = place as u32;
        }
        places
    }

    /// Permanent number of the first grain whose state is not finite.
    pub fn not_finite(&self) -> Option<u64> {
        let first = self.first_grain(|sphere, body| {
            let values = sphere.centre.iter().chain(&body.velocity).chain(&body.scaled_spin);
            values.fold(0.0, |sum, value| sum + 0.0 * value) != 0.0
        });
        first.map(|(id, _)| self.world.roll.number(id))
    }

    /// Smallest id of the grains that satisfy a predicate, and the place of this grain.
    pub(crate) fn first_grain(&self, holds: impl Fn(&Sphere, &Body) -> bool) -> Option<(u32, usize)> {
        let World { spheres, bodies, ids, .. } = &self.world;
        let grains = spheres.iter().zip(bodies).zip(ids).enumerate();
        grains.filter(|(_, ((sphere, body), _))| holds(sphere, body)).map(|(place, (_, &id))| (id, place)).min()
    }

    /// Memory of the simulation for bodies, candidates and contacts, bytes.
    pub fn memory_bytes(&self) -> usize {
        self.world.memory_bytes()
            + self.candidates.memory_bytes()
            + self.layout.memory_bytes()
            + self.constrainer.memory_bytes()
            + self.solver.memory_bytes()
    }
}
