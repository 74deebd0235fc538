//! Settings of the steps to come, and interrupts. An impossible setting is refused, and nothing changes.

use super::Simulation;
use crate::interrupt::{Interrupt, polls_interrupt};
use crate::lanes::InstructionSet;
use crate::methods::Solver;
use crate::partition::Portion;
use crate::scene::{Obstacle, Precision, SettingError, SolverMethod, Stop, method_goes_with, precision_goes_with};
use crate::schedule::{Scheduler, Team};
use crate::world::World;

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

    /// Property of the scene that only Gauss-Seidel in double precision has equations for.
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

    /// Checks that a method can solve the steps to come.
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

impl Simulation {
    /// Handle that stops a step of this simulation, and of its clones, from another thread: see [`interrupt`](crate::interrupt). Solves of
    /// at most 64 sweeps do not look.
    pub fn interrupt_handle(&self) -> Interrupt {
        self.interrupt.clone()
    }

    /// Stops when this is asked to: one request may stop many simulations.
    pub fn set_interrupt(&mut self, interrupt: Interrupt) {
        self.interrupt = interrupt;
    }

    /// Returns true if its solves may be so long that they look whether they are to stop.
    pub fn polls_interrupt(&self) -> bool {
        polls_interrupt(&self.settings)
    }

    /// Returns true if spins at the start of a step are kept: friction may go by how contacts slide, and a step may be abandoned.
    pub(crate) fn keeps_spins(&self) -> bool {
        let effects = &self.relaxation.effects;
        effects.kinetic_friction() || (effects.tangential() && polls_interrupt(&self.settings))
    }

    /// Goes back to the start of a step whose solve was interrupted.
    pub(crate) fn abandon_step(&mut self) {
        let World { bodies, before, spins_before, drives, .. } = &mut self.world;
        for (body, before) in bodies.iter_mut().zip(before) {
            let [x, y, z, _] = before.0;
            body.velocity = [x, y, z];
        }
        for (body, before) in bodies.iter_mut().zip(spins_before) {
            let [x, y, z, _] = before.0;
            body.scaled_spin = [x, y, z];
        }
        drives.iter_mut().for_each(|drive| drive.rate = drive.rate_before);
        self.abandon_torques();
        self.layout.contacts = 0;
        self.layout.driven.clear();
        for groups in &mut self.layout.groups {
            groups.empty(self.relaxation.effects);
        }
    }
}
