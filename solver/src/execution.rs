//! Execution settings, and the builder of a simulation.

use crate::Simulation;
use crate::lanes::InstructionSet;
use crate::partition::Portion;
use crate::scene::{Precision, Scene, SolverMethod, Stop};
use crate::schedule::Scheduler;
use crate::{Error, SettingError};

/// Threads, their scheduler, and the instruction set of the kernels. The result does not depend on these settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Execution {
    /// Scheduler of the tasks.
    pub scheduler: Scheduler,
    /// Number of threads.
    pub threads: usize,
    /// Instruction set of the kernels.
    pub instruction_set: InstructionSet,
    /// Prefetch distance of a sweep in lane groups; 0 disables software prefetching. Default: the distance that pays.
    pub prefetch: Option<usize>,
    /// Task granularity.
    pub portion: Portion,
}

impl Execution {
    /// Returns the settings of one thread on the widest instruction set.
    pub fn serial() -> Execution {
        Execution {
            scheduler: Scheduler::Serial,
            threads: 1,
            instruction_set: InstructionSet::detect(),
            prefetch: None,
            portion: Portion::Batches,
        }
    }

    /// Returns true if this is the serial reference for a speed-up of the other execution.
    pub fn is_serial_of(&self, other: &Execution) -> bool {
        self.scheduler == Scheduler::Serial
            && (self.instruction_set, self.portion) == (other.instruction_set, other.portion)
    }

    /// Applies the settings to a simulation from its next step on.
    ///
    /// # Errors
    /// [`SettingError::NoInstructionSet`] if the processor lacks the set, [`SettingError::NoThreads`] if the system cannot start more threads.
    pub fn apply(&self, simulation: &mut Simulation) -> Result<(), SettingError> {
        simulation.use_instruction_set(self.instruction_set)?;
        simulation.use_prefetch(self.prefetch);
        simulation.use_portion(self.portion);
        simulation.use_team(self.scheduler, self.threads)
    }
}

/// Builder of a simulation: [`Simulation::builder`].
///
/// Defaults are the settings of the scene, one thread, and the widest instruction set of the processor.
#[derive(Clone, Debug)]
pub struct SimulationBuilder {
    scene: Scene,
    seed: u64,
    execution: Execution,
}

impl Simulation {
    /// Returns a builder of a simulation of a scene.
    pub fn builder(scene: &Scene) -> SimulationBuilder {
        SimulationBuilder { scene: scene.clone(), seed: scene.seed, execution: Execution::serial() }
    }
}

impl SimulationBuilder {
    crate::setters! {
        /// Seed of the positions and radii of grains; default: the seed of the scene.
        seed(seed: u64) |builder| builder.seed = seed;
        /// Scheduler of the tasks.
        scheduler(scheduler: Scheduler) |builder| builder.execution.scheduler = scheduler;
        /// Instruction set of the kernels; all give the same bits.
        instruction_set(instruction_set: InstructionSet) |builder| builder.execution.instruction_set = instruction_set;
        /// Threads, scheduler and instruction set together.
        execution(execution: Execution) |builder| builder.execution = execution;
        /// Time step, s, instead of the scene's.
        time_step(step: f64) |builder| builder.scene.solver.step = step;
        /// Stopping rule of a solve, instead of the scene's.
        stop(stop: Stop) |builder| builder.scene.solver.stop = stop;
        /// Solution method, instead of the scene's.
        method(method: SolverMethod) |builder| builder.scene.solver.method = method;
        /// Precision of the sweeps, instead of the scene's.
        precision(precision: Precision) |builder| builder.scene.solver.precision = precision;
    }

    /// Number of threads; the default [`scheduler`](SimulationBuilder::scheduler) for several threads is work stealing.
    pub fn threads(mut self, threads: usize) -> SimulationBuilder {
        self.execution.threads = threads;
        if self.execution.scheduler == Scheduler::Serial && threads > 1 {
            self.execution.scheduler = Scheduler::WorkStealing;
        }
        self
    }

    /// Places the grains and prepares the first step.
    ///
    /// # Errors
    /// [`Error::Scene`] if the scene is invalid with these settings or its grains cannot be placed, [`Error::Setting`]
    /// if the machine does not support a setting. No setting is replaced silently.
    pub fn build(self) -> Result<Simulation, Error> {
        let mut simulation = Simulation::new(&self.scene, self.seed)?;
        self.execution.apply(&mut simulation)?;
        Ok(simulation)
    }
}
