//! How the steps to come are carried out and solved. What cannot be done is refused, and nothing changes.

use super::Simulation;
use crate::lanes::InstructionSet;
use crate::methods::Solver;
use crate::partition::Portion;
use crate::scene::setting_error::{Obstacle, SettingError, method_goes_with, precision_goes_with};
use crate::scene::{Precision, SolverMethod, Stop};
use crate::schedule::{Scheduler, Team};

impl Simulation {
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
        Obstacle::of_scene(
            self.relaxation.effects.torques(),
            !self.world.drives.is_empty(),
            self.relaxation.effects.spring(),
        )
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
}
