//! Execution settings, and the builder of a simulation.

use crate::Simulation;
use crate::lanes::InstructionSet;
use crate::partition::Portion;
use crate::scene::{Precision, Scene, SolverMethod, Stop};
use crate::schedule::Scheduler;
use crate::{Error, SettingError};

/// Threads, the way in which they share tasks, and the instruction set of the kernels. The result depends on none of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Execution {
    /// Way in which threads share tasks.
    pub scheduler: Scheduler,
    /// Number of threads.
    pub threads: usize,
    /// Instruction set of the kernels.
    pub instruction_set: InstructionSet,
    /// Lane groups ahead of a sweep whose bodies are fetched into the cache; 0 leaves it to the processor. Absent, as many as pay.
    pub prefetch: Option<usize>,
    /// Task granularity.
    pub portion: Portion,
}

impl Execution {
    /// One thread on the widest instruction set.
    pub fn serial() -> Execution {
        Execution {
            scheduler: Scheduler::Serial,
            threads: 1,
            instruction_set: InstructionSet::detect(),
            prefetch: None,
            portion: Portion::Batches,
        }
    }

    /// Returns true if this is the serial execution that a speed-up of the other one refers to.
    pub fn is_serial_of(&self, other: &Execution) -> bool {
        self.scheduler == Scheduler::Serial
            && (self.instruction_set, self.portion) == (other.instruction_set, other.portion)
    }

    /// Makes a simulation run so from its next step on.
    ///
    /// # Errors
    /// [`SettingError::NoInstructionSet`] where the processor lacks it, [`SettingError::NoThreads`] where the system gives no more.
    pub fn apply(&self, simulation: &mut Simulation) -> Result<(), SettingError> {
        simulation.use_instruction_set(self.instruction_set)?;
        simulation.use_prefetch(self.prefetch);
        simulation.use_portion(self.portion);
        simulation.use_team(self.scheduler, self.threads)
    }
}

/// A simulation in the making: [`Simulation::builder`].
///
/// What is not said goes by the scene, on one thread and the widest instruction set that the processor has.
#[derive(Clone, Debug)]
pub struct SimulationBuilder {
    scene: Scene,
    seed: u64,
    execution: Execution,
}

impl Simulation {
    /// A simulation of a scene in the making.
    pub fn builder(scene: &Scene) -> SimulationBuilder {
        SimulationBuilder { scene: scene.clone(), seed: scene.seed, execution: Execution::serial() }
    }
}

impl SimulationBuilder {
    crate::setters! {
        /// Seed of the places and radii of grains; that of the scene where none is given.
        seed(seed: u64) |builder| builder.seed = seed;
        /// Way in which threads share tasks.
        scheduler(scheduler: Scheduler) |builder| builder.execution.scheduler = scheduler;
        /// Instruction set of the kernels; all give the same bits.
        instruction_set(instruction_set: InstructionSet) |builder| builder.execution.instruction_set = instruction_set;
        /// Threads, scheduler and instruction set together.
        execution(execution: Execution) |builder| builder.execution = execution;
        /// Time step, s, instead of the scene's.
        time_step(step: f64) |builder| builder.scene.solver.step = step;
        /// Stopping rule of a solve, instead of the scene's.
        stop(stop: Stop) |builder| builder.scene.solver.stop = stop;
        /// Method of solution, instead of the scene's.
        method(method: SolverMethod) |builder| builder.scene.solver.method = method;
        /// Precision of the sweeps, instead of the scene's.
        precision(precision: Precision) |builder| builder.scene.solver.precision = precision;
    }

    /// Number of threads; they steal work from each other unless a [`scheduler`](SimulationBuilder::scheduler) is given.
    pub fn threads(mut self, threads: usize) -> SimulationBuilder {
        self.execution.threads = threads;
        if self.execution.scheduler == Scheduler::Serial && threads > 1 {
            self.execution.scheduler = Scheduler::WorkStealing;
        }
        self
    }

    /// Places the grains and makes ready for the first step.
    ///
    /// # Errors
    /// [`Error::Scene`] where the scene with these settings is not sound or its grains cannot be placed, [`Error::Setting`] where the
    /// machine cannot carry it out so. Nothing is replaced in silence by what there is.
    pub fn build(self) -> Result<Simulation, Error> {
        let mut simulation = Simulation::new(&self.scene, self.seed)?;
        self.execution.apply(&mut simulation)?;
        Ok(simulation)
    }
}
