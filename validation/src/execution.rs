//! How a simulation is carried out: threads, scheduler, instruction set. Its result depends on none of them.

use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::Scheduler;
use makadam::{SettingError, Simulation};

/// Threads, the way in which they share tasks, and the instruction set of the kernels.
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
    /// What a thread is given at a time.
    pub portion: Portion,
}

/// Why a simulation cannot be carried out so.
#[derive(Debug, thiserror::Error)]
pub enum ExecutionError {
    /// The processor lacks the instruction set.
    #[error("{0}; leave --isa out, or give one that there is")]
    NoInstructionSet(#[from] SettingError),
    /// The system gives no more threads.
    #[error("cannot start {0} threads: {1}; give fewer with --threads")]
    NoThreads(usize, String),
}

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// The machine cannot step as asked.
    #[error(transparent)]
    Execution(#[from] ExecutionError),
    /// The system starts no threads to measure with.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The user asked to stop.
    #[error("interrupted while measuring")]
    Interrupted,
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

    /// Whether this is the serial execution that a speed-up of the other one refers to.
    pub fn is_serial_of(&self, other: &Execution) -> bool {
        self.scheduler == Scheduler::Serial
            && (self.instruction_set, self.portion) == (other.instruction_set, other.portion)
    }

    /// Makes a simulation run so from its next step on.
    ///
    /// # Errors
    /// [`ExecutionError`].
    pub fn apply(&self, simulation: &mut Simulation) -> Result<(), ExecutionError> {
        simulation.use_instruction_set(self.instruction_set)?;
        simulation.use_prefetch(self.prefetch);
        simulation.use_portion(self.portion);
        simulation
            .use_team(self.scheduler, self.threads)
            .map_err(|error| ExecutionError::NoThreads(self.threads, error.to_string()))
    }
}

/// Number of cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}
